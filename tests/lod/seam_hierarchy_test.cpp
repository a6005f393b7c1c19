#include "seam_checks.h"
#include "seam_models.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/active_loops.h>
#include <recede/lod/detail/loop_triangulation.h>
#include <recede/lod/seam_front.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace recede {
namespace {

using test::closed_models;
using test::NamedPatches;

// A graph with all that its levels need. In one place, as fronts refer to it.
struct Levels {
  std::vector<TrimmedPatch> patches;
  std::vector<PatchSurface> surfaces;
  SeamGraph graph;
  SeamHierarchy hierarchy;

  explicit Levels(const std::vector<TrimmedPatch>& of, double tolerance = 2e-3)
      : patches(of), surfaces(prepare_surfaces(of)) {
    SeamGraphOptions options;
    options.tolerance = tolerance;
    graph = build_seam_graph(patches, surfaces, options);
    hierarchy = build_seam_hierarchy(graph, surfaces);
  }
  Levels(const Levels&) = delete;

  std::vector<SeamLoop> loops_of(const SeamFront& front, std::size_t patch) const {
    return front.loops_of(patch, surfaces[patch]);
  }
};

bool are_same(const SeamLoop& a, const SeamLoop& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const SeamSlot& s, const SeamSlot& t) {
    return s.uv == t.uv && s.vertex == t.vertex && s.width == t.width;
  });
}

bool are_same(const std::vector<SeamLoop>& a, const std::vector<SeamLoop>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const SeamLoop& s, const SeamLoop& t) { return are_same(s, t); });
}

std::vector<std::vector<SeamLoop>> all_loops(const Levels& levels, const SeamFront& front) {
  std::vector<std::vector<SeamLoop>> loops;
  for (std::size_t patch = 0; patch < levels.surfaces.size(); ++patch)
    loops.push_back(levels.loops_of(front, patch));
  return loops;
}

// One for each patch, over all errors that there are, and now and then much more or less.
std::vector<double> random_tolerances(const Levels& levels, std::mt19937& random) {
  const std::vector<float>& errors = levels.hierarchy.errors;
  std::vector<double> tolerances;
  for (std::size_t patch = 0; patch < levels.graph.n_patches(); ++patch) {
    const double error = errors[random() % errors.size()];
    tolerances.push_back(random() % 8 == 0 ? 0.0 : random() % 8 == 0 ? 1e9 : error);
  }
  return tolerances;
}

std::set<Index> patches_of_split(const Levels& levels, std::size_t split) {
  const std::vector<Index> of_loops = levels.graph.patches_of_loops();
  std::set<Index> patches;
  for (const SlotChange& change : levels.hierarchy.changes_of(split)) {
    const auto after =
        std::upper_bound(levels.graph.loop_offsets.begin(), levels.graph.loop_offsets.end(), change.slot());
    patches.insert(of_loops[static_cast<std::size_t>(after - levels.graph.loop_offsets.begin()) - 1]);
  }
  return patches;
}

TEST(SeamHierarchy, EndsAtTheLargestErrorAsAWholeOneBegins) {
  for (const auto& [name, patches, pieces] : closed_models()) {
    const Levels whole(patches);
    const std::vector<float>& errors = whole.hierarchy.errors;
    ASSERT_GT(errors.size(), 4u) << name;
    const double largest = errors[errors.size() / 4];
    const SeamHierarchy part = build_seam_hierarchy(whole.graph, whole.surfaces, {.largest_error = largest});
    ASSERT_GT(part.n_splits(), 0u) << name;
    ASSERT_LT(part.n_splits(), whole.hierarchy.n_splits()) << name;
    EXPECT_LE(part.errors.front(), static_cast<float>(largest)) << name;
    const auto skipped = static_cast<std::ptrdiff_t>(errors.size() - part.n_splits());
    EXPECT_TRUE(std::equal(part.errors.begin(), part.errors.end(), errors.begin() + skipped)) << name;
    EXPECT_TRUE(std::equal(
        part.splits.begin(), part.splits.end(), whole.hierarchy.splits.begin() + skipped,
        [](const VertexPair& a, const VertexPair& b) { return a.removed == b.removed && a.kept == b.kept; }))
        << name;
  }
}

