// Displaced surfaces that are drawn by other methods than displacement too: the base that rays meet first,
// and the frames in which bump maps and tables hold.
#pragma once

#include <recede/render/appearance.h>
#include <recede/render/rendering_transition.h>

namespace recede::detail {

/// At a place of the base; its axes are unit vectors, perpendicular to each other.
struct SurfaceFrame {
  Vec3 along_u, along_v, normal;
  Vec2 uv;

  Vec3 to_local(const Vec3& v) const { return {along_u.dot(v), along_v.dot(v), normal.dot(v)}; }
  Vec3 to_world(const Vec3& v) const { return v.x() * along_u + v.y() * along_v + v.z() * normal; }
};

/// How much of each method shades a place.
struct MethodShares {
  double table = 0;      ///< share of the intensity that the table gives; the rest is that of normals
  double displaced = 1;  ///< share of the displacement that the place has

  bool is_on_base() const { return displaced == 0; }
};
MethodShares shares_of(const RenderingTransition& transition);

class AppearanceLook {
 public:
  /// `base` has a direction for heights in `corner_normals`. `normals`, one for each corner, are those of
  /// its shading. `maps` may be empty but for a normal map.
  AppearanceLook(const PolygonSoup& base, std::vector<Vec3> normals, const BakedMaps& maps,
                 std::shared_ptr<const Appearance> appearance);

  /// `weights` of the corners of a triangle of `triangulate(base)`.
  SurfaceFrame frame_at(std::uint32_t triangle, const Vec3& weights) const;
  /// The frame's normal alone.
  Vec3 normal_at(std::uint32_t triangle, const Vec3& weights) const;
  /// The normal of the bump map in the frame of the surface, whose heights are `heights`.
  Vec3 bump_normal(const Vec2& uv, const DisplacementMap& heights) const;
  const Appearance& appearance() const { return *appearance_; }

 private:
  /// What interpolation needs of a triangle, side by side in memory.
  struct Triangle {
    Eigen::Vector3f normals[3], tangents[3];
    Eigen::Vector2f uvs[3];
    float side;  ///< 1, or -1 where the map is mirrored
  };

  std::vector<Triangle> triangles_;
  BakedMaps normal_map_;  // no more than that
  std::shared_ptr<const Appearance> appearance_;
};

/// Of all texels.
struct HeightSpan {
  double least = 0, mean = 0, largest = 0;
};
HeightSpan span_of(const DisplacementMap& heights);

/// The base moved out by a height along the directions of its points, which stay: `corner_normals` of the
/// result. Corners with bit-equal positions move alike.
PolygonSoup raised_base(const PolygonSoup& base, double height);

/// The shortest that directions of the points, which are unit, become when they are interpolated in a
/// triangle of `triangulate(base)`: heights along unit directions reach as much farther than along these. At
/// least 0.05, where directions cancel out.
double least_direction(const PolygonSoup& base);

/// A side of a triangle of `triangulate(base)` that no other one has: from its corner `side` to the next.
struct BorderSide {
  std::uint32_t triangle = 0, side = 0;
};
/// Vertices with bit-equal positions are one.
std::vector<BorderSide> border_sides(const PolygonSoup& base);

}  // namespace recede::detail
