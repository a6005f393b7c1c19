// Points over a rectangle of parameters, as far apart as the surface below allows.
#pragma once

#include <recede/geometry/surface_bounds.h>

#include <functional>

namespace recede::detail {

/// Calls `visit(uv, spacing)` for points of lattices of nearly equilateral triangles whose deviation is
/// within the tolerance. The rectangle is halved as long as parts of it allow much larger triangles than
/// others. `spacing`: between neighbours along u and v. Where no point is needed within a part, there is
/// none.
void each_lattice_seed(const SurfaceBounds& bounds, const ParameterBox& part, double tolerance,
                       const std::function<void(const Vec2& uv, const Vec2& spacing)>& visit);

}  // namespace recede::detail