TEST(SeamHierarchy, LeavesTwoFacesOfABoxBackToBack) {
  const Levels box(test::box_faces({3, 2, 1}));
  // Eight corners, of which three stay.
  EXPECT_EQ(box.hierarchy.n_splits(), 5u);
  EXPECT_EQ(box.hierarchy.refused, 0u);
  SeamFront front(box.graph, box.hierarchy);
  EXPECT_EQ(front.n_patches_left(), 2u);
  std::vector<SeamLoop> left;
  for (std::size_t patch = 0; patch < 6; ++patch) {
    for (const SeamLoop& loop : box.loops_of(front, patch)) left.push_back(loop);
  }
  ASSERT_EQ(left.size(), 2u);
  EXPECT_EQ(left[0].size() + left[1].size(), 6u);
  EXPECT_TRUE(test::open_sides(left).empty());
  // The shortest side makes a face vanish: nothing is free.
  EXPECT_GE(box.hierarchy.errors.back(), 1);
  EXPECT_EQ(front.adapt(0.9).splits, 5u);
  EXPECT_EQ(front.n_patches_left(), 6u);
}

// What has vanished is near to something that is there.
TEST(SeamHierarchy, LeavesAFewPatchesOfEverySurfaceThatHangsTogether) {
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches);
    const SeamFront front(levels.graph, levels.hierarchy);
    EXPECT_GE(front.n_patches_left(), model.pieces) << model.name;
    EXPECT_LE(front.n_patches_left(), 4 * model.pieces) << model.name;
    std::set<Index> vertices;
    for (std::size_t patch = 0; patch < levels.graph.n_patches(); ++patch) {
      for (const SeamLoop& loop : levels.loops_of(front, patch)) {
        for (const SeamSlot& slot : loop) vertices.insert(slot.vertex);
      }
    }
    EXPECT_LE(vertices.size(), 5 * model.pieces) << model.name;
  }
}

// The least that a patch has to tolerate to vanish when all do; 0: it never does.
double vanishing_error(const Levels& levels, std::size_t patch) {
  const std::vector<float>& errors = levels.hierarchy.errors;  // falling
  SeamFront front(levels.graph, levels.hierarchy);
  std::size_t first = 0, end = errors.size();
  while (first < end) {
    const std::size_t middle = (first + end) / 2;
    front.adapt(static_cast<double>(errors[middle]));
    (front.has_vanished(patch) ? first : end) = front.has_vanished(patch) ? middle + 1 : middle;
  }
  return first > 0 ? static_cast<double>(errors[first - 1]) : 0.0;
}

void add_triangles(const std::vector<SeamLoop>& loops, std::vector<Index>& corners) {
  std::vector<Vec2> points;
  std::vector<Index> vertices;
  std::vector<std::array<Index, 2>> sides;
  for (const SeamLoop& loop : loops) {
    const auto first = static_cast<Index>(points.size());
    for (const SeamSlot& slot : loop) {
      const auto here = static_cast<Index>(points.size());
      sides.push_back({here, &slot == &loop.back() ? first : here + 1});
      points.push_back(slot.uv);
      vertices.push_back(slot.vertex);
    }
  }
  if (points.empty()) return;
  const ConstrainedDelaunay delaunay = detail::triangulate_loops(points, sides);
  for (const DelaunayTriangle& triangle : delaunay.triangles()) {
    if (!triangle.is_inside) continue;
    for (const Index point : triangle.vertices) corners.push_back(vertices[point]);
  }
}

// Sides of all patches that are left, and the inside of flat ones.
ClosestPointTree tree_of_what_is_sure(const Levels& levels, const SeamFront& front) {
  std::vector<Index> corners;
  for (std::size_t patch = 0; patch < levels.graph.n_patches(); ++patch) {
    const std::vector<SeamLoop> loops = levels.loops_of(front, patch);
    if (levels.surfaces[patch].bend == SurfaceBend::none) add_triangles(loops, corners);
    for (const SeamLoop& loop : loops) {
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const Index to = loop[(i + 1) % loop.size()].vertex;
        corners.insert(corners.end(), {loop[i].vertex, to, to});
      }
    }
  }
  return {levels.graph.positions, corners};
}

