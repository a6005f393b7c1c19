#include "cancelling.h"
#include "shell_shapes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/shells/shell.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

using test::ball;
using test::cube;
using test::saddle;
using test::sheet;
using test::torus;

// Two rectangles that meet in the y axis, each turned upwards by half of an angle.
PolygonSoup fold(double turning) {
  return sheet(28, 28, [&](double u, double v) {
    const double along = 2 * std::abs(2 * u - 1), side = u < 0.5 ? -1 : 1;
    return Vec3(side * along * std::cos(turning / 2), 4 * v - 2, along * std::sin(turning / 2));
  });
}

// The same, turned around a cylinder.
PolygonSoup round_fold(double turning, double radius) {
  return sheet(144, 16, [&](double u, double v) {
    const double s = 3 * u - 1.5, half = radius * turning / 2, on_arc = std::clamp(s, -half, half),
                 angle = on_arc / radius, straight = s - on_arc;
    return Vec3(radius * std::sin(angle) + straight * std::cos(angle), 3 * v - 1.5,
                radius * (1 - std::cos(angle)) + straight * std::sin(angle));
  });
}

ShellOptions unrepaired(double thickness, ShellSide side = ShellSide::exterior,
                        DirectorMethod method = DirectorMethod::averaged_distance) {
  ShellOptions options;
  options.thickness = thickness;
  options.side = side;
  options.method = method;
  options.repair = false;
  return options;
}

ShellOptions repaired(double thickness, ShellSide side = ShellSide::exterior,
                      DirectorMethod method = DirectorMethod::averaged_distance) {
  ShellOptions options = unrepaired(thickness, side, method);
  options.repair = true;
  return options;
}

const ShellLayer& layer_of(const Shell& shell) { return shell.exterior ? *shell.exterior : *shell.interior; }

ShellThickness thickness_of(const Shell& shell) { return reached_thickness(shell, layer_of(shell)); }

std::size_t n_inverted(const PolygonSoup& surface, const ShellOptions& options) {
  return layer_of(build_shell(surface, options)).validity.inverted.size();
}

TEST(Shell, OverAConvexBodyIsAsThickAsAskedFor) {
  for (const PolygonSoup& body : {ball(8), cube(8)}) {
    const Shell shell = build_shell(body, unrepaired(0.5));
    EXPECT_TRUE(shell.is_valid());
    // The specification's prototype has 0.995 to 1.
    EXPECT_GT(thickness_of(shell).least, 0.995);
    EXPECT_LT(thickness_of(shell).most, 1.001);
  }
}

TEST(Shell, OverFewLargeTrianglesIsAsThickAsAskedFor) {
  const Shell shell = build_shell(cube(1), unrepaired(0.05));
  EXPECT_TRUE(shell.is_valid());
  EXPECT_GT(thickness_of(shell).least, 0.99);
  // All vertices are corners; there the field's speed is 0.33, and the first step goes along the normal.
  const Shell inside = build_shell(cube(1), unrepaired(0.05, ShellSide::interior));
  EXPECT_TRUE(inside.is_valid());
  EXPECT_NEAR(thickness_of(inside).mean, 4 / (7 * std::sqrt(3.0)), 0.03);
}

TEST(Shell, InsideABallStopsBeforeTheCenter) {
  const Shell shell = build_shell(ball(8), unrepaired(1.5, ShellSide::interior));
  EXPECT_TRUE(shell.is_valid());
  // 0.534 of 1.5 in the prototype, whose Euler steps are off by what they are long; with ever shorter ones it
  // becomes 0.518. None goes past the centre.
  EXPECT_NEAR(thickness_of(shell).mean, 0.518, 0.008);
  for (std::size_t v = 0; v < shell.base.positions.size(); ++v)
    EXPECT_GT(shell.interior->tops[v].dot(shell.base.positions[v]), 0);
}

// What the specification counts for normals: on the cube and the saddle the same, on others of other
// triangles.
TEST(Shell, AlongNormalsInvertsWhereDirectorsOfTheFieldDont) {
  struct Case {
    PolygonSoup surface;
    double thickness;
    ShellSide side;
    std::size_t of_normals;
  };
  for (const Case& c :
       {Case{cube(8), 0.5, ShellSide::interior, 336}, Case{saddle(), 0.8, ShellSide::exterior, 140},
        Case{torus(1, 0.4, 32), 0.7, ShellSide::exterior, 320}}) {
    EXPECT_EQ(n_inverted(c.surface, unrepaired(c.thickness, c.side, DirectorMethod::normals)), c.of_normals);
    EXPECT_TRUE(build_shell(c.surface, unrepaired(c.thickness, c.side)).is_valid());
  }
}

