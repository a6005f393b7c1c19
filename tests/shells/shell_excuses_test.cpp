// Layers over surfaces that have a valid one in parts only.
#include "excused_shells.h"
#include "simple_soups.h"
#include "whole_shells.h"
#include <recede/geometry/mesh_io.h>
#include <recede/shells/detail/director_cuts.h>
#include <recede/shells/detail/front_direction.h>

#include <tbb/global_control.h>

#include <filesystem>
#include <numbers>
#include <random>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

void add(PolygonSoup& to, const PolygonSoup& part) {
  const auto first = static_cast<Index>(to.positions.size());
  to.positions.insert(to.positions.end(), part.positions.begin(), part.positions.end());
  for (std::size_t f = 0; f < part.n_faces(); ++f) {
    const std::span<const Index> corners = part.face(f);
    to.add_face(std::array<Index, 3>{first + corners[0], first + corners[1], first + corners[2]});
  }
}

// Of twelve triangles that face outwards.
PolygonSoup box(const Vec3& lower, const Vec3& upper) {
  PolygonSoup soup;
  for (int i = 0; i < 8; ++i)
    soup.positions.emplace_back((i & 1 ? upper : lower).x(), (i & 2 ? upper : lower).y(),
                                (i & 4 ? upper : lower).z());
  for (const auto& q : {std::array<Index, 4>{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    soup.add_face(std::array<Index, 3>{q[0], q[1], q[2]});
    soup.add_face(std::array<Index, 3>{q[0], q[2], q[3]});
  }
  return soup;
}

// A sheet with grooves 128 deep and 128 wide, too narrow for layers of 120; whole coordinates.
PolygonSoup grooves() {
  PolygonSoup soup = test::grid(12, true);
  for (Vec3& p : soup.positions)
    p = Vec3(256 * p.x(), 256 * p.y(), std::round(64 * std::cos(4 * k_pi * p.x())));
  return soup;
}

// Along the normals, which run through each other in grooves.
ShellOptions options_for(double thickness, ShellSide side = ShellSide::exterior) {
  ShellOptions options;
  options.method = DirectorMethod::normals;
  options.thickness = thickness;
  options.side = side;
  return options;
}

const ShellLayer& layer_of(const Shell& shell) { return shell.exterior ? *shell.exterior : *shell.interior; }

// Of triangles with whole coordinates.
std::vector<Index> triangles_that_meet_others(const PolygonSoup& soup) {
  std::vector<Index> found;
  for (std::size_t a = 0; a < soup.n_faces(); ++a) {
    for (std::size_t b = 0; b < soup.n_faces(); ++b) {
      const std::vector<Index> own(soup.face(a).begin(), soup.face(a).end()),
          other(soup.face(b).begin(), soup.face(b).end());
      if (a == b || !test::meet_apart(soup.positions, own, other)) continue;
      found.push_back(static_cast<Index>(a));
      break;
    }
  }
  return found;
}

TEST(ShellExcuses, BoxesThatRunThroughEachOtherLeaveTheGrooveBesideThemValid) {
  PolygonSoup soup = grooves();
  const std::size_t n_grooves = soup.n_faces();
  add(soup, box(Vec3(400, 0, 0), Vec3(500, 100, 100)));
  add(soup, box(Vec3(470, 60, 50), Vec3(600, 170, 180)));
  const std::vector<Index> that_meet_others = triangles_that_meet_others(soup);
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    const Shell shell = build_shell(soup, options_for(120, side));
    const ShellLayer& layer = layer_of(shell);
    EXPECT_FALSE(shell.is_valid());
    EXPECT_EQ(layer.excused, that_meet_others);
    EXPECT_TRUE(layer.given_up.empty());
    ASSERT_FALSE(layer.excused.empty());
    EXPECT_GE(layer.excused.front(), n_grooves);
    EXPECT_GT(layer.inverted_before + layer.contacts_before, 0u);
    EXPECT_GT(layer.shortened, 0u);
    test::expect_valid_elsewhere(shell, layer, side == ShellSide::interior);
    // Without repair it says the same about the surface, and that the rest isn't valid.
    ShellOptions as_traced = options_for(120, side);
    as_traced.repair = false;
    const Shell before = build_shell(soup, as_traced);
    EXPECT_EQ(layer_of(before).excused, layer.excused);
    EXPECT_FALSE(layer_of(before).is_valid_elsewhere);
    EXPECT_EQ(layer_of(before).shortened, 0u);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Shell again = build_shell(soup, options_for(120, side));
    EXPECT_EQ(layer_of(again).tops, layer.tops);
    EXPECT_EQ(layer_of(again).excused, layer.excused);
    EXPECT_EQ(layer_of(again).validity, layer.validity);
  }
}

TEST(ShellExcuses, OfASoundSurfaceThereAreNone) {
  const Shell shell = build_shell(grooves(), options_for(120));
  EXPECT_TRUE(shell.is_valid());
  EXPECT_TRUE(shell.exterior->excused.empty());
  EXPECT_TRUE(shell.exterior->is_valid_elsewhere);
}

// Over a curve around a band on the sphere that is three quarters of a ring wide. The upper side's normals
// point up and inwards, the lower side's down and inwards: every direction lies behind some of them.
TEST(ShellExcuses, AVertexWithNoDirectionInFrontOfItsFacesLeavesTheRestValid) {
  PolygonSoup soup;
  soup.positions.push_back(Vec3::Zero());
  std::vector<Vec3> rays;
  constexpr int k_steps = 6;
  for (const double elevation : {20 * k_pi / 180, -20 * k_pi / 180}) {
    for (int i = 0; i <= k_steps; ++i) {
      const double azimuth = 1.5 * k_pi * (elevation > 0 ? i : k_steps - i) / k_steps;
      rays.emplace_back(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                        std::sin(elevation));
    }
  }
  const auto n = static_cast<Index>(rays.size());
  for (const double radius : {1.0, 2.0}) {
    for (const Vec3& ray : rays) soup.positions.push_back(radius * ray);
  }
  const auto at = [&](Index ring, Index i) { return 1 + ring * n + i % n; };
  for (Index i = 0; i < n; ++i) soup.add_face(std::array<Index, 3>{0, at(0, i), at(0, i + 1)});
  for (Index i = 0; i < n; ++i) {
    soup.add_face(std::array<Index, 3>{at(0, i), at(1, i), at(1, i + 1)});
    soup.add_face(std::array<Index, 3>{at(0, i), at(1, i + 1), at(0, i + 1)});
  }
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    const Shell shell = build_shell(soup, options_for(0.2, side));
    const ShellLayer& layer = layer_of(shell);
    EXPECT_TRUE(layer.validity.has_valid_base());
    std::vector<Index> around;
    for (Index i = 0; i < n; ++i) around.push_back(i);
    EXPECT_EQ(layer.excused, around);
    test::expect_valid_elsewhere(shell, layer, side == ShellSide::interior);
  }
}