// Though all others tolerate anything: what stands for it moves no farther than it tolerates itself.
TEST(SeamFront, KeepsAVanishedPatchWithinItsOwnTolerance) {
  std::mt19937 random(38);
  std::vector<NamedPatches> models = closed_models();
  models.push_back({"tiled beam", test::tiled_box({60, 1, 1}, 10)});
  std::size_t n_vanished = 0;
  for (const NamedPatches& model : models) {
    const Levels levels(model.patches, 5e-3);
    const std::size_t n = levels.graph.n_patches();
    SeamFront front(levels.graph, levels.hierarchy);
    for (std::size_t patch = 0; patch < n; patch += 1 + n / 50) {
      std::vector<double> tolerances(n, 1e9);
      tolerances[patch] = vanishing_error(levels, patch);
      if (tolerances[patch] == 0) continue;
      front.adapt(tolerances);
      if (!front.has_vanished(patch)) continue;
      ++n_vanished;
      const test::TrimmedRegion region(levels.patches[patch], levels.surfaces[patch], 8);
      const ClosestPointTree tree = tree_of_what_is_sure(levels, front);
      EXPECT_LE(test::distance_of_surface(region, levels.surfaces[patch], tree, 100, random),
                tolerances[patch] + region.slack())
          << model.name << ", patch " << patch;
    }
  }
  EXPECT_GT(n_vanished, 50u);
}

bool is_inside(const SeamLoop& outline, const Vec2& point) {
  bool inside = false;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 a = outline[i].uv, b = outline[(i + 1) % outline.size()].uv;
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    inside ^= point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
  }
  return inside;
}

// What vanished on to a closed hole is near to the face only while the face is around it.
TEST(SeamHierarchy, KeepsClosedHolesWithinFlatFaces) {
  std::size_t n_closed = 0;
  for (const std::vector<TrimmedPatch>& patches :
       {test::off_centre_bore(3), test::off_centre_bore(0.3), test::bored_plate(4, 3, 0.3, 3)}) {
    const Levels levels(patches);
    SeamFront front(levels.graph, levels.hierarchy);
    for (std::size_t split = 0; split < levels.hierarchy.n_splits(); split += 5) {
      front.adapt(static_cast<double>(levels.hierarchy.errors[split]));
      for (std::size_t patch = 0; patch < patches.size(); ++patch) {
        const std::vector<SeamLoop> loops = levels.loops_of(front, patch);
        if (levels.surfaces[patch].bend != SurfaceBend::none || loops.empty()) continue;
        for (Index l = levels.graph.patch_loops[patch] + 1; l < levels.graph.patch_loops[patch + 1]; ++l) {
          const auto hole = levels.graph.loop(l);
          const auto is_of_hole = [&](const SeamSlot& slot) {
            return std::any_of(hole.begin(), hole.end(), [&](const SeamSlot& s) { return s.uv == slot.uv; });
          };
          const bool is_open = std::any_of(loops.begin(), loops.end(),
                                           [&](const SeamLoop& loop) { return is_of_hole(loop[0]); });
          if (is_open) continue;
          ++n_closed;
          EXPECT_TRUE(std::any_of(hole.begin(), hole.end(),
                                  [&](const SeamSlot& s) { return is_inside(loops[0], s.uv); }))
              << patches[patch].name << " at " << levels.hierarchy.errors[split];
        }
      }
    }
  }
  EXPECT_GT(n_closed, 10u);
}

TEST(SeamHierarchy, HasErrorsThatDoNotRiseAlongSplits) {
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches);
    const std::vector<float>& errors = levels.hierarchy.errors;
    EXPECT_EQ(errors.size(), levels.hierarchy.n_splits());
    EXPECT_TRUE(std::is_sorted(errors.rbegin(), errors.rend())) << model.name;
    EXPECT_GE(errors.back(), 0);
    EXPECT_LT(errors.front(), 1e3f) << model.name;
  }
}

TEST(SeamHierarchy, ComesBackWholeToTheLastBit) {
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches);
    SeamFront front(levels.graph, levels.hierarchy);
    std::mt19937 random(31);
    for (int round = 0; round < 3; ++round) {
      const FrontMoves moves = front.adapt(-1);
      if (round == 0) {
        EXPECT_EQ(moves.splits, levels.hierarchy.n_splits());
      }
      for (std::size_t patch = 0; patch < levels.graph.n_patches(); ++patch)
        EXPECT_TRUE(are_same(levels.loops_of(front, patch), levels.graph.loops_of(patch))) << model.name;
      front.adapt(random_tolerances(levels, random));
    }
  }
}

