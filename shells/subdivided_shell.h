// Shells over subdivision surfaces: few control points move all of it.
//
// Peng 2004, "Thick Surfaces" (thesis, New York University), section 7 on deformation: directors of the
// points of a coarser level are traced, and the others stand between them.
#pragma once

#include <recede/geometry/subdivision_surface.h>
#include <recede/shells/shell.h>

namespace recede {

struct SubdividedShellOptions {
  SubdivisionOptions subdivision{};
  /// Directors are traced at the points of the level that is so many below that of the surface, 0 to its
  /// level: (2^(level - this) + 1)^2 of a quad. Others are bilinear (with Loop, linear) between them. That
  /// serves where the surface is smooth over a face of that level.
  int interpolated_levels = 0;
  /// `thicknesses`, when given, are those of the surface's vertices.
  ShellOptions shell{};
};

struct SubdividedShell {
  PolygonSoup control{};
  /// Its base are the points of `subdivide` in their order, and its polygons cut into triangles.
  Shell shell{};
  int level = 0;
  LevelInterpolation interpolation{};  ///< of the directors
  std::size_t traced = 0;              ///< vertices whose directors follow the field, the last time
};

/// The shell of a control mesh's limit surface. The layers are those over the surface's triangles: checked
/// and repaired like others, whether their directors were traced or not. Without `interpolated_levels` it is
/// `build_shell` of `subdivide`, bit by bit.
///
/// Throws what these do, and `OptionError` for more interpolated levels than there are.
SubdividedShell build_subdivided_shell(const PolygonSoup& control, const SubdividedShellOptions& options,
                                       Progress* progress = nullptr);

/// After control points moved: `control` has the faces of the shell's control mesh. Points that are other
/// ones now are found, and only the directors within reach of them are traced anew, as `update_shell` does;
/// their number is in `traced`. Triangles, level, texture coordinates and other attributes stay.
///
/// Options are those of the shell. Throws `InputError` for other faces, also those into which polygons are
/// cut for Loop, and as `build_subdivided_shell` does; the shell is then what it was.
void update_subdivided_shell(SubdividedShell& shell, const PolygonSoup& control,
                             const SubdividedShellOptions& options, Progress* progress = nullptr);

}  // namespace recede
