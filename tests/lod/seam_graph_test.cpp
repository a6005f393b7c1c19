#include "trimmed_patches.h"
#include <recede/geometry/error.h>
#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/loop_triangulation.h>
#include <recede/lod/seam_graph.h>

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace recede {
namespace {

using test::box_faces;
using test::parallelogram;
using test::whole;

SeamGraph graph_of(const std::vector<TrimmedPatch>& patches, const SeamGraphOptions& options = {}) {
  return build_seam_graph(patches, prepare_surfaces(patches), options);
}

// How often loops run along each pair of vertices, less how often they run back: what stays open.
std::map<std::pair<Index, Index>, int> open_sides(const SeamGraph& graph) {
  std::map<std::pair<Index, Index>, int> sides;
  for (std::size_t l = 0; l < graph.n_loops(); ++l) {
    const auto loop = graph.loop(l);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Index a = loop[i].vertex, b = loop[(i + 1) % loop.size()].vertex;
      if (a != b) sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  std::erase_if(sides, [](const auto& side) { return side.second == 0; });
  return sides;
}

bool is_simple(const std::vector<Vec2>& points) {
  std::vector<std::array<Index, 2>> sides;
  for (std::size_t i = 0; i < points.size(); ++i)
    sides.push_back({static_cast<Index>(i), static_cast<Index>((i + 1) % points.size())});
  try {
    detail::triangulate_loops(points, sides);
  } catch (const InputError&) {
    return false;
  }
  return true;
}

TEST(SeamGraph, OfABoxHasEightPointsAndTwelveSeams) {
  const SeamGraph graph = graph_of(box_faces({3, 2, 1}));
  EXPECT_EQ(graph.positions.size(), 8u);
  EXPECT_EQ(graph.n_patches(), 6u);
  EXPECT_EQ(graph.n_loops(), 6u);
  EXPECT_EQ(graph.slots.size(), 24u);
  EXPECT_EQ(graph.report.edges_by_position, 12u);
  EXPECT_EQ(graph.report.edges_of_file + graph.report.free_edges + graph.report.crowded_edges, 0u);
  EXPECT_TRUE(graph.report.gaps.empty());
  EXPECT_EQ(graph.report.largest_move, 0);
  EXPECT_TRUE(open_sides(graph).empty());
  // Straight lines, but for rounding.
  for (const SeamSlot& slot : graph.slots) EXPECT_LT(slot.width, 1e-14f);
}

TEST(SeamGraph, CutsAnEdgeWhereKnotsOfItsCurvesAreAlmostInOnePlace) {
  std::vector<TrimmedPatch> patches{whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})),
                                    whole(parallelogram({1, 0, 0}, {1, 0, 0}, {0, 1, 0}))};
  TrimmingCurve &right = patches[0].loops[0].curves[1], &left = patches[1].loops[0].curves[3];
  right.edge = left.edge = 7;
  left.runs_against = true;
  // More than rounding apart, which makes them two places, and less than twice that.
  const double knot = 0.5 + 1.3e-9;
  right.curve = {1, {0, 0, 0.5, 1, 1}, {{1, 0}, {1, 0.5}, {1, 1}}, {}};
  left.curve = {1, {0, 0, 1 - knot, 1, 1}, {{0, 1}, {0, knot}, {0, 0}}, {}};
  const SeamGraph graph = graph_of(patches);
  EXPECT_EQ(graph.report.edges_of_file, 1u);
  EXPECT_EQ(graph.positions.size(), 8u) << "the six corners and both knots";
}

TEST(SeamGraph, TakesSharedEdgesFromTheFile) {
  // Two squares side by side, a tenth apart: only the file knows that they belong together.
  std::vector<TrimmedPatch> patches{whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})),
                                    whole(parallelogram({1.1, 0, 0}, {1, 0, 0}, {0, 1, 0}))};
  TrimmingCurve &right = patches[0].loops[0].curves[1], &left = patches[1].loops[0].curves[3];
  right.edge = left.edge = 7;
  left.runs_against = true;
  right.corners = {4, 9};
  left.corners = {9, 4};
  const SeamGraph graph = graph_of(patches);
  EXPECT_EQ(graph.positions.size(), 6u);
  EXPECT_EQ(graph.report.edges_of_file, 1u);
  EXPECT_EQ(graph.report.free_edges, 6u);
  EXPECT_NEAR(graph.report.largest_move, 0.05, 1e-12);
  EXPECT_EQ(open_sides(graph).size(), 6u);
  SeamGraphOptions options;
  options.use_connectivity = false;
  options.gap = 0.01;
  const SeamGraph apart = graph_of(patches, options);
  EXPECT_EQ(apart.positions.size(), 8u);
  EXPECT_EQ(apart.report.edges_of_file, 0u);
}

