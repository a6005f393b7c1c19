// How far a surface is from a triangle between three of its points.
#pragma once

#include <recede/geometry/patch_surface.h>

#include <array>

namespace recede::detail {

/// At least the distance of any point of the surface from the point of equal parameters on the triangle.
/// Within a few per cent of the largest, or above `enough`: where the bound by derivatives is not below it at
/// once, the triangle is divided into equal ones, whose corners are measured and whose insides are bounded.
double triangle_deviation(const PatchSurface& surface, const std::array<Vec2, 3>& uvs, double enough);

/// The largest deviation that is met at a few points: no bound.
double measured_deviation(const PatchSurface& surface, const std::array<Vec2, 3>& uvs);

}  // namespace recede::detail
