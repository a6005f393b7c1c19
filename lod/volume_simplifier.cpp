// Passes of independent collapses in the order of a volume-preserving cost (see volume_cost.h), or of the
// texture deviation (see texture_deviation.h).
//
// Every pass ranks all edges, then walks them from the cheapest on and collapses those whose ends no earlier
// collapse of the pass has moved. A pass ends at the cost of an edge that would come not long after the last
// one if all went in order, so that independence costs little quality.
//
// Points are numbered along a space-filling curve, so that a range of numbers is a patch of surface. Patches
// rank and collapse on their own, in parallel and inside a cache; what reaches over the rim of a patch is
// left for afterwards. The patches don't depend on the number of threads, and neither does the result.
#include <recede/lod/detail/edge_ranker.h>
#include <recede/lod/detail/point_classifier.h>
#include <recede/lod/detail/simplifier.h>
#include <recede/lod/detail/volume_cost.h>

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace recede::detail {
namespace {

/// Share of the points that one pass may remove at most; about a third of them are then independent.
constexpr double k_pass_share = 1.0;
/// A pass ends at the cost of the edge that would come this many times later than the last one if all went in
/// order: fewer passes, and hardly more error. Where polygons are to be kept the order counts more.
constexpr double k_pass_reach = 2.0;
/// Only above this share of the points still to go, which no pass can remove: independent edges have an end
/// in every two points.
constexpr double k_far_share = 0.5;
/// Below this share of the points still to go, edges are taken one by one to the exact count.
constexpr double k_last_share = 0.1;
/// For the last pass: it may go on to the edge that would come this many times later if all were independent.
constexpr double k_last_reach = 2.0;
/// Since it was ranked, a cost may have grown by this factor; beyond that the edge waits for the next pass.
constexpr double k_grown = 1.5;
/// Cosine between a polygon's normals before and after one collapse; and where nothing else is left to do.
constexpr double k_least_normal_cosine = 0.2, k_last_normal_cosine = 0.0;
/// Factor on the cost for each step of `polygon_loss`.
constexpr float k_polygon_loss = 40;
/// Points of one patch.
constexpr std::size_t k_least_patch = 1024, k_largest_patch = 16384;
constexpr std::size_t k_patches = 8;

/// An edge and its cost in one number: costs are positive floats, whose bits are ordered as they are. The
/// edge is named by the corner where one of its sides begins, so that no two are equal.
using Candidate = std::uint64_t;
Candidate make_candidate(float cost, Index corner) {
  return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(cost)) << 32 | corner;
}
float cost_of(Candidate candidate) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(candidate >> 32));
}
Index corner_of(Candidate candidate) { return static_cast<Index>(candidate); }

/// Counts of costs by their leading bits: sixteen bins for each power of two.
class CostHistogram {
 public:
  void add(float cost) { ++counts_[bin(cost)]; }
  void merge(const CostHistogram& other) {
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
  }
  /// A cost below which `wanted` are or, as bins allow, fewer; when `at_least`, more.
  float limit(std::size_t wanted, bool at_least) const {
    std::size_t below = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      if (below + counts_[i] > wanted) return lower_end(at_least ? i + 1 : i);
      below += counts_[i];
    }
    return std::numeric_limits<float>::infinity();
  }

 private:
  static constexpr unsigned k_shift = 19;
  static std::size_t bin(float cost) { return std::bit_cast<std::uint32_t>(cost) >> k_shift; }
  static float lower_end(std::size_t bin) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(bin) << k_shift);
  }
  std::array<Index, std::size_t{1} << (31 - k_shift)> counts_{};
};

/// Edges that wait to be ranked together.
struct EdgeBlock {
  std::array<PointPair, EdgeRanker::k_lanes> edges;
  std::array<Index, EdgeRanker::k_lanes> corners;
  std::size_t size = 0;

  void add(const PointPair& edge, Index corner) {
    edges[size] = edge;
    corners[size++] = corner;
  }
};

