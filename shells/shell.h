// Shells: a layer of space over a surface, in which detail lives. Every vertex of the surface has a director,
// a straight line to the layer's other side, and prisms over the triangles fill the space between.
//
// Peng 2004, "Thick Surfaces" (thesis, New York University), sections 3.1, 4.1 to 4.7: directors follow the
// gradient of an averaged distance, which gets shorter where there is less room. That shells are valid, or
// why they aren't, is proved here; the source can't promise it.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>
#include <recede/shells/lp_distance.h>
#include <recede/shells/shell_validity.h>

#include <optional>
#include <vector>

namespace recede {

enum class ShellSide { exterior, interior, envelope };

/// Where directors lead.
enum class DirectorMethod {
  averaged_distance,  ///< along the gradient of `LpDistance`
  exact_distance,     ///< along the extended gradient: jumps where several points are nearest
  normals             ///< along the vertices' normals, as far as asked for
};

struct ShellOptions {
  double thickness = 0;               ///< object units, above 0
  std::vector<double> thicknesses{};  ///< instead, one of each vertex, above 0
  ShellSide side = ShellSide::exterior;
  DirectorMethod method = DirectorMethod::averaged_distance;
  /// Of averaged distances. `support` is set to twice the largest thickness.
  LpDistanceOptions field{};
  /// The longest step of a director, as a share of the thickness, up to 1. It turns by at most 0.8 times as
  /// many radians, and is off by about a quarter of its third power of the thickness. 0.25 is interactive,
  /// 0.125 precise.
  double step = 0.25;
  /// Past open borders the field sees the surface go on this far, in thicknesses, so that directors don't
  /// bend outwards.
  double border_extension = 2.5;
  bool repair = true;  ///< shortens directors until the layer is valid
  /// With `repair`: where plain normals of one share of the thicknesses are valid all over the surface and
  /// more than a hundredth longer than the directors on average, they take their place. Whether that is so
  /// can change with one vertex, and then all of the layer does; false for surfaces that are deformed.
  bool at_least_normals = true;
};

/// One layer: from the surface to the ends of the directors.
struct ShellLayer {
  std::vector<Vec3> tops{};    ///< of each vertex: where its director ends
  std::vector<Vec3> traced{};  ///< the same before any repair
  ShellValidity validity{};    ///< of `tops`; of `traced` without repair
  /// Triangles over which no layer is valid, ascending: they meet others in the surface, overlap neighbours,
  /// or have no area; and all around a vertex at which two of its triangles meet beside it, or with no
  /// direction in front of all its triangles.
  std::vector<Index> excused{};
  /// Other triangles beside which repair can't end the faults: sheets that overlap by rounding errors without
  /// meeting, and other sharpest shapes. Ascending, seldom any.
  std::vector<Index> given_up{};
  /// The layer over all but the excused and given up triangles is valid by itself, and doesn't meet that over
  /// these: all that is wrong is wrong among them.
  bool is_valid_elsewhere = false;
  std::size_t inverted_before = 0, contacts_before = 0;  ///< prisms and pairs that repair found
  std::size_t shortened = 0;                             ///< directors that repair changed
  int repair_rounds = 0;
  std::size_t evaluations = 0;  ///< of the field
  bool is_of_normals = false;   ///< these took the place of the directors, see `at_least_normals`
  /// Of `Shell::quads`, those over which textures see one hexahedron instead of two prisms: points are
  /// trilinear between its corners, so that a texture doesn't bend at a diagonal. In each the Jacobian keeps
  /// its sign, and the hulls of its bottom and of its top meet nothing but neighbours where they are shared;
  /// so a valid layer stays valid. Ascending.
  std::vector<Index> hexahedra{};
};

struct Shell {
  /// The surface: triangles, with the attributes of the input but its normals and feature edges.
  PolygonSoup base{};
  /// Of the surface's quads: the first of their two triangles, after which the other one comes. Ascending.
  std::vector<Index> quads{};
  std::vector<double> thicknesses{};  ///< that were asked for, of each vertex
  std::optional<ShellLayer> exterior{}, interior{};
  /// Of an envelope: triangles of both layers' tops that meet. Of open surfaces, walls of one layer aren't
  /// compared with the other layer.
  ShellValidity::Pairs layers_meet{};

  bool is_valid() const;  ///< each layer is, and nothing was found between the two
};

/// Builds the layers over a surface. Polygons become triangles (`triangulate`); vertices are those of the
/// soup, so merge identical ones first.
///
/// Directors start along the normals, which see all faces of a vertex where a direction does, and follow the
/// field in steps that turn little; how far they get is what thickness there is room for (`mean_thickness`).
/// They are straight: the layer's points are those between a triangle and the triangle of the directors'
/// ends. Over quads they may be seen as trilinear, too (`ShellLayer::hexahedra`).
///
/// With `repair`, directors of prisms that are inverted or meet others are shortened in rounds, and turned
/// towards the normals where they lean too far, until `check_shell` finds nothing. Where the surface meets
/// itself, or a vertex has no direction in front of all its faces, no layer is valid: what such triangles do
/// among themselves is left as it is, and everything else is repaired. `excused` names them, and `validity`
/// says all that is wrong with them.
///
/// Same result for any number of threads. Throws `InputError` for a soup that `validate` refuses or without
/// area, `OptionError` for options out of range or a thickness beyond the diagonal of the surface's box, and
/// `Cancelled`.
Shell build_shell(const PolygonSoup& surface, const ShellOptions& options, Progress* progress = nullptr);

/// After the surface was deformed: `surface` has the shell's triangles with other positions of
/// `changed_vertices`. Directors are traced anew only where the field reaches (3.5 thicknesses from old and
/// new places of the faces around these vertices, 4 of `LpForm::averaged`, and their sides' lengths; also of
/// what the field sees of them beyond open borders); then the layers are repaired. Options are those of the
/// shell, whose thicknesses stay. Returns the number of vertices whose directors were traced. Throws
/// `InputError` for other triangles or vertices that there aren't, `OptionError` for other sides than the
/// shell's, and as `build_shell` does; the shell is then what it was.
std::size_t update_shell(Shell& shell, const PolygonSoup& surface, std::span<const Index> changed_vertices,
                         const ShellOptions& options, Progress* progress = nullptr);

/// All sides of the layers as one closed mesh of triangles that face outwards: the outermost tops, the
/// innermost ones turned over, and between them walls of quads at open borders.
PolygonSoup shell_boundary(const Shell& shell);

/// A place of a layer: inside of triangle `triangle` with the weights `weights` of its corners, and from 0 at
/// the surface to 1 at the top.
struct ShellPlace {
  Index triangle = k_no_index;
  Vec3 weights = Vec3::Zero();
  double height = 0;
};

Vec3 shell_point(const Shell& shell, const ShellLayer& layer, const ShellPlace& place);

/// The place in a triangle's prism of a point of space, by Newton's method: none where the point is outside.
std::optional<ShellPlace> place_in_prism(const Shell& shell, const ShellLayer& layer, Index triangle,
                                         const Vec3& point);

/// Lengths of directors over thicknesses asked for; the mean is over all vertices with triangles.
struct ShellThickness {
  double least = 0, mean = 0, most = 0;
};
ShellThickness reached_thickness(const Shell& shell, const ShellLayer& layer);

}  // namespace recede
