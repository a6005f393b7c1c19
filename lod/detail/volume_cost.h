// What a collapse costs, and the best place for the point that remains.
//
// P. Lindstrom, G. Turk: Fast and Memory Efficient Polygonal Simplification. Visualization 1998.
//
// Every triangle that moves with the edge sweeps a volume that is linear in the new place x: n.(x - v), where
// v is the triangle's moving corner and n twice its vector area. The cost is the sum of the squared volumes;
// the new place is the best of those where the volumes cancel, so that the enclosed volume stays. Along lines
// (borders, creases, seams) the areas swept by the line's pieces count likewise, and there the new place is
// the best of those where the areas cancel: straight lines stay straight, flat ones flat. Nothing is
// remembered from earlier collapses: all is measured on the surface as it stands. Polygons with more than
// three sides count by their ears: the triangle at each corner, which is all of the polygon that moves with
// it.
#pragma once

#include <recede/lod/detail/attribute_cost.h>

namespace recede::detail {

/// A symmetric matrix in single precision; six numbers instead of nine.
struct SymmetricMatrix {
  float xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;

  float trace() const { return xx + yy + zz; }
  Eigen::Vector3f times(const Eigen::Vector3f& v) const {
    return {xx * v.x() + xy * v.y() + xz * v.z(), xy * v.x() + yy * v.y() + yz * v.z(),
            xz * v.x() + yz * v.y() + zz * v.z()};
  }
  /// v . M v
  float form(const Eigen::Vector3f& v) const { return v.dot(times(v)); }
  /// Adds factor v v^T.
  void add_square(const Eigen::Vector3f& v, float factor = 1) {
    const Eigen::Vector3f w = factor * v;
    xx += w.x() * v.x();
    xy += w.x() * v.y();
    xz += w.x() * v.z();
    yy += w.y() * v.y();
    yz += w.y() * v.z();
    zz += w.z() * v.z();
  }
  /// scale * (this + sign * other)
  SymmetricMatrix combined(const SymmetricMatrix& other, float sign, float scale) const {
    return {scale * (xx + sign * other.xx), scale * (xy + sign * other.xy), scale * (xz + sign * other.xz),
            scale * (yy + sign * other.yy), scale * (yz + sign * other.yz), scale * (zz + sign * other.zz)};
  }
  /// The inverse times the determinant, which goes to `determinant`.
  SymmetricMatrix adjugate(float& determinant) const {
    const SymmetricMatrix result{yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy,
                                 xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy};
    determinant = xx * result.xx + xy * result.xy + xz * result.xz;
    return result;
  }
};

/// The sum of n n^T over the triangles around a point, and the sum of n: enough for the cost of an edge,
/// because all triangles pass through the point. Float is enough to rank, as all is relative to the point.
struct PointMatrix {
  SymmetricMatrix squares;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
};

/// `scale` multiplies lengths; about one over an edge's length keeps the numbers near 1.
PointMatrix point_matrix(const CornerTable& table, Index point, double scale);

/// Cost of collapsing an edge between smooth points, from the matrices of its ends; the triangles on the edge
/// count twice. An approximation for ranking; `scale` as in the matrices. `sums_at_first` and
/// `sums_at_second` are those of `add_rank_sums`, empty without attributes.
float rank_smooth_edge(const Vec3& first, const Vec3& second, const PointMatrix& at_first,
                       const PointMatrix& at_second, std::span<const float> sums_at_first,
                       std::span<const float> sums_at_second, double scale, VertexPlacement placement);

/// Where an edge goes and what that costs.
struct CollapsePlan {
  Collapse collapse;  ///< `removed` is k_no_index when the edge must stay
  double cost = 0;    ///< in the unit of `rank_smooth_edge` with scale 1
  /// Root mean square distance of the new place from the planes and lines that it replaces.
  double deviation = 0;
  bool sets_attributes = false;  ///< those that count get new values, see `CollapsePlanner::set_attributes`
};

/// Evaluates edges exactly. Keeps lists between edges, so that no memory is allocated: one object per thread.
class CollapsePlanner {
 public:
  /// `channels` are empty when no attribute counts.
  CollapsePlanner(const CornerTable& table, const AttributeChannels& channels, VertexPlacement placement)
      : table_(table),
        placement_(placement),
        has_attributes_(!channels.empty()),
        attributes_(table, channels) {}

  /// `rings` are those of the edge, `first` as removed.
  CollapsePlan plan(const EdgeRings& rings, Index first, Index second);

  /// The same for two points that no edge connects.
  CollapsePlan plan_join(const EdgeRings& rings, const EdgeFreedom& freedom, Index first, Index second);

  /// After the last plan was carried out: the best values of the attributes that count.
  void set_attributes(CornerTable& table, const Collapse& collapse) {
    attributes_.write_best(table, collapse.kept, collapse.position - center_);
  }

 private:
  void gather(const EdgeRings& rings, Index first, Index second);
  void add_corner(const RingCorner& corner, Index other);
  void add_triangle(Index at, Index before, Index after);
  void add_lines(Index first, Index second);
  void add_line(const Vec3& through, const Vec3& along);
  void add_fold(Index point, Index before, Index after);
  Vec3 best_place(bool keep_volume) const;
  Vec3 best_place_on_line(const Vec3& before, const Vec3& after) const;
  CollapsePlan plan_at(Index removed, Index kept, const Vec3& place, double share) const;
  CollapsePlan plan_at_ends(const EdgeFreedom& freedom, Index first, Index second);
  bool is_near(const Vec3& place, const EdgeRings& rings) const;
  bool is_free(const CollapsePlan& plan) const;

  const CornerTable& table_;
  VertexPlacement placement_;
  Vec3 center_ = Vec3::Zero();
  bool has_attributes_;
  AttributeCost attributes_;
  QuadraticForm shape_, cost_;  // what is swept; and with attributes
  // The volume stays where volume_normal.x = volume.
  Vec3 volume_normal_ = Vec3::Zero();
  double volume_ = 0;
  Vec3 half_edge_ = Vec3::Zero();  // from the middle to the second point
  double half_length_squared_ = 0;
  std::vector<Index> neighbours_;
  Index line_before_ = k_no_index, line_after_ = k_no_index;  // where the line through the edge goes on
};

}  // namespace recede::detail
