#include <recede/render/detail/billboard_view.h>

#include <numbers>

namespace recede::detail {

namespace {

/// Three numbers of a vector; `parts` begin with the first of them for its cluster.
Rgb color_of(const LocalPca& pca, std::uint32_t vector, const float* parts) {
  const auto components = static_cast<std::size_t>(pca.components);
  const float* weights = pca.weights.data() + vector * components;
  Rgb color;
  for (float& channel : color) {
    channel = *parts++;
    for (std::size_t c = 0; c < components; ++c) channel += weights[c] * *parts++;
  }
  return color;
}

}  // namespace

ReflectanceTables::ReflectanceTables(std::shared_ptr<const BillboardReflectance> with)
    : reflectance(std::move(with)), views(reflectance->views()), lights(reflectance->lights()) {
  const LocalPca& pca = reflectance->radiance;
  const std::size_t colors = 3 * pca.parts_per_entry(), n_lights = lights.size();
  const auto solid_angle = static_cast<float>(4 * std::numbers::pi / static_cast<double>(n_lights));
  sky.assign(pca.parts.size() / n_lights, 0.0f);
  for (std::size_t i = 0; i < pca.parts.size(); ++i)
    sky[i / (colors * n_lights) * colors + i % colors] += solid_angle * pca.parts[i];
}

Rgb BillboardView::value(const Vec3& toward_light) const {
  const LocalPca& pca = tables->reflectance->radiance;
  const NodeMix lights = tables->lights.mix((to_side * toward_light).normalized());
  const std::size_t colors = 3 * pca.parts_per_entry(), n_lights = tables->lights.size();
  Rgb value = Rgb::Zero();
  for (std::size_t t = 0; t < 4; ++t) {
    for (std::size_t v = 0; v < 4; ++v) {
      if (shares[t][v] == 0) continue;
      const float* parts = pca.parts.data() + (pca.clusters[vectors[t]] * tables->views.size() +
                                               static_cast<std::size_t>(views.nodes[v])) *
                                                  n_lights * colors;
      for (std::size_t l = 0; l < 4; ++l) {
        const float share = shares[t][v] * static_cast<float>(lights.weights[l]);
        value +=
            share * color_of(pca, vectors[t], parts + static_cast<std::size_t>(lights.nodes[l]) * colors);
      }
    }
  }
  // What compression loses may be more than there is.
  return value.cwiseMax(0.0f);
}

Rgb BillboardView::albedo() const {
  const LocalPca& pca = tables->reflectance->radiance;
  const std::size_t colors = 3 * pca.parts_per_entry();
  Rgb albedo = Rgb::Zero();
  for (std::size_t t = 0; t < 4; ++t) {
    for (std::size_t v = 0; v < 4; ++v) {
      if (shares[t][v] == 0) continue;
      const std::size_t at =
          pca.clusters[vectors[t]] * tables->views.size() + static_cast<std::size_t>(views.nodes[v]);
      albedo += shares[t][v] * color_of(pca, vectors[t], tables->sky.data() + at * colors);
    }
  }
  return albedo.cwiseMax(0.0f);
}

}  // namespace recede::detail
