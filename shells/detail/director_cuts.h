// Directors that run through the surface.
#pragma once

#include <recede/shells/detail/shell_directors.h>

#include <span>
#include <vector>

namespace recede::detail {

/// Of each director from a vertex to its end: the share of it, above 0 and at most 1, at which it first meets
/// a triangle that the vertex isn't a corner of; 1 without one. To rounding.
std::vector<double> shares_before_surface(const ShellSurface& surface, std::span<const Vec3> ends);

}  // namespace recede::detail
