#include <recede/geometry/error.h>
#include <recede/lod/detail/masked_area.h>
#include <recede/render/billboard_reflectance.h>
#include <recede/render/detail/half_numbers.h>
#include <recede/render/detail/texel_light.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace recede {
namespace {

using detail::SidedTexel;
using detail::TexelLight;

void check(const BillboardReflectanceOptions& options) {
  const auto in_range = [](const char* what, int value, int least, int most) {
    if (value < least || value > most)
      throw OptionError(
          fmt::format("reflectance of billboards: {} {} to {}, not {}", what, least, most, value));
  };
  in_range("views a side", options.view_side, 1, 32);
  in_range("lights a side", options.light_side, 1, 32);
  in_range("samples along a texel's side", options.samples, 1, 16);
  in_range("shaded samples", options.shaded, 1, 256);
  in_range("bounces", options.bounces, 0, 16);
  if (!(options.largest_share > 0)) throw OptionError("reflectance of billboards takes a share above 0");
  if (!(options.memory >= 0))
    throw OptionError("reflectance of billboards takes a memory of 0 bytes or more");
}

void check(const PolygonSoup& model, const BillboardCloud& cloud, const BillboardTextures& textures) {
  if (cloud.is_impostor)
    throw InputError("impostors have no reflectance: their billboards are seen from in front only");
  const auto faces_of = [](const Billboard& billboard) -> const std::vector<Index>& {
    return billboard.faces;
  };
  if (textures.billboards.empty() || textures.places.size() != textures.billboards.size() ||
      !std::ranges::equal(textures.billboards, cloud.billboards, {}, faces_of, faces_of))
    throw InputError("these textures aren't those of the billboard cloud");
  for (const Billboard& billboard : cloud.billboards) {
    if (billboard.faces.empty())
      throw InputError("a billboard cloud that was read doesn't know its faces: it has no reflectance");
    if (billboard.faces.back() >= model.n_faces())
      throw InputError("the billboard cloud isn't one of this model");
  }
}

// Of all texels of a cloud from all sides and views: by side, billboard and texel, and then by view.
class Opacities {
 public:
  Opacities(const TexelLight& light, const BillboardTextures& textures, int n_sides, std::size_t n_views,
            Progress* progress)
      : textures_(textures), n_views_(n_views) {
    std::size_t n = 0;
    for (int side = 0; side < n_sides; ++side) {
      for (const BillboardPlace& place : textures.places) {
        first_.push_back(n);
        n += static_cast<std::size_t>(place.width) * static_cast<std::size_t>(place.height);
      }
    }
    values_.assign(n * n_views, 0.0f);
    const std::size_t count = textures.places.size(), n_jobs = static_cast<std::size_t>(n_sides) * count;
    constexpr std::size_t k_at_once = 16;  // between two reports
    for (std::size_t first = 0; first < n_jobs; first += k_at_once) {
      report_progress(progress, "opacity by view", static_cast<double>(first) / static_cast<double>(n_jobs));
      const std::size_t jobs = std::min(k_at_once, n_jobs - first);
      tbb::parallel_for(std::size_t{0}, jobs * n_views,
                        [&](std::size_t i) { see(light, first + i / n_views, i % n_views); });
    }
  }

  // Calls work(texel, its opacities) for those that show something from some view.
  template <typename Work>
  void for_each_shown(const Work& work) const {
    const std::size_t count = textures_.places.size();
    for (std::size_t job = 0; job < first_.size(); ++job) {
      const BillboardPlace& place = textures_.places[job % count];
      for (int y = 0; y < place.height; ++y) {
        for (int x = 0; x < place.width; ++x) {
          const float* values = values_.data() + at(job, x, y) * n_views_;
          if (std::any_of(values, values + n_views_, [](float value) { return value > 0; }))
            work(SidedTexel{static_cast<std::uint32_t>(job % count), job >= count, x, y}, values);
        }
      }
    }
  }