// What a front asks for, with the vertices around each split as they were when it was recorded.
class RecordingGraph {
 public:
  explicit RecordingGraph(const Levels& levels) : hierarchy_(levels.hierarchy), loops_(levels.graph) {
    around_.resize(hierarchy_.n_splits());
    for (std::size_t s = hierarchy_.n_splits(); s-- > 0;) {
      const auto split = static_cast<Index>(s);
      around_[s].before_merge = surroundings_of_merge(split);
      merge(split);
      around_[s].before_split = surroundings_of_split(split);
    }
  }

  void apply_split(Index split) {
    EXPECT_EQ(surroundings_of_split(split), around_[split].before_split) << "split " << split;
    const auto changes = hierarchy_.changes_of(split);
    for (std::size_t i = changes.size(); i-- > 0;) {
      if (changes[i].is_dropped()) {
        loops_.restore(changes[i].slot());
      } else {
        loops_.give(changes[i].slot(), hierarchy_.splits[split].removed);
      }
    }
    EXPECT_EQ(surroundings_of_merge(split), around_[split].before_merge) << "split " << split;
  }
  void apply_merge(Index split) {
    EXPECT_EQ(surroundings_of_merge(split), around_[split].before_merge) << "merge " << split;
    merge(split);
    EXPECT_EQ(surroundings_of_split(split), around_[split].before_split) << "merge " << split;
  }
  template <typename Visit>
  void around_split(Index split, Visit&& visit) const {
    loops_.each_neighbour(hierarchy_.splits[split].kept, visit);
  }
  template <typename Visit>
  void around_merge(Index split, Visit&& visit) const {
    loops_.each_neighbour(hierarchy_.splits[split].kept, visit);
    loops_.each_neighbour(hierarchy_.splits[split].removed, visit);
  }
  bool is_ready(Index) const { return true; }
  std::size_t size() const { return 0; }

 private:
  using Surroundings = std::set<std::pair<Index, Index>>;  // slots of vertices around, with these
  struct Around {
    Surroundings before_merge, before_split;
  };

  void merge(Index split) {
    for (const SlotChange& change : hierarchy_.changes_of(split)) {
      if (change.is_dropped()) {
        loops_.drop(change.slot());
      } else {
        loops_.give(change.slot(), hierarchy_.splits[split].kept);
      }
    }
  }
  void add(Index vertex, Surroundings& to) const {
    loops_.each_slot(vertex, [&](Index slot) {
      for (const Index s : {loops_.previous(slot), slot, loops_.next(slot)}) to.emplace(s, loops_.vertex(s));
    });
  }
  Surroundings surroundings_of_merge(Index split) const {
    Surroundings result;
    add(hierarchy_.splits[split].kept, result);
    add(hierarchy_.splits[split].removed, result);
    return result;
  }
  Surroundings surroundings_of_split(Index split) const {
    Surroundings result;
    add(hierarchy_.splits[split].kept, result);
    return result;
  }

  const SeamHierarchy& hierarchy_;
  detail::ActiveLoops loops_;
  std::vector<Around> around_;
};

TEST(SeamHierarchy, IsWalkedOnlyWhereSurroundingsAreThoseThatWereRecorded) {
  std::mt19937 random(32);
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches, 5e-3);
    RecordingGraph graph(levels);
    const VertexHierarchy vertices(levels.graph.positions.size(), levels.hierarchy.splits);
    VertexFront front(vertices);
    std::size_t n_moves = 0;
    for (int round = 0; round < 60 && !testing::Test::HasFailure(); ++round) {
      // Any splits, each with all before it of the same vertex.
      std::vector<unsigned char> is_wanted(levels.hierarchy.n_splits());
      const auto one_of = 1 + random() % 12;
      for (std::size_t s = is_wanted.size(); s-- > 0;) {
        if (random() % one_of == 0) is_wanted[s] = 1;
        const Index before = vertices.preceding(static_cast<Index>(s));
        if (is_wanted[s] != 0 && before != k_no_index) is_wanted[before] = 1;
      }
      const FrontMoves moves = front.adapt(graph, [&](Index split) { return is_wanted[split] != 0; });
      n_moves += moves.splits + moves.merges;
    }
    EXPECT_GT(n_moves, 10 * levels.hierarchy.n_splits() / 4) << model.name;
  }
}

