// What texels of a level can't know, as how holes line up for rays that cross them, is measured: rays through
// the finest level against rays through the matter.
#include <recede/geometry/detail/hashed_number.h>
#include <recede/shells/detail/empty_regions.h>
#include <recede/shells/detail/matter_calibration.h>
#include <recede/shells/detail/matter_path.h>
#include <recede/shells/detail/volume_sampler.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace recede::detail {

namespace {

// Squared: rays of a direction. Flat ones pass more of the layer, and differ less; straight ones are the same
// in all columns.
int rays_along(const Vec3& direction) {
  const double height = std::abs(direction.z());
  return height == 1 ? 60 : std::max(6, static_cast<int>(22 * std::sqrt(height)));
}

constexpr double k_degree = std::numbers::pi / 180;
constexpr std::size_t k_rows = MatterDirections::k_elevations.size(),
                      k_directions = k_rows * static_cast<std::size_t>(MatterDirections::k_columns);

// In lengths of the texture's extent.
Vec3 direction_of(std::size_t number) {
  const auto column = static_cast<int>(number % MatterDirections::k_columns);
  const double elevation = k_degree * MatterDirections::k_elevations[number / MatterDirections::k_columns],
               turn = 2 * std::numbers::pi * column / MatterDirections::k_columns;
  return {std::cos(elevation) * std::cos(turn), std::cos(elevation) * std::sin(turn), std::sin(elevation)};
}

/// `measure(d)` of all directions in parallel; straight ones are the same in all columns.
template <typename Value, typename Measure>
std::vector<Value> for_directions(Measure&& measure) {
  std::vector<Value> values(k_directions);
  const auto first_column = [](std::size_t d) { return d - d % MatterDirections::k_columns; };
  const auto is_repeated = [&](std::size_t d) {
    return d != first_column(d) &&
           std::abs(MatterDirections::k_elevations[d / MatterDirections::k_columns]) == 90;
  };
  tbb::parallel_for(std::size_t{0}, k_directions, [&](std::size_t d) {
    if (!is_repeated(d)) values[d] = measure(d);
  });
  for (std::size_t d = 0; d < k_directions; ++d) {
    if (is_repeated(d)) values[d] = values[first_column(d)];
  }
  return values;
}

// Places evenly over a period, each somewhere in its cell, and as much of a texel to the side as pictures
// take.
struct Start {
  double s, t, shift_s, shift_t;
};

Start start_of(int ray, int along) {
  const auto key = static_cast<std::uint64_t>(ray) << 32;
  return {(ray % along + hashed_number(key, 0)) / along, (ray / along + hashed_number(key, 1)) / along,
          hashed_number(key, 2) - 0.5, hashed_number(key, 3) - 0.5};
}

// A ray through the whole layer.
struct LayerRay {
  Vec3 from, across;  // places

  LayerRay(const Start& start, const Vec3& direction, const Vec3& extent) {
    const Vec3 rate = direction.cwiseQuotient(extent);
    across = rate / std::abs(rate.z());
    from = Vec3(start.s, start.t, direction.z() > 0 ? 0 : 1) - Vec3(across.x() / 2, across.y() / 2, 0);
  }
  Vec3 at(double share) const { return from + share * across; }
};

Vec3 size_of(const std::array<int, 3>& size) { return {size[0] * 1.0, size[1] * 1.0, size[2] * 1.0}; }

Vec3 surface_normal(const VolumeTexture& texture, const Vec3& place, const Vec3& direction) {
  const Vec3 normal = -opacity_gradient(texture, place).cwiseQuotient(texture.extent);
  return normal.squaredNorm() > 0 ? Vec3(normal.normalized()) : Vec3(-direction);
}

}  // namespace

