#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/volume_mipmap.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace {

using namespace recede;
using Matrix3 = Eigen::Matrix3d;

double mean_opacity(const VolumeTexture& texture) {
  double sum = 0;
  for (const std::uint8_t opacity : texture.opacity.to_dense()) sum += opacity / 255.0;
  return sum / static_cast<double>(texture.n_texels());
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
    const std::vector<std::uint8_t> texels = level.opacity.to_dense();
    return static_cast<double>(std::count_if(texels.begin(), texels.end(),
                                             [](std::uint8_t opacity) { return opacity >= 128; })) /
           static_cast<double>(texels.size());
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
  EXPECT_NEAR(last.opacity_along({0, 0, 0}, Vec3::UnitZ()), 0.64,
              0.02);  // a texel's half width at 8 borders, of 64
  EXPECT_NEAR(last.opacity_along({0, 0, 0}, Vec3::UnitY()), 16 * std::numbers::pi * 0.08 * 0.08, 0.003);
  EXPECT_NEAR(last.opacity_along({0, 0, 0}, Vec3::UnitX()), 0.64, 0.02);
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
  const Matrix3 of_ball = normal_matrix(make_mipmap(ball).transparent.back().normals.at(0, 0, 0));
  EXPECT_LT((of_ball - Matrix3::Identity()).norm(), 0.05);  // the grid is no ball
  EXPECT_NEAR(mean_normal_along(of_ball, Vec3(1, 2, 3).normalized()).norm(), 2.0 / 3, 0.02);

  const VolumeTexture plane = make_volume([](const Vec3& point) { return 0.4 - point.z(); },
                                          {.size = {16, 16, 16}, .extent = Vec3::Ones()});
  const Matrix3 of_plane =
      normal_matrix(make_mipmap(plane, {.flatness = 0.08}).transparent.back().normals.at(0, 0, 0));
  EXPECT_NEAR(of_plane(0, 0), 1, 1e-6);
  EXPECT_NEAR(of_plane(2, 2), 0.08 * 0.08, 0.01);
  // Seen from above: up, and as long as a unit; flat discs bend their normals at the rim only.
  const Vec3 mean = mean_normal_along(of_plane, -Vec3::UnitZ());
  EXPECT_GT(mean.z(), 0.97);
  EXPECT_LT(mean.head<2>().norm(), 0.01);  // entries are rounded by 1/255
  // Rough is shorter, so darker.
  EXPECT_LT(mean_normal_along(of_ball, -Vec3::UnitZ()).norm(), mean.norm());
}

Matrix3 ellipsoid(const Eigen::Quaterniond& turn, const Vec3& axes) {
  const Matrix3 columns = turn.toRotationMatrix() * axes.asDiagonal();
  return columns * columns.transpose();
}

std::array<std::uint8_t, 6> encoded(const Matrix3& matrix) {
  const double entries[] = {matrix(0, 0), matrix(1, 1), matrix(2, 2),
                            matrix(0, 1), matrix(0, 2), matrix(1, 2)};
  std::array<std::uint8_t, 6> bytes{};
  for (std::size_t e = 0; e < 6; ++e) {
    EXPECT_LE(std::abs(entries[e]), 1 + 1e-12);  // with a longest axis of 1
    bytes[e] = static_cast<std::uint8_t>(std::lround(127.5 * (std::clamp(entries[e], -1.0, 1.0) + 1)));
  }
  return bytes;
}

Vec3 random_unit(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

Eigen::Quaterniond random_turn(std::mt19937& random) {
  std::uniform_real_distribution<double> angle(0, std::numbers::pi);
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle(random), random_unit(random)));
}

// Checklist 25: bytes keep an ellipsoid's axes, and what is linear between ellipsoids is one.
TEST(VolumeMipmap, BytesKeepEllipsoids) {
  constexpr double k_step = 0.5 / 127.5;  // what rounding an entry changes
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(0, 1);
  for (int n = 0; n < 200; ++n) {
    Matrix3 between = Matrix3::Zero();
    double weights = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 axes(1, 0.3 + 0.5 * number(random), 0.3 + 0.5 * number(random));
      const Eigen::Quaterniond turn = random_turn(random);
      const Matrix3 exact = ellipsoid(turn, axes), kept = normal_matrix(encoded(exact));
      EXPECT_LE((kept - exact).cwiseAbs().maxCoeff(), k_step + 1e-12);
      EXPECT_EQ(encoded(kept), encoded(exact));
      const Eigen::SelfAdjointEigenSolver<Matrix3> solver(kept);
      Vec3 squares = axes.cwiseProduct(axes);
      std::sort(squares.data(), squares.data() + 3);
      // Nine entries that are off change no eigenvalue by more than three times as much, and the longest
      // axis, whose square is 0.36 above the next, by no more than that over the difference.
      EXPECT_LE((solver.eigenvalues() - squares).cwiseAbs().maxCoeff(), 3 * k_step);
      const Vec3 longest = turn * Vec3::UnitX();
      EXPECT_LT(longest.cross(solver.eigenvectors().col(2)).norm(), 3 * k_step / 0.36 * 1.1);
      const double weight = number(random);
      between += weight * kept;
      weights += weight;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3> solver(between / weights);
    EXPECT_GT(solver.eigenvalues()[0], 0.09 - 3 * k_step);
    EXPECT_LE(solver.eigenvalues()[2], 1 + 3 * k_step);
  }
}

