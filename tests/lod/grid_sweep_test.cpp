// Voxels of a view, and triangles among them: claims about the space and the sweep before anything is
// displaced.
#include <recede/geometry/error.h>
#include <recede/lod/detail/grid_sweep.h>

#include <gmock/gmock.h>

#include <map>
#include <numbers>
#include <random>
#include <set>

namespace recede::detail {
namespace {

/// An angle of 90 degrees and 300 pixels, along -z.
GridSpace right_angle(double voxel_pixels = 1) {
  RemeshView view;
  view.position = Vec3::Zero();
  view.target = -Vec3::UnitZ();
  view.field_of_view = std::numbers::pi / 2;
  view.width = view.height = 300;
  return {view, voxel_pixels, 1, 0};
}

TEST(GridSpace, HasTheDepthsOfTheSource) {
  const GridSpace space = right_angle();
  // Values of the specification, three digits after the point.
  EXPECT_NEAR(space.steps_to(2), 104.318, 5e-4);
  EXPECT_NEAR(space.steps_to(10), 346.538, 5e-4);
  EXPECT_NEAR(space.steps_to(100), 693.076, 5e-4);
}

TEST(GridSpace, HasVoxelsThatAreAsDeepAsWideAtEveryDepth) {
  const GridSpace space = right_angle();
  for (const double depth : {1.0, 2.0, 10.0, 99.0, 1e5}) {
    const double behind = depth + space.voxel_size(depth);
    // Differences of some thousand steps.
    EXPECT_NEAR(space.steps_to(behind) - space.steps_to(depth), 1, 1e-11) << "as deep as wide";
  }
}

TEST(GridSpace, KeepsVoxelsWhereDepthOnTheScreenStretchesThemTenfold) {
  // Depth on the screen for planes at 1 and 100, scaled so that a voxel at depth 10 is a cube.
  const auto on_screen = [](double z) { return 101.0 / 99 - 200 / (99 * z); };
  const GridSpace space = right_angle();
  const auto width_over_depth = [&](auto&& steps_to, double z) {
    constexpr double k_small = 1e-4;
    const double slope = (steps_to(z + k_small) - steps_to(z - k_small)) / (2 * k_small);
    return slope * space.voxel_size(z);  // depth of a voxel is 1 / slope
  };
  const auto in_space = [&](double z) { return space.steps_to(z); };
  for (const double z : {1.0, 10.0, 100.0}) {
    // The slope's square is what the quotient of differences is off by, at most 1e-8.
    EXPECT_NEAR(width_over_depth(on_screen, z) / width_over_depth(on_screen, 10), 10 / z, 1e-6);
    EXPECT_NEAR(width_over_depth(in_space, z) / width_over_depth(in_space, 10), 1, 1e-6);
  }
}

TEST(GridSpace, PutsPixelsWhereTheCameraSeesThem) {
  const GridSpace space = right_angle();
  const ViewPoint middle = space.view({0, 0, -5}), corner = space.view({5, 5, -5});
  EXPECT_EQ(middle.voxel[0], 150);
  EXPECT_EQ(middle.voxel[1], 150);
  EXPECT_EQ(corner.voxel[0], 300) << "x to the right";
  EXPECT_EQ(corner.voxel[1], 0) << "y downwards";
  EXPECT_EQ(right_angle(5).view({5, 5, -5}).voxel[0], 60);
}

TEST(GridSpace, RefusesNumbersOutOfRange) {
  const auto space = [](const auto& change) {
    RemeshView view;
    double pixels = 1;
    change(view, pixels);
    return GridSpace(view, pixels, 1, 0);
  };
  EXPECT_NO_THROW(space([](RemeshView&, double&) {}));
  EXPECT_NO_THROW(space([](RemeshView& v, double&) { v.up = v.target - v.position; }));
  EXPECT_THROW(space([](RemeshView& v, double&) { v.target = v.position; }), OptionError);
  EXPECT_THROW(space([](RemeshView& v, double&) { v.position.x() = std::nan(""); }), OptionError);
  EXPECT_THROW(space([](RemeshView& v, double&) { v.field_of_view = 4; }), OptionError);
  EXPECT_THROW(space([](RemeshView& v, double&) { v.width = 0; }), OptionError);
  EXPECT_THROW(space([](RemeshView& v, double&) { v.height = -3; }), OptionError);
  EXPECT_THROW(space([](RemeshView&, double& pixels) { pixels = 0; }), OptionError);
  EXPECT_THROW(space([](RemeshView&, double& pixels) { pixels = 1e-9; }), OptionError);
}

using Corners = std::array<GridPoint, 3>;

Corners random_corners(std::mt19937& random, int extent) {
  Corners corners;
  for (GridPoint& p : corners) {
    for (auto& x : p) x = static_cast<std::int32_t>(random() % static_cast<unsigned>(extent + 1));
  }
  return corners;
}

TEST(GridSweep, FindsAPrimaryEdgeInEveryTriangle) {
  std::mt19937 random(1);
  for (int i = 0; i < 200'000; ++i) {
    const Corners p = random_corners(random, 1 + i % 20);  // small extents give ties
    const SweepPlan plan = plan_sweep(p);
    const MainDirection main = main_direction(p[plan.a], p[plan.b]);
    ASSERT_EQ(plan.sweep, main.axis);
    ASSERT_LE(p[plan.a][plan.sweep], p[plan.c][plan.sweep]);
    ASSERT_LE(p[plan.c][plan.sweep], p[plan.b][plan.sweep]);
    ASSERT_NE(plan.side, plan.sweep);
    // The longest one: no other primary edge has more pieces.
    for (std::size_t k = 0; k < 3; ++k) {
      const GridPoint &a = p[k], &b = p[(k + 1) % 3], &c = p[(k + 2) % 3];
      const MainDirection other = main_direction(a, b);
      const auto [least, most] = std::minmax(a[other.axis], b[other.axis]);
      if (least <= c[other.axis] && c[other.axis] <= most) {
        ASSERT_LE(other.length, main.length);
      }
    }
  }
}

/// What must hold for the small triangles of one, and how many there are for a voxel of its area.
struct SweepCheck {
  std::size_t triangles = 0, without_area = 0;
  double twice_area = 0;
};

SweepCheck check_sweep(const Corners& corners) {
  GridSweep sweep;
  sweep.set(corners);
  const SweepPlan& plan = sweep.plan();
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  SweepCheck check;
  const auto cross = [](const GridSweep::Node& a, const GridSweep::Node& b, const GridSweep::Node& c) {
    return (b.sweep - a.sweep) * (c.side - a.side) - (c.sweep - a.sweep) * (b.side - a.side);
  };
  const double direction = plan.is_reversed ? -1 : 1;
  sweep.triangulate([&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    const double area = direction * cross(sweep.node(i), sweep.node(j), sweep.node(k));
    EXPECT_GE(area, -1e-9) << "turned over; rounding of products of some 1e3 is below 1e-12";
    check.without_area += area < 1e-9 ? 1 : 0;
    check.twice_area += area;
    ++check.triangles;
    for (const auto& edge : {std::pair(i, j), std::pair(j, k), std::pair(k, i)}) {
      EXPECT_EQ(++edges[edge], 1) << "an edge that is used twice in one direction";
    }
  });
  EXPECT_EQ(check.triangles, sweep.n_triangles());
  // The border is that of the triangle, in its direction; everything else is matched.
  std::set<std::pair<std::uint32_t, std::uint32_t>> border;
  for (std::uint32_t k = 0; k < 3; ++k) {
    std::uint32_t last = k;
    for (std::size_t i = 0; i < sweep.n_on_edge(k); ++i) {
      const auto v = static_cast<std::uint32_t>(sweep.first_on_edge(k) + i);
      border.emplace(last, v);
      last = v;
    }
    border.emplace(last, (k + 1) % 3);
  }
  for (const auto& [edge, n] : edges) {
    const bool is_matched = edges.count({edge.second, edge.first}) > 0;
    EXPECT_NE(is_matched, border.count(edge) > 0);
  }
  for (const auto& edge : border) EXPECT_EQ(edges.count(edge), 1u);
  const double whole = direction * cross(sweep.node(0), sweep.node(1), sweep.node(2));
  EXPECT_NEAR(check.twice_area, whole, 1e-9 * (1 + whole));
  return check;
}

TEST(GridSweep, CoversTrianglesByADiskOfTheirDirectionWithTheirBorder) {
  std::mt19937 random(2);
  std::size_t triangles = 0, without_area = 0;
  for (int i = 0; i < 8000; ++i) {
    const Corners corners = random_corners(random, 2 + i % 60);
    const SweepCheck check = check_sweep(corners);
    if (testing::Test::HasFailure()) {
      FAIL() << "corners " << testing::PrintToString(corners);
    }
    triangles += check.triangles;
    GridSweep sweep;
    sweep.set(corners);
    if (!sweep.plan().is_flat) without_area += check.without_area;
  }
  // The specification saw 14 of 4.5 million.
  EXPECT_LT(double(without_area), 1e-4 * double(triangles));
}

TEST(GridSweep, CoversTrianglesWithoutAreaToo) {
  for (const Corners& corners :
       std::vector<Corners>{{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}},  // one voxel
                            {{{0, 0, 0}, {0, 0, 0}, {5, 2, 0}}},  // two corners in one
                            {{{5, 2, 1}, {0, 0, 0}, {0, 0, 0}}},
                            {{{0, 0, 0}, {6, 3, 0}, {2, 1, 0}}},  // a line
                            {{{0, 0, 0}, {-4, 8, 4}, {-2, 4, 2}}},
                            {{{3, 3, 3}, {4, 3, 3}, {5, 3, 3}}}}) {
    GridSweep sweep;
    sweep.set(corners);
    EXPECT_TRUE(sweep.plan().is_flat);
    EXPECT_EQ(sweep.n_inside(), 0u);
    check_sweep(corners);
  }
}

TEST(GridSweep, MakesTwoTrianglesForAVoxel) {
  // Shares of the specification for these extents, and what other random triangles may differ by.
  const std::pair<int, double> expected[] = {{3, 2.43}, {6, 2.19}, {12, 2.07}, {40, 2.01}, {100, 2.00}};
  std::mt19937 random(3);
  for (const auto& [extent, share] : expected) {
    double triangles = 0, area = 0;
    for (int i = 0; i < 3000; ++i) {
      GridSweep sweep;
      sweep.set(random_corners(random, extent));
      if (sweep.plan().is_flat) continue;
      triangles += static_cast<double>(sweep.n_triangles());
      area +=
          0.5 *
          std::abs((sweep.node(1).sweep - sweep.node(0).sweep) * (sweep.node(2).side - sweep.node(0).side) -
                   (sweep.node(2).sweep - sweep.node(0).sweep) * (sweep.node(1).side - sweep.node(0).side));
    }
    EXPECT_NEAR(triangles / area, share, 0.03) << "extent " << extent;
  }
}

TEST(GridSweep, StepsAlongEdgesByOneVoxelInTheMainDirectionAndNoMoreInOthers) {
  std::mt19937 random(4);
  for (int i = 0; i < 2000; ++i) {
    const Corners corners = random_corners(random, 50);
    GridSweep sweep;
    sweep.set(corners);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      const MainDirection main = main_direction(corners[k], corners[next]);
      ASSERT_EQ(sweep.n_on_edge(k) + 1, static_cast<std::size_t>(std::max(main.length, 1)));
      GridSweep::Node before = sweep.node(k);
      for (std::size_t j = 0; j < sweep.n_on_edge(k); ++j) {
        const GridSweep::Node at = sweep.node(sweep.first_on_edge(k) + j);
        const double sweep_step = std::abs(at.sweep - before.sweep),
                     side_step = std::abs(at.side - before.side);
        // Whole numbers are divided once; differences of numbers up to 50 are off by some 1e-14.
        if (main.axis == sweep.plan().sweep) {
          ASSERT_NEAR(sweep_step, 1, 1e-13);
        }
        if (main.axis == sweep.plan().side) {
          ASSERT_NEAR(side_step, 1, 1e-13);
        }
        ASSERT_LE(std::max(sweep_step, side_step), 1 + 1e-13);
        before = at;
      }
    }
  }
}