std::vector<SeenLayer> measure_layer(const VolumeTexture& texture) {
  const EmptyRegions empty(texture);
  return for_directions<SeenLayer>([&](std::size_t d) -> SeenLayer {
    const Vec3 direction = direction_of(d);
    // Colours and normals differ much at the finest level; what its rays cost is little beside those of
    // matter.
    constexpr int k_finer = 3;
    const int along = k_finer * rays_along(direction);
    double hits = 0;
    Vec3 normal = Vec3::Zero(), color = Vec3::Zero();
    for (int r = 0; r < along * along; ++r) {
      const LayerRay ray(start_of(r, along), direction, texture.extent);
      const int steps =
          1 + static_cast<int>(ray.across.cwiseProduct(size_of(texture.size)).cwiseAbs().maxCoeff());
      for (int n = 0; n < steps; ++n) {
        const Vec3 place = ray.at((n + 0.5) / steps);
        if (sampled_opacity(texture, place) < 0.5) {
          n += static_cast<int>(std::min(empty.free_length(place, ray.across), 1.0) * steps);
          continue;
        }
        ++hits;
        normal += surface_normal(texture, place, direction);
        color += texture.colors.empty() ? Vec3(Vec3::Ones()) : sampled_color(texture, place);
        break;
      }
    }
    if (!(hits > 0)) return {0, -direction};
    return {hits / (along * along), normal / hits, color / hits};
  });
}

namespace {

struct Step {
  double depth;  // -log of the share that goes on, so far
  Vec3 normal, color;
};

/// What texels add once they stop a ray of one direction.
class SeenTexels {
 public:
  SeenTexels(const TransparentVolume& matter, const Vec3& direction)
      : matter_(matter), direction_(direction) {
    // Of larger levels few texels are met twice.
    constexpr std::size_t k_most_kept = std::size_t{1} << 20;
    if (matter.normals.n_texels() <= k_most_kept) normals_.resize(matter.normals.n_texels());
  }

  Vec3 normal(const std::array<int, 3>& texel) {
    if (normals_.empty()) {
      if (texel != last_) last_normal_ = made(texel);
      last_ = texel;
      return last_normal_;
    }
    const std::array<int, 3>& size = matter_.size;
    std::optional<Vec3>& kept =
        normals_[static_cast<std::size_t>(texel[0] + size[0] * (texel[1] + size[1] * texel[2]))];
    if (!kept) kept = made(texel);
    return *kept;
  }
  // Linear light; white without colours.
  Vec3 color(const std::array<int, 3>& texel) const {
    if (matter_.colors.empty()) return Vec3::Ones();
    const std::array<std::uint8_t, 3>& bytes = matter_.colors.at(texel);
    return {linear_[bytes[0]], linear_[bytes[1]], linear_[bytes[2]]};
  }

 private:
  Vec3 made(const std::array<int, 3>& texel) const {
    return mean_normal_along(normal_matrix(matter_.normals.at(texel)), direction_);
  }

