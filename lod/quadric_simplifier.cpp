// Passes of independent collapses in the order of their quadric cost.
//
// M. Garland, P. Heckbert: Surface Simplification Using Quadric Error Metrics. SIGGRAPH 1997. (plane
// quadrics) P. Lindstrom, G. Turk: Fast and Memory Efficient Polygonal Simplification. Visualization 1998.
// (volume preservation)
//
// One plane per polygon, weighted by the length of its vector area. Every pass ranks all edges, then walks
// them from the cheapest on and collapses those whose ends no earlier collapse of the pass has moved. A pass
// ends at the cost that the last collapse would have if all went in order, so that independence costs little
// quality.
#include <recede/lod/detail/quadric.h>
#include <recede/lod/detail/simplifier.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

/// Weight of a border's or crease's upright planes against that of the faces (both by area; a line's area is
/// its squared length).
constexpr double k_line_weight = 1.0;
/// Pull towards the middle of the edge where the planes leave the position open, as a share of their weight.
constexpr double k_regularization = 1e-7;
/// A new vertex stays within this many edge lengths of the edge's middle: an ill-conditioned solve must not
/// throw it out of its neighbourhood.
constexpr double k_reach = 2.0;
/// Share of all edges that one pass may collapse at most.
constexpr double k_pass_share = 0.12;
/// At the pass's end a cost may have grown by this factor since it was ranked; beyond that the edge waits for
/// the next pass.
constexpr double k_grown = 1.2;
/// Cosine between a polygon's normals before and after one collapse.
constexpr double k_least_normal_cosine = 0.2;
/// Weight of the squared edge length in the cost, per unit of area weight: orders what the planes don't tell
/// apart.
constexpr double k_length_weight = 1e-9;

/// Factor on the cost for each step of `polygon_loss`.
constexpr double k_polygon_loss = 8;

struct Placement {
  Collapse collapse;
  double cost = std::numeric_limits<double>::infinity();
  double error = 0;  ///< root mean square distance to the planes
};

struct Candidate {
  float cost;
  Index first, second;
  friend bool operator<(const Candidate& x, const Candidate& y) {
    if (x.cost != y.cost) return x.cost < y.cost;
    return x.first != y.first ? x.first < y.first : x.second < y.second;
  }
};

/// The volume that a collapse must keep is linear in the new position x: gradient . x = value.
struct VolumeConstraint {
  Vec3 gradient = Vec3::Zero();
  double value = 0;
};

class QuadricSimplifier final : public Simplifier {
 public:
  QuadricSimplifier(CornerTable table, const SimplifyOptions& options)
      : Simplifier(std::move(table), options, k_least_normal_cosine),
        has_polygons_(table_.point.size() > 3 * table_.face_size.size()) {
    quadrics_.resize(table_.positions.size());
    touched_.resize(table_.positions.size(), 0);
    add_planes();
  }

 private:
  std::size_t pass(const Limits& limits, Progress* progress) override;

  void add_planes();
  void add_line_planes(Index face, const Vec3& normal);
  std::vector<Candidate> rank_edges();
  Placement place(Index first, Index second) const;
  Placement at_end(const Quadric& sum, Index removed, Index kept, const Vec3& center) const;
  Vec3 best_position(const Quadric& sum, Index first, Index second, const Vec3& center) const;
  VolumeConstraint volume_constraint(Index first, Index second, const Vec3& center) const;
  bool commit(const Candidate& candidate, double most, const Limits& limits);

  bool has_polygons_;              // some face has more than three sides
  std::vector<Quadric> quadrics_;  // of each point, centred at it
  std::vector<Index> touched_;     // last pass in which the point was the result of a collapse
  EdgeRings rings_;
  std::size_t last_refused_ = 0;  // candidates that the last pass refused
};

void QuadricSimplifier::add_planes() {
  for (Index f = 0; f < table_.face_corner.size(); ++f) {
    const Vec3 area = twice_vector_area(table_, f);
    const double length = area.norm();
    if (!(length > 0)) continue;
    const Vec3 normal = area / length;
    Vec3 middle = Vec3::Zero();
    Index corner = table_.face_corner[f];
    for (Index i = 0; i < table_.face_size[f]; ++i, corner = table_.next[corner]) {
      middle += table_.positions[table_.point[corner]];
    }
    middle /= table_.face_size[f];
    for (Index i = 0; i < table_.face_size[f]; ++i, corner = table_.next[corner]) {
      const Index p = table_.point[corner];
      quadrics_[p].add_plane(normal, middle - table_.positions[p], 0.5 * length);
    }
    add_line_planes(f, normal);
  }
}