// Ratios of the specification's table for sharp folds, with the widest opening of the field: 0.02 for steps
// and triangles of other sizes.
TEST(Shell, IsCompressedInAFold) {
  struct Row {
    double degrees, calibrated, averaged;
  };
  for (const Row& row : {Row{0, 1, 1.083}, Row{30, 0.975, 1.015}, Row{60, 0.836, 0.933},
                         Row{90, 0.539, 0.840}, Row{120, 0.321, 0.737}, Row{150, 0.151, 0.611}}) {
    const PolygonSoup surface = fold(row.degrees * k_pi / 180);
    constexpr Index k_middle = 14 * 29 + 14;
    for (const LpForm form : {LpForm::calibrated, LpForm::averaged}) {
      ShellOptions options = unrepaired(0.3);
      options.step = 0.125;
      options.field.form = form;
      const Shell shell = build_shell(surface, options);
      const double reached = (shell.exterior->tops[k_middle] - surface.positions[k_middle]).norm() / 0.3;
      EXPECT_NEAR(reached, form == LpForm::calibrated ? row.calibrated : row.averaged, 0.02)
          << row.degrees << " degrees";
    }
  }
}

// The same table for folds around a cylinder of half the thickness and of all of it. Sides of 0.02 go around
// it in enough steps; the rest is as above.
TEST(Shell, IsCompressedLessInARoundFold) {
  struct Row {
    double degrees, half, whole;
  };
  for (const Row& row :
       {Row{60, 0.951, 0.997}, Row{90, 0.793, 0.976}, Row{120, 0.646, 0.888}, Row{150, 0.555, 0.818}}) {
    for (const double radius : {0.15, 0.3}) {
      const PolygonSoup surface = round_fold(row.degrees * k_pi / 180, radius);
      ShellOptions options = unrepaired(0.3);
      options.step = 0.125;
      const Shell shell = build_shell(surface, options);
      const std::size_t middle = surface.positions.size() / 2;
      const double reached = (shell.exterior->tops[middle] - surface.positions[middle]).norm() / 0.3;
      EXPECT_NEAR(reached, radius < 0.3 ? row.half : row.whole, 0.02)
          << row.degrees << " degrees, " << radius;
    }
  }
}

TEST(Shell, FollowsDirectorsInStepsOfAShareOfTheThickness) {
  const PolygonSoup flat = sheet(4, 4, [](double u, double v) { return Vec3(u, v, 0); });
  for (const auto& [step, n_steps] :
       {std::pair(1.0, 1u), std::pair(0.25, 4u), std::pair(0.1, 10u), std::pair(0.001, 980u)}) {
    // Of the exact distance, as paths in the averaged one are let go where nothing is near.
    ShellOptions options = unrepaired(0.5, ShellSide::exterior, DirectorMethod::exact_distance);
    options.step = step;
    const Shell shell = build_shell(flat, options);
    // One look where the path begins, and one for each step; the first one is taken in halves.
    EXPECT_EQ(shell.exterior->evaluations, flat.positions.size() * (n_steps + 2));
    // All the way, but for rounding of a thousand steps.
    EXPECT_NEAR(thickness_of(shell).least, 1, 1e-12);
    EXPECT_NEAR(thickness_of(shell).most, 1, 1e-12);
  }
}

TEST(Shell, WithTheSmallestStepsGetsAsFar) {
  const PolygonSoup sphere = make_displaced_sphere(1000, true);
  ShellOptions options = unrepaired(1);
  const double least = thickness_of(build_shell(sphere, options)).least;
  EXPECT_GT(least, 0.99);
  options.step = 0.004;
  // Larger steps are off by about a quarter of their third power.
  EXPECT_NEAR(thickness_of(build_shell(sphere, options)).least, least, 0.004);
}