/// What one thread needs to look at an edge.
struct Workbench {
  Workbench(const CornerTable& table, const AttributeChannels& channels, const SimplifyOptions& options,
            double least_cosine = k_least_normal_cosine)
      : rules(table, least_cosine), planner(table, channels, options.cost, options.placement) {}
  EdgeRings rings;
  CollapseRules rules;
  CollapsePlanner planner;
  EdgeBlock block;
  std::vector<Index> seen;  // neighbours of the point at hand
};

/// A range of points that is worked on by itself, and what came of it.
struct Patch {
  Index first = 0, last = 0;  ///< points [first, last)
  std::vector<Candidate> candidates;
  CostHistogram histogram;
  std::vector<Candidate> across;  ///< edges that reach over the rim
  RunCounts counts;
  std::size_t refused = 0;

  /// Keeps the memory of the lists.
  void start(Index from, Index to) {
    first = from;
    last = to;
    candidates.clear();
    across.clear();
    histogram = {};
    counts = {};
    refused = 0;
  }
  bool contains(Index point) const { return point >= first && point < last; }
};

class VolumeSimplifier final : public Simplifier {
 public:
  VolumeSimplifier(CornerTable table, const SimplifyOptions& options)
      : Simplifier(std::move(table), options, k_least_normal_cosine),
        channels_(table_, options_.weights),
        ranker_(table_, channels_, options_.placement) {}

 private:
  enum class Try { done, refused, busy, outside };

  std::size_t pass(const Limits& limits, Progress* progress) override;

  void start_pass();
  void rank(Patch& patch);
  void rank_point(Patch& patch, Workbench& bench, Index p);
  void rank_block(Patch& patch, EdgeBlock& block) const;
  float exact_cost(Patch& patch, Workbench& bench, Index p, Index q) const;
  void add_candidate(Patch& patch, Index p, Index q, Index corner, float cost) const;
  void collapse_inside(Patch& patch, float limit, double error);
  std::vector<Candidate> collapse_inside_all(std::vector<Patch>& patches, float limit, double error);
  void shift_patches(const std::vector<Candidate>& candidates);
  std::size_t collapse_in_order(std::vector<Candidate>& candidates, float limit, const Limits& limits,
                                double least_cosine = k_least_normal_cosine);
  Try attempt(Candidate candidate, float limit, double error, Workbench& bench, const Patch* within,
              RunCounts& counts);
  std::size_t join(float limit, const Limits& limits);
  bool attempt_join(const PointPair& pair, float limit, double error, Workbench& bench, RunCounts& counts);
  std::optional<Refusal> carry_out(const CollapsePlan& plan, Index first, Index second, double error,
                                   Workbench& bench, RunCounts& counts);
  std::size_t wanted(const Limits& limits) const;
  std::vector<Candidate> take_all_below(float limit);

  AttributeChannels channels_;
  EdgeRanker ranker_;
  LargeList<unsigned char> touched_;  // by point: an end of a collapse of this pass
  std::vector<Patch> patches_, shifted_;
  double cost_scale_ = 1;    // from costs in table units to those of ranking
  std::size_t refused_ = 0;  // edges that the last pass refused
  bool has_joined_ = false;  // since the points were classified
};

template <typename Work>
void each_patch(std::vector<Patch>& patches, Work&& work) {
  tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t i) { work(patches[i]); });
}

void VolumeSimplifier::start_pass() {
  pack(table_);
  const std::size_t n = table_.n_points();
  touched_.assign(n, 0);
  if (std::exchange(has_joined_, false)) {
    PointClassifier classifier(table_, options_.lock_borders);
    for (Index p = 0; p < n; ++p) {
      if (table_.classes[p] != PointClass::smooth) table_.classes[p] = classifier.classify(p);
    }
  }
  const std::size_t size = std::clamp(n / k_patches, k_least_patch, k_largest_patch);
  patches_.resize((n + size - 1) / size);
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    patches_[i].start(static_cast<Index>(i * size), static_cast<Index>(std::min(n, (i + 1) * size)));
  }
  // A unit in which edges are about 1 long; costs are sixth powers of lengths.
  const double scale = std::sqrt(static_cast<double>(std::max<std::size_t>(table_.n_faces(), 1)));
  cost_scale_ = std::pow(scale, 6);
  if (options_.cost == CostPolicy::volume) ranker_.start(scale);
}

