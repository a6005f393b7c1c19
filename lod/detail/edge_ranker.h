// What collapsing an edge between smooth points would cost, roughly and quickly: enough to put edges in
// order.
//
// The cost is that of volume_cost.h, from one matrix of each end instead of the triangles around the edge;
// the triangles on the edge count twice. Single precision is enough, as all is relative to the edge. Several
// edges are ranked at once, number by number beside each other, which is what processors are good at.
#pragma once

#include <recede/lod/detail/attribute_cost.h>

namespace recede::detail {

/// A symmetric matrix; six numbers instead of nine. `Scalar` is a number, or an array of numbers side by
/// side.
template <typename Scalar>
struct SymmetricMatrix {
  Scalar xx, xy, xz, yy, yz, zz;
};

/// The sum of n n^T over the triangles around a point, n being twice the vector area, and the sum of n: all
/// triangles pass through the point, so that is all there is to know.
struct PointMatrix {
  SymmetricMatrix<float> squares{};
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
};

/// Adds v v^T.
inline void add_square(SymmetricMatrix<float>& matrix, const Eigen::Vector3f& v) {
  matrix.xx += v.x() * v.x();
  matrix.xy += v.x() * v.y();
  matrix.xz += v.x() * v.z();
  matrix.yy += v.y() * v.y();
  matrix.yz += v.y() * v.z();
  matrix.zz += v.z() * v.z();
}

/// Ranks edges of one table. The lists by point are the caller's to fill before ranking.
class EdgeRanker {
 public:
  /// Edges that are ranked at once.
  static constexpr std::size_t k_lanes = 8;

  EdgeRanker(const CornerTable& table, const AttributeChannels& channels, VertexPlacement placement)
      : table_(table), channels_(channels), placement_(placement) {}

  /// Begins a pass over a packed table. `scale` multiplies lengths; about one over an edge's length keeps the
  /// numbers near 1.
  void start(double scale);
  /// Makes what ranking needs of the points from `first` to before `last`, in any order.
  void prepare(Index first, Index last);

  /// Costs of at most `k_lanes` edges between smooth points, in units of the sixth power of 1 / scale.
  void rank(std::span<const PointPair> edges, float* costs) const;

 private:
  Eigen::Vector3f corner_normal(Index corner) const;
  void measure_normals();
  PointMatrix point_matrix(Index point) const;

  const CornerTable& table_;
  const AttributeChannels& channels_;
  VertexPlacement placement_;
  double scale_ = 1;
  LargeList<Eigen::Vector3f> normals_;  // by face, twice the vector area; empty with polygons
  LargeList<PointMatrix> matrices_;     // by point
  LargeList<float> sums_;               // by point, see `add_rank_sums`
};

}  // namespace recede::detail
