// Finding the triangle that holds a point, from neighbour to neighbour.
#pragma once

#include <recede/geometry/constrained_delaunay.h>

#include <optional>

namespace recede::detail {

/// A vertex beyond all others, in any direction: while a triangulation is built, each side of the convex hull
/// has a triangle with it outside.
inline constexpr Index k_far = k_no_index;

/// The corner with the far vertex, -1: none.
inline int far_corner(const DelaunayTriangle& triangle) {
  for (int k = 0; k < 3; ++k) {
    if (triangle.vertex(k) == k_far) return k;
  }
  return -1;
}

/// Walks from a triangle without the far vertex across sides that have the point beyond them (the remembering
/// walk of O. Devillers, S. Pion and M. Teillaud: Walking in a Triangulation, 2002). Triangles that edges
/// keep from being Delaunay's may lead it in circles, so that it gives up after a number of steps. Outside of
/// the convex hull, `triangle` is one with the far vertex that has the point on its side, if there are such
/// triangles.
std::optional<TriangleLocation> walk_to(const Vec2& point, Index start, std::size_t most_steps,
                                        std::span<const Vec2> points,
                                        std::span<const DelaunayTriangle> triangles);

/// The same by a look at every triangle.
TriangleLocation look_everywhere(const Vec2& point, std::span<const Vec2> points,
                                 std::span<const DelaunayTriangle> triangles);

}  // namespace recede::detail
