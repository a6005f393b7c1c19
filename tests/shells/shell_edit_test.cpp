#include "cancelling.h"
#include "uv_sheet.h"
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/shell_edit.h>

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>
#include <random>

namespace {

using namespace recede;
using testing::HasSubstr;
using testing::ThrowsMessage;

// Texture coordinates leave room for a gutter.
PolygonSoup square(int n) { return test::uv_sheet(n, 0.1, 0.9); }

/// Half of a cylinder of radius 1 along y from -1 to 1, with one chart.
PolygonSoup half_cylinder(int n) {
  PolygonSoup soup = square(n);
  for (Vec3& p : soup.positions) {
    const double angle = std::numbers::pi / 2 * p.x();
    p = Vec3(std::sin(angle), p.y(), std::cos(angle));
  }
  return soup;
}

std::shared_ptr<const Shell> shell_of(const PolygonSoup& base, double thickness,
                                      ShellSide side = ShellSide::exterior) {
  return std::make_shared<const Shell>(
      build_shell(base, {.thickness = thickness, .side = side, .method = DirectorMethod::normals}));
}

InsideDistance ball(const Vec3& center, double radius) { return ball_body(center, radius); }

Vec3 place_of(const Shell& shell, const ShellPlace& at) {
  Vec2 uv = Vec2::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    uv += at.weights[static_cast<int>(k)] * shell.base.corner_uvs[3 * at.triangle + k];
  return {uv.x(), uv.y(), at.height};
}

TEST(LayerGrid, KnowsWhereTexelsAre) {
  const LayerGrid grid(shell_of(square(3), 0.5), ShellSide::exterior, {40, 40, 8});
  // Texels are 2 / 32 wide and 0.5 / 8 high; the first in the chart is number 4 of 40.
  EXPECT_TRUE(grid.column(4, 4).is_in_chart);
  EXPECT_LT((grid.point(4, 4, 0) - Vec3(-1 + 1.0 / 32, -1 + 1.0 / 32, 0.5 / 16)).norm(), 1e-12);
  EXPECT_LT((grid.point(20, 12, 7) - Vec3(1.0 / 32, -0.5 + 1.0 / 32, 0.5 - 0.5 / 16)).norm(), 1e-12);
  // Two texels around it, and no more.
  EXPECT_FALSE(grid.column(2, 20).is_in_chart);
  EXPECT_NE(grid.column(2, 20).triangle, k_no_index);
  EXPECT_LT((grid.point(2, 20, 0) - Vec3(-1 - 3.0 / 32, 1.0 / 32, 0.5 / 16)).norm(), 1e-12);
  EXPECT_EQ(grid.column(1, 20).triangle, k_no_index);
  EXPECT_NEAR(grid.texel_side(10, 10), 2.0 / 32, 1e-12);
  double volume = 0;
  for (int k = 0; k < 8; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i)
        if (grid.column(i, j).triangle != k_no_index) volume += grid.texel_volume(i, j, k);
  EXPECT_NEAR(volume, 2 * 2 * 0.5, 1e-12);
  EXPECT_LT((grid.mean_extent() - Vec3(2.5, 2.5, 0.5)).norm(), 1e-12);
  EXPECT_EQ(grid.missed(), 0u);
}

TEST(LayerGrid, SaysWhichTrianglesItMisses) {
  const LayerGrid grid(shell_of(square(16), 0.1), ShellSide::exterior, {8, 8, 2});
  EXPECT_GT(grid.missed(), 300u);  // of 512, on 49 texels at most
}

TEST(LayerGrid, RefusesWhatHasNoPlace) {
  const std::array<int, 3> size{16, 16, 4};
  PolygonSoup base = square(1);
  EXPECT_THROW(LayerGrid(nullptr, ShellSide::exterior, size), InputError);
  EXPECT_THROW(LayerGrid(shell_of(base, 0.5), ShellSide::interior, size), InputError);
  EXPECT_THROW(LayerGrid(shell_of(base, 0.5), ShellSide::envelope, size), OptionError);
  EXPECT_THROW(LayerGrid(shell_of(base, 0.5), ShellSide::exterior, {16, 0, 4}), OptionError);
  EXPECT_THROW(LayerGrid(shell_of(base, 0.5), ShellSide::exterior, {1 << 15, 1 << 15, 4}), OptionError);
  base.corner_uvs[2].x() = 1.5;
  EXPECT_THAT([&] { LayerGrid(shell_of(base, 0.5), ShellSide::exterior, size); },
              ThrowsMessage<InputError>(HasSubstr("from 0 to 1: triangle 0 has (1.5, 0.9)")));
  base.corner_uvs.clear();
  EXPECT_THAT([&] { LayerGrid(shell_of(base, 0.5), ShellSide::exterior, size); },
              ThrowsMessage<InputError>(HasSubstr("needs texture coordinates")));
  PolygonSoup twice = square(2);
  for (std::size_t corner = 12; corner < 16; ++corner)
    twice.corner_uvs[corner] = twice.corner_uvs[corner - 12];
  EXPECT_THAT([&] { LayerGrid(shell_of(twice, 0.5), ShellSide::exterior, size); },
              ThrowsMessage<InputError>(HasSubstr("lie above each other")));
}

// What a texture shows is the body, within the layer, as points of space say by the inverse map.
TEST(ShellEdit, PointsAreInMatterWhereTheyAreInTheBody) {
  const auto shell = shell_of(half_cylinder(24), 0.4);
  const LayerGrid grid(shell, ShellSide::exterior, {160, 160, 24});
  const Vec3 center(0.5, 0.1, 1.1);
  VolumeTexture united = make_uniform_volume(grid, 0), carved = make_uniform_volume(grid, 1), common = carved;
  combine(united, grid, ball(center, 0.3), {.operation = VolumeOperation::unite});
  combine(carved, grid, ball(center, 0.3), {.operation = VolumeOperation::carve});
  combine(common, grid, ball(center, 0.3), {.operation = VolumeOperation::intersect});
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(0, 1);
  int inside = 0;
  for (int n = 0; n < 4000; ++n) {
    const auto triangle = static_cast<Index>(number(random) * static_cast<double>(shell->base.n_faces()));
    double u = number(random), v = number(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const ShellPlace place{triangle, {1 - u - v, u, v}, number(random)};
    const Vec3 point = shell_point(*shell, *shell->exterior, place);
    const std::optional<ShellPlace> found = place_in_prism(*shell, *shell->exterior, triangle, point);
    ASSERT_TRUE(found.has_value());
    const double distance = 0.3 - (point - center).norm();
    // Texels are up to 0.035 wide, and linear between; nearer to the surface either may be.
    if (std::abs(distance) < 0.01) continue;
    const Vec3 at = place_of(*shell, *found);
    EXPECT_EQ(opacity_at(united, at) > 0.5, distance > 0);
    EXPECT_EQ(opacity_at(carved, at) > 0.5, distance < 0);
    EXPECT_EQ(opacity_at(common, at) > 0.5, distance > 0);
    inside += distance > 0 ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

// Cubes of texels that a body contains or misses aren't asked for one by one; the outcome is as if they were.
TEST(ShellEdit, CombinesAsTexelByTexel) {
  const LayerGrid grid(shell_of(half_cylinder(10), 0.3), ShellSide::exterior, {50, 46, 9});
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  VolumeTexture texture = make_uniform_volume(grid, 0);
  std::vector<std::uint8_t> expected(texture.n_texels(), 0);
  for (int n = 0; n < 20; ++n) {
    const Vec3 center(number(random), number(random), 0.6 + 0.6 * number(random));
    const InsideDistance body = ball(center, 0.05 + 0.3 * std::abs(number(random)));
    const auto operation = n < 12       ? VolumeOperation::unite
                           : n % 4 == 0 ? VolumeOperation::intersect
                                        : VolumeOperation::carve;
    const InsideDistance used = operation == VolumeOperation::intersect
                                    ? InsideDistance([](const Vec3& p) { return 0.9 - std::abs(p.x()); })
                                    : body;
    const std::vector<std::uint8_t> before = expected;
    std::size_t changed = 0;
    for (int k = 0; k < 9; ++k) {
      for (int j = 0; j < 46; ++j) {
        for (int i = 0; i < 50; ++i) {
          if (grid.column(i, j).triangle == k_no_index) continue;
          const double ramp = 2 * grid.texel_side(i, j);
          const auto opacity = static_cast<std::uint8_t>(
              255 * std::clamp(0.5 + used(grid.point(i, j, k)) / (2 * ramp), 0.0, 1.0) + 0.5);
          std::uint8_t& value = expected[texture.texel(i, j, k)];
          value = operation == VolumeOperation::unite       ? std::max(value, opacity)
                  : operation == VolumeOperation::intersect ? std::min(value, opacity)
                                                            : std::min(value, std::uint8_t(255 - opacity));
          if (value != before[texture.texel(i, j, k)]) ++changed;
        }
      }
    }
    EXPECT_EQ(combine(texture, grid, used, {.operation = operation}).changed, changed);
    ASSERT_EQ(texture.opacity.to_dense(), expected);
  }
}

// A ball and a box by triangles, whose volumes are known.
TEST(ShellEdit, MeasuresTheBodyInTheLayer) {
  const LayerGrid grid(shell_of(square(4), 0.6), ShellSide::exterior, {100, 100, 30});
  VolumeTexture texture = make_uniform_volume(grid, 0);
  const double of_ball =
      combine(texture, grid, ball({0.1, -0.2, 0.3}, 0.25), {.operation = VolumeOperation::unite}).volume;
  // A ramp of half a texel, 0.0125, adds its square over that of the radius: 0.0025.
  EXPECT_NEAR(of_ball / (4.0 / 3 * std::numbers::pi * std::pow(0.25, 3)), 1.0025, 0.003);
  // A ball of triangles of radius 1 +- 0.2 around the origin: the layer holds z from 0 to 0.6 of it.
  const InsideDistance inside =
      mesh_body(std::make_shared<const SignedDistance>(make_displaced_sphere(5000, true)));
  VolumeTexture other = make_uniform_volume(grid, 1);
  const EditReport carved = combine(other, grid, inside, {.operation = VolumeOperation::carve});
  double left = 0;
  for (int k = 0; k < 30; ++k)
    for (int j = 0; j < 100; ++j)
      for (int i = 0; i < 100; ++i)
        if (grid.column(i, j).triangle != k_no_index)
          left += other.opacity.at(i, j, k) / 255.0 * grid.texel_volume(i, j, k);
  // Ramps of opacity are four texels wide, of volumes one: over a curved surface they differ.
  EXPECT_NEAR(left + carved.volume, 4 * 0.6, 4 * 0.6 * 0.01);
  EXPECT_GT(carved.volume, 1);
}

TEST(ShellEdit, MeasuresTheSameWhateverTheRamp) {
  const LayerGrid grid(shell_of(square(4), 0.6), ShellSide::exterior, {60, 60, 20});
  for (int n = 0; n < 20; ++n) {
    const InsideDistance body = ball({0.1, -0.2, 0.3}, 0.15 + 0.013 * n);
    const auto volume = [&](double ramp) {
      VolumeTexture texture = make_uniform_volume(grid, 0);
      return combine(texture, grid, body, {.operation = VolumeOperation::unite, .ramp_texels = ramp}).volume;
    };
    EXPECT_EQ(volume(0.01), volume(2)) << n;
  }
}

TEST(ShellEdit, UnitesWithColors) {
  const LayerGrid grid(shell_of(square(2), 0.5), ShellSide::exterior, {40, 40, 10});
  VolumeTexture texture = make_uniform_volume(grid, 0);
  combine(texture, grid, ball({-0.4, 0, 0.25}, 0.2), {.operation = VolumeOperation::unite});
  EXPECT_TRUE(texture.colors.empty());
  combine(texture, grid, ball({0.4, 0, 0.25}, 0.2),
          {.operation = VolumeOperation::unite, .color = Vec3(1, 0, 0), .other_color = Vec3(0, 0, 1)});
  const auto color_at = [&](const Vec3& place) {
    return texture.colors.at(static_cast<int>(place.x() * 40), static_cast<int>(place.y() * 40),
                             static_cast<int>(place.z() * 10));
  };
  EXPECT_EQ(color_at({0.5 - 0.4 * 0.4, 0.5, 0.5}), (std::array<std::uint8_t, 3>{0, 0, 255}));
  EXPECT_EQ(color_at({0.5 + 0.4 * 0.4, 0.5, 0.5}), (std::array<std::uint8_t, 3>{255, 0, 0}));
}

TEST(ShellEdit, CutsExactlyTheRegion) {
  const LayerGrid grid(shell_of(half_cylinder(6), 0.2), ShellSide::exterior, {48, 48, 6});
  VolumeTexture texture = make_uniform_volume(grid, 0);
  combine(texture, grid, ball({0, 0, 1.1}, 0.8), {.operation = VolumeOperation::unite});
  const VolumeTexture before = texture;
  const auto is_cut = [](const Vec3& place, const Vec3& point) { return place.x() > 0.5 && point.y() < 0.2; };
  const EditReport report = cut(texture, grid, is_cut);
  std::size_t changed = 0;
  for (int k = 0; k < 6; ++k) {
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 48; ++i) {
        const bool is_there = grid.column(i, j).triangle != k_no_index;
        if (is_there && is_cut(texture.middle(i, j, k), grid.point(i, j, k))) {
          EXPECT_EQ(texture.opacity.at(i, j, k), 0);
          if (before.opacity.at(i, j, k) > 0) ++changed;
        } else {
          EXPECT_EQ(texture.opacity.at(i, j, k), before.opacity.at(i, j, k));
        }
      }
    }
  }
  EXPECT_EQ(report.changed, changed);
  EXPECT_GT(changed, 100u);
}

TEST(ShellEdit, RefusesCoordinatesWithoutMeaning) {
  TexturedShell textured;
  textured.shell = shell_of(square(2), 0.3);
  textured = with_texture(textured, make_volume(weave(), 4));
  EXPECT_NO_THROW(textured.layer());
  textured.coordinates.repeat = {0, 1};
  EXPECT_THAT([&] { textured.layer(); }, ThrowsMessage<InputError>(HasSubstr("periods")));
  textured.coordinates = {.offset = {0, std::nan("")}};
  EXPECT_THROW(textured.layer(), InputError);
}

TEST(ShellEdit, UnwrapsWhatRepeats) {
  TexturedShell textured;
  textured.shell = shell_of(square(2), 0.3);
  textured.texture = std::make_shared<const VolumeMipmap>(make_mipmap(make_volume(weave(), 16)));
  textured.coordinates = {.repeat = {3, 2}, .offset = {0.25, 0.5}};
  const VolumeTexture& source = textured.texture->surfaces.front();
  EXPECT_EQ(unwrapped_size(textured), (std::array<int, 3>{48, 2 * source.size[1], source.size[2]}));
  const LayerGrid grid(textured.shell, ShellSide::exterior, {96, 64, source.size[2]});
  const VolumeTexture unwrapped = unwrap_volume(textured, grid);
  for (const auto& [i, j, k] : {std::array{20, 30, 2}, {50, 11, 5}, {75, 50, 1}}) {
    const Vec3 place = unwrapped.middle(i, j, k);
    const Vec2 st = textured.coordinates.of(place.head<2>());
    EXPECT_NEAR(unwrapped.opacity.at(i, j, k) / 255.0, opacity_at(source, {st.x(), st.y(), place.z()}),
                0.5 / 255 + 1e-9);
  }
  EXPECT_EQ(unwrapped.colors.size(), unwrapped.size);
  EXPECT_FALSE(unwrapped.is_periodic);
}

TEST(ShellEdit, FillsALayerOnceBeforeItIsEdited) {
  TexturedShell textured;
  textured.shell = shell_of(square(2), 0.3);
  textured = with_texture(textured, make_volume(weave(), 8));
  textured.coordinates = {.repeat = {4, 4}};
  const FilledLayer filled = fill_once(textured);
  EXPECT_EQ(filled.texture.size, unwrapped_size(textured));
  EXPECT_FALSE(filled.texture.is_periodic);
  const TexturedShell once = with_texture(textured, filled.texture);
  EXPECT_EQ(once.coordinates.repeat, Vec2(1, 1));
  EXPECT_EQ(fill_once(once).texture.opacity, filled.texture.opacity);
  EXPECT_EQ(fill_once(once, std::array{20, 30, 4}).texture.size, (std::array{20, 30, 4}));
}

TEST(ShellEdit, FindsTheNearestPlace) {
  const auto shell = shell_of(half_cylinder(6), 0.3);
  const ShellPlace place = nearest_place(*shell, {0.3, 0.2, 5});
  EXPECT_NEAR(place.weights.sum(), 1, 1e-12);
  EXPECT_GE(place.weights.minCoeff(), -1e-12);
  const Vec3 from(0.3, 0.2, 5);
  const double distance = (shell_point(*shell, *shell->exterior, place) - from).norm();
  for (Index t = 0; t < shell->base.n_faces(); ++t) {
    for (int n = 0; n < 66; ++n) {
      const double u = n % 11 / 10.0, v = (1 - u) * (n / 11) / 5.0;
      EXPECT_GE((shell_point(*shell, *shell->exterior, {t, {1 - u - v, u, v}, 0}) - from).norm(),
                distance - 1e-12);
    }
  }
}

TEST(ShellEdit, FindsNoPlaceInATriangleWithoutArea) {
  PolygonSoup base = square(2);
  const auto first = static_cast<Index>(base.positions.size());
  for (const double x : {1.5, 2.0, 2.5}) base.positions.emplace_back(x, 0, 0);
  base.add_face(std::array<Index, 3>{first, first + 1, first + 2});
  base.corner_uvs.insert(base.corner_uvs.end(), 3, Vec2(0.95, 0.95));
  const auto shell = shell_of(base, 0.3);
  const ShellPlace place = nearest_place(*shell, {2, 0.25, 0.5});
  const Vec3 nearest = shell_point(*shell, *shell->exterior, place);
  EXPECT_LT((nearest - Vec3(1, 0.25, 0)).norm(), 1e-12);
  PolygonSoup flat = base;
  for (Vec3& p : flat.positions) p.y() = 0;
  Shell without_area = *shell;
  without_area.base.positions = flat.positions;
  EXPECT_THROW(nearest_place(without_area, {2, 0.25, 0.5}), InputError);
  // The square of the second one's distance isn't finite.
  for (const double y : {std::nan(""), 1e300}) EXPECT_THROW(nearest_place(*shell, {2, y, 0.5}), OptionError);
}

// On a plane the maps are without stretch: a ball that moves is a ball elsewhere.
TEST(ShellEdit, MovesMatterOverAPlane) {
  const auto shell = shell_of(square(8), 0.3);
  const LayerGrid grid(shell, ShellSide::exterior, {125, 125, 16});
  const auto with_balls = [&](std::initializer_list<Vec3> centers) {
    VolumeTexture texture = make_uniform_volume(grid, 0);
    for (const Vec3& center : centers)
      combine(texture, grid, ball(center, 0.1), {.operation = VolumeOperation::unite});
    return texture;
  };
  const Vec3 from(-0.4, -0.3, 0.15), to(0.35, 0.25, 0.15);
  const auto largest_difference = [](const VolumeTexture& a, const VolumeTexture& b) {
    int most = 0;
    for_each_texel({{0, 0, 0}, a.size}, [&](int i, int j, int k) {
      most = std::max(most, std::abs(a.opacity.at(i, j, k) - b.opacity.at(i, j, k)));
    });
    return most;
  };
  VolumeTexture moved = with_balls({from});
  MoveOptions options{.from = nearest_place(*shell, from), .to = nearest_place(*shell, to), .radius = 0.25};
  const MoveReport report = move_matter(moved, grid, options);
  EXPECT_NEAR(report.stretch, 1, 1e-6);
  EXPECT_EQ(report.without_source, 0u);
  // Sampled once more opacity is smoothed over a texel: of a ball of five texels' radius, with a ramp of
  // four, by less than a sixteenth.
  EXPECT_LT(largest_difference(moved, with_balls({to})), 255 / 16);
  VolumeTexture copied = with_balls({from});
  options.is_copy = true;
  move_matter(copied, grid, options);
  EXPECT_LT(largest_difference(copied, with_balls({from, to})), 255 / 16);
  // Beside the middle, turned a quarter counter-clockwise.
  VolumeTexture turned = with_balls({from + Vec3(0.1, 0, 0)});
  options.is_copy = false;
  options.turn = std::numbers::pi / 2;
  move_matter(turned, grid, options);
  EXPECT_LT(largest_difference(turned, with_balls({to + Vec3(0, 0.1, 0)})), 255 / 16);
  // Where it is: nothing changes but what is between the discs' borders.
  VolumeTexture stays = with_balls({from});
  options = {.from = options.from, .to = options.from, .radius = 0.25};
  move_matter(stays, grid, options);
  EXPECT_LE(largest_difference(stays, with_balls({from})), 1);  // rounded once more
}

// Around a corner: what moved is as large as it was, and stands on the surface there.
TEST(ShellEdit, MovesMatterOverACurve) {
  const auto shell = shell_of(half_cylinder(24), 0.3);
  const LayerGrid grid(shell, ShellSide::exterior, {200, 200, 16});
  VolumeTexture texture = make_uniform_volume(grid, 0);
  const Vec3 from(std::sin(-0.8), 0.2, std::cos(-0.8)), to(std::sin(0.7), -0.3, std::cos(0.7));
  const double radius = 0.12;
  combine(texture, grid, ball(1.1 * from - Vec3(0, 0.02, 0), radius), {.operation = VolumeOperation::unite});
  const auto moments = [&] {
    double volume = 0;
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < 16; ++k)
      for (int j = 0; j < 200; ++j)
        for (int i = 0; i < 200; ++i)
          if (grid.column(i, j).triangle != k_no_index) {
            const double part = texture.opacity.at(i, j, k) / 255.0 * grid.texel_volume(i, j, k);
            volume += part;
            sum += part * grid.point(i, j, k);
          }
    return std::pair(volume, Vec3(sum / volume));
  };
  const auto [before, middle_before] = moments();
  move_matter(texture, grid,
              {.from = nearest_place(*shell, from), .to = nearest_place(*shell, to), .radius = 0.3});
  const auto [after, middle_after] = moments();
  // The map of a piece of cylinder by triangles of a fifteenth stretches little.
  EXPECT_NEAR(after / before, 1, 0.003);
  EXPECT_LT((middle_after - Vec3(1.1 * std::sin(0.7), -0.3, 1.1 * std::cos(0.7))).norm(), 0.05);
}

TEST(ShellEdit, SaysWhatMovesOverABorder) {
  const auto shell = shell_of(square(8), 0.3);
  const LayerGrid grid(shell, ShellSide::exterior, {60, 60, 8});
  VolumeTexture texture = make_uniform_volume(grid, 0.25);
  const MoveReport report = move_matter(
      texture, grid,
      {.from = nearest_place(*shell, {-0.9, 0, 0}), .to = nearest_place(*shell, {0.4, 0, 0}), .radius = 0.3});
  // The disc's part beyond the border, 0.1 from its middle: 0.29 of its area.
  EXPECT_NEAR(static_cast<double>(report.without_source) / (std::numbers::pi * 0.09 / (2 * 2) * 48 * 48 * 8),
              0.29, 0.1);
}

TEST(ShellEdit, IsTheSameForAnyNumberOfThreads) {
  const auto run = [] {
    const auto shell = shell_of(half_cylinder(8), 0.3);
    const LayerGrid grid(shell, ShellSide::exterior, {64, 64, 8});
    VolumeTexture texture = make_uniform_volume(grid, 1);
    const double volume = combine(texture, grid, ball({0.2, 0, 1.1}, 0.3)).volume;
    move_matter(texture, grid,
                {.from = nearest_place(*shell, {0.2, 0, 1}),
                 .to = nearest_place(*shell, {-0.5, 0.2, 0.8}),
                 .radius = 0.3});
    return std::pair(texture.opacity.to_dense(), volume);
  };
  const auto many = run();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(run(), many);
}

TEST(ShellEdit, RefusesWhatItCannotEdit) {
  const auto shell = shell_of(square(2), 0.3);
  const LayerGrid grid(shell, ShellSide::exterior, {32, 32, 4});
  VolumeTexture texture = make_uniform_volume(grid, 1), other = texture;
  const InsideDistance body = ball({0, 0, 0}, 0.2);
  EXPECT_THROW(ball_body({0, 0, 0}, -1), OptionError);
  EXPECT_THROW(ball_body({std::nan(""), 0, 0}, 1), OptionError);
  other.is_periodic = true;
  EXPECT_THAT([&] { combine(other, grid, body); }, ThrowsMessage<InputError>(HasSubstr("unwrap")));
  other = make_uniform_volume(LayerGrid(shell, ShellSide::exterior, {16, 32, 4}), 1);
  EXPECT_THAT([&] { combine(other, grid, body); },
              ThrowsMessage<InputError>(HasSubstr("has 16 x 32 x 4 texels, the grid 32 x 32 x 4")));
  EXPECT_THAT([&] { combine(texture, grid, [](const Vec3&) { return std::nan(""); }); },
              ThrowsMessage<InputError>(HasSubstr("isn't a number")));
  EXPECT_THROW(combine(texture, grid, body, {.ramp_texels = 0}), OptionError);
  EXPECT_THROW(combine(texture, grid, body, {.color = Vec3(2, 0, 0)}), OptionError);
  EXPECT_THROW(make_uniform_volume(grid, 1.5), OptionError);
  test::Cancelling cancelling;
  const BrickGrid<std::uint8_t> before = texture.opacity;
  EXPECT_THROW(combine(texture, grid, body, {}, &cancelling), Cancelled);
  EXPECT_EQ(texture.opacity, before);
  const ShellPlace place = nearest_place(*shell, {0, 0, 0});
  EXPECT_THROW(move_matter(texture, grid, {.from = place, .to = place, .radius = 0}), OptionError);
  EXPECT_THROW(move_matter(texture, grid, {.from = place, .to = {9, {1, 0, 0}, 0}, .radius = 1}),
               OptionError);
  EXPECT_THROW(move_matter(texture, grid, {.from = place, .to = {0, {2, 0, -1}, 0}, .radius = 1}),
               OptionError);
}

// Frames of an animation: the base moves, the texture changes, neither asks for the other.
TEST(ShellEdit, AnimatesBaseAndTextureApart) {
  const PolygonSoup rest = half_cylinder(12);
  const ShellOptions options{.thickness = 0.2};
  Shell shell = build_shell(rest, options);
  std::vector<Index> all(rest.positions.size());
  for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<Index>(v);
  const std::vector<Index> triangles = shell.base.corner_vertices;
  const std::vector<Vec2> coordinates = shell.base.corner_uvs;
  std::vector<BrickGrid<std::uint8_t>> textures;
  for (int frame = 0; frame < 3; ++frame) {
    PolygonSoup waving = shell.base;
    waving.positions = rest.positions;
    for (Vec3& p : waving.positions) p.z() += 0.05 * std::sin(4 * p.y() + frame);
    update_shell(shell, waving, all, options);
    EXPECT_EQ(shell.base.corner_vertices, triangles);
    EXPECT_EQ(shell.base.corner_uvs, coordinates);
    EXPECT_TRUE(shell.is_valid());
    textures.push_back(make_volume(bubbles({.bubbles = 8, .time = 0.1 * frame}), 16).opacity);
  }
  EXPECT_NE(textures[0], textures[1]);
  EXPECT_NE(textures[1], textures[2]);
  EXPECT_EQ(textures[1], make_volume(bubbles({.bubbles = 8, .time = 0.1}), 16).opacity);
}

}  // namespace
