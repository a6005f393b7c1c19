#include <recede/lod/detail/volume_cost.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {
namespace {

/// Pull towards the middle of the edge where the triangles leave the place open, as a share of their weight.
constexpr double k_regularization = 1e-7;
/// Share of an edge length that a new point may lie out of the box around the neighbours.
constexpr double k_reach_out = 0.5;
/// Weight of the squared area that a line sweeps, times its squared length, against the squared volumes. With
/// volumes of tetrahedra (1/6 of the product) and areas of triangles (1/2), the source's equal weights.
constexpr double k_line_weight = 9.0;

/// Share of the texture deviation that an edge's ends had already in the cost of their collapse. With all of
/// it the largest deviation is least, with nothing the mean: between them.
constexpr double k_so_far = 0.3;
/// Cost over weight and squared half edge length that counts as none.
constexpr double k_flat = 1e-20;

/// Calls `visit(q)` for every neighbour to which a line of borders, creases or seams runs from `point`.
template <typename Visit>
void each_line_neighbour(const CornerTable& table, Index point, std::vector<Index>& seen, Visit&& visit) {
  if (table.classes[point] == PointClass::smooth) return;
  seen.clear();
  table.each_corner(point, [&](Index corner) {
    for (const Index q : {table.point_after(corner), table.point_before(corner)}) {
      if (table.classes[q] == PointClass::smooth || std::find(seen.begin(), seen.end(), q) != seen.end())
        continue;
      seen.push_back(q);
      if (table.edge_kind(point, q) != k_smooth_edge) visit(q);
    }
  });
}

/// Squared area that a piece of line sweeps, as a matrix: that of |along|^2 |along x d|^2.
Eigen::Matrix3d line_matrix(const Vec3& along) {
  const double squared = along.squaredNorm();
  return k_line_weight * squared * (squared * Eigen::Matrix3d::Identity() - along * along.transpose());
}

}  // namespace

/// The triangle between three points, of which `at` moves. Of the matrix only the lower half is kept until
/// `gather` is done.
void CollapsePlanner::add_triangle(Index at, Index before, Index after) {
  const Vec3 from = table_.positions[at] - center_;
  const Vec3 normal =
      (table_.positions[after] - table_.positions[at]).cross(table_.positions[before] - table_.positions[at]);
  const double offset = normal.dot(from);
  shape_.matrix.col(0) += normal.x() * normal;
  shape_.matrix(1, 1) += normal.y() * normal.y();
  shape_.matrix(2, 1) += normal.y() * normal.z();
  shape_.matrix(2, 2) += normal.z() * normal.z();
  shape_.pull += offset * normal;
  shape_.constant += offset * offset;
  volume_normal_ += normal;
  volume_ += offset;
}

void CollapsePlanner::add_line(const Vec3& through, const Vec3& along) {
  const Eigen::Matrix3d m = line_matrix(along);
  shape_.matrix += m;
  shape_.pull += m * through;
  shape_.constant += through.dot(m * through);
}

/// Adds what moves with a corner of `at`. A polygon on the edge counts as the triangle between the edge and
/// the corner before it, and the triangle that is left at the edge's far end; both are met where the side
/// begins.
void CollapsePlanner::add_corner(const RingCorner& corner, Index at, Index other) {
  if (corner.on_edge && corner.after != other) return;
  add_triangle(at, corner.before, corner.after);
  const bool is_cut = corner.on_edge && corner.size > 3;
  if (!is_cut && !has_attributes_) return;
  const Index c = corner.corner, after = table_.next(c), before = table_.previous(c);
  if (has_attributes_) attributes_.add_triangle(c, before, after);
  if (!is_cut) return;
  const Index beyond = table_.next(after);
  add_triangle(other, corner.before, table_.point[beyond]);
  if (has_attributes_) attributes_.add_triangle(after, before, beyond);
}

/// A point where a line turns back is the end of something thin, whose loss sweeps no area. Moving it inwards
/// counts as if the line went across there, by how much it turns back.
void CollapsePlanner::add_fold(Index point, Index before, Index after) {
  const Vec3& at = table_.positions[point];
  const Vec3 in = at - table_.positions[before], out = table_.positions[after] - at;
  const double in_length = in.norm(), out_length = out.norm();
  if (!(in.dot(out) < 0)) return;
  const Vec3 outwards = (in / in_length - out / out_length).normalized();
  const double cosine = in.dot(out) / (in_length * out_length);
  const double weight = -cosine * k_line_weight * std::pow(in_length * out_length, 2);
  shape_.add_square(outwards, -outwards.dot(at - center_), weight);
}