// That is what `adapt` promises, for each patch by itself.
TEST(SeamFront, LeavesNoPatchSeamsOfALargerErrorThanItTolerates) {
  std::mt19937 random(33);
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches, 5e-3);
    std::vector<std::set<Index>> patches;
    for (std::size_t s = 0; s < levels.hierarchy.n_splits(); ++s)
      patches.push_back(patches_of_split(levels, s));
    SeamFront front(levels.graph, levels.hierarchy);
    for (int round = 0; round < 50; ++round) {
      const std::vector<double> tolerances = random_tolerances(levels, random);
      front.adapt(tolerances);
      std::size_t n_bad = 0;
      for (std::size_t s = 0; s < levels.hierarchy.n_splits(); ++s) {
        const double error = levels.hierarchy.errors[s];
        n_bad += !front.is_applied(s) && std::any_of(patches[s].begin(), patches[s].end(),
                                                     [&](Index patch) { return error > tolerances[patch]; });
      }
      EXPECT_EQ(n_bad, 0u) << model.name << ", round " << round;
    }
  }
}

TEST(SeamFront, IsTheSameWhereverItCameFrom) {
  std::mt19937 random(34);
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches, 5e-3);
    SeamFront walking(levels.graph, levels.hierarchy);
    for (int round = 0; round < 25; ++round) {
      const std::vector<double> tolerances = random_tolerances(levels, random);
      walking.adapt(tolerances);
      SeamFront fresh(levels.graph, levels.hierarchy);
      fresh.adapt(tolerances);
      const auto here = all_loops(levels, walking), there = all_loops(levels, fresh);
      for (std::size_t patch = 0; patch < here.size(); ++patch)
        EXPECT_TRUE(are_same(here[patch], there[patch])) << model.name << ", round " << round;
      EXPECT_EQ(walking.adapt(tolerances).splits + walking.adapt(tolerances).merges, 0u);
    }
  }
}

TEST(SeamFront, NamesThePatchesThatChanged) {
  std::mt19937 random(35);
  const Levels levels(test::tiled_box({3, 2, 1}, 4));
  SeamFront front(levels.graph, levels.hierarchy);
  EXPECT_EQ(front.take_changed().size(), levels.graph.n_patches());
  EXPECT_TRUE(front.take_changed().empty());
  auto before = all_loops(levels, front);
  for (int round = 0; round < 20; ++round) {
    front.adapt(random_tolerances(levels, random));
    const std::vector<Index> changed = front.take_changed();
    const auto after = all_loops(levels, front);
    for (std::size_t patch = 0; patch < after.size(); ++patch) {
      const bool is_named = std::find(changed.begin(), changed.end(), patch) != changed.end();
      EXPECT_TRUE(is_named || are_same(before[patch], after[patch])) << patch;
    }
    before = after;
  }
}

bool do_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const int ac = detail::orientation(a, b, c), ad = detail::orientation(a, b, d);
  const int ca = detail::orientation(c, d, a), cb = detail::orientation(c, d, b);
  const auto is_on = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    return r.x() >= std::min(p.x(), q.x()) && r.x() <= std::max(p.x(), q.x()) &&
           r.y() >= std::min(p.y(), q.y()) && r.y() <= std::max(p.y(), q.y());
  };
  if (ac * ad < 0 && ca * cb < 0) return true;
  return (ac == 0 && is_on(a, b, c)) || (ad == 0 && is_on(a, b, d)) || (ca == 0 && is_on(c, d, a)) ||
         (cb == 0 && is_on(c, d, b));
}