/// The exact cost of an edge; negative for an edge that must stay, which is counted by its reason.
float VolumeSimplifier::exact_cost(Patch& patch, Workbench& bench, Index p, Index q) const {
  Refusal reason = Refusal::border;
  if (edge_freedom(table_, p, q).allowed) {
    bench.rings.gather(table_, p, q);
    const CollapsePlan plan = bench.planner.plan(bench.rings, p, q);
    if (plan.collapse.removed != k_no_index) return static_cast<float>(plan.cost * cost_scale_);
    reason = plan.refused.value_or(reason);
  }
  ++patch.counts.refused[reason];
  return -1;
}

void VolumeSimplifier::add_candidate(Patch& patch, Index p, Index q, Index corner, float cost) const {
  if (table_.has_polygons && options_.keep_polygons) {
    for (int loss = polygon_loss(table_, p, q); loss > 0; --loss) cost *= k_polygon_loss;
  }
  if (!(cost <= std::numeric_limits<float>::max())) cost = std::numeric_limits<float>::max();
  patch.candidates.push_back(make_candidate(cost, corner));
  patch.histogram.add(cost);
}

/// Ranks the edges that wait in the block.
void VolumeSimplifier::rank_block(Patch& patch, EdgeBlock& block) const {
  if (block.size == 0) return;
  std::array<float, EdgeRanker::k_lanes> costs;
  ranker_.rank({block.edges.data(), block.size}, costs.data());
  for (std::size_t i = 0; i < block.size; ++i) {
    add_candidate(patch, block.edges[i].first, block.edges[i].second, block.corners[i], costs[i]);
  }
  block.size = 0;
}

/// Every edge belongs to the lower of its points.
void VolumeSimplifier::rank_point(Patch& patch, Workbench& bench, Index p) {
  std::vector<Index>& seen = bench.seen;
  seen.clear();
  const bool smooth = table_.classes[p] == PointClass::smooth;
  const auto add = [&](Index corner, Index q) {
    if (table_.is_held(p, q)) {
      ++patch.counts.refused[Refusal::error];
      return;
    }
    if (smooth && table_.classes[q] == PointClass::smooth && options_.cost == CostPolicy::volume) {
      bench.block.add({p, q}, corner);
      if (bench.block.size == EdgeRanker::k_lanes) rank_block(patch, bench.block);
      return;
    }
    const float cost = exact_cost(patch, bench, p, q);
    if (cost >= 0) add_candidate(patch, p, q, corner, cost);
  };
  for (Index i = table_.ring_start[p]; i < table_.ring_start[p + 1]; ++i) {
    const Index corner = table_.ring[i], q = table_.point_after(corner);
    if (smooth) {  // every neighbour comes after exactly one corner
      if (q > p) add(corner, q);
      continue;
    }
    const Index before = table_.previous(corner);
    for (const auto& [side, end] : {std::pair{corner, q}, {before, table_.point[before]}}) {
      if (end < p || std::find(seen.begin(), seen.end(), end) != seen.end()) continue;
      seen.push_back(end);
      add(side, end);
    }
  }
}

void VolumeSimplifier::rank(Patch& patch) {
  Workbench bench(table_, channels_, options_);
  patch.candidates.reserve(3 * (patch.last - patch.first) + 64);
  for (Index p = patch.first; p < patch.last; ++p) rank_point(patch, bench, p);
  rank_block(patch, bench.block);
}