TEST(Shell, OfASheetStandsUprightAtItsBorders) {
  const PolygonSoup flat = sheet(20, 20, [](double u, double v) { return Vec3(2 * u - 1, 2 * v - 1, 0); });
  const auto largest_tilt = [&](double extension) {
    ShellOptions options = unrepaired(0.3);
    options.border_extension = extension;
    const Shell shell = build_shell(flat, options);
    double least = 1;
    for (std::size_t v = 0; v < flat.positions.size(); ++v)
      least = std::min(least, (shell.exterior->tops[v] - flat.positions[v]).normalized().z());
    return std::acos(least) * 180 / k_pi;
  };
  // About 79, 6.7 and 1.4 degrees in the prototype.
  EXPECT_GT(largest_tilt(0), 45);
  EXPECT_LT(largest_tilt(1), 7);
  EXPECT_LT(largest_tilt(2.5), 2);
}

TEST(Shell, IsValidAfterRepair) {
  const PolygonSoup waves = sheet(48, 16, [](double u, double v) {
    const double x = 4 * u - 2;
    return Vec3(x, 4.0 / 3 * v, 0.5 * std::sin(2 * k_pi * x));
  });
  for (const DirectorMethod method :
       {DirectorMethod::averaged_distance, DirectorMethod::exact_distance, DirectorMethod::normals}) {
    const Shell before = build_shell(waves, unrepaired(0.6, ShellSide::exterior, method));
    const Shell after = build_shell(waves, repaired(0.6, ShellSide::exterior, method));
    EXPECT_FALSE(before.is_valid());
    EXPECT_TRUE(after.is_valid());
    EXPECT_GT(after.exterior->shortened, 0u);
    EXPECT_EQ(after.exterior->inverted_before, before.exterior->validity.inverted.size());
    // An independent look at the result.
    EXPECT_TRUE(
        check_shell(after.base.positions, after.exterior->tops, after.base.corner_vertices).is_valid());
    EXPECT_LT(thickness_of(after).mean, thickness_of(before).mean);
    EXPECT_GT(thickness_of(after).least, 0);
  }
}

TEST(Shell, IsAtLeastAsThickAsPlainNormalsThatAreValid) {
  // All vertices are corners, where the field is slow. Their normals lead to the centre, sqrt(3) away.
  for (const double thickness : {0.5, 1.5, 3.0}) {
    ShellOptions options = repaired(thickness, ShellSide::interior);
    const Shell thick = build_shell(cube(1), options);
    options.at_least_normals = false;
    const Shell thin = build_shell(cube(1), options);
    EXPECT_TRUE(thick.is_valid());
    EXPECT_TRUE(thick.interior->is_of_normals);
    EXPECT_FALSE(thin.interior->is_of_normals);
    ShellCheckOptions inward;
    inward.is_inward = true;
    EXPECT_TRUE(check_shell(thick.base.positions, thick.interior->tops, thick.base.corner_vertices, inward)
                    .is_valid());
    EXPECT_LT(thickness_of(thin).mean, 0.4);
    // Found to half a percent.
    const double most = std::min(1.0, std::sqrt(3.0) / thickness);
    EXPECT_LE(thickness_of(thick).mean, most + 1e-12);
    EXPECT_GT(thickness_of(thick).mean, most / 1.0051);
    EXPECT_EQ(thick.interior->traced, thin.interior->traced);
  }
}

TEST(Shell, KeepsItsDirectorsWherePlainNormalsAreNoBetter) {
  EXPECT_FALSE(build_shell(ball(8), repaired(0.5)).exterior->is_of_normals);
  EXPECT_FALSE(build_shell(torus(1, 0.4, 32), repaired(0.7)).exterior->is_of_normals);
  EXPECT_FALSE(build_shell(cube(8), repaired(0.5, ShellSide::interior)).interior->is_of_normals);
  EXPECT_FALSE(build_shell(cube(1), unrepaired(0.5, ShellSide::interior)).interior->is_of_normals);
}

