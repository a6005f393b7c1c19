#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/raster.h>
#include <recede/lod/detail/map_surface.h>
#include <recede/lod/displacement_bake.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace recede {
namespace {

using detail::MapPlace;
using detail::MapTriangles;

// The points of a triangle stand in rows, from its first corner to the opposite side.

template <typename Take>
void for_points(std::size_t parts, const Take& take) {
  for (std::size_t row = 0; row <= parts; ++row) {
    for (std::size_t column = 0; column <= row; ++column) take(row, column);
  }
}

Vec3 weights_at(std::size_t parts, std::size_t row, std::size_t column) {
  return Vec3(double(parts - row), double(row - column), double(column)) / static_cast<double>(parts);
}

/// Small triangles of one large one.
class Dicer {
 public:
  Dicer(const BakedMaps& maps, const MapTriangles& triangles, bool displace, int parts)
      : maps_(maps),
        triangles_(triangles),
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
    const Vec3 weights = weights_at(parts_, row, column);
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
    for_points(parts_,
               [&](std::size_t row, std::size_t column) { points.push_back(point_at(t, row, column)); });
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
  const MapTriangles& triangles_;
  bool displace_;
  std::size_t parts_;
  PolygonSoup soup_;
};

/// Colours of the large triangles for the small ones, which are in their order.
class ColoredParts {
 public:
  ColoredParts(const PolygonSoup& surface, const MapTriangles& triangles, int parts)
      : surface_(surface), triangles_(triangles), parts_(static_cast<std::size_t>(parts)) {}

  void add_to(PolygonSoup& soup) const {
    soup.materials = surface_.materials;
    if (!surface_.face_materials.empty()) {
      soup.face_materials.reserve(soup.n_faces());
      for (std::size_t t = 0; t < triangles_.size(); ++t)
        soup.face_materials.insert(soup.face_materials.end(), parts_ * parts_, material_of(t));
    }
    if (surface_.vertex_colors.empty()) return;
    soup.vertex_colors.reserve(soup.positions.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) add_points(t, soup.vertex_colors);
  }

 private:
  Index material_of(std::size_t t) const {
    const auto& offsets = surface_.face_offsets;
    const auto after = std::upper_bound(offsets.begin(), offsets.end(), triangles_.corner(t, 0));
    return surface_.face_materials[static_cast<std::size_t>(after - offsets.begin()) - 1];
  }

  void add_points(std::size_t t, std::vector<Vec4>& colors) const {
    const auto color = [&](std::size_t k) -> const Vec4& {
      return surface_.vertex_colors[surface_.corner_vertices[triangles_.corner(t, k)]];
    };
    for_points(parts_, [&](std::size_t row, std::size_t column) {
      const Vec3 w = weights_at(parts_, row, column);
      colors.emplace_back(w.x() * color(0) + w.y() * color(1) + w.z() * color(2));
    });
  }

  const PolygonSoup& surface_;
  const MapTriangles& triangles_;
  std::size_t parts_;
};

double covered_texels(const MapTriangles& triangles, int size) {
  double area = 0;  // of the unit square, doubled
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const Vec2 a = triangles.uv(t, 1) - triangles.uv(t, 0), b = triangles.uv(t, 2) - triangles.uv(t, 0);
    area += std::abs(a.x() * b.y() - a.y() * b.x());
  }
  return 0.5 * area * size * size;
}

int parts_of(const MapTriangles& triangles, int size) {
  constexpr double k_most = 1e6;
  const auto n = static_cast<double>(std::max<std::size_t>(triangles.size(), 1));
  const double wanted = std::min(k_most, 2 * covered_texels(triangles, size));
  return std::max(1, static_cast<int>(std::sqrt(wanted / n)));
}

}  // namespace

PolygonSoup colored_surface(const BakedMaps& maps) {
  PolygonSoup surface = maps.surface;
  if (maps.color.samples.empty()) return surface;
  Material material;
  material.base_color = Vec4::Ones();
  material.name = material.base_color_texture = "color.png";
  material.base_color_picture = std::make_shared<const std::string>(encode_png(maps.color));
  surface.materials = {std::move(material)};
  surface.face_materials.assign(surface.n_faces(), 0);
  surface.vertex_colors.clear();
  return surface;
}

PolygonSoup dice_surface(const BakedMaps& maps, const DiceOptions& options) {
  if (options.parts < 0) throw OptionError("a triangle's side has no negative number of parts");
  const MapTriangles triangles(maps);
  const int parts = options.parts > 0 ? options.parts : parts_of(triangles, maps.size);
  PolygonSoup diced = Dicer(maps, triangles, options.displace, parts).run();
  ColoredParts(colored_surface(maps), triangles, parts).add_to(diced);
  return diced;
}

MapAccuracy measure_maps(const PolygonSoup& fine, const BakedMaps& maps, Progress* progress) {
  const DistanceMeter meter(fine);
  const MeshDistance bare = meter.to(maps.surface, {}, progress);
  const MapTriangles triangles(maps);
  const PolygonSoup diced = Dicer(maps, triangles, true, parts_of(triangles, maps.size)).run();
  const MeshDistance displaced = meter.to(diced, {}, progress);
  return {bare.max, bare.rms, displaced.max, displaced.rms};
}

}  // namespace recede