/// Tries one edge. `within`: the collapse must not reach beyond the patch.
VolumeSimplifier::Try VolumeSimplifier::attempt(Candidate candidate, float limit, double error,
                                                Workbench& bench, const Patch* within, RunCounts& counts) {
  const Index corner = corner_of(candidate);
  if (!table_.is_alive(corner)) return Try::busy;
  const Index p = table_.point[corner], q = table_.point_after(corner);
  const Index first = std::min(p, q), second = std::max(p, q);
  if (within && !(within->contains(first) && within->contains(second))) return Try::outside;
  if (touched_[first] != 0 || touched_[second] != 0) return Try::busy;
  bench.rings.gather(table_, first, second);
  if (within && !bench.rings.lie_within(table_, within->first, within->last)) return Try::outside;
  const CollapsePlan plan = bench.planner.plan(bench.rings, first, second);
  if (plan.refused) ++counts.refused[*plan.refused];
  if (plan.collapse.removed == k_no_index) return Try::refused;
  const double most =
      std::max(static_cast<double>(limit), k_grown * static_cast<double>(cost_of(candidate))) / cost_scale_;
  if (plan.cost > most) return Try::refused;
  auto refused = carry_out(plan, first, second, error, bench, counts);
  if (refused == Refusal::flip || refused == Refusal::degenerate) {
    // An end of the edge may do where the best place doesn't.
    const CollapsePlan at_end = bench.planner.plan_at_an_end(first, second);
    if (at_end.collapse.removed != k_no_index && at_end.cost <= most) {
      refused = carry_out(at_end, first, second, error, bench, counts);
    }
  }
  if (!refused) return Try::done;
  ++counts.refused[*refused];
  return Try::refused;
}

/// Collapses an edge as planned, unless something speaks against it. `bench.rings` are those of `first` and
/// `second`.
std::optional<Refusal> VolumeSimplifier::carry_out(const CollapsePlan& plan, Index first, Index second,
                                                   double error, Workbench& bench, RunCounts& counts) {
  const Collapse& collapse = plan.collapse;
  const bool is_turned = collapse.removed == second;
  if (is_turned) std::swap(bench.rings.removed, bench.rings.kept);
  double deviation =
      plan.deviation + static_cast<double>(std::max(table_.deviation[first], table_.deviation[second]));
  // With a limit it pays to look closer.
  if (std::isfinite(error)) {
    deviation = std::max(deviation, local_deviation(table_, bench.rings, collapse));
  }
  const std::optional<Refusal> refused =
      deviation > error ? Refusal::error : bench.rules.refusal(bench.rings, collapse);
  if (refused) {
    if (is_turned) std::swap(bench.rings.removed, bench.rings.kept);
    return refused;
  }
  if (table_.is_logged()) counts.log.begin(table_, bench.rings, collapse, deviation);
  counts.add(apply_collapse(table_, collapse));
  counts.cost += plan.cost;
  if (plan.sets_attributes) bench.planner.set_attributes(table_, collapse);
  if (table_.is_logged()) counts.log.end(table_, collapse);
  counts.error = std::max(counts.error, deviation);
  table_.deviation[collapse.kept] = static_cast<float>(deviation);
  touched_[first] = touched_[second] = 1;
  return std::nullopt;
}

void VolumeSimplifier::collapse_inside(Patch& patch, float limit, double error) {
  const auto cheap = std::partition(patch.candidates.begin(), patch.candidates.end(),
                                    [&](Candidate c) { return cost_of(c) <= limit; });
  std::sort(patch.candidates.begin(), cheap);
  Workbench bench(table_, channels_, options_);
  for (auto c = patch.candidates.begin(); c != cheap; ++c) {
    const Try result = attempt(*c, limit, error, bench, &patch, patch.counts);
    if (result == Try::outside) patch.across.push_back(*c);
    if (result == Try::refused) ++patch.refused;
  }
}

/// Collapses in all patches at once. Returns the edges that reach over rims.
std::vector<Candidate> VolumeSimplifier::collapse_inside_all(std::vector<Patch>& patches, float limit,
                                                             double error) {
  each_patch(patches, [&](Patch& patch) { collapse_inside(patch, limit, error); });
  std::vector<Candidate> across;
  for (const Patch& patch : patches) {
    refused_ += patch.refused;
    count(patch.counts);
    across.insert(across.end(), patch.across.begin(), patch.across.end());
  }
  return across;
}

