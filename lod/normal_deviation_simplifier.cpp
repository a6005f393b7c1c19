// Sweeps of collapses that turn polygons least.
//
// S. Ramsey, M. Bertram, C. Hansen: Simplification of Arbitrary Polyhedral Meshes. CGIM 2003.
//
// The source draws k edges at random for every collapse and takes the best. Drawing k of N edges with
// replacement and taking the best is the same as taking the edge of rank N (1 - u^(1/k)) for a uniform u, so
// costs are kept in rank order, brought up to date when a polygon near the edge changes, and one random
// number replaces k evaluations. What the source leaves open: borders, seams and non-manifold edges collapse
// along themselves only, and there the direction of the line counts like a normal; the link condition and the
// shape rules of all strategies apply.
#include <recede/lod/detail/polygon_normal.h>
#include <recede/lod/detail/rank_buckets.h>
#include <recede/lod/detail/simplifier.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace recede::detail {
namespace {

/// Factor on the cost for each step of `polygon_loss`.
constexpr double k_polygon_loss = 32;

/// A point with more polygons than this is never removed: with so many around it, one of them would turn too
/// far, and looking at all of them for every edge would take quadratic time.
constexpr Index k_hub = 256;

struct Edge {
  Index first, second;
};

/// What a collapse of an edge would do at best: 1 minus the least dot product, and which end goes.
struct EdgeCost {
  double cost = 4;  ///< above every possible value: not permitted
  bool removes_first = true;
  double rank = 4;  ///< cost by which edges are ordered
};

class NormalDeviationSimplifier final : public Simplifier {
 public:
  NormalDeviationSimplifier(CornerTable table, const SimplifyOptions& options)
      : Simplifier(std::move(table), options,
                   std::max(0.0, std::min(options.normal_threshold, k_least_cosine))),
        random_(options.seed),
        draws_(std::ceil(options.candidate_share * static_cast<double>(table_.n_alive_faces))),
        use_corner_normals_(options.polygon_normal == PolygonNormal::source && table_.has_normals) {}

 private:
  // The cost itself watches how far polygons turn; the shape rule only keeps them from turning over.
  static constexpr double k_least_cosine = 0.0;

  std::size_t pass(const Limits& limits, Progress* progress) override;

  void start_sweep();
  void list_edges();
  void rank_all_edges();
  Vec3 normal(Index face, const Collapse& collapse) const;
  Vec3 corner_normal_mean(Index face, const Collapse& collapse) const;
  EdgeCost evaluate(const Edge& edge) const;
  double cost_of(const Collapse& collapse) const;
  double line_turn(const Collapse& collapse) const;
  Collapse make_collapse(const Edge& edge, bool removes_first) const;
  bool is_eligible(const Edge& edge) const;
  Index draw();
  bool commit(Index edge, const Limits& limits);
  void update_around(const std::vector<Index>& changed_faces);

