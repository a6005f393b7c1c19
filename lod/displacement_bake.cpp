#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/texture.h>
#include <recede/lod/detail/fine_surface.h>
#include <recede/lod/detail/map_seams.h>
#include <recede/lod/detail/map_texels.h>
#include <recede/lod/displacement_bake.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace recede {
namespace {

using detail::FineSurface;
using detail::MapPlace;
using Vec3f = Eigen::Vector3f;

void require(bool condition, const char* text) {
  if (!condition) throw OptionError(text);
}

void check(const PolygonSoup& fine, const PolygonSoup& coarse, const MapOptions& options) {
  constexpr int k_largest = 16384;
  require(options.displacement || options.normal || options.color, "at least one map must be asked for");
  require(options.size >= 4 && options.size <= k_largest, "maps have 4 to 16384 texels a side");
  require(options.normal_bits == 8 || options.normal_bits == 16, "normal maps have 8 or 16 bits");
  require(
      !options.search_distance || (std::isfinite(*options.search_distance) && *options.search_distance > 0),
      "the search distance must be positive");
  require(!options.seam_weight || (std::isfinite(*options.seam_weight) && *options.seam_weight >= 0),
          "the seam weight must not be negative");
  validate(fine, "fine surface");
  validate(coarse, "coarse surface");
  if (fine.n_faces() == 0 || coarse.n_faces() == 0) throw InputError("maps need surfaces with faces");
}

std::uint16_t quantised(double value, int bits) {
  const double most = static_cast<double>((1 << bits) - 1);
  return static_cast<std::uint16_t>(std::lround(std::clamp(value, 0.0, 1.0) * most));
}

/// As a lookup reads it in the middle of a texel.
double height_of(const BakedMaps& maps, Index texel) {
  if (!maps.float_displacement.samples.empty()) return maps.float_displacement.samples[texel];
  return maps.height_offset + maps.height_scale * maps.displacement.samples[texel] / 65535;
}

/// Coded from 0 to 1.
Vec3 normal_of(const BakedMaps& maps, Index texel) {
  const std::size_t first = 3 * std::size_t{texel};
  if (!maps.float_normal.samples.empty()) {
    const float* samples = &maps.float_normal.samples[first];
    return {samples[0], samples[1], samples[2]};
  }
  const std::uint16_t* samples = &maps.normal.samples[first];
  return Vec3(samples[0], samples[1], samples[2]) / ((1 << maps.normal.bits) - 1);
}

/// A normal of object space in the frame of a place. glTF's normals don't point below the surface.
Vec3 to_tangent_space(const MapPlace& point, const Vec3& normal) {
  Eigen::Matrix3d frame;
  frame << point.tangent, point.bitangent, point.normal;
  constexpr double k_flat = 1e-3;  // volume of the frame's unit vectors
  if (std::abs(frame.determinant()) < k_flat) return Vec3::UnitZ();
  Vec3 result = frame.inverse() * normal;
  result.z() = std::max(result.z(), 0.0);
  const double length = result.norm();
  return length > 0 ? Vec3(result / length) : Vec3(Vec3::UnitZ());
}

class Baker {
 public:
  Baker(const PolygonSoup& fine, const PolygonSoup& coarse, const MapOptions& options, Progress* progress)
      : options_(options), progress_(progress) {
    maps_.size = options.size;
    prepare_surface(coarse);
    report_progress(progress, "look at the fine surface", 0);
    maps_.report.search_distance = options.search_distance ? *options.search_distance : reach(fine, coarse);
  }

  BakedMaps run(const PolygonSoup& fine) {
    const FineSurface surface(fine);
    const detail::MapTriangles triangles(maps_);
    owners_ = detail::own_texels(triangles, options_.size);
    bake_texels(triangles, surface);
    report_progress(progress_, "close seams", 0);
    if (options_.displacement) finish_heights();
    if (!normals_.empty()) finish_normals();
    if (!colors_.empty()) finish_colors();
    report_progress(progress_, "close seams", 1);
    return std::move(maps_);
  }

 private:
  void prepare_surface(const PolygonSoup& coarse) {
    maps_.surface = coarse;
    maps_.report.atlas_reason = detail::why_not_one_to_one(coarse);
    if (!maps_.report.atlas_reason.empty()) {
      PolygonSoup joined = coarse;
      merge_identical_vertices(joined);
      AtlasOptions atlas = options_.atlas;
      atlas.packing.resolution = options_.size;
      maps_.surface.corner_uvs = make_atlas(joined, atlas, progress_).soup.corner_uvs;
      drop_textures(maps_.surface.materials);
    }
    maps_.surface.corner_normals = detail::point_normals(maps_.surface);
    maps_.corner_tangents = detail::tangents_of(maps_.surface);
  }

