// Which collapses are legal: the class of the ends, the link condition, duplicates, and what happens to the
// polygons.
#pragma once

#include <recede/lod/detail/corner_table.h>
#include <recede/lod/simplify.h>

#include <optional>

namespace recede::detail {

/// A live corner of a point with what stands beside it in its face.
struct RingCorner {
  Index corner, face, size;
  Index before, after;  ///< points of the previous and the next corner
  bool on_edge;         ///< the face has the edge in question
};

/// Both rings of an edge; kept between edges so that no memory is allocated.
struct EdgeRings {
  std::vector<RingCorner> removed, kept;
  void gather(const CornerTable& table, Index removed_point, Index kept_point);
  /// True when all points of the faces are numbered from `first` up to, not including, `last`.
  bool lie_within(const CornerTable& table, Index first, Index last) const;
};

/// Twice the vector area of a face, with `moved_a` and `moved_b` standing at `position` (k_no_index: nothing
/// moves).
Vec3 twice_vector_area(const CornerTable& table, Index face, Index moved_a = k_no_index,
                       Index moved_b = k_no_index, const Vec3& position = Vec3::Zero());

/// Which end of the edge may go and where the other may then stand.
struct EdgeFreedom {
  bool allowed = false;
  bool may_remove_first = false;   ///< first may go to second's place
  bool may_remove_second = false;  ///< second may go to first's place
  bool may_move = false;           ///< the remaining point may leave its place
};
EdgeFreedom edge_freedom(const CornerTable& table, Index first, Index second);

/// The same for joining two points that no edge connects: only corners and ends of lines keep their places,
/// and of two of those either may go to the other's. With `keep_fixed` they don't.
EdgeFreedom join_freedom(const CornerTable& table, Index first, Index second, bool keep_fixed);

/// How much a collapse breaks up polygons with more than three sides: 0 when triangles vanish on all faces of
/// the edge; 1 when some do, or when a quad's side opposite to the edge belongs to a triangle, so that the
/// two collapses together take a whole row of quads out; 2 when only larger polygons are shortened.
int polygon_loss(const CornerTable& table, Index first, Index second);

/// How far the collapse may take the surface from the input near the new point: the distance between the
/// places that the ends leave and the polygons that come, and between the new place and the polygons that go,
/// on top of what either end already stood off. `rings` are those of the edge.
double local_deviation(const CornerTable& table, const EdgeRings& rings, const Collapse& collapse);

/// Tests collapses on one table. Keeps lists between tests, so that no memory is allocated: one object per
/// thread.
class CollapseRules {
 public:
  /// `least_normal_cosine`: a polygon may turn in one collapse until the cosine between its normals falls to
  /// this.
  CollapseRules(const CornerTable& table, double least_normal_cosine);

  /// Why the collapse is refused, or nothing. `rings` are those of the edge.
  std::optional<Refusal> refusal(const EdgeRings& rings, const Collapse& collapse);
  /// The same for points that no edge connects. They may have common neighbours, whose edges become one.
  std::optional<Refusal> join_refusal(const EdgeRings& rings, const Collapse& collapse);

 private:
  bool breaks_link(const EdgeRings& rings, const Collapse& collapse);
  bool is_third(Index point) const;
  bool face_has_both(const RingCorner& corner, Index other) const;
  bool closes_crease(const Collapse& collapse) const;
  bool makes_duplicate(const EdgeRings& rings, const Collapse& collapse, bool look_at_all);
  std::optional<Refusal> shapes_refusal(const EdgeRings& rings, const Collapse& collapse) const;
  std::optional<Refusal> shape_refusal(const RingCorner& corner, Index moved, const Collapse& collapse) const;
  bool turns_corner(const RingCorner& corner, Index moved, const Collapse& collapse,
                    const Vec3& normal_before, const Vec3& normal_after) const;

  const CornerTable& table_;
  double least_cosine_;
  std::vector<Index> near_removed_;  // neighbours of the removed point
  std::vector<Index> thirds_;        // third corners of the triangles on the edge
  struct Shape {
    Index before, after, size, face;
  };
  std::vector<Shape> shapes_;
};

}  // namespace recede::detail
