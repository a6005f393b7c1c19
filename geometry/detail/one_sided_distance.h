// The distance of one surface's points to another surface: sampled, and where that is measured.
#pragma once

#include <recede/geometry/detail/bound_search.h>
#include <recede/geometry/mesh_distance.h>

#include <cmath>

namespace recede::detail {

/// Where both surfaces are measured: their box's centre goes to the origin and its larger extent to about 1.
/// Squares of lengths then neither overflow nor underflow, and what is far from the origin loses no digits.
/// Scaling is by a power of two and rounds nothing.
struct Frame {
  explicit Frame(const Box3& box) {
    if (box.isEmpty()) return;
    // Halves first: sums and differences of the largest numbers overflow.
    center = 0.5 * box.min() + 0.5 * box.max();
    const double largest = (0.5 * box.max() - 0.5 * box.min()).maxCoeff();
    if (largest > 0) exponent = -std::ilogb(largest);
  }

  double inside(double length) const { return std::ldexp(length, exponent); }
  double outside(double length) const { return std::ldexp(length, -exponent); }
  Vec3 outside(const Vec3& p) const { return center + Vec3(outside(p.x()), outside(p.y()), outside(p.z())); }
  Vec3 inside(const Vec3& p) const {
    const Vec3 d = p - center;
    return {inside(d.x()), inside(d.y()), inside(d.z())};
  }
  Surface inside(const PolygonSoup& soup) const {
    PolygonSoup moved;
    moved.face_offsets = soup.face_offsets;
    moved.corner_vertices = soup.corner_vertices;
    moved.positions.reserve(soup.positions.size());
    for (const Vec3& p : soup.positions) moved.positions.push_back(inside(p));
    return Surface(std::move(moved));
  }

  Vec3 center = Vec3::Zero();
  int exponent = 0;
};

/// What samples of one side say.
struct SampledSide {
  OneSidedDistance distance;
  std::size_t evaluated = 0;
  std::vector<Index> nearest;  ///< for each position of the source surface, the nearest triangle of the other
};

/// From `samples` points spread over `from` by area, and its positions, to `to`.
SampledSide sampled_distance(const Surface& from, const Surface& to, std::size_t samples);

}  // namespace recede::detail
