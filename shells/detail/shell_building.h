// The steps in which shells are built, and built anew.
#pragma once

#include <recede/geometry/subdivision_surface.h>
#include <recede/shells/shell.h>

#include <span>
#include <vector>

namespace recede::detail {

/// Triangles with the attributes of the polygons. Throws `InputError`.
PolygonSoup shell_base_of(const PolygonSoup& surface);

/// Over that surface, with thicknesses and no layers. Throws `InputError` and `OptionError`.
Shell shell_without_layers(const PolygonSoup& surface, const ShellOptions& options);

/// `base` has the shell's triangles with other positions of `changed` and takes the place of its base.
/// Returns the vertices whose directors may be other ones. Throws as `update_shell`.
std::vector<Index> move_shell_base(Shell& shell, PolygonSoup base, std::span<const Index> changed,
                                   const ShellOptions& options);

/// Directors of `vertices` are traced and those of others stay, or stand `between` the ones of their means
/// when that is given: shares of their own thicknesses. Then layers are repaired, and
/// hexahedra found.
void build_layers(Shell& shell, std::span<const Index> vertices, const LevelInterpolation* between,
                  const ShellOptions& options, Progress* progress);

}  // namespace recede::detail
