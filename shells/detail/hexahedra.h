// Which pairs of prisms of a layer may be hexahedra.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/shells/shell.h>

#include <array>
#include <vector>

namespace recede::detail {

/// Corners in their order around, at the surface and at the top.
struct Hexahedron {
  std::array<Vec3, 4> bottom, top;
};

/// Whether the Jacobian of the trilinear map is above 0 in the whole hexahedron (below 0 with `is_inward`):
/// all its Bernstein coefficients are, even if they are off by rounding. That is enough, and seldom more.
bool surely_has_one_orientation(const Hexahedron& hexahedron, bool is_inward);

/// See `ShellLayer::hexahedra`.
std::vector<Index> find_hexahedra(const Shell& shell, const ShellLayer& layer, bool is_inward,
                                  Progress* progress);

}  // namespace recede::detail
