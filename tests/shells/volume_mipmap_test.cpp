#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/volume_mipmap.h>

#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>

#include <cmath>
#include <random>

namespace {

using namespace recede;
using Matrix3 = Eigen::Matrix3d;

double mean_opacity(const VolumeTexture& texture) {
  double sum = 0;
  for (const std::uint8_t opacity : texture.opacity) sum += opacity / 255.0;
  return sum / static_cast<double>(texture.opacity.size());
}

// Bars along t, round, a quarter of a period apart.
VolumeTexture bars(int n) {
  return make_volume(
      [](const Vec3& point) {
        const double beside = point.x() - std::floor(4 * point.x()) / 4 - 0.125;
        return 0.08 - std::hypot(beside, point.z() - 0.125);
      },
      {.size = {n, n, n / 4}, .extent = {1, 1, 0.25}});
}

// Checklist 23: the mean stays, and thin things vanish under the threshold.
TEST(VolumeMipmap, KeepsTheMeanAndStopsBeforeThingsVanish) {
  const VolumeTexture texture = bars(64);
  const VolumeMipmap mipmap = make_mipmap(texture, {.least_share = 0, .seen_tolerance = 1e9});
  // With no share to keep, all levels are surfaces.
  ASSERT_EQ(mipmap.surfaces.size(), 7u);
  for (const VolumeTexture& level : mipmap.surfaces)
    EXPECT_NEAR(mean_opacity(level), mean_opacity(texture), 6 * 0.5 / 255);  // rounding at each level
  const VolumeMipmap kept = make_mipmap(texture, {.seen_tolerance = 0.2});
  EXPECT_GE(kept.surfaces.size(), 2u);
  EXPECT_LT(kept.surfaces.size(), 5u);
  const auto inside = [](const VolumeTexture& level) {
    return static_cast<double>(std::count_if(level.opacity.begin(), level.opacity.end(),
                                             [](std::uint8_t opacity) { return opacity >= 128; })) /
           static_cast<double>(level.opacity.size());
  };
  for (const VolumeTexture& level : kept.surfaces) EXPECT_GE(inside(level), 0.75 * inside(texture));
  // The last one, without a share to keep, is empty.
  EXPECT_EQ(inside(mipmap.surfaces.back()), 0);
  EXPECT_EQ(kept.n_levels(), 7);
  EXPECT_EQ(kept.transparent.front().size, kept.surfaces.back().size);
  EXPECT_EQ(kept.transparent.back().size, (std::array<int, 3>{1, 1, 1}));
}

// Checklist 26: tubes are opaque across and clear along.
TEST(VolumeMipmap, KnowsTheDirectionOfBars) {
  const VolumeMipmap mipmap = make_mipmap(bars(64));
  const TransparentVolume& last = mipmap.transparent.back();
  // Bars cover 4 * 0.16 of the side, seen along r, and 4 * pi * 0.08^2 of their ends' 0.25.
  EXPECT_NEAR(last.opacity_along(0, Vec3::UnitZ()), 0.64, 0.02);  // a texel's half width at 8 borders, of 64
  EXPECT_NEAR(last.opacity_along(0, Vec3::UnitY()), 16 * std::numbers::pi * 0.08 * 0.08, 0.03);
  EXPECT_NEAR(last.opacity_along(0, Vec3::UnitX()), 0.64, 0.02);
  // Along t, texels in a row have the same holes.
  const TransparentVolume& middle = mipmap.transparent[1];
  EXPECT_GT(middle.correlation.y(), 0.9);
}

TEST(VolumeMipmap, CombinesRowsByCorrelation) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> number(0.05, 0.95);
  for (int n = 0; n < 100; ++n) {
    const double a = number(random), b = number(random);
    EXPECT_DOUBLE_EQ(opacity_in_row(a, b, 0), 1 - (1 - a) * (1 - b));
    EXPECT_DOUBLE_EQ(opacity_in_row(a, b, 1), std::max(a, b));
    double before = 1;
    for (int c = 0; c <= 10; ++c) {
      const double opacity = opacity_in_row(a, b, c / 10.0);
      EXPECT_LT(opacity, before);
      before = opacity;
    }
  }
}

// Checklist 25.
TEST(VolumeMipmap, NormalsOfABallAndOfAPlane) {
  const VolumeTexture ball =
      make_volume([](const Vec3& point) { return 0.35 - (point - Vec3(0.5, 0.5, 0.5)).norm(); },
                  {.size = {32, 32, 32}, .extent = Vec3::Ones()});
  const Matrix3 of_ball = normal_matrix(make_mipmap(ball).transparent.back().normals.front());
  EXPECT_LT((of_ball - Matrix3::Identity()).norm(), 0.05);  // the grid is no ball
  EXPECT_NEAR(mean_normal_along(of_ball, Vec3(1, 2, 3).normalized()).norm(), 2.0 / 3, 0.02);

  const VolumeTexture plane = make_volume([](const Vec3& point) { return 0.4 - point.z(); },
                                          {.size = {16, 16, 16}, .extent = Vec3::Ones()});
  const Matrix3 of_plane =
      normal_matrix(make_mipmap(plane, {.flatness = 0.08}).transparent.back().normals.front());
  EXPECT_NEAR(of_plane(0, 0), 1, 0.01);
  EXPECT_NEAR(of_plane(2, 2), 0.08 * 0.08, 0.01);
  // Seen from above: up, and as long as a unit; flat discs bend their normals at the rim only.
  const Vec3 mean = mean_normal_along(of_plane, -Vec3::UnitZ());
  EXPECT_GT(mean.z(), 0.97);
  EXPECT_LT(mean.head<2>().norm(), 0.01);  // entries are rounded by 1/255
  // Rough is shorter, so darker.
  EXPECT_LT(mean_normal_along(of_ball, -Vec3::UnitZ()).norm(), mean.norm());
}

TEST(VolumeMipmap, NormalMatricesStayEllipsoids) {
  for (const ProceduralVolume& volume : {chain_mail(), weave(), bark()}) {
    for (const TransparentVolume& level : make_mipmap(make_volume(volume, 32)).transparent) {
      for (const auto& bytes : level.normals) {
        const Eigen::SelfAdjointEigenSolver<Matrix3> solver(normal_matrix(bytes));
        EXPECT_GT(solver.eigenvalues()[0], -0.01);  // three entries are each rounded by 1/255
        EXPECT_LE(solver.eigenvalues()[2], 1.01);
      }
    }
  }
}

TEST(VolumeMipmap, TakesTexturesOfOneTexelAndOddSizes) {
  const VolumeTexture one{.size = {1, 1, 1}, .opacity = {200}};
  const VolumeMipmap mipmap = make_mipmap(one);
  EXPECT_EQ(mipmap.n_levels(), 1);
  EXPECT_EQ(mipmap.transparent.front().opacity.front()[0], 200);
  const VolumeMipmap odd = make_mipmap(make_volume(chain_mail(), 13));
  EXPECT_EQ(odd.transparent.back().size, (std::array<int, 3>{1, 1, 1}));
  EXPECT_THROW(make_mipmap(one, {.least_share = 2}), OptionError);
  EXPECT_THROW(make_mipmap(VolumeTexture{}), InputError);
}

}  // namespace
