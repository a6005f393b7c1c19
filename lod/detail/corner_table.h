// The flat table that simplification works on: polygons as loops of corners, points as rings of corners. No
// objects, no allocation once it is built; edges with any number of faces are as good as others.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/lod/detail/large_list.h>

#include <string>
#include <vector>

namespace recede::detail {

/// What makes an edge more than a place where two faces meet. Bits may combine.
enum EdgeKind : unsigned {
  k_smooth_edge = 0,
  k_border_edge = 1,      ///< one face
  k_many_faces_edge = 2,  ///< more than two, or two that disagree in orientation
  k_material_edge = 4,
  k_uv_seam_edge = 8,
  k_normal_seam_edge = 16,
  k_feature_edge = 32,
};

/// How freely a point may move; ordered by how little.
enum class PointClass : unsigned char {
  smooth,  ///< all its edges are smooth
  crease,  ///< on a line of two edges of the same kind: moves along it
  fixed,   ///< an end or meeting of such lines, or several fans of faces: others may come to it
};

/// What a corner carries beside its place; corners of one point that agree in it share a wedge.
struct Wedge {
  Vec2 uv = Vec2::Zero();
  Vec3 normal = Vec3::Zero();
};

/// Two points, the lower one first.
struct PointPair {
  Index first, second;
  auto operator<=>(const PointPair&) const = default;
};

/// Points are numbered along a space-filling curve and faces by their points, so that neighbours lie near
/// each other in memory and the numbering does not depend on that of the input. Between two calls of `pack`,
/// faces and corners only die and points only merge; numbers stay.
struct CornerTable {
  // By point.
  LargeList<Vec3> positions;  ///< in the unit box; see `origin` and `scale`
  LargeList<PointClass> classes;
  LargeList<float> deviation;      ///< how far removed points near it may stand off, in table units
  LargeList<unsigned char> held;   ///< 1: edges at the point stay; empty: all may go
  LargeList<Vec4> colors;          ///< empty: none
  LargeList<double> scalars;       ///< one for each of `scalar_names`, point after point
  LargeList<Index> source_vertex;  ///< in the input
  LargeList<Index> ring_start;     ///< one more than points: where the point's corners begin in `ring`
  LargeList<Index> merged;         ///< circular list of the points that became one since `pack`

  std::vector<PointPair> joins;  ///< points of different parts that may become one

  // By corner. Corners of a face of a table of triangles stand in threes.
  LargeList<Index> point;            ///< k_no_index: the corner is dead
  LargeList<Index> ring;             ///< corners sorted by the point that they had at `pack`
  LargeList<Index> wedge;            ///< empty: no corner attributes
  LargeList<unsigned char> feature;  ///< empty: none; 1: the side to the next corner is a feature edge
  LargeList<Index> source_corner;    ///< in the table as it was built; empty: collapses aren't logged

  // By face.
  LargeList<Index> source_face;           ///< in the input
  LargeList<Index> face_material;         ///< empty: none
  LargeList<unsigned char> double_sided;  ///< 1: the face stands for itself and its reverse; empty: none does

  // Only when some face has more than three sides.
  bool has_polygons = false;
  LargeList<Index> loop_next, corner_face;  ///< by corner
  LargeList<Index> loop_start, loop_size;   ///< by face: a corner, and the number of sides (0: dead)

  LargeList<Wedge> wedges;
  bool has_uvs = false, has_normals = false;
  std::vector<std::string> scalar_names;
  std::vector<Material> materials;

  std::size_t n_alive_faces = 0, n_alive_points = 0;  ///< double-sided faces count twice
  // Object space = origin + scale * table space.
  Vec3 origin = Vec3::Zero();
  double scale = 1;

  std::size_t n_points() const { return positions.size(); }
  std::size_t n_corners() const { return point.size(); }
  std::size_t n_faces() const { return source_face.size(); }