void CollapsePlanner::add_lines(Index first, Index second) {
  line_before_ = line_after_ = k_no_index;
  const auto add = [&](Index from, Index to) {
    add_line(table_.positions[from] - center_, table_.positions[to] - table_.positions[from]);
  };
  bool is_line = false;
  each_line_neighbour(table_, first, neighbours_, [&](Index q) {
    add(first, q);
    if (q == second) is_line = true;
    if (q != second) line_before_ = q;
  });
  each_line_neighbour(table_, second, neighbours_, [&](Index q) {
    if (q == first) return;  // the edge itself counts once
    add(second, q);
    line_after_ = q;
  });
  if (is_line && line_before_ != k_no_index) add_fold(first, line_before_, second);
  if (is_line && line_after_ != k_no_index) add_fold(second, first, line_after_);
}

void CollapsePlanner::gather(const EdgeRings& rings, Index first, Index second) {
  const Vec3 &p = table_.positions[first], &q = table_.positions[second];
  center_ = 0.5 * (p + q);
  half_edge_ = 0.5 * (q - p);
  half_length_squared_ = half_edge_.squaredNorm();
  shape_ = {};
  volume_normal_.setZero();
  volume_ = 0;
  if (has_attributes_) attributes_.start(rings, first, second, center_);
  for (const RingCorner& corner : rings.removed) add_corner(corner, first, second);
  // Sides that run from second to first begin there.
  for (const RingCorner& corner : rings.kept) add_corner(corner, second, first);
  shape_.matrix(0, 1) = shape_.matrix(1, 0);
  shape_.matrix(0, 2) = shape_.matrix(2, 0);
  shape_.matrix(1, 2) = shape_.matrix(2, 1);
  add_lines(first, second);
  cost_ = shape_;
  if (has_attributes_) cost_ += attributes_.form();
}

/// Least cost among the places that keep the volume, or among all.
Vec3 CollapsePlanner::best_place(bool keep_volume) const {
  Eigen::Matrix3d regular = cost_.matrix;
  regular.diagonal().array() += k_regularization * cost_.matrix.trace();
  const Eigen::Matrix3d inverse = regular.inverse();
  Vec3 place = inverse * cost_.pull;
  // One step of refinement takes the pull out of the directions that the triangles do determine.
  place += inverse * (cost_.pull - cost_.matrix * place);
  if (!keep_volume) return place;
  const Vec3 way = inverse * volume_normal_;
  const double slope = volume_normal_.dot(way);
  if (slope > 0) place += way * ((volume_ - volume_normal_.dot(place)) / slope);
  return place;
}

/// Least cost among the places where the line from `before` over the new place to `after` sweeps no area in
/// sum: x cross (after - before) is what it was, which leaves a line for x.
Vec3 CollapsePlanner::best_place_on_line(const Vec3& before, const Vec3& after) const {
  const Vec3 along = after - before;
  const Vec3 p = -half_edge_, q = half_edge_;
  const double length = along.squaredNorm();
  // Where the line turns back, keeping the area would move its end away.
  constexpr double k_straight = 0.5;
  const double way = (p - before).norm() + (q - p).norm() + (after - q).norm();
  if (!(length > k_straight * k_straight * way * way)) return best_place(false);
  const Vec3 area = before.cross(p) + p.cross(q) + q.cross(after);
  const Vec3 through = along.cross(area) / length;
  const double curvature = along.dot(cost_.matrix * along);
  // Without curvature the middle is as good as any place.
  const double step = curvature > k_regularization * cost_.matrix.trace() * length
                          ? along.dot(cost_.pull - cost_.matrix * through) / curvature
                          : -along.dot(through) / length;
  return through + step * along;
}

/// True for a place, relative to the middle, that an edge may send its point to.
bool CollapsePlanner::is_near(const Vec3& place, const EdgeRings& rings) const {
  const double squared = place.squaredNorm();
  if (!(squared <= 4 * k_reach * k_reach * half_length_squared_)) return false;
  // The box has the middle in it.
  if (squared <= 4 * k_reach_out * k_reach_out * half_length_squared_) return true;
  Box3 box;
  box.extend(-half_edge_).extend(half_edge_);
  for (const auto* ring : {&rings.removed, &rings.kept}) {
    for (const RingCorner& c : *ring) {
      box.extend(table_.positions[c.after] - center_).extend(table_.positions[c.before] - center_);
    }
  }
  const double out = 2 * k_reach_out * std::sqrt(half_length_squared_);
  return ((place - box.min()).array() >= -out).all() && ((box.max() - place).array() >= -out).all();
}

/// True when what the collapse costs beside its length is rounding.
bool CollapsePlanner::is_free(const CollapsePlan& plan) const {
  return plan.cost <= (k_length_weight + k_flat) * shape_.matrix.trace() * half_length_squared_;
}

CollapsePlan CollapsePlanner::plan_at(Index removed, Index kept, const Vec3& place, double share) const {
  const double weight = shape_.matrix.trace();
  const double cost = cost_.at(place) + k_length_weight * weight * half_length_squared_;
  return {{removed, kept, place + center_, share},
          cost,
          weight > 0 ? std::sqrt(shape_.at(place) / weight) : 0,
          has_attributes_,
          {}};
}