  static double reach(const PolygonSoup& fine, const PolygonSoup& coarse) {
    constexpr std::size_t k_samples = 20'000;
    constexpr double k_least = 1e-6;  // of the diagonal: equal surfaces find each other in spite of rounding
    const MeshDistance distance = measure_distance(fine, coarse, {.samples = k_samples});
    const double least = std::max(k_least * distance.diagonal, std::numeric_limits<double>::min());
    return std::max(MapOptions::k_reach * distance.max, least);
  }

  void bake_texels(const detail::MapTriangles& triangles, const FineSurface& surface) {
    const auto side = static_cast<std::size_t>(options_.size);
    heights_.assign(side * side, 0);
    if (options_.normal) normals_.assign(side * side, Vec3f::Zero());
    if (options_.color && surface.attributes().has_colors()) colors_.assign(side * side, Vec3f::Zero());
    std::vector<std::size_t> inside(side, 0), missed(side, 0);
    constexpr std::size_t k_batch = 64;  // rows between reports
    for (std::size_t begin = 0; begin < side; begin += k_batch) {
      report_progress(progress_, "bake maps", double(begin) / double(side));
      tbb::parallel_for(begin, std::min(begin + k_batch, side), [&](std::size_t row) {
        for (std::size_t texel = row * side; texel < (row + 1) * side; ++texel) {
          if (owners_.triangles[texel] == k_no_index) continue;
          const bool miss = bake_texel(triangles, surface, texel);
          if (owners_.inside[texel] == 0) continue;
          ++inside[row];
          missed[row] += miss ? 1 : 0;
        }
      });
    }
    for (std::size_t row = 0; row < side; ++row) {
      maps_.report.texels += inside[row];
      maps_.report.missed += missed[row];
    }
  }

  /// Returns whether the line met nothing.
  bool bake_texel(const detail::MapTriangles& triangles, const FineSurface& surface, std::size_t texel) {
    const std::size_t t = owners_.triangles[texel];
    const MapPlace point = triangles.at(t, weights_for(triangles, t, texel));
    const FineSurface::Place place = surface.over(point, maps_.report.search_distance);
    heights_[texel] = place.height;
    if (!normals_.empty())
      normals_[texel] = to_tangent_space(point, surface.attributes().normal_at(place)).cast<float>();
    if (!colors_.empty()) {
      const double width = triangles.texel_width(t, options_.size);
      colors_[texel] = surface.attributes().color_at(place, width).cast<float>();
    }
    return place.missed;
  }

  /// Texels beside a triangle take its nearest point. To continue the triangle instead is a little nearer on
  /// smooth surfaces, but leaves sharp edges where both surfaces have one.
  Vec3 weights_for(const detail::MapTriangles& triangles, std::size_t t, std::size_t texel) const {
    const Vec2 uv = detail::uv_of_texel(texel, options_.size);
    if (owners_.inside[texel] != 0) return triangles.weights(t, uv);
    const auto flat = [](const Vec2& p) { return Vec3(p.x(), p.y(), 0); };
    const Triangle triangle{flat(triangles.uv(t, 0)), flat(triangles.uv(t, 1)), flat(triangles.uv(t, 2))};
    const Vec3 nearest = triangles.weights(t, closest_point_on_triangle(flat(uv), triangle).head<2>());
    return nearest.cwiseMax(0.0) / nearest.cwiseMax(0.0).sum();
  }

  std::vector<char> known_texels() const {
    std::vector<char> known(owners_.triangles.size());
    std::transform(owners_.triangles.begin(), owners_.triangles.end(), known.begin(),
                   [](Index triangle) { return triangle == k_no_index ? 0 : 1; });
    return known;
  }

  void finish_heights() {
    const std::vector<detail::Seam> seams = detail::find_seams(maps_.surface);
    maps_.report.seam_edges = seams.size();
    maps_.report.seam_difference_before =
        detail::largest_difference(seams, options_.size, [&](Index texel) { return heights_[texel]; });
    close_seams(seams);
    detail::fill_holes(heights_, known_texels(), options_.size, options_.size);
    const auto [low, high] = std::minmax_element(heights_.begin(), heights_.end());
    maps_.height_offset = *low;
    maps_.height_scale = *high - *low;
    const double scale = maps_.height_scale > 0 ? maps_.height_scale : 1;
    maps_.displacement = raster(1, 16);
    for (const double height : heights_)
      maps_.displacement.samples.push_back(quantised((height - maps_.height_offset) / scale, 16));
    if (!options_.seam_weight) detail::repair_samples(seams, options_.size, maps_.displacement.samples);
    if (options_.format == MapFormat::exr) maps_.float_displacement = float_raster({"Y"}, heights_);
    maps_.report.seam_difference = detail::largest_difference(
        seams, options_.size, [&](Index texel) { return height_of(maps_, texel); });
  }