// Whether sides of loops have points in common but for the ends of neighbours.
bool are_simple(const std::vector<SeamLoop>& loops) {
  struct Side {
    Vec2 from, to;
    std::size_t loop, number;
  };
  std::vector<Side> sides;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    const auto& slots = loops[l];
    if (slots.size() < 3) return false;
    for (std::size_t i = 0; i < slots.size(); ++i)
      sides.push_back({slots[i].uv, slots[(i + 1) % slots.size()].uv, l, i});
  }
  for (std::size_t i = 0; i < sides.size(); ++i) {
    for (std::size_t k = i + 1; k < sides.size(); ++k) {
      const Side &a = sides[i], &b = sides[k];
      const std::size_t n = loops[a.loop].size();
      if (a.loop == b.loop && (a.number + 1 == b.number || (a.number == 0 && b.number + 1 == n))) {
        const Side &first = a.number + 1 == b.number ? a : b, &second = a.number + 1 == b.number ? b : a;
        // They may not turn back on to each other.
        if (detail::orientation(first.from, first.to, second.to) == 0 &&
            (first.from - first.to).dot(second.to - first.to) > 0)
          return false;
        continue;
      }
      if (do_cross(a.from, a.to, b.from, b.to)) return false;
    }
  }
  return true;
}

TEST(SeamFront, KeepsLoopsSimpleInParametersForAnyTolerancesOfPatches) {
  std::mt19937 random(36);
  std::vector<NamedPatches> models = closed_models();
  TrimmedPatch holes = test::whole(test::RandomNurbs(37).sheet(3, 3, 3, false), "sheet");
  const ParameterRange u = holes.surface.domain(0), v = holes.surface.domain(1);
  for (int i = 0; i < 9; ++i) {
    TrimmingLoop hole = test::circle({(i % 3 + 0.5) / 3, (i / 3 + 0.5) / 3}, 0.15, true);
    for (Vec2& p : hole.curves[0].curve.points)
      p = Vec2(u.begin + p.x() * u.length(), v.begin + p.y() * v.length());
    holes.loops.push_back(hole);
  }
  models.push_back({"sheet with holes", {holes}});
  for (const NamedPatches& model : models) {
    const Levels levels(model.patches, 0.02);
    SeamFront front(levels.graph, levels.hierarchy);
    for (int round = 0; round < 200; ++round) {
      std::vector<double> tolerances = random_tolerances(levels, random);
      // A neighbour may not open a hole that its patch has closed.
      if (model.name == "ring") tolerances.assign(tolerances.size(), tolerances[0]);
      front.adapt(tolerances);
      for (std::size_t patch = 0; patch < levels.graph.n_patches(); ++patch)
        ASSERT_TRUE(are_simple(levels.loops_of(front, patch))) << model.name << ", patch " << patch;
    }
  }
}

// Slots beside those of a coarse loop are as far as the widths say.
TEST(SeamFront, KnowsHowFarTrimmingCurvesAreFromCoarseLoops) {
  for (const NamedPatches& model : closed_models()) {
    const Levels levels(model.patches);
    SeamFront front(levels.graph, levels.hierarchy);
    for (const double tolerance : {1.0, 0.3, 0.05}) {
      front.adapt(tolerance);
      for (std::size_t patch = 0; patch < levels.graph.n_patches(); ++patch) {
        const test::TrimmedRegion region(levels.patches[patch], levels.surfaces[patch], 24);
        for (const SeamLoop& loop : levels.loops_of(front, patch)) {
          for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2 &a = loop[i].uv, &b = loop[(i + 1) % loop.size()].uv;
            for (const double share : {0.25, 0.5, 0.75}) {
              const Vec3 on_chord = levels.surfaces[patch].shape.evaluate(a + share * (b - a));
              // The strip between curve and chord holds all of both.
              EXPECT_LE(region.distance_to_outline(on_chord), loop[i].width + region.slack()) << model.name;
            }
          }
        }
      }
    }
  }
}

TEST(SeamHierarchy, OfAnOpenSheetKeepsATriangle) {
  const Levels sheet({test::whole(test::quarter_tube(1, 2))});
  SeamFront front(sheet.graph, sheet.hierarchy);
  ASSERT_EQ(front.n_patches_left(), 1u);
  EXPECT_EQ(sheet.loops_of(front, 0)[0].size(), 3u);
}

TEST(SeamHierarchy, NeedsASurfaceForEachPatch) {
  const Levels box(test::box_faces({1, 1, 1}));
  EXPECT_THROW(build_seam_hierarchy(box.graph, std::span(box.surfaces).first(5)), OptionError);
}

}  // namespace
}  // namespace recede
