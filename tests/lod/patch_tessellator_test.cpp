#include "error_text.h"
#include "seam_checks.h"
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/error.h>
#include <recede/lod/patch_tessellator.h>

#include <gmock/gmock.h>

#include <set>

namespace recede {
namespace {

using test::circle;
using test::parallelogram;
using test::RandomNurbs;
using test::TrimmedRegion;
using test::whole;

// A patch, sewn with nothing but itself, and its triangles.
struct Tessellated {
  TrimmedPatch patch;
  PatchSurface surface;
  SeamGraph graph;
  std::vector<SeamLoop> loops;
  PatchTriangles triangles;
};

Tessellated tessellate(const TrimmedPatch& patch, double tolerance, std::size_t most_points = 4'000'000) {
  Tessellated result{patch, PatchSurface(patch.surface), {}, {}, {}};
  const double size = result.surface.bounds.box(result.surface.shape.domain()).diagonal().norm();
  SeamGraphOptions options;
  // More would make points of whole shapes.
  options.tolerance = std::min(tolerance, 0.2 * size);
  options.gap = 1e-9 * tolerance;  // poles of small balls stay apart
  result.graph = build_seam_graph({&patch, 1}, {&result.surface, 1}, options);
  result.loops = result.graph.loops_of(0);
  PatchTessellationOptions of_patch;
  of_patch.tolerance = tolerance;
  of_patch.most_points = most_points;
  result.triangles = triangulate_patch(result.loops, result.graph.positions, result.surface, of_patch);
  return result;
}

std::vector<Index> vertices_of(const std::vector<SeamLoop>& loops) {
  std::vector<Index> vertices;
  for (const SeamLoop& loop : loops) {
    for (const SeamSlot& slot : loop.slots) vertices.push_back(slot.vertex);
  }
  return vertices;
}

double twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

void expect_points_of_loops(const Tessellated& tested) {
  std::size_t i = 0;
  for (const SeamLoop& loop : tested.loops) {
    for (const SeamSlot& slot : loop.slots) {
      ASSERT_LT(i, tested.triangles.uvs.size());
      EXPECT_EQ(tested.triangles.uvs[i], slot.uv);
      EXPECT_EQ(tested.triangles.positions[i], tested.graph.positions[slot.vertex]);
      ++i;
    }
  }
  for (; i < tested.triangles.uvs.size(); ++i)
    EXPECT_EQ(tested.triangles.positions[i], tested.surface.shape.evaluate(tested.triangles.uvs[i]));
}

// Sides of loops are sides of triangles once, as loops run; all others are there once each way.
void expect_sides_of_loops(const Tessellated& tested) {
  std::map<std::pair<Index, Index>, int> sides;
  for (const auto& t : tested.triangles.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  Index first = 0;
  for (const SeamLoop& loop : tested.loops) {
    const auto n = static_cast<Index>(loop.slots.size());
    for (Index i = 0; i < n; ++i) {
      const std::pair<Index, Index> side{first + i, first + (i + 1) % n};
      EXPECT_EQ(sides[side], 1);
      sides.erase(side);
    }
    first += n;
  }
  for (const auto& [side, times] : sides) {
    EXPECT_EQ(times, 1);
    EXPECT_TRUE(sides.contains({side.second, side.first}));
  }
}

// Where triangles without area in space were left out, the rest is closed over vertices of the graph.
void expect_sides_of_vertices(const Tessellated& tested) {
  const std::vector<Index> vertices = vertices_of(tested.loops);
  const auto vertex = [&](Index point) {
    return point < vertices.size() ? vertices[point]
                                   : static_cast<Index>(tested.graph.positions.size()) + point;
  };
  test::Sides sides = test::open_sides(tested.loops);
  for (const auto& t : tested.triangles.triangles) {
    for (std::size_t k = 0; k < 3; ++k) test::add_side(sides, vertex(t[k]), vertex(t[(k + 1) % 3]), -1);
  }
  EXPECT_TRUE(sides.empty()) << sides.size() << " sides";
}

void expect_fills_loops(const Tessellated& tested) {
  double of_loops = 0, of_triangles = 0;
  for (const SeamLoop& loop : tested.loops) {
    for (std::size_t i = 0; i < loop.slots.size(); ++i)
      of_loops += twice_area(tested.loops[0].slots[0].uv, loop.slots[i].uv,
                             loop.slots[(i + 1) % loop.slots.size()].uv);
  }
  for (const auto& [a, b, c] : tested.triangles.triangles) {
    const std::vector<Vec2>& uvs = tested.triangles.uvs;
    EXPECT_EQ(detail::orientation(uvs[a], uvs[b], uvs[c]), 1);
    of_triangles += twice_area(uvs[a], uvs[b], uvs[c]);
  }
  // Sums of some thousand rounded areas.
  EXPECT_NEAR(of_triangles, of_loops, 1e-11 * of_loops);
}

std::size_t count_inverted(const Tessellated& tested) {
  std::size_t inverted = 0;
  for (const auto& [a, b, c] : tested.triangles.triangles) {
    const auto& p = tested.triangles.positions;
    const Vec3 normal = (p[b] - p[a]).cross(p[c] - p[a]);
    bool is_inverted = true;
    for (const Index corner : {a, b, c})
      is_inverted = is_inverted && tested.surface.shape.normal(tested.triangles.uvs[corner]).dot(normal) <
                                       -1e-6 * normal.norm();
    inverted += is_inverted ? 1 : 0;
  }
  return inverted;
}

void expect_bound_holds(const Tessellated& tested, unsigned seed, std::size_t n = 10'000) {
  std::mt19937 random(seed);
  const TrimmedRegion region(tested.patch, tested.surface);
  const ClosestPointTree tree = test::tree_of(tested.triangles);
  const double limit = tested.triangles.error_bound * (1 + 1e-9) + region.slack();
  EXPECT_LE(test::distance_of_surface(region, tested.surface, tree, n, random), limit);
  EXPECT_LE(test::distance_of_triangles(tested.triangles, region, tested.surface, n, random), limit);
}

void expect_good(const Tessellated& tested, double tolerance, unsigned seed) {
  EXPECT_TRUE(tested.triangles.reached_tolerance) << tested.triangles.error_bound;
  EXPECT_LE(tested.triangles.error_bound, tolerance);
  EXPECT_EQ(tested.triangles.inverted, 0u);
  EXPECT_EQ(count_inverted(tested), 0u);
  expect_points_of_loops(tested);
  expect_sides_of_vertices(tested);
  expect_bound_holds(tested, seed);
}

TrimmedPatch with_holes(NurbsSurface surface, int n) {
  TrimmedPatch patch = whole(surface, "holes");
  const ParameterRange u = surface.domain(0), v = surface.domain(1);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      TrimmingLoop hole = circle({(i + 0.5) / n, (j + 0.45) / n}, 0.3 / n, true);
      for (Vec2& p : hole.curves[0].curve.points)
        p = Vec2(u.begin + p.x() * u.length(), v.begin + p.y() * v.length());
      patch.loops.push_back(hole);
    }
  }
  return patch;
}

TEST(PatchTessellator, MakesTwoTrianglesOfASquare) {
  const Tessellated square = tessellate(whole(parallelogram({0, 0, 0}, {2, 0, 0}, {0, 1, 0})), 1e-6);
  EXPECT_EQ(square.triangles.uvs.size(), 4u);
  EXPECT_EQ(square.triangles.triangles.size(), 2u);
  EXPECT_EQ(square.triangles.error_bound, 0);
  EXPECT_TRUE(square.triangles.reached_tolerance);
  expect_sides_of_loops(square);
  expect_fills_loops(square);
}

TEST(PatchTessellator, AddsNoPointsToPlanes) {
  const Tessellated plate = tessellate(with_holes(parallelogram({0, 0, 0}, {3, 1, 0}, {0, 2, 1}), 4), 1e-4);
  EXPECT_EQ(plate.triangles.uvs.size(), vertices_of(plate.loops).size());
  // Euler: each of 16 holes adds two triangles to the n - 2 of a polygon.
  EXPECT_EQ(plate.triangles.triangles.size(), plate.triangles.uvs.size() - 2 + 2 * 16);
  expect_good(plate, 1e-4, 11);
  expect_sides_of_loops(plate);
  expect_fills_loops(plate);
}

TEST(PatchTessellator, ReachesItsToleranceOnTubes) {
  for (const double tolerance : {0.3, 0.03, 1e-3}) {
    const Tessellated tube = tessellate(whole(test::quarter_tube(1, 5)), tolerance);
    expect_good(tube, tolerance, 12);
    expect_sides_of_loops(tube);
    expect_fills_loops(tube);
  }
  // Long triangles along the tube need no point within: each of n strips is two.
  const Tessellated tube = tessellate(whole(test::quarter_tube(1, 5)), 1e-3);
  EXPECT_LE(tube.triangles.triangles.size(), 4 * tube.loops[0].slots.size());
}

TEST(PatchTessellator, ReachesItsToleranceOnBallsWhereSidesArePoles) {
  for (const double tolerance : {0.2, 0.02, 1e-3}) {
    const Tessellated ball = tessellate(whole(test::ball(1)), tolerance);
    expect_good(ball, tolerance, 13);
    EXPECT_TRUE(test::open_sides(ball.loops).empty());
  }
}

// Without a point within, all triangles of a ball that may be coarse lie between its poles.
TEST(PatchTessellator, LeavesSomethingOfABallThatIsSmallerThanItsTolerance) {
  const Tessellated ball = tessellate(whole(test::ball(1)), 5);
  EXPECT_GT(ball.triangles.triangles.size(), 0u);
  expect_good(ball, 5, 21);
}

TEST(PatchTessellator, ReachesItsToleranceOnSheetsWithHoles) {
  RandomNurbs random(14);
  for (const double tolerance : {0.1, 0.01}) {
    const Tessellated sheet = tessellate(with_holes(random.sheet(3, 3, 4, false), 3), tolerance);
    expect_good(sheet, tolerance, 15);
    expect_sides_of_loops(sheet);
    expect_fills_loops(sheet);
  }
}

TEST(PatchTessellator, ReachesItsToleranceOnRandomSheetsEvenWithKinks) {
  RandomNurbs random(16);
  for (unsigned round = 0; round < 12; ++round) {
    const int degree = random.integer(1, 4);
    const NurbsSurface surface = random.sheet(degree, random.integer(1, 4), random.integer(0, 6),
                                              round % 2 == 0, round % 3 == 0 ? degree : 1);
    const Tessellated sheet = tessellate(whole(surface), 0.02);
    EXPECT_TRUE(sheet.triangles.reached_tolerance) << round;
    expect_points_of_loops(sheet);
    expect_sides_of_loops(sheet);
    expect_fills_loops(sheet);
    expect_bound_holds(sheet, round, 2000);
  }
}

TEST(PatchTessellator, NeedsAboutTwiceTheTrianglesForHalfTheTolerance) {
  RandomNurbs random(17);
  const std::vector<TrimmedPatch> patches{whole(test::ball(1)), whole(random.sheet(3, 3, 3, true))};
  for (const TrimmedPatch& patch : patches) {
    const std::size_t coarse = tessellate(patch, 4e-3).triangles.triangles.size();
    const std::size_t fine = tessellate(patch, 1e-3).triangles.triangles.size();
    // A fourth of the tolerance: errors go with the square of lengths, numbers with it too. 30 % for what
    // lattices and borders round.
    EXPECT_GT(fine, 2.8 * static_cast<double>(coarse));
    EXPECT_LT(fine, 5.2 * static_cast<double>(coarse));
  }
}

TEST(PatchTessellator, SaysWhatItReachedWithFewerPointsThanItNeeds) {
  RandomNurbs random(18);
  for (unsigned round = 0; round < 6; ++round) {
    const TrimmedPatch patch =
        round == 0 ? whole(test::ball(1)) : with_holes(random.sheet(3, 2, 4, round % 2 == 0), 2);
    const Tessellated coarse = tessellate(patch, 1e-3, 20 * round);
    EXPECT_FALSE(coarse.triangles.reached_tolerance);
    EXPECT_GT(coarse.triangles.error_bound, 1e-3);
    EXPECT_LE(coarse.triangles.uvs.size(), vertices_of(coarse.loops).size() + 20 * round);
    expect_sides_of_vertices(coarse);
    expect_bound_holds(coarse, round, 4000);
  }
}

// Loops that the graph has moved a good way: what is sewn counts.
TEST(PatchTessellator, CountsWhatSewingMoved) {
  Tessellated square = tessellate(whole(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})), 0.5);
  square.graph.positions[square.loops[0].slots[2].vertex] += Vec3(0, 0, 0.25);
  PatchTessellationOptions options;
  options.tolerance = 0.5;
  square.triangles = triangulate_patch(square.loops, square.graph.positions, square.surface, options);
  EXPECT_TRUE(square.triangles.reached_tolerance);
  EXPECT_NEAR(square.triangles.error_bound, 0.25, 1e-15);
  expect_bound_holds(square, 19, 2000);
  options.tolerance = 0.2;
  square.triangles = triangulate_patch(square.loops, square.graph.positions, square.surface, options);
  EXPECT_FALSE(square.triangles.reached_tolerance);
  EXPECT_NEAR(square.triangles.error_bound, 0.25, 1e-15);
}

