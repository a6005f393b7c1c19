#include "cancelling.h"
#include "control_meshes.h"
#include "shell_shapes.h"
#include <recede/geometry/error.h>
#include <recede/shells/subdivided_shell.h>

#include <gtest/gtest.h>

#include <cmath>

namespace recede {
namespace {

using test::charted_cube;
using test::control_cube;
using test::control_icosahedron;

SubdividedShellOptions options_of(int level, int interpolated, double thickness,
                                  ShellSide side = ShellSide::exterior) {
  SubdividedShellOptions options;
  options.subdivision.level = level;
  options.interpolated_levels = interpolated;
  options.shell.thickness = thickness;
  options.shell.side = side;
  return options;
}

// Of n x n quads over a square with sides of 4.
PolygonSoup control_grid(int n, const std::function<double(double, double)>& height) {
  PolygonSoup soup;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const double x = 4.0 * i / n - 2, y = 4.0 * j / n - 2;
      soup.positions.emplace_back(x, y, height(x, y));
    }
  }
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto a = static_cast<Index>(j * (n + 1) + i), row = static_cast<Index>(n + 1);
      soup.add_face(std::array<Index, 4>{a, a + 1, a + row + 1, a + row});
    }
  }
  return soup;
}

double largest_difference(const ShellLayer& a, const ShellLayer& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.traced.size(); ++v)
    largest = std::max(largest, (a.traced[v] - b.traced[v]).norm());
  return largest;
}

TEST(SubdividedShell, WithAllDirectorsIsTheShellOfTheSurface) {
  SubdividedShellOptions options = options_of(3, 0, 0.3, ShellSide::envelope);
  options.subdivision.creases = {{0, 1, 2.5}, {1, 3, k_infinite_sharpness}};
  const SubdividedShell built = build_subdivided_shell(charted_cube(), options);
  const PolygonSoup surface = subdivide(charted_cube(), options.subdivision).soup;
  const Shell whole = build_shell(surface, options.shell);
  EXPECT_EQ(built.traced, surface.positions.size());
  EXPECT_EQ(built.shell.base.positions, whole.base.positions);
  EXPECT_EQ(built.shell.base.corner_vertices, whole.base.corner_vertices);
  EXPECT_EQ(built.shell.base.corner_uvs, whole.base.corner_uvs);
  EXPECT_EQ(built.shell.exterior->tops, whole.exterior->tops);
  EXPECT_EQ(built.shell.interior->tops, whole.interior->tops);
}

TEST(SubdividedShell, TracesTheDirectorsOfTheCoarserLevel) {
  const PolygonSoup quad = control_grid(1, [](double x, double y) { return 0.1 * x * y; });
  std::size_t evaluations = 0;
  for (const auto& [interpolated, n] :
       {std::pair(3, 4u), std::pair(2, 9u), std::pair(1, 25u), std::pair(0, 81u)}) {
    const SubdividedShell built = build_subdivided_shell(quad, options_of(3, interpolated, 0.5));
    EXPECT_EQ(built.traced, n);
    EXPECT_EQ(built.shell.base.positions.size(), 81u);
    EXPECT_GT(built.shell.exterior->evaluations, evaluations);
    evaluations = built.shell.exterior->evaluations;
  }
}

TEST(SubdividedShell, KeepsTracedDirectorsAndPutsOthersBetween) {
  const SubdividedShell few = build_subdivided_shell(control_cube(), options_of(3, 2, 0.3));
  const SubdividedShell all = build_subdivided_shell(control_cube(), options_of(3, 0, 0.3));
  const LevelInterpolation& between = few.interpolation;
  const ShellLayer& layer = *few.shell.exterior;
  std::size_t n_traced = 0;
  for (std::size_t v = 0; v < layer.traced.size(); ++v) {
    if (between.is_coarse(v)) {
      // Followed beside other paths, with the same bits.
      EXPECT_EQ(layer.traced[v], all.shell.exterior->traced[v]);
      ++n_traced;
      continue;
    }
    Vec3 mean = few.shell.base.positions[v];
    for (std::size_t i = between.starts[v]; i < between.starts[v + 1]; ++i) {
      const Index other = between.points[i];
      mean += between.weights[i] * (layer.traced[other] - few.shell.base.positions[other]);
    }
    EXPECT_LT((layer.traced[v] - mean).norm(), 1e-15 * 4);
  }
  EXPECT_EQ(n_traced, few.traced);
  EXPECT_EQ(few.traced, 26u) << "the points of level 1";
}

