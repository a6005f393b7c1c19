// Progressive meshes of polygons: a coarse base and the vertex splits that bring the input back, bit for bit.
//
// H. Hoppe: Progressive Meshes. SIGGRAPH 1996. S. Ramsey, M. Bertram, C. Hansen: Simplification of Arbitrary
// Polyhedral Meshes. CGIM 2003 (records for polygons with more than three sides).
//
// Every collapse is recorded in the numbers of the input: a vertex, its corners that went to another one, the
// triangles that vanished and the corners that larger polygons lost. Dead corners stay in their lists, so
// that the pair of neighbours between which a corner comes back (the context of Ramsey et al.) is what stands
// beside it there.
//
// Deviation from the sources: collapses are not kept in the order in which they were made, but sorted by how
// far they take the surface from the input, each at least as far as those it follows from. Those that share
// no polygon may be exchanged, so this order is as good as the original one, and levels in between are as
// even as the passes that made them.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/lod/simplify.h>

#include <memory>
#include <vector>

namespace recede {

struct ProgressiveOptions {
  /// How the base is made. `target` is that of the base; its error targets are compared with the estimate.
  /// The placement `automatic` is `half_edge`: every level then has vertices of the input, and files are
  /// smallest. `prove_error` off: the errors of the levels are estimates.
  SimplifyOptions simplify;
};

/// What bringing one vertex back does. Its entries in `ProgressiveMesh::items`, from `first` up to that of
/// the next split: corners that go from `kept` to `removed`, then faces that come back, then single corners
/// that come back into faces with more than three sides.
struct VertexSplit {
  Index removed = k_no_index, kept = k_no_index;  ///< vertices; k_no_index: a part of the surface comes back
  Index first = 0;
  Index n_corners = 0, n_faces = 0;
};

/// A list whose row i has the entries [start[i], start[i + 1]); no rows at all when nothing has any.
template <typename Entry>
struct SplitRows {
  std::vector<Index> start;
  std::vector<Entry> entries;
  std::span<const Entry> operator[](std::size_t row) const {
    if (start.empty()) return {};
    return {entries.data() + start[row], start[row + 1] - start[row]};
  }
  bool operator==(const SplitRows&) const = default;
};

/// A value on both sides of a split.
template <typename Value>
struct Change {
  Value fine, coarse;
  bool operator==(const Change&) const = default;
};

/// A base and the splits that refine it. The levels are named by how many splits they have: 0 is the base,
/// `n_splits()` the input. All numbers of vertices and faces are those of the input; corners and faces that
/// only levels have (a face of the input that visits a vertex twice is mended first) come after them.
///
/// A plain value, which `ProgressiveCursor` reads. Lists by vertex, corner and face hold the state of the
/// base; what isn't there holds the state in which it comes back.
struct ProgressiveMesh {
  // By vertex.
  std::vector<Vec3> positions;
  std::vector<Vec4> colors;  ///< or empty
  std::vector<VertexScalar> scalars;

  // By face and corner. Face f has the corners [face_offsets[f], face_offsets[f + 1]).
  std::vector<Index> face_offsets{0};
  std::vector<unsigned char> face_alive;
  std::vector<Index> face_materials;  ///< or empty
  std::vector<Index> corner_vertices;
  std::vector<unsigned char> corner_alive;  ///< empty: all corners of faces that are there; see `VertexSplit`
  std::vector<Index> corner_wedges;         ///< positions in the lists of wedges; empty: no corner attributes
  std::vector<unsigned char> corner_features;  ///< 1: the side to the next corner is a feature edge; or empty
  std::vector<Vec2> wedge_uvs;                 ///< or empty
  std::vector<Vec3> wedge_normals;             ///< or empty
  std::vector<Material> materials;

  // By split, from the base on. Lists of changes are empty when no split changes anything of the kind.
  std::vector<VertexSplit> splits;
  std::vector<Index> items;
  std::vector<Change<Vec3>> position_changes;  ///< of `kept`
  std::vector<Change<Vec4>> color_changes;     ///< of `kept`
  std::vector<Change<double>> scalar_changes;  ///< of `kept`; one for each of `scalars`, split after split
  struct CornerWedge {
    Index corner, fine, coarse;
    bool operator==(const CornerWedge&) const = default;
  };
  SplitRows<CornerWedge> corner_wedge_changes;
  struct WedgeValue {
    Index wedge;
    Change<Vec2> uv;
    Change<Vec3> normal;
    bool operator==(const WedgeValue&) const = default;
  };
  SplitRows<WedgeValue> wedge_changes;
  SplitRows<Index> feature_changes;  ///< corners whose flag changes

  /// The last split, which `splits` has not: from the surface that was simplified to the input. Present when
  /// the input has several vertices at one place, faces that visit a vertex twice, or attributes that differ
  /// where they count as equal.
  struct Mending {
    struct CornerVertex {
      Index corner, fine, coarse;
      bool operator==(const CornerVertex&) const = default;
    };
    std::vector<CornerVertex> vertices;
    std::vector<CornerWedge> wedges;
    std::vector<Index> fine_faces, coarse_faces;  ///< that only the one or the other has
    bool empty() const { return vertices.empty() && wedges.empty() && fine_faces.empty(); }
    bool operator==(const Mending&) const = default;
  } mending;

