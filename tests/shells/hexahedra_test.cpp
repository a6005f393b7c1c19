#include "uv_sheet.h"
#include <recede/shells/detail/hexahedra.h>
#include <recede/shells/detail/shell_cell.h>
#include <recede/shells/layer_grid.h>

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace {

using namespace recede;
using detail::Hexahedron;
using detail::surely_has_one_orientation;
using testing::ElementsAre;
using testing::IsEmpty;

TEST(Hexahedra, CornersOfAQuadGoAroundItWhicheverDiagonalCutsIt) {
  // Corners 0 to 3 around: cut from 0 to 2, and from 1 to 3.
  const std::vector<Index> first{0, 1, 2, 0, 2, 3}, second{1, 2, 3, 3, 0, 1};
  for (const std::vector<Index>& triangles : {first, second}) {
    EXPECT_TRUE(detail::is_quad(triangles, 0));
    const std::array<Index, 4> corners = detail::quad_corners(triangles, 0);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_EQ(triangles[corners[(k + 1) % 4]], (triangles[corners[k]] + 1) % 4);
  }
  EXPECT_FALSE(detail::is_quad(std::vector<Index>{0, 1, 2, 2, 0, 3}, 0));  // both run the same way
  EXPECT_FALSE(detail::is_quad(std::vector<Index>{0, 1, 2, 2, 3, 4}, 0));  // a vertex in common
  EXPECT_FALSE(detail::is_quad(std::vector<Index>{0, 1, 2, 0, 2, 1}, 0));  // and all three
}

Hexahedron cube() {
  return {{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(0, 1, 0)},
          {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 1, 1), Vec3(0, 1, 1)}};
}

double jacobian_at(const Hexahedron& h, double u, double v, double r) {
  const detail::FaceWeights weights = detail::weights_at(4, {u, v});
  const auto [along_u, along_v] = detail::weight_steps_at(4, {u, v});
  Eigen::Matrix3d columns = Eigen::Matrix3d::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3 at = (1 - r) * h.bottom[k] + r * h.top[k];
    columns.col(0) += along_u[k] * at;
    columns.col(1) += along_v[k] * at;
    columns.col(2) += weights[k] * (h.top[k] - h.bottom[k]);
  }
  return columns.determinant();
}

double least_jacobian(const Hexahedron& h) {
  constexpr int k_steps = 12;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= k_steps; ++i)
    for (int j = 0; j <= k_steps; ++j)
      for (int k = 0; k <= k_steps; ++k)
        least = std::min(least, jacobian_at(h, 1.0 * i / k_steps, 1.0 * j / k_steps, 1.0 * k / k_steps));
  return least;
}

TEST(Hexahedra, HaveOneOrientationWhereTheTopLies) {
  EXPECT_TRUE(surely_has_one_orientation(cube(), false));
  EXPECT_FALSE(surely_has_one_orientation(cube(), true));
  Hexahedron below = cube();
  for (Vec3& p : below.top) p.z() = -1;
  EXPECT_FALSE(surely_has_one_orientation(below, false));
  EXPECT_TRUE(surely_has_one_orientation(below, true));
  Hexahedron flat = cube();
  flat.top = flat.bottom;
  EXPECT_FALSE(surely_has_one_orientation(flat, false));
  // An arrow's head: beyond the inner corner the map folds.
  Hexahedron arrow = cube();
  for (std::array<Vec3, 4>* face : {&arrow.bottom, &arrow.top}) (*face)[2].head<2>() = Vec2(0.25, 0.25);
  EXPECT_FALSE(surely_has_one_orientation(arrow, false));
  // Turned by an angle: the Jacobian in the middle is that of a square of side cos(angle / 2), above 0.
  for (const double degrees : {10.0, 60.0, 100.0, 170.0}) {
    Hexahedron turned = cube();
    const Eigen::AngleAxisd turn(degrees * M_PI / 180, Vec3::UnitZ());
    for (Vec3& p : turned.top) p = Vec3(0.5, 0.5, 0) + turn * (p - Vec3(0.5, 0.5, 0));
    EXPECT_EQ(surely_has_one_orientation(turned, false), degrees < 90) << degrees;
    EXPECT_GT(least_jacobian(turned), 0) << degrees;
  }
}

