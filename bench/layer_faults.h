// Whether a layer is valid but over the triangles that it names, found out anew.
#pragma once

#include <recede/shells/shell.h>

namespace recede::bench {

/// Faults of a layer in which a triangle takes part that it neither excused nor gave up. Nothing that the
/// layer says of its validity is used.
std::size_t faults_beside_named(const Shell& shell, const ShellLayer& layer, ShellSide side);

}  // namespace recede::bench
