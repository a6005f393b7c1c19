// How far a limit surface is from its facets.
#pragma once

#include <recede/geometry/detail/limit_surface.h>

namespace recede::detail {

/// See `SubdivisionResult::error_estimate`. `facets` has the facets of the grids of `level`, in order.
double estimate_limit_error(const ControlMesh& control, const LimitSurface& surface, SubdivisionScheme scheme,
                            int level, const PolygonSoup& facets, Progress* progress);
/// Of the points that it looks at.
int limit_sample_level(SubdivisionScheme scheme, int level);

}  // namespace recede::detail
