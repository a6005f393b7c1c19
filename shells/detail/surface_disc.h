// A disc of a surface around a place of it, spread out in the plane.
#pragma once

#include <recede/geometry/closest_point.h>
#include <recede/shells/shell.h>

#include <optional>
#include <vector>

namespace recede::detail {

/// The place is in the origin. Areas are those of the surface on the whole.
class SurfaceDisc {
 public:
  /// All triangles within `radius` of the place along the surface, and more around them. `axis` is a
  /// direction of space that leads along the first axis. Throws `InputError` for a piece of surface without
  /// area around the place.
  SurfaceDisc(const PolygonSoup& base, const ShellPlace& place, double radius, const Vec3& axis);

  /// Where a triangle's place is; none beyond the disc. Weights may leave the triangle.
  std::optional<Vec2> to_plane(Index triangle, const Vec3& weights) const;
  /// The place over a point; none beyond the disc.
  std::optional<ShellPlace> from_plane(const Vec2& point) const;
  double stretch() const { return stretch_; }

 private:
  void grow(const PolygonSoup& base, const ShellPlace& place, double radius);
  void spread(const PolygonSoup& base, const ShellPlace& place, const Vec3& axis);

  std::vector<Index> triangles_;           // of the base
  std::vector<Index> number_of_triangle_;  // their numbers here, or none
  std::vector<Index> corners_;             // vertices of the disc, three to a triangle
  std::vector<Vec2> points_;               // of vertices
  std::optional<ClosestPointTree> flat_;
  double stretch_ = 1;
};

}  // namespace recede::detail