// Checklist 25: the normals of a sum are those of both but for the square of the angle between them.
TEST(VolumeMipmap, NormalsOfSumsAreSumsOfNormals) {
  std::mt19937 random(7);
  for (int n = 0; n < 50; ++n) {
    const Eigen::Quaterniond turn = random_turn(random);
    const Vec3 about = random_unit(random), direction = random_unit(random);
    const auto error = [&](double angle) {
      const Vec3 axes(1, 0.7, 0.4);
      const Matrix3 one = ellipsoid(Eigen::AngleAxisd(angle / 2, about) * turn, axes),
                    other = ellipsoid(Eigen::AngleAxisd(-angle / 2, about) * turn, axes);
      return (mean_normal_along((one + other) / 2, direction) -
              (mean_normal_along(one, direction) + mean_normal_along(other, direction)) / 2)
          .norm();
    };
    // Half the angle, a quarter of the error; a third at most, as what the angle's fourth power adds isn't
    // nothing.
    EXPECT_LT(error(0.1), error(0.2) / 3 + 1e-6) << n;
    EXPECT_LT(error(0.2), 0.04);
  }
}

/// Mean of the unit normals over the outline's disc, as a brute-force sum.
Vec3 exact_mean_normal(const Matrix3& inverse, const Vec3& direction) {
  const Matrix3 form = inverse.inverse();
  const Vec3 side = direction.unitOrthogonal(), up = direction.cross(side);
  Eigen::Matrix<double, 3, 2> basis;
  basis << side, up;
  const Eigen::LLT<Eigen::Matrix2d> shadow(basis.transpose() * inverse * basis);
  const Eigen::Matrix2d root = shadow.matrixL();
  constexpr int k_side = 60;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (int i = 0; i < k_side * k_side; ++i) {
    const Vec2 on_disc((i % k_side + 0.5) / k_side * 2 - 1, (i / k_side + 0.5) / k_side * 2 - 1);
    if (on_disc.squaredNorm() >= 1) continue;
    const Vec3 at = basis * (root * on_disc);
    const double a = direction.dot(form * direction), b = direction.dot(form * at), c = at.dot(form * at) - 1;
    sum += (form * (at + (-b - std::sqrt(std::max(b * b - a * c, 0.0))) / a * direction)).normalized();
    ++count;
  }
  return sum / count;
}

// Checklist 25: nine places for the whole disc.
TEST(VolumeMipmap, MeanNormalsAreThoseOfTheWholeOutline) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> axis(0.1, 1);
  double sum = 0, worst = 0, firm_sum = 0;
  constexpr int k_rounds = 1000;
  for (int n = 0; n < k_rounds; ++n) {
    Vec3 axes(axis(random), axis(random), axis(random));
    axes /= axes.maxCoeff();
    const Matrix3 inverse = ellipsoid(random_turn(random), axes);
    const Vec3 direction = random_unit(random), mean = mean_normal_along(inverse, direction);
    // That is what is added for ellipsoids that rounding made hollow.
    const double error = (mean - exact_mean_normal(inverse + 0.01 * Matrix3::Identity(), direction)).norm();
    sum += error;
    worst = std::max(worst, error);
    firm_sum += (mean - exact_mean_normal(inverse, direction)).norm();
  }
  // The specification has 0.0225 and 0.14; measured 0.018 and 0.123. What is added moves thin ones that are
  // seen on edge: measured 0.027 with it.
  EXPECT_LT(sum / k_rounds, 0.0225);
  EXPECT_LT(worst, 0.14);
  EXPECT_LT(firm_sum / k_rounds, 0.032);
}

TEST(VolumeMipmap, NormalMatricesStayEllipsoids) {
  for (const ProceduralVolume& volume : {chain_mail(), weave(), bark()}) {
    for (const TransparentVolume& level : make_mipmap(make_volume(volume, 32)).transparent) {
      for (const auto& bytes : level.normals.to_dense()) {
        const Eigen::SelfAdjointEigenSolver<Matrix3> solver(normal_matrix(bytes));
        EXPECT_GT(solver.eigenvalues()[0], -0.01);  // three entries are each rounded by 1/255
        EXPECT_LE(solver.eigenvalues()[2], 1.01);
      }
    }
  }
}

TEST(VolumeMipmap, TakesTexturesOfOneTexelAndOddSizes) {
  const VolumeTexture one{.size = {1, 1, 1}, .opacity = {{1, 1, 1}, 200}};
  const VolumeMipmap mipmap = make_mipmap(one);
  EXPECT_EQ(mipmap.n_levels(), 1);
  EXPECT_EQ(mipmap.transparent.front().opacity.at(0, 0, 0)[0], 200);
  const VolumeMipmap odd = make_mipmap(make_volume(chain_mail(), 13));
  EXPECT_EQ(odd.transparent.back().size, (std::array<int, 3>{1, 1, 1}));
  EXPECT_THROW(make_mipmap(one, {.least_share = 2}), OptionError);
  EXPECT_THROW(make_mipmap(VolumeTexture{}), InputError);
}

}  // namespace
