#include <recede/render/detail/sample_stream.h>
#include <recede/render/detail/texel_light.h>

#include <algorithm>

namespace recede::detail {

namespace {

std::vector<Vec3> directions_of(const DirectionGrid& grid) {
  std::vector<Vec3> directions;
  for (std::size_t node = 0; node < grid.size(); ++node) directions.push_back(grid.direction(node));
  return directions;
}

}  // namespace

Eigen::Matrix3d axes_of(const Billboard& billboard, bool is_back) {
  Eigen::Matrix3d axes;
  const double sign = is_back ? -1 : 1;
  axes << sign * billboard.axis_u, billboard.axis_v, sign * billboard.normal();
  return axes;
}

TexelLight::TexelLight(const PolygonSoup& model, const BillboardCloud& cloud,
                       const BillboardTextures& textures, const BillboardReflectanceOptions& options)
    : textures_(textures),
      options_(options),
      rays_(model, cloud),
      scene_(model),
      views_(directions_of({.side = options.view_side})),
      lights_(directions_of({.side = options.light_side, .whole_sphere = true})) {}

// Beside what the texture shows, only the billboard's own faces come into sight, which stand out of it.
bool TexelLight::shows_others(const SidedTexel& texel) const {
  const BillboardPlace& place = textures_.places[texel.billboard];
  return textures_.color.at(place.x + texel.x, place.y + texel.y, 3) > 0;
}

std::vector<TexelLight::Place> TexelLight::places_of(const SidedTexel& texel, std::size_t view,
                                                     const Vec3& viewer) const {
  const Billboard& billboard = textures_.billboards[texel.billboard];
  const BillboardPlace& place = textures_.places[texel.billboard];
  const bool with_others = shows_others(texel);
  std::vector<Place> places;
  for (int i = 0; i < options_.samples * options_.samples; ++i) {
    // The same places each time that the texel is asked for, in each view others.
    SampleStream numbers(place.x + texel.x, place.y + texel.y + (static_cast<int>(view) << 16),
                         static_cast<std::uint32_t>(i));
    const Vec2 inside = numbers.next_pair();
    const Vec2 at(2 * (texel.x + inside.x()) / place.width - 1,
                  1 - 2 * (texel.y + inside.y()) / place.height);
    const auto sample = rays_.sample_towards(texel.billboard, at.cwiseProduct(billboard.half_sizes), viewer);
    if (sample && (sample->is_own || with_others)) places.push_back({sample->place, i});
  }
  return places;
}

float TexelLight::coverage(const SidedTexel& texel, std::size_t view) const {
  const Vec3 viewer = axes_of(textures_.billboards[texel.billboard], texel.is_back) * views_[view];
  return static_cast<float>(places_of(texel, view, viewer).size()) /
         static_cast<float>(options_.samples * options_.samples);
}

Hit TexelLight::hit_at(const TrianglePlace& place) const {
  const MeshData& mesh = scene_.data().meshes.front();
  const std::array<std::uint32_t, 3>& corners = mesh.triangles[place.triangle];
  const Vec3 first = mesh.position(corners[1]) - mesh.position(corners[0]),
             second = mesh.position(corners[2]) - mesh.position(corners[0]);
  Hit hit;
  hit.part = {0, place.triangle};
  hit.u = static_cast<float>(place.weights[1]);
  hit.v = static_cast<float>(place.weights[2]);
  hit.front = first.cross(second).stableNormalized().cast<float>();
  return hit;
}

void TexelLight::add_light(const SurfacePoint& point, const Rgb& share, const std::vector<Vec3>& lights,
                           float* values) const {
  for (std::size_t light = 0; light < lights.size(); ++light) {
    const Rgb reflected = scattered(point, lights[light]).cwiseProduct(share);
    if (reflected.isZero(0) || occluded(scene_.data(), point.ray_towards(lights[light]))) continue;
    for (std::size_t k = 0; k < 3; ++k) values[3 * light + k] += reflected[static_cast<Eigen::Index>(k)];
  }
}

bool TexelLight::add_radiance(const SidedTexel& texel, std::size_t view, std::uint32_t number,
                              float* values) const {
  const Eigen::Matrix3d axes = axes_of(textures_.billboards[texel.billboard], texel.is_back);
  const Vec3 viewer = axes * views_[view];
  const std::vector<Place> places = places_of(texel, view, viewer);
  if (places.empty()) return false;
  std::vector<Vec3> lights;
  for (const Vec3& light : lights_) lights.emplace_back(axes * light);
  const std::size_t count = std::min(places.size(), static_cast<std::size_t>(options_.shaded));
  for (std::size_t i = 0; i < count; ++i) {
    const Place& place = places[i * places.size() / count];
    SampleStream numbers(static_cast<int>(number), static_cast<int>(view),
                         static_cast<std::uint32_t>(place.sample));
    Rgb share = Rgb::Constant(1 / static_cast<float>(count));
    Hit hit = hit_at(place.on_triangle);
    Vec3f along = (-viewer).cast<float>();
    for (int bounce = 0;; ++bounce) {
      const SurfacePoint point = surface_point(scene_.data(), hit, along);
      add_light(point, share, lights, values);
      ScatterSample scatter;
      if (bounce == options_.bounces || !sample_scattering(point, numbers.next_pair(), scatter)) break;
      share = share.cwiseProduct(scatter.weight);
      if (share.isZero(0) || !nearest_hit(scene_.data(), point.ray_towards(scatter.direction), hit)) break;
      along = scatter.direction.cast<float>();
    }
  }
  return true;
}

}  // namespace recede::detail