 private:
  std::size_t at(std::size_t job, int x, int y) const {
    const BillboardPlace& place = textures_.places[job % textures_.places.size()];
    return first_[job] + static_cast<std::size_t>(y * place.width + x);
  }

  void see(const TexelLight& light, std::size_t job, std::size_t view) {
    const std::size_t count = textures_.places.size();
    const BillboardPlace& place = textures_.places[job % count];
    std::vector<float> opacity;
    for (int y = 0; y < place.height; ++y) {
      for (int x = 0; x < place.width; ++x)
        opacity.push_back(
            light.coverage({static_cast<std::uint32_t>(job % count), job >= count, x, y}, view));
    }
    detail::keep_thin_parts(opacity, place.width, place.height);
    for (std::size_t i = 0; i < opacity.size(); ++i)
      values_[(first_[job] + i) * n_views_ + view] = opacity[i];
  }

  const BillboardTextures& textures_;
  std::size_t n_views_;
  std::vector<std::size_t> first_;  // texel, of each side of each billboard
  std::vector<float> values_;
};

// Makes vectors when they are read, and keeps as many as there is room for.
class RadianceVectors {
 public:
  RadianceVectors(const TexelLight& light, const std::vector<SidedTexel>& texels,
                  const std::vector<std::uint8_t>& opacities, std::size_t n_views, std::size_t n_lights,
                  double memory)
      : light_(light), texels_(texels), opacities_(opacities), n_views_(n_views), per_view_(3 * n_lights) {
    const double room = memory / (2 * static_cast<double>(dimension()));
    const auto n = static_cast<std::size_t>(std::min(room, static_cast<double>(texels.size())));
    kept_.resize(n * dimension());
    is_kept_.assign(n, 0);
  }

  std::size_t dimension() const { return n_views_ * per_view_; }

  VectorSource source() {
    return {.count = texels_.size(),
            .dimension = dimension(),
            .read = [this](std::size_t first, std::span<float> values) { read(first, values); }};
  }

 private:
  void read(std::size_t first, std::span<float> values) {
    const std::size_t count = values.size() / dimension();
    std::vector<std::size_t> missing;
    for (std::size_t i = 0; i < count; ++i) {
      if (first + i >= is_kept_.size() || is_kept_[first + i] == 0) missing.push_back(i);
    }
    tbb::parallel_for(std::size_t{0}, missing.size() * n_views_, [&](std::size_t job) {
      const std::size_t i = missing[job / n_views_], view = job % n_views_;
      float* into = values.data() + i * dimension() + view * per_view_;
      std::fill(into, into + per_view_, 0.0f);
      light_.add_radiance(texels_[first + i], view, static_cast<std::uint32_t>(first + i), into);
    });
    for (const std::size_t i : missing) complete(first + i, values.subspan(i * dimension(), dimension()));
    for (std::size_t i = 0; i < count; ++i) {
      if (first + i < is_kept_.size()) keep(first + i, values.subspan(i * dimension(), dimension()));
    }
  }

  // Views without anything get the mean of the others: as halves, as which they are kept.
  void complete(std::size_t vector, std::span<float> values) const {
    const std::uint8_t* opacity = opacities_.data() + vector * n_views_;
    std::vector<float> mean(per_view_, 0.0f);
    float sum = 0;
    for (std::size_t view = 0; view < n_views_; ++view) {
      const float covered = opacity[view];
      sum += covered;
      for (std::size_t k = 0; k < per_view_; ++k) mean[k] += covered * values[view * per_view_ + k];
    }
    for (std::size_t view = 0; view < n_views_; ++view) {
      if (opacity[view] > 0) continue;
      for (std::size_t k = 0; k < per_view_; ++k) values[view * per_view_ + k] = mean[k] / sum;
    }
    for (float& value : values) value = detail::from_half(detail::to_half(value));
  }

  void keep(std::size_t vector, std::span<float> values) {
    std::uint16_t* halves = kept_.data() + vector * dimension();
    if (is_kept_[vector] != 0) {
      std::transform(halves, halves + dimension(), values.begin(), detail::from_half);
    } else {
      std::transform(values.begin(), values.end(), halves, detail::to_half);
      is_kept_[vector] = 1;
    }
  }