/// The better of the ends to which the edge may shrink.
CollapsePlan CollapsePlanner::plan_at_ends(const EdgeFreedom& freedom, Index first, Index second) {
  CollapsePlan best;
  const auto consider = [&](Index removed, Index kept) {
    const Vec3 place = table_.positions[kept] - center_;
    CollapsePlan plan = plan_at(removed, kept, place, 1);
    plan.sets_attributes = false;  // they stay with their point
    if (has_attributes_) plan.cost += attributes_.cost_of_keeping(kept, place);
    plan.collapse.position = table_.positions[kept];  // its very bits
    if (best.collapse.removed == k_no_index || plan.cost < best.cost) best = plan;
  };
  if (freedom.may_remove_first) consider(first, second);
  if (freedom.may_remove_second) consider(second, first);
  return best;
}

CollapsePlan CollapsePlanner::plan_at_an_end(Index first, Index second) {
  if (policy_ == CostPolicy::texture_deviation) return {};  // its plans are at ends
  return plan_at_ends(edge_freedom(table_, first, second), first, second);
}

CollapsePlan CollapsePlanner::plan_join(const EdgeRings& rings, const EdgeFreedom& freedom, Index first,
                                        Index second) {
  gather(rings, first, second);
  const Vec3 place = freedom.may_move ? best_place(true) : Vec3::Zero();
  if (placement_ == VertexPlacement::half_edge || !freedom.may_move || !is_near(place, rings)) {
    return plan_at_ends(freedom, first, second);
  }
  return plan_at(first, second, placement_ == VertexPlacement::midpoint ? Vec3::Zero() : place, 0.5);
}

/// Twice the area of the triangles between a point and its neighbours.
double CollapsePlanner::doubled_area(const std::vector<RingCorner>& ring, Index point) const {
  const Vec3& middle = table_.positions[point];
  double area = 0;
  for (const RingCorner& c : ring) {
    area += (table_.positions[c.after] - middle).cross(table_.positions[c.before] - middle).norm();
  }
  return area;
}

/// Cheap first: a small deviation, where little of the surface has it. With the cube root of the area the
/// shape is within 1.3 times of what half-edge collapses can do for it, and the largest deviation grows
/// little; without area, or with its square root, the one or the other is worse.
CollapsePlan CollapsePlanner::plan_by_texture(const EdgeRings& rings, const EdgeFreedom& freedom, Index first,
                                              Index second) {
  CollapsePlan best;
  best.refused = Refusal::flip;
  const auto so_far = static_cast<double>(std::max(table_.deviation[first], table_.deviation[second]));
  const auto consider = [&](const std::vector<RingCorner>& ring, Index removed, Index kept) {
    const auto deviation = texture_.measure(ring, removed, kept);
    if (!deviation || (!best.refused && *deviation >= best.deviation)) return;
    const double cost = (*deviation + k_so_far * so_far) * std::cbrt(doubled_area(ring, removed));
    best = {{removed, kept, table_.positions[kept], 1}, cost, *deviation, false, {}};
  };
  if (freedom.may_remove_first) consider(rings.removed, first, second);
  if (freedom.may_remove_second) consider(rings.kept, second, first);
  return best;
}

CollapsePlan CollapsePlanner::plan(const EdgeRings& rings, Index first, Index second) {
  const EdgeFreedom freedom = edge_freedom(table_, first, second);
  if (!freedom.allowed) return {};
  if (policy_ == CostPolicy::texture_deviation) return plan_by_texture(rings, freedom, first, second);
  gather(rings, first, second);
  if (placement_ == VertexPlacement::half_edge || !freedom.may_move) {
    return plan_at_ends(freedom, first, second);
  }
  Vec3 place = Vec3::Zero();
  if (placement_ != VertexPlacement::midpoint) {
    place = line_before_ == k_no_index || line_after_ == k_no_index
                ? best_place(true)
                : best_place_on_line(table_.positions[line_before_] - center_,
                                     table_.positions[line_after_] - center_);
  }
  if (!is_near(place, rings)) return plan_at_ends(freedom, first, second);
  const double share = half_length_squared_ > 0
                           ? std::clamp(0.5 + 0.5 * place.dot(half_edge_) / half_length_squared_, 0.0, 1.0)
                           : 1;
  const CollapsePlan best = freedom.may_remove_first ? plan_at(first, second, place, share)
                                                     : plan_at(second, first, place, 1 - share);
  if (placement_ == VertexPlacement::midpoint || !is_free(best)) return best;
  // Where it costs nothing either way, what stays is a point of the input.
  const CollapsePlan at_end = plan_at_ends(freedom, first, second);
  return is_free(at_end) ? at_end : best;
}

}  // namespace recede::detail