/// Planes upright on the face along its sides that are borders, seams or features keep those lines in place.
void QuadricSimplifier::add_line_planes(Index face, const Vec3& normal) {
  Index corner = table_.face_corner[face];
  for (Index i = 0; i < table_.face_size[face]; ++i, corner = table_.next[corner]) {
    const Index p = table_.point[corner], q = table_.point[table_.next[corner]];
    if (table_.classes[p] == PointClass::smooth || table_.classes[q] == PointClass::smooth) continue;
    if (table_.edge_kind(p, q) == k_smooth_edge) continue;
    const Vec3 along = table_.positions[q] - table_.positions[p];
    const double length = along.norm();
    if (!(length > 0)) continue;
    const Vec3 upright = along.cross(normal) / length;
    const double weight = k_line_weight * length * length;
    quadrics_[p].add_plane(upright, Vec3::Zero(), weight);
    quadrics_[q].add_plane(upright, Vec3::Zero(), weight);
  }
}

VolumeConstraint QuadricSimplifier::volume_constraint(Index first, Index second, const Vec3& center) const {
  VolumeConstraint constraint;
  const auto at = [&](Index p) -> Vec3 { return table_.positions[p] - center; };
  const auto add_ring = [&](Index of, Index other) {
    const Vec3 v = at(of);
    table_.each_corner(of, [&](Index corner) {
      const Index before = table_.point[table_.previous(corner)], after = table_.point[table_.next[corner]];
      // A polygon is seen as the ear at the moving corner and a remainder that stays. With the edge in it,
      // the ear has four corners, before-first-second-after, and is met once, at the end where the edge
      // leaves.
      if (before == other) return;
      if (after == other) {
        const Index beyond = table_.point[table_.next[table_.next[corner]]];
        const Vec3 w = at(after);
        constraint.value += v.cross(w).dot(at(before));
        if (beyond == before) return;
        constraint.value += w.cross(at(beyond)).dot(at(before));
        constraint.gradient += at(beyond).cross(at(before));
        return;
      }
      const Vec3 normal = at(after).cross(at(before));
      constraint.gradient += normal;
      constraint.value += normal.dot(v);
    });
  };
  add_ring(first, second);
  add_ring(second, first);
  return constraint;
}

/// Least value of the quadric among the positions that keep the volume.
Vec3 QuadricSimplifier::best_position(const Quadric& sum, Index first, Index second,
                                      const Vec3& center) const {
  Eigen::Matrix3d a = sum.matrix();
  const double pull = k_regularization * sum.weight;
  a.diagonal().array() += pull;
  const Eigen::LDLT<Eigen::Matrix3d> solver(a);
  Vec3 x = solver.solve(-sum.b);
  // One step of refinement takes the pull out of the directions that the planes do determine.
  x -= solver.solve(sum.times(x) + sum.b);
  const bool closed =
      table_.classes[first] == PointClass::smooth && table_.classes[second] == PointClass::smooth;
  if (closed) {
    const VolumeConstraint volume = volume_constraint(first, second, center);
    const Vec3 direction = solver.solve(volume.gradient);
    const double slope = volume.gradient.dot(direction);
    if (slope > 0) x += direction * ((volume.value - volume.gradient.dot(x)) / slope);
  }
  return x;
}

Placement QuadricSimplifier::at_end(const Quadric& sum, Index removed, Index kept, const Vec3& center) const {
  const Vec3& position = table_.positions[kept];
  return {{removed, kept, position, 1}, sum(position - center), 0};
}

Placement QuadricSimplifier::place(Index first, Index second) const {
  const EdgeFreedom freedom = edge_freedom(table_, first, second);
  if (!freedom.allowed) return {};
  const Vec3 &p = table_.positions[first], &q = table_.positions[second];
  const Vec3 center = 0.5 * (p + q);
  // Both quadrics move to the middle of the edge, where the numbers are small.
  Quadric sum;
  sum.add(quadrics_[first], p - center);
  sum.add(quadrics_[second], q - center);
  const double length = (p - q).squaredNorm();
  Placement best;
  const bool ends_only = options_.placement == VertexPlacement::half_edge || !freedom.may_move;
  if (!ends_only) {
    const Index removed = freedom.may_remove_first ? first : second;
    const Index kept = removed == first ? second : first;
    Vec3 x = options_.placement == VertexPlacement::midpoint ? Vec3(Vec3::Zero())
                                                             : best_position(sum, first, second, center);
    if (x.allFinite() && x.squaredNorm() <= k_reach * k_reach * length) {
      const Vec3 along = table_.positions[kept] - table_.positions[removed];
      const double share =
          length > 0 ? std::clamp((x + center - table_.positions[removed]).dot(along) / length, 0.0, 1.0) : 1;
      best = {{removed, kept, x + center, share}, sum(x), 0};
    }
  }
  if (best.collapse.removed == k_no_index) {
    if (freedom.may_remove_first) best = at_end(sum, first, second, center);
    if (freedom.may_remove_second) {
      const Placement other = at_end(sum, second, first, center);
      if (best.collapse.removed == k_no_index || other.cost < best.cost) best = other;
    }
  }
  best.error = sum.weight > 0 ? std::sqrt(best.cost / sum.weight) : 0;
  best.cost += k_length_weight * sum.weight * length;
  if (has_polygons_ && options_.keep_polygons) {
    best.cost *= std::pow(k_polygon_loss, polygon_loss(table_, first, second));
  }
  return best;
}