  std::mt19937_64 random_;
  double draws_;
  bool use_corner_normals_;
  std::vector<Index> valence_;          // by point: corners at the start of this sweep
  std::vector<unsigned char> altered_;  // by face: changed in this sweep
  std::vector<Vec3> normals_;           // by face: unit, or zero where there is none
  std::vector<Edge> edges_;             // of this sweep
  std::vector<Index> edge_of_side_;     // by corner: edge of its side
  std::vector<EdgeCost> costs_;         // by edge
  std::unique_ptr<RankBuckets> ranked_;
  EdgeRings rings_;
  std::vector<Index> changed_, stale_;
  std::vector<Index> stale_mark_;  // by edge
  Index stale_epoch_ = 0;
};

/// Direction of a polygon with the collapse carried out; see `PolygonNormal`. Zero where there is none.
Vec3 NormalDeviationSimplifier::normal(Index face, const Collapse& collapse) const {
  if (!table_.is_face_alive(face)) return Vec3::Zero();
  constexpr std::size_t k_on_stack = 32;  // larger polygons are rare and may allocate
  std::array<Vec3, k_on_stack> buffer;
  std::vector<Vec3> large;
  if (table_.face_size(face) > k_on_stack) large.resize(table_.face_size(face));
  Vec3* const points = large.empty() ? buffer.data() : large.data();
  std::size_t n = 0;
  bool met = false;  // the new point stands once, although both ends may be corners
  table_.each_corner_of_face(face, [&](Index corner) {
    const Index p = table_.point[corner];
    const bool moves = p == collapse.removed || p == collapse.kept;
    if (moves && met) return;
    met = met || moves;
    points[n++] = moves ? collapse.position : table_.positions[p];
  });
  const std::span<const Vec3> polygon(points, n);
  if (options_.polygon_normal == PolygonNormal::vector_area) return vector_area_normal(polygon);
  const Vec3 by_corners = corner_average_normal(polygon);
  if (!use_corner_normals_ || by_corners.isZero(0)) return by_corners;
  const Vec3 mean = corner_normal_mean(face, collapse);
  return mean.isZero(0) ? by_corners : Vec3(mean.normalized());
}

Vec3 NormalDeviationSimplifier::corner_normal_mean(Index face, const Collapse& collapse) const {
  Vec3 sum = Vec3::Zero();
  table_.each_corner_of_face(face, [&](Index corner) {
    if (table_.point[corner] != collapse.removed) {
      sum += table_.wedges[table_.wedge[corner]].normal;
      return;
    }
    // The removed point's corner takes the kept one's normal, from a face that has the edge.
    Index at_kept = k_no_index;
    table_.each_corner(collapse.kept, [&](Index c) {
      const Index before = table_.point_before(c), after = table_.point_after(c);
      if (before == collapse.removed || after == collapse.removed) at_kept = c;
    });
    if (at_kept != k_no_index) sum += table_.wedges[table_.wedge[at_kept]].normal;
  });
  return sum;
}

Collapse NormalDeviationSimplifier::make_collapse(const Edge& edge, bool removes_first) const {
  Collapse collapse;
  collapse.removed = removes_first ? edge.first : edge.second;
  collapse.kept = removes_first ? edge.second : edge.first;
  collapse.position = table_.positions[collapse.kept];
  if (options_.placement != VertexPlacement::midpoint ||
      !edge_freedom(table_, edge.first, edge.second).may_move) {
    return collapse;
  }
  collapse.position = 0.5 * (table_.positions[edge.first] + table_.positions[edge.second]);
  collapse.share = 0.5;
  return collapse;
}

/// 1 minus the least dot product of the normals before and after, over the polygons that change and stay.
double NormalDeviationSimplifier::cost_of(const Collapse& collapse) const {
  double least = 1;
  const auto look = [&](Index of, Index other, bool skip_edge_faces) {
    table_.each_corner(of, [&](Index corner) {
      const Index f = table_.face(corner);
      const bool on_edge = table_.point_after(corner) == other || table_.point_before(corner) == other;
      if (on_edge && (skip_edge_faces || table_.face_size(f) == 3)) return;
      const Vec3& before = normals_[f];
      if (before.isZero(0)) return;
      const Vec3 after = normal(f, collapse);
      least = std::min(least, after.isZero(0) ? -1.0 : before.dot(after));
    });
  };
  look(collapse.removed, collapse.kept, false);
  if (collapse.position != table_.positions[collapse.kept]) look(collapse.kept, collapse.removed, true);
  if (table_.classes[collapse.removed] != PointClass::smooth) least = std::min(least, line_turn(collapse));
  return 1 - least;
}

/// Least dot product between the directions of the line of creases through the edge, before and after.
double NormalDeviationSimplifier::line_turn(const Collapse& collapse) const {
  double least = 1;
  const auto compare = [&](const Vec3& before, const Vec3& after) {
    const double lengths = before.norm() * after.norm();
    if (lengths > 0) least = std::min(least, before.dot(after) / lengths);
  };
  const auto look = [&](Index end, Index other) {
    table_.each_corner(end, [&](Index corner) {
      for (const Index q : {table_.point_after(corner), table_.point_before(corner)}) {
        if (q == other || table_.classes[q] == PointClass::smooth ||
            table_.edge_kind(end, q) == k_smooth_edge)
          continue;
        const Vec3 &at_end = table_.positions[end], &at_q = table_.positions[q],
                   &at_other = table_.positions[other];
        compare(at_q - at_end, at_q - collapse.position);
        // The collapsed piece itself becomes part of the line to q.
        compare(at_end - at_other, at_q - collapse.position);
      }
    });
  };
  look(collapse.removed, collapse.kept);
  if (collapse.position != table_.positions[collapse.kept]) look(collapse.kept, collapse.removed);
  return least;
}

EdgeCost NormalDeviationSimplifier::evaluate(const Edge& edge) const {
  const EdgeFreedom freedom = edge_freedom(table_, edge.first, edge.second);
  EdgeCost best;
  const bool may_remove_first = freedom.may_remove_first && valence_[edge.first] <= k_hub;
  const bool may_remove_second = freedom.may_remove_second && valence_[edge.second] <= k_hub;
  if (may_remove_first) best = {cost_of(make_collapse(edge, true)), true};
  const bool same_either_way = options_.placement == VertexPlacement::midpoint && freedom.may_move;
  if (may_remove_second && !(may_remove_first && same_either_way)) {
    const double cost = cost_of(make_collapse(edge, false));
    if (cost < best.cost) best = {cost, false};
  }
  best.rank = std::max(0.0, best.cost);
  if (options_.keep_polygons)
    best.rank *= std::pow(k_polygon_loss, polygon_loss(table_, edge.first, edge.second));
  return best;
}

/// Lists the edges of the table as it stands and names them in every corner.
void NormalDeviationSimplifier::list_edges() {
  edges_.clear();
  edge_of_side_.assign(table_.n_corners(), k_no_index);
  // The edge to a point and the point from which it was last met: finds an edge at once, also at hubs.
  std::vector<Edge> last(table_.n_points(), {k_no_index, k_no_index});
  for (Index p = 0; p < table_.n_points(); ++p) {
    const auto name = [&](Index side, Index q) {
      if (q < p) return;
      if (last[q].first != p) {
        last[q] = {p, static_cast<Index>(edges_.size())};
        edges_.push_back({p, q});
      }
      edge_of_side_[side] = last[q].second;
    };
    table_.each_corner(p, [&](Index corner) {
      name(corner, table_.point_after(corner));
      const Index before = table_.previous(corner);
      name(before, table_.point[before]);
    });
  }
}

void NormalDeviationSimplifier::rank_all_edges() {
  costs_.assign(edges_.size(), {});
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, edges_.size(), 1024), [&](const auto& range) {
    for (std::size_t e = range.begin(); e < range.end(); ++e) costs_[e] = evaluate(edges_[e]);
  });
  ranked_ = std::make_unique<RankBuckets>(edges_.size());
  const double most = 1 - options_.normal_threshold;
  for (Index e = 0; e < edges_.size(); ++e) {
    if (costs_[e].cost < most)
      ranked_->set(e, costs_[e].rank);
    else if (table_.is_held(edges_[e].first, edges_[e].second))
      ++counts_.refused[Refusal::error];
    else if (costs_[e].cost <= 2)
      ++counts_.refused[Refusal::deviation];
    else
      ++counts_.refused[Refusal::border];
  }
  stale_mark_.assign(edges_.size(), 0);
  stale_epoch_ = 0;
}