// A border that is coarser than the tolerance can't be mended by points within: there are not many more.
// What a strip takes of the tolerance isn't taken from triangles beside it, which end at its chord.
TEST(PatchTessellator, TakesTheLargerOfStripsAndTriangles) {
  TrimmedPatch patch = whole(parallelogram({0, 0, 0}, {4, 0, 0}, {0, 4, 0}));
  patch.loops = {circle({0.5, 0.5}, 0.25, false)};
  const Tessellated disc = tessellate(patch, 0.1);
  EXPECT_TRUE(disc.triangles.reached_tolerance);
  EXPECT_EQ(disc.triangles.error_bound,
            static_cast<double>(*std::max_element(disc.graph.widths.begin(), disc.graph.widths.end())));
  EXPECT_GT(disc.triangles.error_bound, 0.02);
  EXPECT_EQ(disc.triangles.positions.size(), disc.graph.positions.size()) << "no points within a disc";
}

TEST(PatchTessellator, DoesNotTryForEverWhereLoopsAreCoarserThanItsTolerance) {
  Tessellated sheet = tessellate(whole(test::RandomNurbs(22).sheet(3, 3, 3, false)), 0.1);
  const std::size_t expected = tessellate(sheet.patch, 0.01).triangles.triangles.size();
  PatchTessellationOptions options;
  options.tolerance = 0.01;
  sheet.triangles = triangulate_patch(sheet.loops, sheet.graph.positions, sheet.surface, options);
  EXPECT_FALSE(sheet.triangles.reached_tolerance);
  EXPECT_TRUE(std::isfinite(sheet.triangles.error_bound));
  EXPECT_LT(sheet.triangles.triangles.size(), 4 * expected);
  expect_bound_holds(sheet, 23, 2000);
}