TEST(ShellExcuses, TrianglesWithoutAreaLeaveTheRestValid) {
  // A cap on the border of a sheet: its third corner is the middle of a side.
  PolygonSoup soup = test::grid(8, true);
  const Index a = soup.face(0)[0], b = soup.face(0)[1];
  soup.positions.push_back((soup.positions[a] + soup.positions[b]) / 2);
  soup.add_face(std::array<Index, 3>{b, a, static_cast<Index>(soup.positions.size() - 1)});
  const Shell shell = build_shell(soup, options_for(0.1));
  const ShellLayer& layer = *shell.exterior;
  EXPECT_TRUE(
      std::binary_search(layer.excused.begin(), layer.excused.end(), static_cast<Index>(soup.n_faces() - 1)));
  EXPECT_LT(layer.excused.size(), 10u) << "only what is around it";
  test::expect_valid_elsewhere(shell, layer, false);
}

TEST(ShellExcuses, ARealModelThatMeetsItselfIsValidElsewhere) {
  const std::filesystem::path file = std::filesystem::path(RECEDE_DATA) / "meshes" / "cow.off";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "run ./dev data";
  PolygonSoup cow = read_soup(file);
  merge_identical_vertices(cow);
  const double size = bounding_box(cow).sizes().maxCoeff();
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    ShellOptions options = options_for(0.03 * size, side);
    options.method = DirectorMethod::averaged_distance;
    const Shell shell = build_shell(cow, options);
    const ShellLayer& layer = layer_of(shell);
    EXPECT_FALSE(layer.validity.has_valid_base());
    // Where the horns and ears are stuck into the head, and what is folded there.
    EXPECT_GT(layer.excused.size(), 0u);
    EXPECT_LT(layer.excused.size(), cow.n_faces() / 20);
    test::expect_valid_elsewhere(shell, layer, side == ShellSide::interior);
    // Half is what the interior of a thin-legged model has; nothing is thrown away.
    EXPECT_GT(reached_thickness(shell, layer).mean, 0.5);
  }
}