TEST(Shell, OfAPieceInTheLayerOfAnotherShortensNoThird) {
  // The small ball floats between the directors of the large one and their tops, and meets neither.
  PolygonSoup balls = ball(4);
  const std::array<Index, 3> face{balls.face(0)[0], balls.face(0)[1], balls.face(0)[2]};
  const Vec3 out =
      (balls.positions[face[0]] + balls.positions[face[1]] + balls.positions[face[2]]).normalized();
  const std::size_t n = balls.positions.size(), n_faces = balls.n_faces();
  const auto add = [&](double radius, const Vec3& center) {
    const auto first = static_cast<Index>(balls.positions.size());
    const PolygonSoup one = ball(4);
    for (const Vec3& p : one.positions) balls.positions.push_back(center + radius * p);
    for (std::size_t f = 0; f < one.n_faces(); ++f) {
      const std::span<const Index> corners = one.face(f);
      balls.add_face(std::array<Index, 3>{first + corners[0], first + corners[1], first + corners[2]});
    }
  };
  add(0.02, 1.5 * out);
  add(1, Vec3(9, 0, 0));
  ShellOptions options = unrepaired(1, ShellSide::exterior, DirectorMethod::normals);
  options.thicknesses.assign(3 * n, 1.0);
  std::fill_n(options.thicknesses.begin() + static_cast<std::ptrdiff_t>(n), n, 0.02);
  const Shell before = build_shell(balls, options);
  ShellValidity nested;
  nested.nested_pieces = {{static_cast<Index>(n_faces), 0}};
  EXPECT_EQ(before.exterior->validity, nested);
  options.repair = true;
  const Shell after = build_shell(balls, options);
  EXPECT_TRUE(after.is_valid());
  EXPECT_TRUE(check_shell(after.base.positions, after.exterior->tops, after.base.corner_vertices).is_valid());
  EXPECT_LT((after.exterior->tops[face[0]] - balls.positions[face[0]]).norm(), 0.6);
  for (std::size_t v = 2 * n; v < 3 * n; ++v)
    EXPECT_EQ(after.exterior->tops[v], after.exterior->traced[v]) << "of the third ball";
}

TEST(Shell, OfAnAnimalIsThickerThanItsNormalsAllow) {
  const std::filesystem::path file = std::filesystem::path(RECEDE_DATA) / "meshes" / "elephant.off";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "run ./dev data";
  PolygonSoup elephant = read_soup(file);
  merge_identical_vertices(elephant);
  const double size = bounding_box(elephant).sizes().maxCoeff();
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    const Shell ours = build_shell(elephant, repaired(0.05 * size, side));
    const Shell theirs = build_shell(elephant, repaired(0.05 * size, side, DirectorMethod::normals));
    EXPECT_TRUE(ours.is_valid());
    EXPECT_TRUE(theirs.is_valid());
    EXPECT_GT(thickness_of(ours).mean, thickness_of(theirs).mean);
  }
}

TEST(Shell, OfASurfaceThatMeetsItselfSaysSo) {
  // Two sheets across each other.
  PolygonSoup soup = sheet(4, 4, [](double u, double v) { return Vec3(u, v, 0); });
  const PolygonSoup other = sheet(4, 4, [](double u, double v) { return Vec3(0.43, v + 0.1, u - 0.5); });
  const auto first = static_cast<Index>(soup.positions.size());
  soup.positions.insert(soup.positions.end(), other.positions.begin(), other.positions.end());
  for (std::size_t f = 0; f < other.n_faces(); ++f) {
    const std::span<const Index> corners = other.face(f);
    soup.add_face(std::array<Index, 3>{first + corners[0], first + corners[1], first + corners[2]});
  }
  const Shell shell = build_shell(soup, repaired(0.1));
  EXPECT_FALSE(shell.is_valid());
  EXPECT_FALSE(shell.exterior->validity.has_valid_base());
  EXPECT_FALSE(shell.exterior->validity.bottom_contacts.empty());
  EXPECT_EQ(shell.exterior->shortened, 0u) << "that wouldn't help";
}

TEST(Shell, AsAnEnvelopeHasBothLayers) {
  const Shell both = build_shell(torus(1, 0.4, 16), repaired(0.2, ShellSide::envelope));
  EXPECT_TRUE(both.is_valid());
  const Shell exterior = build_shell(torus(1, 0.4, 16), repaired(0.2));
  const Shell interior = build_shell(torus(1, 0.4, 16), repaired(0.2, ShellSide::interior));
  EXPECT_EQ(both.exterior->tops, exterior.exterior->tops);
  EXPECT_EQ(both.interior->tops, interior.interior->tops);
  // Two surfaces of the torus, without a border.
  EXPECT_EQ(shell_boundary(both).n_faces(), 2 * both.base.n_faces());
}

TEST(Shell, HasAClosedBoundary) {
  for (const PolygonSoup& surface : {ball(4), saddle()}) {
    const PolygonSoup boundary = shell_boundary(build_shell(surface, repaired(0.1)));
    const auto mesh = repair_to_polygon_mesh(boundary);
    for (const auto edge : mesh.mesh.edges()) EXPECT_FALSE(mesh.mesh.is_boundary(edge));
    double volume = 0;
    const std::vector<Index> triangles = triangulate(boundary);
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      volume += boundary.positions[triangles[t]].dot(
                    boundary.positions[triangles[t + 1]].cross(boundary.positions[triangles[t + 2]])) /
                6;
    }
    EXPECT_GT(volume, 0) << "it faces outwards";
  }
}

