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
#include <recede/lod/detail/texture_deviation.h>

namespace recede::detail {

/// A new point stays within this many edge lengths of the edge's middle: an ill-conditioned solve must not
/// throw it out of its neighbourhood.
inline constexpr double k_reach = 2.0;
/// Share of the squared edge length in the cost: orders what the triangles don't tell apart. At the noise of
/// single precision, in which edges are ranked.
inline constexpr double k_length_weight = 1e-7;

/// Where an edge goes and what that costs.
struct CollapsePlan {
  Collapse collapse;  ///< `removed` is k_no_index when the edge must stay
  double cost = 0;    ///< in the unit of `EdgeRanker::rank` with scale 1; see `plan_by_texture` for its own
  /// Root mean square distance of the new place from the planes and lines that it replaces.
  double deviation = 0;
  bool sets_attributes = false;  ///< those that count get new values, see `CollapsePlanner::set_attributes`
  /// Why the edge must stay, when that is neither its line nor its class.
  std::optional<Refusal> refused{};
};

/// Evaluates edges exactly. Keeps lists between edges, so that no memory is allocated: one object per thread.
class CollapsePlanner {
 public:
  /// `channels` are empty when no attribute counts.
  CollapsePlanner(const CornerTable& table, const AttributeChannels& channels, CostPolicy policy,
                  VertexPlacement placement)
      : table_(table),
        policy_(policy),
        placement_(placement),
        has_attributes_(!channels.empty()),
        attributes_(table, channels),
        texture_(table) {}

  /// `rings` are those of the edge, `first` as removed.
  CollapsePlan plan(const EdgeRings& rings, Index first, Index second);

  /// The better one of the ends for the edge that was planned last.
  CollapsePlan plan_at_an_end(Index first, Index second);
  /// The same as `plan` for two points that no edge connects.
  CollapsePlan plan_join(const EdgeRings& rings, const EdgeFreedom& freedom, Index first, Index second);

  /// After the last plan was carried out: the best values of the attributes that count.
  void set_attributes(CornerTable& table, const Collapse& collapse) {
    attributes_.write_best(table, collapse.kept, collapse.position - center_);
  }

 private:
  void gather(const EdgeRings& rings, Index first, Index second);
  void add_corner(const RingCorner& corner, Index at, Index other);
  void add_triangle(Index at, Index before, Index after);
  void add_lines(Index first, Index second);
  void add_line(const Vec3& through, const Vec3& along);
  void add_fold(Index point, Index before, Index after);
  Vec3 best_place(bool keep_volume) const;
  Vec3 best_place_on_line(const Vec3& before, const Vec3& after) const;
  CollapsePlan plan_at(Index removed, Index kept, const Vec3& place, double share) const;
  double doubled_area(const std::vector<RingCorner>& ring, Index point) const;
  CollapsePlan plan_by_texture(const EdgeRings& rings, const EdgeFreedom& freedom, Index first, Index second);
  CollapsePlan plan_at_ends(const EdgeFreedom& freedom, Index first, Index second);
  bool is_near(const Vec3& place, const EdgeRings& rings) const;
  bool is_free(const CollapsePlan& plan) const;

  const CornerTable& table_;
  CostPolicy policy_;
  VertexPlacement placement_;
  Vec3 center_ = Vec3::Zero();
  bool has_attributes_;
  AttributeCost attributes_;
  TextureDeviation texture_;
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