  const TexelLight& light_;
  const std::vector<SidedTexel>& texels_;
  const std::vector<std::uint8_t>& opacities_;
  std::size_t n_views_, per_view_;
  std::vector<std::uint16_t> kept_;
  std::vector<char> is_kept_;
};

std::uint8_t byte_of(float share) { return static_cast<std::uint8_t>(std::lround(255 * share)); }

// Fewer clusters where they would take too much.
LocalPcaOptions within(double most_bytes, LocalPcaOptions options, std::size_t count, std::size_t dimension) {
  const double per_vector = 2 + 2 * static_cast<double>(options.components);
  const double per_cluster = 2 * static_cast<double>(dimension) * (options.components + 1);
  const double room = (most_bytes - per_vector * static_cast<double>(count)) / per_cluster;
  options.clusters = static_cast<int>(std::min(static_cast<double>(options.clusters), std::max(1.0, room)));
  return options;
}

std::size_t bytes_besides(const BillboardReflectance& reflectance) {
  return reflectance.opacity.size() + sizeof(std::uint32_t) * reflectance.vectors.size();
}

}  // namespace

std::size_t bytes(const BillboardReflectance& reflectance) {
  return bytes(reflectance.radiance) + bytes_besides(reflectance);
}

std::size_t raw_bytes(const BillboardReflectance& reflectance) {
  const std::size_t n_colors = 3 * reflectance.views().size() * reflectance.lights().size();
  return 2 * n_colors * (reflectance.opacity.size() / reflectance.views().size()) +
         reflectance.opacity.size();
}

BillboardReflectance make_billboard_reflectance(const PolygonSoup& model, const BillboardCloud& cloud,
                                                const BillboardTextures& textures,
                                                const BillboardReflectanceOptions& options,
                                                Progress* progress) {
  check(options);
  check(model, cloud, textures);
  BillboardReflectance result{.view_side = options.view_side,
                              .light_side = options.light_side,
                              .width = textures.color.width,
                              .height = textures.color.height,
                              .is_two_sided = cloud.is_two_sided};
  BillboardCloud turned = cloud;
  turned.billboards = textures.billboards;
  const TexelLight light(model, turned, textures, options);
  const int n_sides = cloud.is_two_sided ? 2 : 1;
  const std::size_t n_views = result.views().size(), n_lights = result.lights().size();

  std::vector<SidedTexel> texels;
  const auto n_of_atlas = static_cast<std::size_t>(result.width) * static_cast<std::size_t>(result.height);
  result.vectors.assign(static_cast<std::size_t>(n_sides) * n_of_atlas, BillboardReflectance::k_none);
  Opacities(light, textures, n_sides, n_views, progress)
      .for_each_shown([&](const SidedTexel& texel, const float* values) {
        const BillboardPlace& place = textures.places[texel.billboard];
        const auto at = static_cast<std::size_t>(place.y + texel.y) * static_cast<std::size_t>(result.width) +
                        static_cast<std::size_t>(place.x + texel.x);
        result.vectors[(texel.is_back ? n_of_atlas : 0) + at] = static_cast<std::uint32_t>(texels.size());
        texels.push_back(texel);
        std::transform(values, values + n_views, std::back_inserter(result.opacity), byte_of);
      });
  if (texels.empty()) throw InputError("billboards that show nothing have no reflectance");

  RadianceVectors vectors(light, texels, result.opacity, n_views, n_lights, options.memory);
  const VectorSource radiance = vectors.source();
  const double most_bytes = options.largest_share * static_cast<double>(raw_bytes(result)) -
                            static_cast<double>(bytes_besides(result));
  result.radiance = make_local_pca(
      radiance, within(most_bytes, options.radiance, radiance.count, radiance.dimension), progress);
  result.error = measure_error(result.radiance, radiance);
  return result;
}

}  // namespace recede