TEST(SubdividedShell, IsTheNearerTheSmootherTheSurface) {
  // In thicknesses: less with lower waves, and with fewer levels between.
  double last = 1e9;
  for (const double height : {0.4, 0.2, 0.1, 0.05}) {
    const PolygonSoup control =
        control_grid(8, [&](double x, double y) { return height * std::sin(2 * x) * std::cos(2 * y); });
    const SubdividedShell all = build_subdivided_shell(control, options_of(3, 0, 0.3));
    const auto off = [&](int interpolated) {
      const SubdividedShell few = build_subdivided_shell(control, options_of(3, interpolated, 0.3));
      EXPECT_TRUE(few.shell.is_valid());
      return largest_difference(*few.shell.exterior, *all.shell.exterior) / 0.3;
    };
    const double by_two = off(2), by_one = off(1);
    EXPECT_LT(by_one, by_two);
    EXPECT_LT(by_two, last);
    EXPECT_GT(by_one, 0);
    last = by_two;
  }
  // Bilinear: a quarter of the square of a face's side, 1/4, times the curvature of the directors, 4 * 0.05
  // and once more for what is compressed, over 8.
  EXPECT_LT(last, 0.01);
}

TEST(SubdividedShell, TakesThicknessesOfTheSurfacesVertices) {
  SubdividedShellOptions options = options_of(2, 1, 0);
  const PolygonSoup flat = control_grid(2, [](double, double) { return 0; });
  for (const Vec3& position : subdivide(flat, options.subdivision).soup.positions)
    options.shell.thicknesses.push_back(0.2 + 0.05 * position.x());
  const SubdividedShell built = build_subdivided_shell(flat, options);
  for (std::size_t v = 0; v < built.shell.thicknesses.size(); ++v) {
    const double reached = (built.shell.exterior->tops[v] - built.shell.base.positions[v]).norm();
    // The field is made for the largest of them, and bends a little at borders.
    EXPECT_NEAR(reached / options.shell.thicknesses[v], 1, 0.01);
  }
}

TEST(SubdividedShell, OfACubeWithCreasesIsValid) {
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    for (const double sharpness : {2.0, double{k_infinite_sharpness}}) {
      SubdividedShellOptions options = options_of(3, 1, 0.4, side);
      options.subdivision.crease_angle = 1.0;
      options.subdivision.crease_sharpness = sharpness;
      const SubdividedShell built = build_subdivided_shell(control_cube(), options);
      const ShellLayer& layer = side == ShellSide::exterior ? *built.shell.exterior : *built.shell.interior;
      EXPECT_TRUE(built.shell.is_valid());
      ShellCheckOptions check;
      check.is_inward = side == ShellSide::interior;
      EXPECT_TRUE(check_shell(built.shell.base.positions, layer.tops, built.shell.base.corner_vertices, check)
                      .is_valid());
    }
  }
}

TEST(SubdividedShell, OfTrianglesIsLinearBetween) {
  SubdividedShellOptions options = options_of(3, 2, 0.3);
  options.subdivision.scheme = SubdivisionScheme::loop;
  options.shell.at_least_normals = false;
  const SubdividedShell built = build_subdivided_shell(control_icosahedron(), options);
  EXPECT_TRUE(built.shell.is_valid());
  EXPECT_EQ(built.traced, 42u) << "12 vertices and 30 edges";
  EXPECT_EQ(built.shell.base.n_faces(), 20u * 64);
  // Directors at corners of a triangle are 32 to 36 degrees apart, and 21 from its middle: its cosine.
  const ShellThickness reached = reached_thickness(built.shell, *built.shell.exterior);
  EXPECT_GT(reached.least, 0.93);
  EXPECT_LT(reached.mean, 0.97);
  EXPECT_NEAR(reached.most, 1, 1e-12) << "at corners";
}

// Deformations of control points: against all directors traced anew, over the same triangles.
class MovedControlPoints : public testing::TestWithParam<int> {};

