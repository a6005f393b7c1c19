#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/detail/map_surface.h>
#include <recede/lod/displacement_bake.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

using detail::MapPlace;
using detail::MapTriangles;

/// Small triangles of one large one: points in rows from its first corner to the opposite side.
class Dicer {
 public:
  Dicer(const BakedMaps& maps, bool displace, int parts)
      : maps_(maps),
        triangles_(maps),
        displace_(displace && !maps.displacement.samples.empty()),
        parts_(static_cast<std::size_t>(parts)) {}

  PolygonSoup run() {
    const std::size_t n_points = (parts_ + 1) * (parts_ + 2) / 2, n_small = parts_ * parts_;
    const std::size_t n = triangles_.size();
    soup_.positions.resize(n * n_points);
    soup_.corner_vertices.resize(3 * n * n_small);
    soup_.corner_uvs.resize(3 * n * n_small);
    if (!maps_.normal.samples.empty()) soup_.corner_normals.resize(3 * n * n_small);
    soup_.face_offsets.resize(n * n_small + 1);
    for (std::size_t f = 0; f < soup_.face_offsets.size(); ++f)
      soup_.face_offsets[f] = static_cast<Index>(3 * f);
    tbb::parallel_for(std::size_t{0}, n, [&](std::size_t t) { dice(t, t * n_points, 3 * t * n_small); });
    return std::move(soup_);
  }

 private:
  struct Point {
    Vec3 position, normal;
    Vec2 uv;
  };

  Point point_at(std::size_t t, std::size_t row, std::size_t column) const {
    const double n = static_cast<double>(parts_);
    const Vec3 weights(double(parts_ - row) / n, double(row - column) / n, double(column) / n);
    const MapPlace place = triangles_.at(t, weights);
    Point point{place.position, place.normal, Vec2::Zero()};
    for (std::size_t k = 0; k < 3; ++k)
      point.uv += weights[static_cast<Eigen::Index>(k)] * triangles_.uv(t, k);
    if (displace_) point.position += maps_.height_at(point.uv) * place.normal;
    if (!maps_.normal.samples.empty()) {
      const Vec3 mapped = maps_.normal_at(point.uv);
      point.normal = (mapped.x() * place.tangent + mapped.y() * place.bitangent + mapped.z() * place.normal)
                         .stableNormalized();
    }
    return point;
  }

  void dice(std::size_t t, std::size_t first_point, std::size_t first_corner) {
    std::vector<Point> points;
    for (std::size_t row = 0; row <= parts_; ++row) {
      for (std::size_t column = 0; column <= row; ++column) points.push_back(point_at(t, row, column));
    }
    for (std::size_t i = 0; i < points.size(); ++i) soup_.positions[first_point + i] = points[i].position;
    std::size_t corner = first_corner;
    const auto add = [&](std::size_t i) {
      soup_.corner_vertices[corner] = static_cast<Index>(first_point + i);
      soup_.corner_uvs[corner] = points[i].uv;
      if (!soup_.corner_normals.empty()) soup_.corner_normals[corner] = points[i].normal;
      ++corner;
    };
    for (std::size_t row = 0; row < parts_; ++row) {
      const std::size_t above = row * (row + 1) / 2, below = above + row + 1;
      for (std::size_t column = 0; column <= row; ++column) {
        for (const std::size_t i : {above + column, below + column, below + column + 1}) add(i);
        if (column == row) break;
        for (const std::size_t i : {above + column, below + column + 1, above + column + 1}) add(i);
      }
    }
  }

  const BakedMaps& maps_;
  MapTriangles triangles_;
  bool displace_;
  std::size_t parts_;
  PolygonSoup soup_;
};

double covered_texels(const MapTriangles& triangles, int size) {
  double area = 0;  // of the unit square, doubled
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec2 a = triangles.uv(t, 1) - triangles.uv(t, 0), b = triangles.uv(t, 2) - triangles.uv(t, 0);
    area += std::abs(a.x() * b.y() - a.y() * b.x());
  }
  return 0.5 * area * size * size;
}

}  // namespace

PolygonSoup dice_surface(const BakedMaps& maps, const DiceOptions& options) {
  if (options.parts < 0) throw OptionError("a triangle's side has no negative number of parts");
  int parts = options.parts;
  if (parts == 0) {
    constexpr double k_most = 1e6;
    const MapTriangles triangles(maps);
    const auto n = static_cast<double>(std::max<std::size_t>(triangles.size(), 1));
    const double wanted = std::min(k_most, 2 * covered_texels(triangles, maps.size));
    parts = std::max(1, static_cast<int>(std::sqrt(wanted / n)));
  }
  return Dicer(maps, options.displace, parts).run();
}

MapAccuracy measure_maps(const PolygonSoup& fine, const BakedMaps& maps, Progress* progress) {
  const DistanceMeter meter(fine);
  const MeshDistance bare = meter.to(maps.surface, {}, progress);
  const MeshDistance displaced = meter.to(dice_surface(maps), {}, progress);
  return {bare.max, bare.rms, displaced.max, displaced.rms};
}

}  // namespace recede