TEST(SeamGraph, SewsGapsUpToTheWidthGivenAndListsTheOthers) {
  const auto patches_apart = [](double gap) {
    return std::vector<TrimmedPatch>{whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), "one"),
                                     whole(parallelogram({1 + gap, 0, 0}, {1, 0, 0}, {0, 1, 0}), "two")};
  };
  SeamGraphOptions options;
  options.gap = 1e-3;
  const SeamGraph sewn = graph_of(patches_apart(0.9e-3), options);
  EXPECT_EQ(sewn.report.edges_by_position, 1u);
  EXPECT_NEAR(sewn.report.largest_move, 0.45e-3, 1e-12);
  EXPECT_TRUE(sewn.report.gaps.empty());
  const SeamGraph open = graph_of(patches_apart(1.1e-3), options);
  EXPECT_EQ(open.report.edges_by_position, 0u);
  ASSERT_EQ(open.report.gaps.size(), 2u);  // seen from both sides
  EXPECT_EQ(open.report.gaps[0].patch, 0u);
  EXPECT_EQ(open.report.gaps[0].other, 1u);
  EXPECT_NEAR(open.report.gaps[0].distance, 1.1e-3, 1e-12);
}

TEST(SeamGraph, CutsSeamsWhereAThirdPatchBegins) {
  // A long side meets two short ones.
  const std::vector<TrimmedPatch> patches{whole(parallelogram({0, 0, 0}, {2, 0, 0}, {0, 1, 0})),
                                          whole(parallelogram({0, -1, 0}, {0.7, 0, 0}, {0, 1, 0})),
                                          whole(parallelogram({0.7, -1, 0}, {1.3, 0, 0}, {0, 1, 0}))};
  const SeamGraph graph = graph_of(patches);
  EXPECT_EQ(graph.loop(0).size(), 5u);
  EXPECT_EQ(graph.positions.size(), 8u);
  EXPECT_EQ(graph.report.edges_by_position, 3u);
  // Left open: the outline, without the sides in common.
  EXPECT_EQ(open_sides(graph).size(), 7u);
}

TEST(SeamGraph, HoldsSeamsOfThreePatches) {
  const std::vector<TrimmedPatch> patches{whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})),
                                          whole(parallelogram({0, 0, 0}, {-1, 0, 0}, {0, 1, 0})),
                                          whole(parallelogram({0, 0, 0}, {0, 0, 1}, {0, 1, 0}))};
  const SeamGraph graph = graph_of(patches);
  EXPECT_EQ(graph.report.crowded_edges, 1u);
  EXPECT_EQ(graph.positions.size(), 8u);
}

TEST(SeamGraph, HoldsTheSamePatchTwice) {
  const NurbsSurface square = parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  const SeamGraph graph = graph_of({whole(square), whole(square)});
  EXPECT_EQ(graph.positions.size(), 4u);
  EXPECT_EQ(graph.report.edges_by_position, 4u);
}

TEST(SeamGraph, ClosesSeamsOfAPatchWithItself) {
  for (const double tolerance : {0.1, 1e-3}) {
    SeamGraphOptions options;
    options.tolerance = tolerance;
    const SeamGraph graph = graph_of(test::can(1, 2), options);
    // The bottom's circle starts a quarter off the wall's, and is two seams for that.
    EXPECT_EQ(graph.report.edges_by_position, 4u) << tolerance;
    EXPECT_EQ(graph.report.free_edges, 0u);
    EXPECT_TRUE(open_sides(graph).empty());
    // All points are on the two circles.
    for (const Vec3& point : graph.positions) EXPECT_NEAR(point.head<2>().norm(), 1, 1e-12);
    // A chord of n in a circle is 1 - cos(pi / n) away. Bounds of both strips add to three times that,
    // halving makes it four times less at most, and points of matched circles lie between one another.
    const double n = static_cast<double>(graph.loop(1).size());
    EXPECT_LT(1 - std::cos(std::numbers::pi / n), tolerance);
    EXPECT_GT(1 - std::cos(std::numbers::pi / n), tolerance / 30);
  }
}

TEST(SeamGraph, KeepsPolesAsOnePoint) {
  const SeamGraph graph = graph_of({whole(test::ball(1))});
  EXPECT_TRUE(open_sides(graph).empty());
  std::size_t poles = 0;
  for (const Vec3& point : graph.positions)
    if (std::abs(point.z()) > 1 - 1e-12) ++poles;
  EXPECT_EQ(poles, 2u);
  EXPECT_EQ(graph.report.edges_by_position, 1u);
}