TEST(GridSweep, PlacesEdgesAlikeFromBothSides) {
  std::mt19937 random(5);
  for (int i = 0; i < 500; ++i) {
    const Corners p = random_corners(random, 40);
    GridSweep sweep, other;
    sweep.set(p);
    other.set({p[1], p[0], p[2]});
    ASSERT_EQ(sweep.n_on_edge(0), other.n_on_edge(0));
    if (sweep.plan().upwards != other.plan().upwards) continue;  // the same plane, seen from its back
    for (std::size_t j = 0; j < sweep.n_on_edge(0); ++j) {
      const GridSweep::Node a = sweep.node(sweep.first_on_edge(0) + j);
      const GridSweep::Node b = other.node(other.first_on_edge(0) + sweep.n_on_edge(0) - 1 - j);
      ASSERT_EQ(a.sweep, b.sweep);
      ASSERT_EQ(a.side, b.side);
    }
  }
}

TEST(GridSweep, WeightsGiveBackThePlacesOfCornersAndVertices) {
  std::mt19937 random(6);
  for (int i = 0; i < 500; ++i) {
    GridSweep sweep;
    sweep.set(random_corners(random, 40));
    if (sweep.plan().is_flat) continue;
    const GridSweep::Node a = sweep.node(sweep.plan().a), b = sweep.node(sweep.plan().b),
                          c = sweep.node(sweep.plan().c);
    for (std::size_t v = sweep.n_border(); v < sweep.n_border() + sweep.n_inside(); ++v) {
      const GridSweep::Node at = sweep.node(v);
      const GridSweep::Weights w = sweep.weights(at);
      // Rounding of quotients of areas up to 1600, thin triangles included.
      ASSERT_NEAR(w.a * a.sweep + w.b * b.sweep + w.c * c.sweep, at.sweep, 1e-10);
      ASSERT_NEAR(w.a * a.side + w.b * b.side + w.c * c.side, at.side, 1e-10);
      ASSERT_EQ(at.sweep, rounded(at.sweep)) << "inside lie whole voxels";
      ASSERT_EQ(at.side, rounded(at.side));
    }
  }
}