/// The best of `draws_` edges drawn at random among the permitted ones.
Index NormalDeviationSimplifier::draw() {
  const double u = static_cast<double>(random_() >> 11) * 0x1p-53;
  const double share = 1 - std::pow(1 - u, 1 / draws_);
  const auto n = static_cast<double>(ranked_->size());
  return ranked_->at_rank(std::min(static_cast<std::size_t>(share * n), ranked_->size() - 1));
}

bool NormalDeviationSimplifier::commit(Index edge, const Limits& limits) {
  const Collapse collapse = make_collapse(edges_[edge], costs_[edge].removes_first);
  rings_.gather(table_, collapse.removed, collapse.kept);
  if (const auto refused = rules_.refusal(rings_, collapse)) {
    ++counts_.refused[*refused];
    return false;
  }
  const double deviation = local_deviation(table_, rings_, collapse);
  if (deviation > limits.error) {
    ++counts_.refused[Refusal::error];
    return false;
  }
  changed_.clear();
  for (const RingCorner& c : rings_.removed) changed_.push_back(c.face);
  if (options_.placement == VertexPlacement::midpoint) {
    for (const RingCorner& c : rings_.kept) changed_.push_back(c.face);
  }
  // Sides of faces that vanish or change lose their edges before the corners go.
  for (const Index f : changed_) {
    table_.each_corner_of_face(f, [&](Index corner) {
      ranked_->erase(edge_of_side_[corner]);
      costs_[edge_of_side_[corner]].cost = 4;
    });
    altered_[f] = 1;
  }
  RunCounts made;
  if (table_.is_logged()) made.log.begin(table_, rings_, collapse, deviation);
  made.add(apply_collapse(table_, collapse));
  if (table_.is_logged()) made.log.end(table_, collapse);
  count(made);
  table_.deviation[collapse.kept] = static_cast<float>(deviation);
  counts_.error = std::max(counts_.error, deviation);
  for (const Index f : changed_) normals_[f] = normal(f, {});
  update_around(changed_);
  return true;
}

