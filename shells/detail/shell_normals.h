// Plain normals in the place of directors that got shorter than those could be.
#pragma once

#include <recede/shells/detail/shell_directors.h>

namespace recede::detail {

/// A valid layer becomes that of plain normals of one share of the thicknesses, the longest one at which
/// it's valid, found to half a percent, when that is longer than its directors are on average by more than a
/// hundredth. Returns whether it did.
bool stand_on_normals(const ShellSurface& surface, std::span<const double> thicknesses, double side,
                      ShellLayer& layer, Progress* progress);

}  // namespace recede::detail