SeamLoop loop_of(const std::vector<Vec2>& uvs, Index first_vertex) {
  SeamLoop loop;
  for (const Vec2& uv : uvs) {
    loop.slots.push_back({uv, first_vertex++});
    loop.widths.push_back(0);
  }
  return loop;
}

// What `triangulate_patch` complains about for loops over a square of side 1.
std::string complaint(const std::vector<std::vector<Vec2>>& loops) {
  const PatchSurface surface(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  std::vector<SeamLoop> of_graph;
  std::vector<Vec3> positions;
  for (const auto& uvs : loops) {
    of_graph.push_back(loop_of(uvs, static_cast<Index>(positions.size())));
    for (const Vec2& uv : uvs) positions.emplace_back(uv.x(), uv.y(), 0);
  }
  PatchTessellationOptions options;
  options.tolerance = 0.1;
  return test::error_text([&] { triangulate_patch(of_graph, positions, surface, options); });
}

TEST(PatchTessellator, RefusesLoopsThatCrossOrGoAroundNothing) {
  EXPECT_EQ(complaint({{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}), "");
  EXPECT_THAT(complaint({{{0, 0}, {1, 1}, {1, 0}, {0, 1}}}), testing::HasSubstr("cross"));
  EXPECT_THAT(complaint({{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, {{0.5, 0.5}, {0.5, 0.7}, {1.5, 0.6}}}),
              testing::HasSubstr("cross"));
  EXPECT_NE(complaint({}), "");
  EXPECT_NE(complaint({{{0, 0}, {1, 1}}}), "");
  // All on a line, and twice the same point in a row.
  EXPECT_THAT(complaint({{{0, 0}, {0.5, 0.5}, {1, 1}}}), testing::HasSubstr("around nothing"));
  EXPECT_NE(complaint({{{0, 0}, {1, 0}, {1, 0}, {0, 1}}}), "");
  EXPECT_THAT(complaint({{{0, 0}, {0, 1}, {1, 1}, {1, 0}}}), testing::HasSubstr("the wrong way"));
}

TEST(PatchTessellator, RefusesTolerancesThatAreNone) {
  const PatchSurface surface(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const std::vector<Vec3> positions{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
  const std::vector<SeamLoop> loops{loop_of({{0, 0}, {1, 0}, {1, 1}}, 0)};
  for (const double tolerance : {0.0, -1.0, std::nan("")}) {
    PatchTessellationOptions options;
    options.tolerance = tolerance;
    EXPECT_THROW(triangulate_patch(loops, positions, surface, options), OptionError) << tolerance;
  }
}

// The same shape in other units and elsewhere has about the same triangles.
TEST(PatchTessellator, DoesNotDependOnUnits) {
  const std::size_t expected = tessellate(whole(test::ball(1)), 0.01).triangles.triangles.size();
  for (const double scale : {1e-9, 1e-3, 1e9}) {
    const Tessellated ball = tessellate(whole(test::ball(scale)), 0.01 * scale);
    EXPECT_TRUE(ball.triangles.reached_tolerance) << scale;
    EXPECT_EQ(ball.triangles.inverted, 0u);
    // Rounding may turn some flips of equal circles.
    EXPECT_NEAR(static_cast<double>(ball.triangles.triangles.size()), static_cast<double>(expected),
                0.05 * static_cast<double>(expected))
        << scale;
    expect_bound_holds(ball, 20, 2000);
  }
}

TEST(PatchTessellator, WorksFarFromTheOrigin) {
  const Tessellated ball = tessellate(whole(test::ball(1, {1e6, -1e6, 1e6})), 0.01);
  EXPECT_TRUE(ball.triangles.reached_tolerance);
  EXPECT_EQ(ball.triangles.inverted, 0u);
  expect_sides_of_vertices(ball);
  EXPECT_LT(ball.triangles.triangles.size(), 2000u);
}

TEST(PatchTessellator, ProvesFineTolerancesWhereTrianglesAreWideInParametersAndNarrowInSpace) {
  const double radius = 10;
  for (const double tolerance : {0.3, 0.02, 0.002}) {
    const PatchTriangles made = tessellate(whole(test::ball(radius)), tolerance).triangles;
    EXPECT_TRUE(made.reached_tolerance) << tolerance;
    EXPECT_LE(made.error_bound, tolerance);
    for (const auto& [a, b, c] : made.triangles) {
      // Triangles of a ball are inside of it, farthest at the middle of their circles or sides.
      const Vec3 &p = made.positions[a], &q = made.positions[b], &r = made.positions[c];
      for (const Vec3& point :
           {Vec3((p + q) / 2), Vec3((q + r) / 2), Vec3((r + p) / 2), Vec3((p + q + r) / 3)})
        EXPECT_GE(point.norm(), radius - tolerance);
    }
  }
}

TEST(PatchTessellator, DoesNotCrowdPointsAtPoles) {
  const double tolerance = 0.002;
  const PatchTriangles made = tessellate(whole(test::ball(10)), tolerance).triangles;
  for (std::size_t i = 0; i < made.positions.size(); ++i) {
    const double from_axis = made.positions[i].head<2>().norm();
    // Halving the way to a pole again and again would come to 1e-9; a hundredth of the tolerance isn't
    // needed.
    if (from_axis > 1e-12) {
      EXPECT_GT(from_axis, tolerance / 100) << i;
    }
  }
}

}  // namespace
}  // namespace recede