TEST(Shell, FindsThePlaceOfAPoint) {
  const Shell shell = build_shell(saddle(), repaired(0.4));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 500; ++i) {
    ShellPlace place{static_cast<Index>(random() % shell.base.n_faces()), {}, share(random)};
    Vec3 weights(share(random), share(random), share(random));
    place.weights = weights / weights.sum();
    const Vec3 point = shell_point(shell, *shell.exterior, place);
    const std::optional<ShellPlace> found = place_in_prism(shell, *shell.exterior, place.triangle, point);
    ASSERT_TRUE(found.has_value());
    // 1e-8 is the specification's; points are found to 1e-12 of the prism.
    EXPECT_LT((found->weights - place.weights).norm(), 1e-8);
    EXPECT_NEAR(found->height, place.height, 1e-8);
    EXPECT_FALSE(place_in_prism(shell, *shell.exterior, place.triangle, point + Vec3(0, 0, 3)).has_value());
  }
}

TEST(Shell, ChangesNearADeformationOnly) {
  PolygonSoup surface =
      sheet(40, 40, [](double u, double v) { return Vec3(4 * u, 4 * v, 0.2 * std::sin(3 * u)); });
  const ShellOptions options = repaired(0.2);
  const Shell before = build_shell(surface, options);
  constexpr Index k_moved = 20 * 41 + 20;
  const Vec3 was = surface.positions[k_moved];
  surface.positions[k_moved] += Vec3(0.02, 0.01, 0.08);
  Shell updated = before;
  const std::size_t n_traced = update_shell(updated, surface, std::array<Index, 1>{k_moved}, options);
  const Shell anew = build_shell(surface, options);
  EXPECT_LT(n_traced, surface.positions.size() / 2);
  std::size_t n_different = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    // The tree of the field is another one, in which parts may be summed up in other groups.
    EXPECT_LT((updated.exterior->tops[v] - anew.exterior->tops[v]).norm(), 1e-6 * 0.2);
    const double moved_by = (updated.exterior->tops[v] - before.exterior->tops[v]).norm();
    n_different += moved_by > 0 ? 1 : 0;
    // 3.5 thicknesses, and sides of triangles, 0.1 to 0.2: to the changed corners, along them, and once more.
    if ((surface.positions[v] - was).norm() > 3.5 * 0.2 + 0.5) {
      EXPECT_EQ(moved_by, 0);
    }
  }
  EXPECT_GT(n_different, 0u);
  EXPECT_TRUE(updated.is_valid());
}

TEST(Shell, ChangesWhereABorderIsSeenToGoOn) {
  // A wall beside the border of a floor: 0.9 apart, but the field sees the floor go on for 0.5.
  PolygonSoup surface = sheet(16, 16, [](double u, double v) { return Vec3(u, v, 0); });
  constexpr Index k_wall = 17 * 17, k_moved = 8 * 17 + 16;
  const PolygonSoup wall = sheet(8, 8, [](double u, double v) { return Vec3(1.9, v, 0.6 * u - 0.3); });
  surface.positions.insert(surface.positions.end(), wall.positions.begin(), wall.positions.end());
  for (std::size_t f = 0; f < wall.n_faces(); ++f) {
    const std::span<const Index> corners = wall.face(f);
    surface.add_face(std::array<Index, 3>{k_wall + corners[0], k_wall + corners[1], k_wall + corners[2]});
  }
  ShellOptions options = repaired(0.2);
  options.field.error = 1e-7;  // so that the field's tree, which is another one, shows in the seventh digit
  const Shell before = build_shell(surface, options);
  ASSERT_EQ(surface.positions[k_moved], Vec3(1, 0.5, 0));
  surface.positions[k_moved] += Vec3(0, 0, 0.05);
  Shell updated = before;
  update_shell(updated, surface, std::array<Index, 1>{k_moved}, options);
  const Shell anew = build_shell(surface, options);
  double moved_by = 0;
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_LT((updated.exterior->tops[v] - anew.exterior->tops[v]).norm(), 1e-6 * 0.2);
    if (v >= k_wall)
      moved_by = std::max(moved_by, (anew.exterior->tops[v] - before.exterior->tops[v]).norm());
  }
  EXPECT_GT(moved_by, 1e-3 * 0.2);
}