  // By level.
  std::vector<Index> level_faces;  ///< number of faces, never falling but for `mending`, which may join some
  /// Two-sided distance to the input, object units, never rising: a certified bound up to rounding in double
  /// precision when `errors_are_proved`, else an estimate.
  std::vector<double> level_errors;
  bool errors_are_proved = false;

  /// Of the input, in its order; empty: those that `corner_features` give.
  std::vector<std::pair<Index, Index>> feature_edges;

  /// Counts and seconds of the simplification to the base; `proof_seconds` are those of all errors together.
  SimplifyReport report;

  std::size_t n_splits() const { return splits.size() + (mending.empty() ? 0 : 1); }
  std::size_t n_levels() const { return n_splits() + 1; }
  std::size_t n_faces() const { return face_offsets.size() - 1; }
  std::span<const Index> items_of(std::size_t split) const {
    const std::size_t first = splits[split].first,
                      last = split + 1 < splits.size() ? splits[split + 1].first : items.size();
    return {items.data() + first, last - first};
  }

  /// The finest level with at most `faces` faces, in splits; the base when none has so few.
  std::size_t level_for_faces(std::size_t faces) const;
  /// The coarsest level whose error is at most `error`, object units.
  std::size_t level_for_error(double error) const;
};

/// Simplifies and records the way back. The simplified surface is that of `simplify` with the same options.
/// Throws `OptionError` for options out of range, `InputError` for what `validate` refuses. Same result for
/// any number of threads.
ProgressiveMesh build_progressive_mesh(const PolygonSoup& soup, const ProgressiveOptions& options = {},
                                       Progress* progress = nullptr);

namespace detail {

/// The lists of a progressive mesh with some of its splits applied. Which may be applied when is the caller's
/// business: see `ProgressiveCursor` and `SelectiveMesh`.
class LevelState {
 public:
  /// No splits: the base.
  explicit LevelState(const ProgressiveMesh& mesh);

  /// Applies a split, or takes it back.
  template <bool refines>
  void apply(std::size_t split);
  template <bool refines>
  void apply_mending();
  /// What is there as polygons, in the order of the input; vertices without faces are left out. `is_input`:
  /// all is applied, so that they stay and the feature edges are the input's.
  PolygonSoup soup(bool is_input) const;

  const std::vector<Vec3>& positions() const { return positions_; }
  const std::vector<Index>& corner_vertices() const { return corner_vertices_; }
  bool is_face_alive(Index face) const { return face_alive_[face] != 0; }
  bool is_corner_alive(Index corner) const { return corner_alive_.empty() || corner_alive_[corner] != 0; }
  /// Of a corner; needs texture coordinates, normals.
  const Vec2& uv(Index corner) const { return wedge_uvs_[corner_wedges_[corner]]; }
  const Vec3& normal(Index corner) const { return wedge_normals_[corner_wedges_[corner]]; }
  const std::vector<Vec4>& colors() const { return colors_; }
  const std::vector<VertexScalar>& scalars() const { return scalars_; }

 private:
  template <bool refines>
  void apply_attributes(std::size_t split);
  void write_face(Index face, const std::vector<Index>& number, PolygonSoup& soup) const;

  const ProgressiveMesh* mesh_;
  bool has_attribute_changes_ = false;
  std::vector<Vec3> positions_;
  std::vector<Vec4> colors_;
  std::vector<VertexScalar> scalars_;
  std::vector<unsigned char> face_alive_, corner_alive_, corner_features_;
  std::vector<Index> corner_vertices_, corner_wedges_;
  std::vector<Vec2> wedge_uvs_;
  std::vector<Vec3> wedge_normals_;
};

/// All splits applied, but not what they don't cover (`ProgressiveMesh::mending`).
LevelState level_of_all_splits(const ProgressiveMesh& mesh);

}  // namespace detail

/// One level of a progressive mesh, which can be moved up and down. Moving takes time for the splits that it
/// passes and allocates nothing; several cursors may stand in one mesh at once.
class ProgressiveCursor {
 public:
  /// Stands at the base. `mesh` must live as long as the cursor and stay as it is.
  explicit ProgressiveCursor(const ProgressiveMesh& mesh) : mesh_(&mesh), state_(mesh) {}

  /// Number of splits of the level where the cursor stands.
  std::size_t level() const { return level_; }
  /// Applies or takes back splits. Throws `OptionError` when there are fewer than `level`.
  void move_to(std::size_t level);

  std::size_t n_faces() const { return mesh_->level_faces[level_]; }
  double error() const { return mesh_->level_errors[level_]; }

  /// The level as polygons, in the order of the input; vertices without faces are left out. At the full level
  /// the input itself, bit for bit.
  PolygonSoup soup() const { return state_.soup(level_ == mesh_->n_splits()); }

  // The level in the lists and numbers of `ProgressiveMesh`.
  const std::vector<Vec3>& positions() const { return state_.positions(); }
  const std::vector<Index>& corner_vertices() const { return state_.corner_vertices(); }
  bool is_face_alive(Index face) const { return state_.is_face_alive(face); }
  bool is_corner_alive(Index corner) const { return state_.is_corner_alive(corner); }
  const detail::LevelState& state() const { return state_; }

 private:
  const ProgressiveMesh* mesh_;
  std::size_t level_ = 0;
  detail::LevelState state_;
};

}  // namespace recede