// What it says is true, and of what clearly keeps its orientation it says so mostly; in any place and size.
TEST(Hexahedra, ThatSurelyHaveOneOrientationHaveIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-1, 1);
  int said = 0, clear = 0, clear_and_said = 0, others = 0;
  for (int n = 0; n < 3000; ++n) {
    Hexahedron h = cube();
    const double most = 0.1 + 0.5 * (n % 10) / 10;
    for (std::array<Vec3, 4>* face : {&h.bottom, &h.top})
      for (Vec3& p : *face) p += most * Vec3(off(random), off(random), off(random));
    const double least = least_jacobian(h);
    const double scale = std::pow(10.0, n % 19 - 9);
    Hexahedron elsewhere = h;
    for (std::array<Vec3, 4>* face : {&elsewhere.bottom, &elsewhere.top})
      for (Vec3& p : *face) p = scale * (p + Vec3(1e3, -2e3, 5e2));
    const bool is_sure = surely_has_one_orientation(elsewhere, false);
    if (is_sure) {
      EXPECT_GT(least, 0);
    }
    said += is_sure;
    clear += least > 0.2;
    clear_and_said += least > 0.2 && is_sure;
    others += least < 0;
  }
  EXPECT_GT(said, 500);
  EXPECT_GT(others, 300);
  EXPECT_GT(clear_and_said, clear * 9 / 10);
}

TEST(Hexahedra, AreTheCellsOverQuads) {
  const PolygonSoup quads = test::uv_sheet(3);
  const Shell shell = build_shell(quads, {.thickness = 0.2, .side = ShellSide::envelope});
  EXPECT_THAT(shell.quads, ElementsAre(0, 2, 4, 6, 8, 10, 12, 14, 16));
  EXPECT_EQ(shell.exterior->hexahedra, shell.quads);
  EXPECT_EQ(shell.interior->hexahedra, shell.quads);

  const Shell of_triangles = build_shell(shell.base, {.thickness = 0.2});
  EXPECT_THAT(of_triangles.quads, IsEmpty());
  EXPECT_THAT(of_triangles.exterior->hexahedra, IsEmpty());

  // Triangles, a quad and a pentagon.
  PolygonSoup mixed;
  for (int k = 0; k < 5; ++k)
    mixed.positions.emplace_back(std::cos(0.4 * M_PI * k), std::sin(0.4 * M_PI * k), 0);
  mixed.positions.emplace_back(2, 0.2, 0);
  mixed.positions.emplace_back(2, -1, 0);
  mixed.add_face(std::array<Index, 5>{0, 1, 2, 3, 4});
  mixed.add_face(std::array<Index, 4>{0, 4, 6, 5});
  mixed.add_face(std::array<Index, 3>{0, 5, 1});
  EXPECT_THAT(build_shell(mixed, {.thickness = 0.1}).exterior->hexahedra, ElementsAre(3));
}

// A small triangle between the two diagonals of a bent quad, below that which cuts it: it doesn't meet the
// quad's prisms, but the bilinear patch runs through there.
TEST(Hexahedra, AreNoneWhereTheirFacesMayMeetOthers) {
  PolygonSoup bent;
  bent.positions = {{0.2, 0.2, 0.1}, {2, 0, 0}, {1.8, 1.8, 0.1}, {0, 2, 0}};
  bent.add_face(std::array<Index, 4>{0, 1, 2, 3});
  ShellOptions options{.thicknesses = {0.3, 0.3, 0.3, 0.3}, .method = DirectorMethod::normals};
  EXPECT_THAT(build_shell(bent, options).exterior->hexahedra, ElementsAre(0));
  for (const Vec3& p : {Vec3(0.95, 0.95, 0.05), Vec3(1.05, 0.95, 0.05), Vec3(1, 1.05, 0.05)})
    bent.positions.push_back(p);
  bent.add_face(std::array<Index, 3>{4, 5, 6});
  options.thicknesses.resize(7, 0.001);
  const Shell shell = build_shell(bent, options);
  EXPECT_TRUE(shell.is_valid());
  EXPECT_EQ(shell.exterior->shortened, 0u);
  EXPECT_THAT(shell.exterior->hexahedra, IsEmpty());
}