TEST_P(MovedControlPoints, ChangeDirectorsWithinReachOnly) {
  const PolygonSoup before = control_grid(12, [](double x, double) { return 0.2 * std::sin(x); });
  SubdividedShellOptions options = options_of(2, GetParam(), 0.15, ShellSide::envelope);
  // The tree of the field is another one: parts would be summed up in other groups, some thousandths of a
  // thickness.
  options.shell.field.error = 1e-7;
  SubdividedShell updated = build_subdivided_shell(before, options);
  const SubdividedShell old = updated;
  PolygonSoup after = before;
  for (const Index v : {Index{6 * 13 + 6}, Index{6 * 13 + 7}})
    after.positions[static_cast<std::size_t>(v)] += Vec3(0.1, 0, 0.3);
  update_subdivided_shell(updated, after, options);

  EXPECT_EQ(updated.shell.base.corner_vertices, old.shell.base.corner_vertices);
  EXPECT_LT(updated.traced, old.traced * 2 / 3);
  EXPECT_GT(updated.traced, 0u);
  EXPECT_EQ(updated.control.positions, after.positions);
  EXPECT_EQ(updated.shell.base.positions, subdivide(after, options.subdivision).soup.positions);
  EXPECT_TRUE(updated.shell.is_valid());
  // Moved away and back, everything is traced anew.
  PolygonSoup away = after;
  for (Vec3& position : away.positions) position += Vec3(0, 0, 1);
  SubdividedShell anew = updated;
  update_subdivided_shell(anew, away, options);
  update_subdivided_shell(anew, after, options);
  EXPECT_EQ(anew.traced, old.traced);
  std::size_t n_same = 0;
  for (std::size_t v = 0; v < after.positions.size(); ++v) {
    for (const auto of : {&Shell::exterior, &Shell::interior}) {
      const Vec3& top = (updated.shell.*of)->tops[v];
      EXPECT_LT((top - (anew.shell.*of)->tops[v]).norm(), 1e-6 * 0.15);
      if (top == (old.shell.*of)->tops[v]) ++n_same;
    }
  }
  EXPECT_GT(n_same, 0u);
  if (GetParam() > 0) return;
  const Shell whole = build_shell(updated.shell.base, options.shell);
  EXPECT_EQ(whole.exterior->tops, anew.shell.exterior->tops);
}

INSTANTIATE_TEST_SUITE_P(Levels, MovedControlPoints, testing::Values(0, 1, 2));

TEST(SubdividedShell, ThatDoesntMoveStaysAsItIs) {
  const SubdividedShellOptions options = options_of(2, 1, 0.3);
  SubdividedShell shell = build_subdivided_shell(control_cube(), options);
  const std::vector<Vec3> tops = shell.shell.exterior->tops;
  update_subdivided_shell(shell, control_cube(), options);
  EXPECT_EQ(shell.traced, 0u);
  EXPECT_EQ(shell.shell.exterior->tops, tops);
}

TEST(SubdividedShell, IsWhatItWasWhereItsUpdateIsCancelled) {
  const SubdividedShellOptions options = options_of(2, 1, 0.3);
  SubdividedShell shell = build_subdivided_shell(control_cube(), options);
  const SubdividedShell before = shell;
  PolygonSoup control = control_cube();
  control.positions[0] *= 1.2;
  test::Cancelling cancelling("averaged distance");  // where directors begin
  EXPECT_THROW(update_subdivided_shell(shell, control, options, &cancelling), Cancelled);
  EXPECT_EQ(shell.control.positions, before.control.positions);
  EXPECT_EQ(shell.shell.base.positions, before.shell.base.positions);
  EXPECT_EQ(shell.shell.exterior->tops, before.shell.exterior->tops);
  EXPECT_EQ(shell.traced, before.traced);
  update_subdivided_shell(shell, control, options);
  EXPECT_GT(shell.traced, 0u) << "it sees what has changed";
}

TEST(SubdividedShell, RefusesWhatHasNoMeaning) {
  EXPECT_THROW(build_subdivided_shell(control_cube(), options_of(2, 3, 0.1)), OptionError);
  EXPECT_THROW(build_subdivided_shell(control_cube(), options_of(2, -1, 0.1)), OptionError);
  EXPECT_THROW(build_subdivided_shell(control_cube(), options_of(2, 1, -0.1)), OptionError);
  EXPECT_THROW(build_subdivided_shell({}, options_of(2, 1, 0.1)), InputError);
  SubdividedShell shell = build_subdivided_shell(control_cube(), options_of(2, 1, 0.1));
  EXPECT_THROW(update_subdivided_shell(shell, control_icosahedron(), options_of(2, 1, 0.1)), InputError);
  EXPECT_THROW(update_subdivided_shell(shell, control_cube(), options_of(2, 1, 0.1, ShellSide::interior)),
               OptionError);
}

}  // namespace
}  // namespace recede