  Index next(Index corner) const {
    if (has_polygons) return loop_next[corner];
    return corner % 3 == 2 ? corner - 2 : corner + 1;
  }
  Index previous(Index corner) const {
    if (!has_polygons) return corner % 3 == 0 ? corner + 2 : corner - 1;
    Index before = loop_next[corner];
    while (loop_next[before] != corner) before = loop_next[before];
    return before;
  }
  Index face(Index corner) const { return has_polygons ? corner_face[corner] : corner / 3; }
  Index face_size(Index of_face) const { return has_polygons ? loop_size[of_face] : 3; }
  Index face_corner(Index of_face) const { return has_polygons ? loop_start[of_face] : 3 * of_face; }
  bool is_logged() const { return !source_corner.empty(); }
  bool is_held(Index a, Index b) const { return !held.empty() && (held[a] != 0 || held[b] != 0); }
  double* point_scalars(Index of_point) { return scalars.data() + of_point * scalar_names.size(); }
  const double* point_scalars(Index of_point) const {
    return scalars.data() + of_point * scalar_names.size();
  }
  Index sides(Index of_face) const { return double_sided.empty() ? 1 : 1 + double_sided[of_face]; }
  bool is_alive(Index corner) const { return point[corner] != k_no_index; }
  bool is_face_alive(Index of_face) const {
    return has_polygons ? loop_size[of_face] != 0 : is_alive(3 * of_face);
  }
  /// Point at the other end of the side that begins at the corner.
  Index point_after(Index corner) const { return point[next(corner)]; }
  Index point_before(Index corner) const { return point[previous(corner)]; }

  /// Calls `visit(corner)` for every live corner of the point.
  template <typename Visit>
  void each_corner(Index of_point, Visit&& visit) const {
    Index part = of_point;
    do {
      for (Index i = ring_start[part]; i < ring_start[part + 1]; ++i) {
        if (is_alive(ring[i])) visit(ring[i]);
      }
      part = merged[part];
    } while (part != of_point);
  }
  /// Calls `visit(corner)` for every corner of a live face, once around.
  template <typename Visit>
  void each_corner_of_face(Index of_face, Visit&& visit) const {
    Index corner = face_corner(of_face);
    for (Index i = face_size(of_face); i > 0; --i, corner = next(corner)) visit(corner);
  }
  /// Kind of the edge between two points; which seams count was decided when the table was built.
  unsigned edge_kind(Index a, Index b) const;
};

struct CornerTableOptions {
  bool keep_uv_seams = true, keep_normal_seams = true, lock_borders = false;
};

/// The table of a soup. Vertices at bit-equal positions become one point; what remains of faces that then
/// visit a point twice is as in `remove_degenerate_faces`.
CornerTable build_corner_table(const PolygonSoup& soup, const CornerTableOptions& options);

/// A collapse: `removed` goes to `kept`, which moves to `position`. `share` says where between them
/// attributes are taken: 0 at `removed`, 1 at `kept`.
struct Collapse {
  Index removed = k_no_index, kept = k_no_index;
  Vec3 position = Vec3::Zero();
  double share = 1;
};

/// What a collapse did to the counts.
struct CollapseEffect {
  Index edge_faces = 0, removed_faces = 0, lost_sides = 0;
};

/// Carries out a collapse that `CollapseRules` allowed; constant work for each corner of `removed`. The
/// counts of live faces and points are the caller's to keep, so that collapses that share no face may run in
/// parallel.
CollapseEffect apply_collapse(CornerTable& table, const Collapse& collapse);

/// Sorts the corners of a table without dead ones by their points.
void link_rings(CornerTable& table);

/// Takes out what is dead and numbers the rest anew, in the same order.
void pack(CornerTable& table);

/// Triangles over the points that cover the live faces, three points each.
std::vector<Index> fan_triangles(const CornerTable& table);

/// Live faces and points in the order of the input, in object space. Vertices without faces are left out. A
/// point that never moved has the bits of `source_positions`, those of the input.
PolygonSoup to_soup(const CornerTable& table, const std::vector<Vec3>& source_positions);

}  // namespace recede::detail