TEST(DirectorCuts, AreWhereAnotherPartOfTheSurfaceStands) {
  // Two squares, one above the other; of one vertex' director the end lies before it, of one beside it.
  PolygonSoup soup = test::grid(1, true);
  add(soup, test::grid(1, true));
  for (std::size_t v = 4; v < 8; ++v) soup.positions[v] += Vec3(-0.5, -0.5, 0.25);
  const detail::ShellSurface surface = detail::shell_surface_of(soup.positions, soup.corner_vertices);
  std::vector<Vec3> ends = soup.positions;
  for (std::size_t v = 0; v < 4; ++v) ends[v] += Vec3(0, 0, 1);
  // Vertices 0 to 3 lie at (0, 0), (0, 1), (1, 0) and (1, 1): only the first is below the other square.
  EXPECT_EQ(detail::shares_before_surface(surface, ends), (std::vector<double>{0.25, 1, 1, 1, 1, 1, 1, 1}));
  ends[0].z() = 0.2;
  EXPECT_EQ(detail::shares_before_surface(surface, ends), std::vector<double>(8, 1));
}

TEST(FrontDirection, IsFoundWhereItIsNarrow) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(0, 1);
  for (int round = 0; round < 200; ++round) {
    // Normals almost across an axis, at angles that go all the way around it.
    const Vec3 axis = Vec3(share(random) - 0.5, share(random) - 0.5, share(random) - 0.5).normalized();
    const Vec3 side = axis.unitOrthogonal(), other = axis.cross(side);
    std::vector<Vec3> normals;
    Vec3 mean = Vec3::Zero();
    constexpr double k_least = 1e-3;
    for (int i = 0; i < 7; ++i) {
      const double angle = 2 * k_pi * (i + share(random)) / 7, cosine = k_least * (1 + share(random));
      const Vec3 across = std::cos(angle) * side + std::sin(angle) * other;
      normals.push_back((cosine * axis + std::sqrt(1 - cosine * cosine) * across).normalized());
      mean += share(random) * normals.back();
    }
    const Vec3 found = detail::axis_of_normals(normals, mean.normalized());
    EXPECT_NEAR(found.norm(), 1, 1e-12);
    // The axis has this cosine or more, so the best one has; 1e-9 for rounding.
    EXPECT_GT(detail::least_cosine(normals, found), k_least - 1e-9);
  }
  // Of these none is in front.
  const std::vector<Vec3> around = {Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY()};
  EXPECT_LE(detail::least_cosine(around, detail::axis_of_normals(around, Vec3::UnitY())), 0);
}

}  // namespace
}  // namespace recede