  const TransparentVolume& matter_;
  Vec3 direction_;
  const std::array<double, 256>& linear_ = linear_of_bytes();
  std::vector<std::optional<Vec3>> normals_;
  std::array<int, 3> last_{-1, -1, -1};
  Vec3 last_normal_ = Vec3::Zero();
};

// Of rays of one direction, one after the other.
std::vector<std::vector<Step>> pass_matter(const TransparentVolume& matter, const VolumeTexture& finest,
                                           const Vec3& direction) {
  std::vector<std::vector<Step>> rays;
  const Vec3 size = size_of(matter.size);
  const int along = rays_along(direction);
  SeenTexels texels(matter, direction);
  for (int r = 0; r < along * along; ++r) {
    const Start start = start_of(r, along);
    LayerRay ray(start, direction, finest.extent);
    ray.from += Vec3(start.shift_s / size.x(), start.shift_t / size.y(), 0);
    // As pictures take them: one more would give a texel more than its part.
    constexpr double k_rounding = 1e-9;
    const int steps = std::max(
        1,
        static_cast<int>(std::ceil(ray.across.cwiseProduct(size).norm() / MatterPath::k_step - k_rounding)));
    MatterPath path(matter, finest);
    std::vector<Step>& passed = rays.emplace_back();
    double before = 0;
    for (int n = 0; n < steps; ++n) {
      const double stopped = path.advance(ray.at((n + 0.5) / steps), ray.across / steps);
      if (stopped <= before) continue;
      before = stopped;
      passed.push_back({-std::log(1 - stopped), texels.normal(path.texel()), texels.color(path.texel())});
    }
  }
  return rays;
}

// Share of the rays that is stopped.
double opacity_with(const std::vector<std::vector<Step>>& rays, double density) {
  double opacity = 0;
  for (const std::vector<Step>& ray : rays) {
    double before = 0;
    for (const Step& step : ray) {
      const double stopped = 1 - std::exp(-density * step.depth);
      opacity += stopped - before;
      before = stopped;
    }
  }
  return opacity / static_cast<double>(rays.size());
}

SeenLayer seen_with(const std::vector<std::vector<Step>>& rays, double density) {
  double opacity = 0;
  Vec3 normal = Vec3::Zero(), color = Vec3::Zero();
  for (const std::vector<Step>& ray : rays) {
    double before = 0;
    for (const Step& step : ray) {
      const double stopped = 1 - std::exp(-density * step.depth), part = stopped - before;
      opacity += part;
      normal += part * step.normal;
      color += part * step.color;
      before = stopped;
    }
  }
  if (!(opacity > 0)) return {0, normal};
  return {opacity / static_cast<double>(rays.size()), normal / opacity, color / opacity};
}

}  // namespace

void calibrate(const VolumeTexture& finest, const std::vector<SeenLayer>& exact, TransparentVolume& matter) {
  matter.corrections = for_directions<MatterCorrection>([&](std::size_t d) -> MatterCorrection {
    const std::vector<std::vector<Step>> rays = pass_matter(matter, finest, direction_of(d));
    // Opacity rises with density; a factor of 8 either way makes nearly all of what can be made.
    double low = 1.0 / 8, high = 8;
    for (int round = 0; round < 12; ++round) {
      const double middle = std::sqrt(low * high);
      (opacity_with(rays, middle) < exact[d].opacity ? low : high) = middle;
    }
    const double density = std::sqrt(low * high);
    const SeenLayer seen = seen_with(rays, density);
    if (!(seen.opacity > 0)) return {density};
    return {density, exact[d].normal - seen.normal,
            (seen.color.array() > 0).select(exact[d].color.cwiseQuotient(seen.color), Vec3::Ones())};
  });
}

}  // namespace recede::detail

namespace recede {

MatterCorrection TransparentVolume::correction_along(const Vec3& direction) const {
  using Directions = MatterDirections;
  if (corrections.empty()) return {};
  const double elevation = std::asin(std::clamp(direction.z(), -1.0, 1.0)) / detail::k_degree;
  const auto above =
      std::upper_bound(Directions::k_elevations.begin() + 1, Directions::k_elevations.end() - 1, elevation);
  const auto row = static_cast<std::size_t>(above - Directions::k_elevations.begin()) - 1;
  const double v = (elevation - above[-1]) / (above[0] - above[-1]);
  const double turn = std::atan2(direction.y(), direction.x()) / (2 * std::numbers::pi);
  const double column = (turn < 0 ? turn + 1 : turn) * Directions::k_columns;
  const auto left = static_cast<std::size_t>(column);
  const double u = column - static_cast<double>(left);
  MatterCorrection sum{0, Vec3::Zero(), Vec3::Zero()};
  const auto add = [&](double weight, std::size_t i, std::size_t j) {
    const MatterCorrection& correction = corrections[i * Directions::k_columns + j % Directions::k_columns];
    sum.density += weight * std::log(correction.density);
    sum.normal += weight * correction.normal;
    sum.color += weight * correction.color;
  };
  add((1 - v) * (1 - u), row, left);
  add((1 - v) * u, row, left + 1);
  add(v * (1 - u), row + 1, left);
  add(v * u, row + 1, left + 1);
  sum.density = std::exp(sum.density);
  return sum;
}

}  // namespace recede