TEST(GridSweep, ShowsTheTriangleInAPlaneThatStretchesItLittle) {
  // A footprint in the plane of the sweep is stretched on the triangle by the tangent of the angle between
  // the two: sqrt(2) at most in the best of all three planes, sqrt(5) in the better of the two with the
  // sweep's axis.
  std::mt19937 random(7);
  int n = 0, above_sqrt_2 = 0;
  double largest = 0;
  for (int i = 0; i < 50'000; ++i) {
    const Corners p = random_corners(random, 100);
    const SweepPlan plan = plan_sweep(p);
    if (plan.is_flat) continue;
    const double in_plane = std::abs(static_cast<double>(twice_area(p, plan.sweep, plan.side)));
    const double whole =
        std::hypot(static_cast<double>(twice_area(p, 0, 1)), static_cast<double>(twice_area(p, 1, 2)),
                   static_cast<double>(twice_area(p, 2, 0)));
    const double tangent = std::sqrt(std::max(0.0, whole * whole - in_plane * in_plane)) / in_plane;
    largest = std::max(largest, tangent);
    above_sqrt_2 += tangent > std::sqrt(2.0) ? 1 : 0;
    ++n;
  }
  EXPECT_LE(largest, std::sqrt(5.0) + 1e-12);
  EXPECT_NEAR(double(above_sqrt_2) / n, 0.015, 0.005) << "the specification saw 1.5 %";
}

}  // namespace
}  // namespace recede::detail