// Layers of hexahedra over bumps, cut finely along their trilinear maps, are valid by the exact check.
TEST(Hexahedra, MakeAValidLayer) {
  constexpr int k_quads = 5, k_cuts = 5, k_row = k_quads * k_cuts + 1;
  std::mt19937 random(8);
  std::uniform_real_distribution<double> off(-1, 1);
  int whole = 0, others = 0;
  for (int n = 0; n < 60; ++n) {
    PolygonSoup base = test::uv_sheet(k_quads);
    const double height = 0.06 * (1 + n % 6);
    for (Vec3& p : base.positions) p += Vec3(0.05 * off(random), 0.05 * off(random), height * off(random));
    const Shell shell = build_shell(base, {.thickness = 0.3});
    const ShellLayer& layer = *shell.exterior;
    ASSERT_TRUE(layer.validity.is_valid());
    if (layer.hexahedra.size() != shell.quads.size()) {
      ++others;
      continue;
    }
    ++whole;
    std::vector<Vec3> bottom, top;
    for (int y = 0; y < k_row; ++y) {
      for (int x = 0; x < k_row; ++x) {
        const int i = std::min(x / k_cuts, k_quads - 1), j = std::min(y / k_cuts, k_quads - 1);
        const detail::FaceWeights weights =
            detail::weights_at(4, {1.0 * x / k_cuts - i, 1.0 * y / k_cuts - j});
        const std::span<const Index> corners = base.face(static_cast<std::size_t>(j * k_quads + i));
        Vec3 low = Vec3::Zero(), high = Vec3::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
          low += weights[k] * base.positions[corners[k]];
          high += weights[k] * layer.tops[corners[k]];
        }
        bottom.push_back(low);
        top.push_back(high);
      }
    }
    const std::vector<Index> triangles = triangulate(test::uv_sheet(k_quads * k_cuts));
    EXPECT_TRUE(check_shell(bottom, top, triangles).is_valid()) << n;
  }
  EXPECT_GT(whole, 10);
  EXPECT_GT(others, 10);
}

// A quad wider on one side: a texel's column stands where the bilinear map has it, not on the diagonal.
TEST(Hexahedra, HoldTexelsWhereTheyAreBilinear) {
  PolygonSoup base;
  base.positions = {{0, 0, 0}, {4, 0, 0}, {3, 2, 0}, {1, 2, 0}};
  base.add_face(std::array<Index, 4>{0, 1, 2, 3});
  base.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const auto shell = std::make_shared<const Shell>(
      build_shell(base, {.thickness = 1, .method = DirectorMethod::normals, .at_least_normals = false}));
  const LayerGrid grid(shell, ShellSide::exterior, {7, 7, 4});
  double volume = 0;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 7; ++j) {
      for (int i = 0; i < 7; ++i) {
        const double s = (i + 0.5) / 7, t = (j + 0.5) / 7;
        const Vec3 expected((1 - t) * 4 * s + t * (1 + 2 * s), 2 * t, (k + 0.5) / 4);
        // Newton's method ends at 1e-12.
        EXPECT_LT((grid.point(i, j, k) - expected).norm(), 1e-10);
        volume += grid.texel_volume(i, j, k);
      }
    }
  }
  // The Jacobian is linear in t: sums over middles are exact.
  EXPECT_NEAR(volume, 6, 1e-9);
}

}  // namespace