  void close_seams(const std::vector<detail::Seam>& seams) {
    // Texels beside charts show less than those inside, so they change more easily.
    constexpr double k_cost_outside = 0.1;
    std::vector<double> costs(heights_.size(), k_cost_outside);
    for (std::size_t texel = 0; texel < costs.size(); ++texel) {
      if (owners_.inside[texel] != 0) costs[texel] = 1;
    }
    if (options_.seam_weight)
      return detail::close_seams(seams, options_.size, *options_.seam_weight, costs, heights_);
    // Half a step of the stored map; rounding adds about another, most of which `repair_samples` takes back.
    // Where closing makes the range of heights smaller, and with it the step, once more.
    constexpr double k_share = 0.5, k_enough = 0.6;
    constexpr int k_most_rounds = 4;
    for (int round = 0; round < k_most_rounds; ++round) {
      const double tolerance = k_share * step_of_heights();
      detail::close_seams_within(seams, options_.size, tolerance, costs, heights_);
      if (tolerance <= k_enough * step_of_heights()) return;
    }
  }

  /// Of 16 bits over the range of the texels that have a height.
  double step_of_heights() const {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t texel = 0; texel < heights_.size(); ++texel) {
      if (owners_.triangles[texel] == k_no_index) continue;
      low = std::min(low, heights_[texel]);
      high = std::max(high, heights_[texel]);
    }
    return high > low ? (high - low) / 65535 : 0;
  }

  void finish_normals() {
    detail::fill_holes(normals_, known_texels(), options_.size, options_.size);
    maps_.normal = raster(3, options_.normal_bits);
    std::vector<float> coded;
    for (const Vec3f& found : normals_) {
      const Vec3 normal = found.cast<double>().stableNormalized();
      for (const double value : normal) {
        maps_.normal.samples.push_back(quantised(0.5 * value + 0.5, options_.normal_bits));
        if (options_.format == MapFormat::exr) coded.push_back(static_cast<float>(0.5 * value + 0.5));
      }
    }
    if (!coded.empty()) maps_.float_normal = float_raster({"R", "G", "B"}, coded);
  }

  void finish_colors() {
    detail::fill_holes(colors_, known_texels(), options_.size, options_.size);
    maps_.color = raster(3, 8);
    maps_.color.srgb = true;
    for (const Vec3f& color : colors_) {
      for (const float value : color) maps_.color.samples.push_back(quantised(encode_srgb(value), 8));
    }
  }

  Raster raster(int channels, int bits) const {
    Raster result{
        .width = options_.size, .height = options_.size, .channels = channels, .bits = bits, .samples = {}};
    result.samples.reserve(heights_.size() * static_cast<std::size_t>(channels));
    return result;
  }

  template <typename Value>
  FloatRaster float_raster(std::vector<std::string> channels, const std::vector<Value>& values) const {
    FloatRaster result{options_.size, options_.size, std::move(channels), {}};
    result.samples.reserve(values.size());
    for (const Value value : values) result.samples.push_back(static_cast<float>(value));
    return result;
  }

  const MapOptions& options_;
  Progress* progress_;
  BakedMaps maps_;
  detail::TexelOwners owners_;
  std::vector<double> heights_;
  std::vector<Vec3f> normals_, colors_;
};

}  // namespace

BakedMaps bake_maps(const PolygonSoup& fine, const PolygonSoup& coarse, const MapOptions& options,
                    Progress* progress) {
  check(fine, coarse, options);
  const auto start = std::chrono::steady_clock::now();
  BakedMaps maps = Baker(fine, coarse, options, progress).run(fine);
  maps.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return maps;
}

double BakedMaps::height_at(const Vec2& uv) const {
  const detail::Footprint footprint = detail::footprint_of(uv, size);
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) sum += footprint.weights[k] * height_of(*this, footprint.texels[k]);
  return sum;
}

Vec3 BakedMaps::normal_at(const Vec2& uv) const {
  const detail::Footprint footprint = detail::footprint_of(uv, size);
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    sum += footprint.weights[k] * (2 * normal_of(*this, footprint.texels[k]) - Vec3::Ones());
  return sum.stableNormalized();
}

}  // namespace recede