bool NormalDeviationSimplifier::is_eligible(const Edge& edge) const {
  bool eligible = true;
  const bool first_is_smaller = valence_[edge.first] <= valence_[edge.second];
  const Index at = first_is_smaller ? edge.first : edge.second,
              other = first_is_smaller ? edge.second : edge.first;
  table_.each_corner(at, [&](Index corner) {
    const bool on_edge = table_.point_after(corner) == other || table_.point_before(corner) == other;
    if (on_edge && altered_[table_.face(corner)] != 0) eligible = false;
  });
  return eligible;
}

/// Costs depend on the polygons around both ends: those of every eligible edge at a corner of a changed
/// polygon are computed anew.
void NormalDeviationSimplifier::update_around(const std::vector<Index>& changed_faces) {
  ++stale_epoch_;
  stale_.clear();
  for (const Index f : changed_faces) {
    if (!table_.is_face_alive(f)) continue;
    table_.each_corner_of_face(f, [&](Index at) {
      if (valence_[table_.point[at]] > k_hub) return;  // what is around it is seen from its neighbours
      table_.each_corner(table_.point[at], [&](Index corner) {
        if (altered_[table_.face(corner)] != 0) return;
        // All sides of the polygon: those that don't touch the corner see it across a quad (`polygon_loss`).
        for (Index side = table_.next(corner);; side = table_.next(side)) {
          const Index edge = edge_of_side_[side];
          if (stale_mark_[edge] != stale_epoch_) {
            stale_mark_[edge] = stale_epoch_;
            stale_.push_back(edge);
          }
          if (side == corner) break;
        }
      });
    });
  }
  const double most = 1 - options_.normal_threshold;
  for (const Index edge : stale_) {
    if (!is_eligible(edges_[edge])) continue;
    costs_[edge] = evaluate(edges_[edge]);
    if (costs_[edge].cost < most)
      ranked_->set(edge, costs_[edge].rank);
    else
      ranked_->erase(edge);
  }
}

/// Brings the table and what is kept by point or face up to date.
void NormalDeviationSimplifier::start_sweep() {
  pack(table_);
  altered_.assign(table_.n_faces(), 0);
  normals_.resize(table_.n_faces());
  tbb::parallel_for(tbb::blocked_range<Index>(0, static_cast<Index>(normals_.size())),
                    [&](const auto& range) {
                      for (Index f = range.begin(); f < range.end(); ++f) normals_[f] = normal(f, {});
                    });
  valence_.resize(table_.n_points());
  for (Index p = 0; p < table_.n_points(); ++p) valence_[p] = table_.ring_start[p + 1] - table_.ring_start[p];
  list_edges();
  rank_all_edges();
}

std::size_t NormalDeviationSimplifier::pass(const Limits& limits, Progress* progress) {
  ++counts_.passes;
  start_sweep();
  std::size_t done = 0;
  while (ranked_->size() > 0 && !reached(limits)) {
    const Index edge = draw();
    if (!commit(edge, limits)) {
      ranked_->erase(edge);
      continue;
    }
    if (++done % 4096 == 0) report_progress(progress, "simplify", fraction_done(limits));
  }
  return done;
}

}  // namespace

std::unique_ptr<Simplifier> make_normal_deviation_simplifier(CornerTable table,
                                                             const SimplifyOptions& options) {
  return std::make_unique<NormalDeviationSimplifier>(std::move(table), options);
}

}  // namespace recede::detail