std::vector<Candidate> QuadricSimplifier::rank_edges() {
  const std::size_t n_points = table_.positions.size();
  constexpr std::size_t k_block = 2048;  // points of one list; fixed, so that the order is
  std::vector<std::vector<Candidate>> blocks((n_points + k_block - 1) / k_block);
  std::vector<std::size_t> refused(blocks.size(), 0);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 1), [&](const auto& range) {
    std::vector<Index> neighbours;
    for (std::size_t block = range.begin(); block < range.end(); ++block) {
      const auto last = static_cast<Index>(std::min(n_points, (block + 1) * k_block));
      for (auto p = static_cast<Index>(block * k_block); p < last; ++p) {
        neighbours.clear();
        table_.each_corner(p, [&](Index corner) {
          for (const Index q : {table_.point[table_.next[corner]], table_.point[table_.previous(corner)]}) {
            if (q > p) neighbours.push_back(q);
          }
        });
        std::sort(neighbours.begin(), neighbours.end());
        neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
        for (const Index q : neighbours) {
          const Placement placement = place(p, q);
          if (placement.collapse.removed == k_no_index) {
            ++refused[block];
            continue;
          }
          blocks[block].push_back({static_cast<float>(placement.cost), p, q});
        }
      }
    }
  });
  std::vector<Candidate> candidates;
  std::size_t total = 0;
  for (const auto& block : blocks) total += block.size();
  for (const std::size_t count_of_block : refused) counts_.refused[Refusal::border] += count_of_block;
  candidates.reserve(total);
  for (const auto& block : blocks) candidates.insert(candidates.end(), block.begin(), block.end());
  tbb::parallel_sort(candidates.begin(), candidates.end());
  return candidates;
}

bool QuadricSimplifier::commit(const Candidate& candidate, double most, const Limits& limits) {
  const Placement placement = place(candidate.first, candidate.second);
  if (placement.cost > most) return false;
  if (placement.error > limits.error) {
    ++counts_.refused[Refusal::error];
    return false;
  }
  const Collapse& collapse = placement.collapse;
  rings_.gather(table_, collapse.removed, collapse.kept);
  if (const auto refused = rules_.refusal(rings_, collapse)) {
    ++counts_.refused[*refused];
    return false;
  }
  const Vec3 from = table_.positions[collapse.removed], to = table_.positions[collapse.kept];
  Quadric sum;
  sum.add(quadrics_[collapse.removed], from - collapse.position);
  sum.add(quadrics_[collapse.kept], to - collapse.position);
  count(apply_collapse(table_, collapse));
  quadrics_[collapse.kept] = sum;
  counts_.error = std::max(counts_.error, placement.error);
  return true;
}

std::size_t QuadricSimplifier::pass(const Limits& limits, Progress* progress) {
  ++counts_.passes;
  unlink_dead_corners(table_);
  const std::vector<Candidate> candidates = rank_edges();
  if (candidates.empty()) return 0;
  // An interior collapse of a closed triangle mesh removes two faces; with quads fewer, and then the next
  // pass goes on.
  std::size_t wanted = candidates.size();
  if (limits.faces > 0) wanted = std::min(wanted, (table_.n_alive_faces - limits.faces + 1) / 2);
  if (limits.vertices > 0) wanted = std::min(wanted, table_.n_alive_points - limits.vertices);
  const auto share = static_cast<std::size_t>(k_pass_share * static_cast<double>(candidates.size())) + 1;
  // Edges that the last pass refused are likely to be refused again and don't count towards the goal.
  const std::size_t goal = std::min(std::min(wanted, share) + last_refused_, candidates.size() - 1);
  last_refused_ = 0;
  double most = std::max(static_cast<double>(candidates[goal].cost), 1e-300);
  const auto pass_number = static_cast<Index>(counts_.passes);
  std::size_t done = 0;
  for (std::size_t i = 0; i < candidates.size() && done < wanted; ++i) {
    const Candidate& candidate = candidates[i];
    if (static_cast<double>(candidate.cost) > most) {
      // Everything cheap was refused: the pass must still get somewhere.
      if (done > 0) break;
      most = static_cast<double>(candidate.cost);
    }
    if (touched_[candidate.first] == pass_number || touched_[candidate.second] == pass_number) continue;
    if (!commit(candidate, std::max(most, k_grown * static_cast<double>(candidate.cost)), limits)) {
      ++last_refused_;
      continue;
    }
    touched_[candidate.first] = touched_[candidate.second] = pass_number;
    ++done;
    if (reached(limits)) break;
    if (done % 4096 == 0) report_progress(progress, "simplify", fraction_done(limits));
  }
  return done;
}

}  // namespace

std::unique_ptr<Simplifier> make_quadric_simplifier(CornerTable table, const SimplifyOptions& options) {
  return std::make_unique<QuadricSimplifier>(std::move(table), options);
}

}  // namespace recede::detail
