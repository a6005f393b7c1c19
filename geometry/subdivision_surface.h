// Subdivision surfaces: a control mesh stands for the smooth surface to which its refinements converge.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

#include <cstddef>
#include <optional>
#include <vector>

namespace recede {

enum class SubdivisionScheme {
  catmull_clark,  ///< polygons of any number of sides become quads (Catmull and Clark 1978)
  loop,           ///< triangles stay triangles (Loop 1987); other polygons are triangulated first
};

/// What becomes of the border of an open control mesh. It is a crease; its curve is the cubic B-spline of the
/// border's vertices.
enum class SubdivisionBoundary {
  edge_only,        ///< all of it, so that a corner is rounded
  edge_and_corner,  ///< vertices of a single face stay where they are
};

/// How texture coordinates are refined, by OpenSubdiv's names. All but `linear` are smooth inside of a chart,
/// like positions; they differ at its border, where it is cut off from its neighbours.
enum class UvInterpolation {
  smooth,          ///< borders are B-splines, corners are rounded
  corners_only,    ///< corners of a single face stay
  corners_plus_1,  ///< and points at which more than two charts meet, or where seams end
  corners_plus_2,  ///< and concave corners, and what belongs to them on the other charts
  boundaries,      ///< the whole border stays as straight as it is
  linear,          ///< bilinear everywhere
};

/// How the sharpness of an edge falls from level to level.
enum class Creasing {
  uniform,  ///< by one
  chaikin,  ///< towards the mean of its neighbours along the crease, less one: smooth changes of sharpness
};

/// An edge of the control mesh that is sharp for as many refinements as its sharpness says, and then smooth
/// (DeRose, Kass and Truong 1998). From `k_infinite_sharpness` on it stays sharp.
struct SubdivisionCrease {
  Index first = 0, second = 0;  ///< vertices, in any order
  double sharpness = 0;
};
/// A vertex that is sharp in the same way: a peak.
struct SubdivisionCorner {
  Index vertex = 0;
  double sharpness = 0;
};
inline constexpr double k_infinite_sharpness = 10;

struct SubdivisionOptions {
  SubdivisionScheme scheme = SubdivisionScheme::catmull_clark;
  /// Every level has four times the faces of the one before, 0 to 10. At 0 the faces are those of the control
  /// mesh, with their points on the limit surface.
  int level = 2;
  /// Instead of `level`: the least one whose `error_estimate` is at most this, object units.
  std::optional<double> error{};

  std::vector<SubdivisionCrease> creases = {};
  std::vector<SubdivisionCorner> corners = {};
  /// Edges whose two faces' normals differ by more (radians, 0 to pi) get `crease_sharpness`, unless
  /// `creases` names them.
  std::optional<double> crease_angle{};
  double crease_sharpness = k_infinite_sharpness;
  double feature_sharpness = 0;  ///< of the soup's feature edges; 0: they are smooth like others

  SubdivisionBoundary boundary = SubdivisionBoundary::edge_and_corner;
  UvInterpolation uv_interpolation = UvInterpolation::boundaries;
  Creasing creasing = Creasing::uniform;

  static constexpr int k_largest_level = 10;
  static constexpr std::size_t k_most_faces = 50'000'000;
};

/// A control mesh's limit surface as polygons.
struct SubdivisionResult {
  /// Points of the limit surface and the facets between them: first the control mesh's vertices that have
  /// faces, in its order, then those of its edges, then those inside of its faces. Facets stand in the order
  /// of the control mesh's faces. See `subdivide`.
  PolygonSoup soup;
  int level = 0;
  /// How far the limit surface may be from the facets (those of `triangulate`), object units: the largest
  /// distance found, over points between those of `soup` (those of the next level, or those two or three
  /// levels on), each to the facets that meet there. No bound: denser samples found up to 10 % more.
  double error_estimate = 0;
  std::size_t crease_edges = 0;  ///< edges of the control mesh that are sharp, without its border
  std::size_t triangulated = 0;  ///< polygons of more than three sides that were cut for `loop`
};

/// Evaluates the limit surface of a control mesh through OpenSubdiv.
///
/// Every point lies on the limit surface, to rounding, with one exception: where an infinitely sharp crease
/// ends inside of the surface, OpenSubdiv approximates, and points at the very end are off by about 1e-4
/// of the edges there.
///
/// `corner_normals` are the limit surface's normals, unit vectors, the same for all corners of a point. On
/// infinitely sharp creases, where the sides have several, they are their mean, at vertices by the sides'
/// angles, as displaced surfaces want them. Where a surface has no normal, those of the facets serve.
///
/// `corner_uvs` are refined by `uv_interpolation`; corners of neighbouring faces that have the same one in
/// the control mesh have, bit by bit, the same ones along the common edge, and seams stay seams. The points
/// of both sides are the same ones. Vertex colours and scalars are refined like positions; a missing scalar
/// makes those around missing. Materials are those of the control mesh's faces. Feature edges become the
/// pieces of infinitely sharp creases and of the soup's feature edges. The control mesh's normals count for
/// nothing.
///
/// Vertices at one place are different ones: run `merge_identical_vertices` first where a file holds every
/// face by itself. Same bytes for any number of threads.
///
/// Throws `InputError` for a soup that `validate` refuses or without faces, whose faces visit a vertex twice,
/// or that isn't manifold: an edge with more than two faces or with two that disagree in orientation, or a
/// vertex where several fans of faces touch (`remove_degenerate_faces`, `orient_consistently` and
/// `split_non_manifold` help); for a vertex or face with more than 500 edges; and for positions beyond 1e70.
/// Throws `OptionError` for options out of range, creases that are no edges, more than `k_most_faces` facets,
/// and an error that would need them or more than `k_largest_level` levels; and `Cancelled`.
SubdivisionResult subdivide(const PolygonSoup& control, const SubdivisionOptions& options = {},
                            Progress* progress = nullptr);

/// How the points of a level stand between those of a coarser one, which are some of them.
struct LevelInterpolation {
  std::vector<std::size_t> starts{0};  ///< N + 1: where the means of each point of the level begin
  std::vector<Index> points{};         ///< of the level, all of them points of the coarser one, too
  std::vector<double> weights{};       ///< above 0, of each point adding up to 1

  std::size_t n_points() const { return starts.size() - 1; }
  /// A point of the coarser level: the mean of itself.
  bool is_coarse(std::size_t point) const { return starts[point + 1] - starts[point] == 1; }
};

/// Bilinear between the corners of the coarser level's quads, linear in its triangles: for the points of
/// `subdivide` at `options.level`, in its order. What belongs to an edge depends on its ends alone. Weights
/// are dyadic and so exact, but for faces of other than 3 or 4 sides at `coarse_level` 0, which have the mean
/// of their corners in the middle.
///
/// Throws as `subdivide`, and `OptionError` for a coarse level that isn't from 0 to `options.level`.
/// `options.error` counts for nothing.
LevelInterpolation interpolate_level(const PolygonSoup& control, const SubdivisionOptions& options,
                                     int coarse_level);

}  // namespace recede
