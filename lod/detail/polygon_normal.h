// The direction of a polygon that need not be flat.
#pragma once

#include <recede/geometry/vec.h>

#include <span>

namespace recede::detail {

/// Twice the vector area (Newell), relative to the first point so that no digits are lost far from the
/// origin.
Vec3 twice_vector_area(std::span<const Vec3> points);

/// Unit normal as in Ramsey, Bertram, Hansen 2003: for triangles the cross product of two sides, for quads
/// that of the diagonals, else the mean of the cross products at the corners, all oriented counter-clockwise.
/// The mean can vanish or point the wrong way for concave polygons; where it nearly vanishes, the vector area
/// stands in. Zero for a polygon without area.
Vec3 corner_average_normal(std::span<const Vec3> points);

/// Unit vector area, or zero.
Vec3 vector_area_normal(std::span<const Vec3> points);

}  // namespace recede::detail