/// Patches that begin in the middles of the first ones, with these edges.
void VolumeSimplifier::shift_patches(const std::vector<Candidate>& candidates) {
  const Index half = patches_.front().last / 2;
  shifted_.resize(patches_.size() + 1);
  for (std::size_t i = 0; i < shifted_.size(); ++i) {
    shifted_[i].start(i == 0 ? 0 : patches_[i - 1].first + half,
                      i < patches_.size() ? patches_[i].first + half : patches_.back().last);
  }
  shifted_.back().last = std::max(shifted_.back().first, shifted_.back().last);
  for (const Candidate candidate : candidates) {
    if (!table_.is_alive(corner_of(candidate))) continue;
    const Index p = table_.point[corner_of(candidate)];
    const auto after = std::upper_bound(shifted_.begin(), shifted_.end(), p,
                                        [](Index point, const Patch& patch) { return point < patch.first; });
    std::prev(after)->candidates.push_back(candidate);
  }
}

/// Collapses over the whole table until a limit. Returns how many.
std::size_t VolumeSimplifier::collapse_in_order(std::vector<Candidate>& candidates, float limit,
                                                const Limits& limits, double least_cosine) {
  std::sort(candidates.begin(), candidates.end());
  Workbench bench(table_, channels_, options_, least_cosine);
  std::size_t done = 0;
  for (const Candidate candidate : candidates) {
    if (reached(limits)) break;
    RunCounts counts;
    const Try result = attempt(candidate, limit, limits.error, bench, nullptr, counts);
    if (result == Try::done) ++done;
    if (result == Try::refused) ++refused_;
    count(counts);
  }
  return done;
}

/// Joins a pair when that costs no more than the limit. What it is afterwards the next pass finds out.
bool VolumeSimplifier::attempt_join(const PointPair& pair, float limit, double error, Workbench& bench,
                                    RunCounts& counts) {
  const auto [first, second] = pair;
  if (touched_[first] != 0 || touched_[second] != 0) return false;
  const EdgeFreedom freedom = join_freedom(table_, first, second, options_.lock_borders);
  if (!freedom.allowed) return false;
  bench.rings.gather(table_, first, second);
  const CollapsePlan plan = bench.planner.plan_join(bench.rings, freedom, first, second);
  if (plan.cost * cost_scale_ > static_cast<double>(limit)) return false;
  const Collapse& collapse = plan.collapse;
  if (collapse.removed == second) std::swap(bench.rings.removed, bench.rings.kept);
  const double deviation = local_deviation(table_, bench.rings, collapse);
  const std::optional<Refusal> refused =
      deviation > error ? Refusal::error : bench.rules.join_refusal(bench.rings, collapse);
  if (refused) {
    ++counts.refused[*refused];
    return false;
  }
  if (table_.is_logged()) counts.log.begin(table_, bench.rings, collapse, deviation);
  counts.add(apply_collapse(table_, collapse));
  counts.cost += plan.cost;
  if (plan.sets_attributes) bench.planner.set_attributes(table_, collapse);
  if (table_.is_logged()) counts.log.end(table_, collapse);
  ++counts.joined;
  counts.error = std::max(counts.error, deviation);
  table_.deviation[collapse.kept] = static_cast<float>(deviation);
  table_.classes[collapse.kept] = PointClass::fixed;
  touched_[first] = touched_[second] = 1;
  has_joined_ = true;
  return true;
}

/// Joins points of different parts up to a cost. Returns how many pairs.
std::size_t VolumeSimplifier::join(float limit, const Limits& limits) {
  if (table_.joins.empty()) return 0;
  Workbench bench(table_, channels_, options_);
  std::size_t done = 0;
  for (const PointPair& pair : table_.joins) {
    if (reached(limits)) break;
    RunCounts counts;
    if (attempt_join(pair, limit, limits.error, bench, counts)) ++done;
    count(counts);
  }
  return done;
}

