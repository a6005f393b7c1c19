// The coarse surface of baked maps: triangles in the atlas, with the normals and tangents at their corners.
#pragma once

#include <recede/lod/displacement_bake.h>

#include <array>

namespace recede::detail {

/// Why the texture coordinates of a soup aren't one-to-one, as `MapReport::atlas_reason` says it; empty: they
/// are. Triangles may run either way round; those that overlap by less than 1e-9 count as apart.
std::string why_not_one_to_one(const PolygonSoup& soup);

/// A unit normal for each corner, the same for all corners at bit-equal positions: the mean of the triangles'
/// normals by angle. Where that vanishes, the normal of one of them.
std::vector<Vec3> point_normals(const PolygonSoup& soup);

/// Tangents for corners with normals: as `BakedMaps::corner_tangents`. Means by angle over the triangles
/// around a point that have the same texture coordinate there and run the same way round.
std::vector<Vec4> tangents_of(const PolygonSoup& soup);

/// Number of a point for each corner, the same for bit-equal positions.
std::vector<Index> points_of_corners(const PolygonSoup& soup);

/// A unit direction for each point (by its number in `points_of_corners`), along which heights count: its
/// corners' normal, their mean where they differ, and where there are none or they cancel out, that of
/// `point_normals`.
std::vector<Vec3> point_directions(const PolygonSoup& soup, const std::vector<Index>& points);

/// A place on the coarse surface.
struct MapPlace {
  Vec3 position;
  Vec3 normal;              ///< unit
  Vec3 tangent, bitangent;  ///< unit, not perpendicular in general
};

/// Triangles of a surface with texture coordinates, normals and tangents.
class MapTriangles {
 public:
  /// Keeps references: `maps.surface` and its tangents must stay.
  explicit MapTriangles(const BakedMaps& maps);

  std::size_t size() const { return corners_.size() / 3; }
  Index corner(std::size_t triangle, std::size_t k) const { return corners_[3 * triangle + k]; }
  const Vec2& uv(std::size_t triangle, std::size_t k) const {
    return maps_.surface.corner_uvs[corner(triangle, k)];
  }
  /// Weights of the corners at a texture coordinate, which may lie outside.
  Vec3 weights(std::size_t triangle, const Vec2& uv) const;
  /// About how wide a texel of a map of `size` is on the triangle, object units.
  double texel_width(std::size_t triangle, int size) const;
  /// The place with these weights; outside of the triangle, its continuation.
  MapPlace at(std::size_t triangle, const Vec3& weights) const;

 private:
  const BakedMaps& maps_;
  std::vector<Index> corners_;
};

}  // namespace recede::detail