TEST(Shell, IsWhatItWasWhereItsUpdateFails) {
  PolygonSoup surface = sheet(8, 8, [](double u, double v) { return Vec3(u, v, 0); });
  const ShellOptions options = repaired(0.1);
  Shell shell = build_shell(surface, options);
  const Shell before = shell;
  constexpr Index k_moved = 4 * 9 + 4;
  const std::array<Index, 1> changed{k_moved};
  surface.positions[k_moved].z() += 0.02;
  test::Cancelling cancelling("averaged distance");  // where directors begin
  EXPECT_THROW(update_shell(shell, surface, changed, options, &cancelling), Cancelled);
  ShellOptions wrong = options;
  wrong.field.p = 1;
  EXPECT_THROW(update_shell(shell, surface, changed, wrong), OptionError);
  EXPECT_EQ(shell.base.positions, before.base.positions);
  EXPECT_EQ(shell.exterior->tops, before.exterior->tops);
  // So the next one sees what has changed.
  EXPECT_GT(update_shell(shell, surface, changed, options), 0u);
  EXPECT_EQ(shell.base.positions, surface.positions);
  EXPECT_NE(shell.exterior->tops, before.exterior->tops);
}

TEST(Shell, IsTheSameWithOneThreadAtAnyScaleAndPlace) {
  const PolygonSoup surface = torus(1, 0.4, 24);
  const Shell shell = build_shell(surface, repaired(0.7));
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(build_shell(surface, repaired(0.7)).exterior->tops, shell.exterior->tops);
  }
  // Powers of two are exact.
  for (const double scale : {std::ldexp(1.0, -30), std::ldexp(1.0, 30)}) {
    PolygonSoup scaled = surface;
    for (Vec3& position : scaled.positions) position *= scale;
    const Shell other = build_shell(scaled, repaired(0.7 * scale));
    EXPECT_TRUE(other.is_valid());
    for (std::size_t v = 0; v < surface.positions.size(); ++v)
      EXPECT_LT((other.exterior->tops[v] / scale - shell.exterior->tops[v]).norm(), 1e-9);
  }
  PolygonSoup moved = surface;
  for (Vec3& position : moved.positions) position += Vec3(1e6, -2e6, 3e6);
  EXPECT_TRUE(build_shell(moved, repaired(0.7)).is_valid());
}

TEST(Shell, TakesAThicknessForEachVertex) {
  const PolygonSoup surface = ball(8);
  ShellOptions options;
  for (const Vec3& position : surface.positions) options.thicknesses.push_back(0.2 + 0.1 * position.z());
  const Shell shell = build_shell(surface, options);
  EXPECT_TRUE(shell.is_valid());
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    // The field is made for the largest of them, and a ball of flat triangles isn't one.
    EXPECT_NEAR((shell.exterior->tops[v] - surface.positions[v]).norm(), options.thicknesses[v], 5e-5);
  }
}

TEST(Shell, RefusesWhatHasNoMeaning) {
  const PolygonSoup surface = ball(2);
  EXPECT_THROW(build_shell(surface, {}), OptionError);
  EXPECT_THROW(build_shell(surface, repaired(-1)), OptionError);
  EXPECT_THROW(build_shell(surface, repaired(std::nan(""))), OptionError);
  EXPECT_THROW(build_shell(surface, repaired(10)), OptionError);
  ShellOptions few = repaired(0.1);
  few.thicknesses = {0.1, 0.1};
  EXPECT_THROW(build_shell(surface, few), OptionError);
  ShellOptions flat = repaired(0.1);
  flat.field.p = 2;
  EXPECT_THROW(build_shell(surface, flat), OptionError);
  EXPECT_THROW(build_shell({}, repaired(0.1)), InputError);
  Shell shell = build_shell(surface, repaired(0.1));
  EXPECT_THROW(update_shell(shell, ball(4), std::array<Index, 1>{0}, repaired(0.1)), InputError);
  EXPECT_THROW(update_shell(shell, surface, std::array<Index, 1>{100000}, repaired(0.1)), InputError);
  EXPECT_THROW(update_shell(shell, surface, {}, repaired(0.1, ShellSide::interior)), OptionError);
}

}  // namespace
}  // namespace recede