/// Collapses that are still to be made; an interior collapse of a closed triangle mesh removes two faces,
/// with quads fewer, and then the next pass goes on.
std::size_t VolumeSimplifier::wanted(const Limits& limits) const {
  std::size_t result = table_.n_alive_points;
  const std::size_t per_collapse = table_.double_sided.empty() ? 2 : 4;
  if (limits.faces > 0)
    result = std::min(result, (table_.n_alive_faces - limits.faces + per_collapse - 1) / per_collapse);
  if (limits.vertices > 0) result = std::min(result, table_.n_alive_points - limits.vertices);
  return result;
}

std::vector<Candidate> VolumeSimplifier::take_all_below(float limit) {
  std::vector<Candidate> all;
  for (Patch& patch : patches_) {
    for (const Candidate c : patch.candidates) {
      if (cost_of(c) <= limit) all.push_back(c);
    }
  }
  return all;
}

std::size_t VolumeSimplifier::pass(const Limits& limits, Progress* progress) {
  ++counts_.passes;
  start_pass();
  if (options_.cost == CostPolicy::volume) {
    each_patch(patches_, [&](const Patch& patch) { ranker_.prepare(patch.first, patch.last); });
  }
  each_patch(patches_, [&](Patch& patch) { rank(patch); });
  CostHistogram histogram;
  std::size_t n_candidates = 0;
  for (Patch& patch : patches_) {
    histogram.merge(patch.histogram);
    n_candidates += patch.candidates.size();
    count(patch.counts);
    patch.counts = {};
  }
  constexpr float k_any_cost = std::numeric_limits<float>::infinity();
  if (n_candidates == 0) return join(k_any_cost, limits);
  report_progress(progress, "simplify", fraction_done(limits));
  const std::size_t left = wanted(limits);
  const auto points = static_cast<double>(table_.n_alive_points);
  // Edges that the last pass refused are likely to be refused again and don't count towards the goal.
  const std::size_t tolerated = std::exchange(refused_, 0);
  const std::size_t collapses_before = counts_.collapses;
  std::size_t done = 0, goal = 1 + tolerated;
  const bool is_far = static_cast<double>(left) > k_far_share * points;
  const double reach = is_far && !(table_.has_polygons && options_.keep_polygons) ? k_pass_reach : 1.0;
  if (static_cast<double>(left) > k_last_share * points) {
    goal += std::min(static_cast<std::size_t>(reach * static_cast<double>(left)),
                     static_cast<std::size_t>(k_pass_share * points));
    const float limit = histogram.limit(goal, false);
    join(limit, limits);
    std::vector<Candidate> across = collapse_inside_all(patches_, limit, limits.error);
    // The rims of the patches lie inside of patches that are shifted by half of one.
    shift_patches(across);
    across = collapse_inside_all(shifted_, limit, limits.error);
    done = counts_.collapses - collapses_before;
    done += collapse_in_order(across, limit, limits);
  } else {
    goal += static_cast<std::size_t>(k_last_reach * static_cast<double>(left));
    const float limit = histogram.limit(goal, true);
    done = join(limit, limits);
    std::vector<Candidate> all = take_all_below(limit);
    done += collapse_in_order(all, limit, limits);
  }
  // Everything cheap was refused: the pass must still get somewhere.
  for (; done == 0 && goal < n_candidates; goal *= 4) {
    const float limit = histogram.limit(goal, true);
    std::vector<Candidate> all = take_all_below(limit);
    done = collapse_in_order(all, limit, limits);
  }
  if (done == 0) done = join(k_any_cost, limits);
  if (done == 0) {
    std::vector<Candidate> all = take_all_below(k_any_cost);
    done = collapse_in_order(all, k_any_cost, limits, k_last_normal_cosine);
  }
  return done;
}

}  // namespace

std::unique_ptr<Simplifier> make_volume_simplifier(CornerTable table, const SimplifyOptions& options) {
  return std::make_unique<VolumeSimplifier>(std::move(table), options);
}

}  // namespace recede::detail
