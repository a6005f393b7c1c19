// Whether the loops of a face bound something.
#pragma once

#include <recede/geometry/detail/cad_face.h>

namespace recede::detail {

/// Throws `CadProblem` when the loops have no area, cross themselves or each other, or run the wrong way
/// around, by points along them.
void check_loops(const TrimmedFace& face);

}  // namespace recede::detail
