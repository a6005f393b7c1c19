// Simplification of polygon meshes by edge collapse. n-gons stay n-gons.
#pragma once

#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/progress.h>

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace recede {

/// What decides which edge goes next.
enum class CostPolicy {
  /// Lindstrom and Turk 1998: a collapse costs the squared volumes (at borders and creases: areas) that the
  /// polygons around the edge sweep, and the new vertex is the one that costs least among those that keep the
  /// enclosed volume.
  volume,
  /// Ramsey, Bertram and Hansen 2003: a collapse is as good as the smallest dot product between the normals
  /// of a changed polygon before and after, and permitted while that exceeds a threshold.
  normal_deviation,
  /// Cohen, Olano and Manocha 1998; Sander et al. 2001: a half-edge collapse costs the largest distance
  /// between two points with the same texture coordinates, before and after, and a share of that so far,
  /// times
  /// the cube root of the area around the removed point. No polygon turns over in the texture. Needs texture
  /// coordinates.
  texture_deviation,
};

/// Where the vertex of a collapsed edge goes.
enum class VertexPlacement {
  automatic,  ///< `optimal` for `volume`, else `half_edge`
  half_edge,  ///< one of the two ends: vertices of the result are vertices of the input
  midpoint,   ///< middle of the edge ("full edge" in the source of `normal_deviation`); not for
              ///< `texture_deviation`
  optimal,    ///< best position for the cost; `volume` only
};

/// What stands for the normal of a polygon, which need not be flat.
enum class PolygonNormal {
  /// As in the source: the mean of the polygon's corner normals when the mesh has them, else
  /// `corner_average`.
  source,
  /// Mean of the cross products at the corners (for triangles and quads: of two sides, of the diagonals).
  /// Where it is nearly zero, the vector area.
  corner_average,
  /// The vector area (Newell), which never points the wrong way for a simple polygon.
  vector_area,
};

/// When to stop. Several may be given; the first that is reached stops. None: simplify as far as the cost
/// permits (`normal_deviation`) or as the mesh allows (`volume`). Errors are the two-sided distance to the
/// input, proved unless `SimplifyOptions::prove_error` is off.
struct SimplifyTarget {
  std::optional<std::size_t> faces{};     ///< at most this many faces
  std::optional<std::size_t> vertices{};  ///< at most this many vertices
  std::optional<double> ratio{};          ///< at most this share of the input's faces, 0 to 1
  std::optional<double> error{};          ///< the error is at most this, object units; less than 1e-12 of the
                                          ///< diagonal counts as that much
  std::optional<double>
      relative_error{};  ///< the same as a share of the bounding box's diagonal (0.01 = 1 %)
};

/// `volume`: how much attributes count in the cost of a collapse, beside the shape. An attribute that changes
/// by one unit costs as much as a surface that moves by its weight, a share of the longest side of the
/// bounding box. 0: the attribute is carried along, but doesn't count. Attributes that the mesh hasn't got
/// don't matter.
struct AttributeWeights {
  double uv = 0.1;
  double normal = 0.003;
  double color = 0.01;
  std::vector<std::pair<std::string, double>> scalars{};  ///< by name; those that aren't here don't count
};

struct SimplifyOptions {
  SimplifyTarget target;
  CostPolicy cost = CostPolicy::volume;
  VertexPlacement placement = VertexPlacement::automatic;

  /// Prove how far the result is from the input (`error_bound`), and keep error targets by that proof;
  /// targets then take several runs. Off: `error_estimate` is all that is known, and error targets are
  /// compared with it.
  bool prove_error = true;

  /// Leave every border vertex where it is, instead of collapsing borders along themselves.
  bool lock_borders = false;
  /// Keep edges where texture coordinates or normals of the two faces differ.
  bool keep_uv_seams = true;
  bool keep_normal_seams = true;

  AttributeWeights weights;

  /// `volume`: points of parts that no face connects may become one when they are this near, object units.
  /// Such a join costs what it sweeps and competes with the collapses of edges; borders that meet grow
  /// together. 0: parts stay apart.
  double join_distance = 0;
  /// Drop parts that no face connects with the rest: once the surface is off by as much as a part's own
  /// error, the distance of its points from the nearest other part, and where nothing else is left to do. One
  /// part stays.
  bool drop_parts = false;

  /// Between collapses of similar cost, prefer those that keep polygons with more than three sides: rows of
  /// quads vanish as a whole. No effect on triangle meshes. Off: the order of the sources alone.
  bool keep_polygons = true;

  /// `normal_deviation`: least dot product between a polygon's normals before and after one collapse, -1
  /// to 1.
  double normal_threshold = 0.99;
  /// `normal_deviation`: candidates drawn per collapse as a share of the input's polygon count, 0 to 1. 1:
  /// exhaustive.
  double candidate_share = 0.01;
  /// `normal_deviation`: seed of the candidate draws. Same seed, same result.
  std::uint64_t seed = 1;
  /// `normal_deviation`: how a polygon's normal is computed.
  PolygonNormal polygon_normal = PolygonNormal::source;
};

/// Why a simplification ended.
enum class StopReason { face_target, vertex_target, error_target, no_collapse_left };
std::string_view to_string(StopReason reason);

/// Why a collapse was refused. Counted once per refused attempt; an edge may be tried again in a later pass.
enum class Refusal : std::size_t {
  border,     ///< would close a border, or pull a border, seam, feature edge or corner of them off its course
  topology,   ///< link condition: the surface would touch or fold onto itself
  duplicate,  ///< two polygons would have the same vertices
  flip,       ///< a polygon would turn over or get a corner that turns the wrong way
  degenerate,  ///< a polygon would lose its area
  deviation,   ///< `normal_deviation`: below the threshold
  error,       ///< the error target
  count
};
std::string_view to_string(Refusal refusal);

/// Number of refused collapses by reason.
struct RefusedCollapses {
  std::array<std::size_t, static_cast<std::size_t>(Refusal::count)> counts{};
  std::size_t& operator[](Refusal r) { return counts[static_cast<std::size_t>(r)]; }
  std::size_t operator[](Refusal r) const { return counts[static_cast<std::size_t>(r)]; }
};

/// What a simplification reached, and why it went no further.
struct SimplifyReport {
  std::size_t faces_before = 0, faces_after = 0;
  std::size_t vertices_before = 0, vertices_after = 0;  ///< points; copies of a split vertex count once
  std::size_t collapses = 0;
  std::size_t interior_collapses = 0;  ///< those of edges with exactly two faces
  std::size_t removed_faces = 0;       ///< each a triangle
  std::size_t lost_sides = 0;          ///< sides lost by faces that stay
  std::size_t joined = 0;              ///< collapses that joined points of different parts
  std::size_t dropped_parts = 0, dropped_faces = 0;
  std::size_t passes = 0;  ///< passes (`volume`) or sweeps (`normal_deviation`)
  /// Largest deviation from the input that the collapses may have made, object units: the distances by which
  /// collapses at one place moved the surface, summed up. An estimate, not a bound.
  double error_estimate = 0;
  /// Certified, up to rounding in double precision: the two-sided Hausdorff distance to the input lies in
  /// [error_lower, error_bound], object units. Absent when it wasn't proved, or without faces.
  std::optional<double> error_bound;
  double error_lower = 0;
  StopReason stop_reason = StopReason::no_collapse_left;
  RefusedCollapses refused;
  double seconds = 0;        ///< without those of the proof
  double proof_seconds = 0;  ///< all proofs since the start of the run
};

struct SimplifyResult : SimplifyReport {
  PolygonMesh mesh;
};

struct SimplifySoupResult : SimplifyReport {
  PolygonSoup soup;  ///< without vertices that no face uses
};

/// Simplifies a copy of `mesh`. No flipped, duplicate, degenerate or non-finite polygon is made (the input's
/// own remain possible); edges with more than two polygons are collapsed along themselves with all their
/// polygons. Corner attributes are interpolated, or taken from the surviving end for half-edge collapses. A
/// target that can't be reached gives the best mesh with `stop_reason == no_collapse_left`. Same bytes for
/// any number of threads. Throws `OptionError` for options out of range, and for `texture_deviation` without
/// texture coordinates or without their seams.
SimplifyResult simplify(const PolygonMesh& mesh, const SimplifyOptions& options = {},
                        Progress* progress = nullptr);

/// The same for polygons without connectivity: no half-edge mesh is built, which takes less time and memory.
/// Vertices at bit-equal positions count as one; nothing else is repaired (see polygon_soup.h): faces that
/// disagree in orientation or occur twice make their edges lines that stay. Throws `InputError` for what
/// `validate` refuses.
SimplifySoupResult simplify(const PolygonSoup& soup, const SimplifyOptions& options = {},
                            Progress* progress = nullptr);

/// One run that stops at each target in turn (fine to coarse) and hands out the mesh as it stands there.
/// `options.target` is ignored. Counts and seconds of a result are those from the start of the run.
std::vector<SimplifyResult> simplify_levels(const PolygonMesh& mesh, std::span<const SimplifyTarget> targets,
                                            const SimplifyOptions& options = {},
                                            Progress* progress = nullptr);
std::vector<SimplifySoupResult> simplify_levels(const PolygonSoup& soup,
                                                std::span<const SimplifyTarget> targets,
                                                const SimplifyOptions& options = {},
                                                Progress* progress = nullptr);

}  // namespace recede