// A crescent between two arcs that come near to one another: chords of one cross those of the other where
// both are coarse.
TEST(SeamGraph, GetsFinerLoopsWhereCoarseOnesWouldCross) {
  TrimmedPatch crescent = whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const std::vector<double> knots{0, 0, 0, 0, 1, 1, 1, 1};
  const NurbsCurve2 outer{3, knots, {{1, 0}, {1.3, 1.3}, {-1.3, 1.3}, {-1, 0}}, {}};
  const NurbsCurve2 inner{3, knots, {{-1, 0}, {0.1, 1.05}, {1.05, 1.05}, {1, 0}}, {}};
  crescent.surface = parallelogram({-2, 0, 0}, {4, 0, 0}, {0, 2, 0});
  crescent.surface.knots = {std::vector<double>{-2, -2, 2, 2}, {0, 0, 2, 2}};
  crescent.loops = {{{{outer}, {inner}}}};
  const std::vector<PatchSurface> surfaces = prepare_surfaces(std::span(&crescent, 1));
  std::size_t n_crossed = 0;
  for (double tolerance = 0.5; tolerance > 1e-3; tolerance *= 0.9) {
    // What the curves are on their own.
    std::vector<Vec2> points;
    for (const NurbsCurve2* curve : {&outer, &inner}) {
      const detail::SeamCurve use{surfaces.data(), curve, curve->domain(), false};
      const std::vector<Vec2> uvs = detail::sample_edge({&use, 1}, tolerance, 2)[0].uvs;
      points.insert(points.end(), uvs.begin(), uvs.end() - 1);
    }
    if (!is_simple(points)) ++n_crossed;
    SeamGraphOptions options;
    options.tolerance = tolerance;
    const SeamGraph graph = build_seam_graph(std::span(&crescent, 1), surfaces, options);
    points.clear();
    for (const SeamSlot& slot : graph.loop(0)) points.push_back(slot.uv);
    EXPECT_TRUE(is_simple(points)) << tolerance;
  }
  EXPECT_GT(n_crossed, 0u) << "nothing to mend";
}

// Two half discs of one plane whose files' edges are apart: half of that is gone before chords take theirs.
TEST(SeamGraph, LeavesChordsWhatSewingLeaves) {
  constexpr double k_tolerance = 0.05;
  const auto graph_with = [&](double apart) {
    const NurbsCurve2 arc{2, {0, 0, 0, 1, 1, 1}, {{0, 0}, {0.5, 1}, {1, 0}}, {}};
    std::vector<TrimmedPatch> patches{whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})),
                                      whole(parallelogram({0, apart, 0}, {1, 0, 0}, {0, 1, 0}))};
    TrimmingCurve below{reversed(arc)}, above{arc};
    below.edge = above.edge = 0;
    above.runs_against = true;
    below.corners = {1, 0};
    above.corners = {0, 1};
    patches[0].loops = {{{test::line({0, 0}, {1, 0}), below}}};
    patches[1].loops = {
        {{above, test::line({1, 0}, {1, 1}), test::line({1, 1}, {0, 1}), test::line({0, 1}, {0, 0})}}};
    SeamGraphOptions options;
    options.tolerance = k_tolerance;
    return graph_of(patches, options);
  };
  const std::size_t together = graph_with(0).positions.size();
  const SeamGraph sewn = graph_with(0.08);
  EXPECT_NEAR(sewn.report.largest_move, 0.04, 1e-12);
  EXPECT_GT(sewn.positions.size(), together);
  for (const SeamSlot& slot : sewn.slots) EXPECT_LE(static_cast<double>(slot.width) + 0.04, k_tolerance);
  // Where no chord would do, none is made finer.
  EXPECT_EQ(graph_with(0.2).positions.size(), together);
}

// The strips between curves and chords, and chords and the surface below them, are as narrow as asked for.
TEST(SeamGraph, StaysWithinItsTolerance) {
  std::vector<TrimmedPatch> patches = test::can(1, 2);
  patches[2].loops.push_back(test::circle({0.55, 0.5}, 0.1, true));
  for (const double tolerance : {0.1, 0.01, 1e-4}) {
    SeamGraphOptions options;
    options.tolerance = tolerance;
    const auto surfaces = prepare_surfaces(patches);
    const SeamGraph graph = build_seam_graph(patches, surfaces, options);
    EXPECT_EQ(graph.tolerance, tolerance);
    for (std::size_t p = 0; p < graph.n_patches(); ++p) {
      for (std::size_t l = graph.patch_loops[p]; l < graph.patch_loops[p + 1]; ++l) {
        const auto loop = graph.loop(l);
        for (std::size_t i = 0; i < loop.size(); ++i) {
          const SeamSlot &a = loop[i], &b = loop[(i + 1) % loop.size()];
          EXPECT_LE(a.width, tolerance);
          for (const double share : {0.25, 0.5, 0.75}) {
            const Vec3 on_surface = surfaces[p].shape.evaluate(a.uv + share * (b.uv - a.uv));
            const Vec3 on_chord =
                graph.positions[a.vertex] + share * (graph.positions[b.vertex] - graph.positions[a.vertex]);
            EXPECT_LE((on_surface - on_chord).norm(), tolerance);
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace recede
