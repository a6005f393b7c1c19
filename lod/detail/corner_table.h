// The flat table that simplification works on: polygons as loops of corners, points as rings of corners. No
// objects, no allocation once it is built; edges with any number of faces are as good as others.
#pragma once

#include <recede/geometry/polygon_soup.h>

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

struct CornerTable {
  // By point.
  std::vector<Vec3> positions;      ///< in the unit box; see `to_unit`
  std::vector<Index> point_corner;  ///< a corner of the point's ring, or k_no_index: no faces, or collapsed
  std::vector<PointClass> classes;
  std::vector<Vec4> colors;  ///< empty: none

  // By corner. A dead corner has face k_no_index and is skipped in rings.
  std::vector<Index> point, face, next;  ///< `next` runs around the face
  std::vector<Index> sibling;            ///< next corner in the ring of the same point
  std::vector<Index> wedge;              ///< empty: no corner attributes
  std::vector<unsigned char> feature;    ///< empty: none; 1: the side to `next` is a feature edge

  // By face.
  std::vector<Index> face_corner;  ///< a corner, or k_no_index: removed
  std::vector<Index> face_size;
  std::vector<Index> face_material;  ///< empty: none

  std::vector<Wedge> wedges;
  bool has_uvs = false, has_normals = false;
  std::vector<Material> materials;

  std::size_t n_alive_faces = 0, n_alive_points = 0;
  // Object space = origin + scale * table space.
  Vec3 origin = Vec3::Zero();
  double scale = 1;

  bool is_alive(Index corner) const { return face[corner] != k_no_index; }
  Index previous(Index corner) const {
    Index before = next[corner];
    while (next[before] != corner) before = next[before];
    return before;
  }
  /// Calls `visit(corner)` for every live corner of the point.
  template <typename Visit>
  void each_corner(Index of_point, Visit&& visit) const {
    const Index start = point_corner[of_point];
    if (start == k_no_index) return;
    Index corner = start;
    do {
      if (is_alive(corner)) visit(corner);
      corner = sibling[corner];
    } while (corner != start);
  }
  /// Kind of the edge between two points; which seams count was decided when the table was built.
  unsigned edge_kind(Index a, Index b) const;
};

struct CornerTableOptions {
  bool keep_uv_seams = true, keep_normal_seams = true, lock_borders = false;
};

/// The table of a soup whose faces visit no vertex twice and whose vertices are merged by position.
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

/// Carries out a collapse that `CollapseRules` allowed. Constant work for each corner of `removed`.
CollapseEffect apply_collapse(CornerTable& table, const Collapse& collapse);

/// Takes dead corners out of all rings.
void unlink_dead_corners(CornerTable& table);

/// Live faces and points in table order, in object space. Vertices without faces are left out.
PolygonSoup to_soup(const CornerTable& table);

}  // namespace recede::detail
