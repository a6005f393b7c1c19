#include <recede/geometry/error.h>
#include <recede/shells/detail/volume_sampler.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/volume_texture.h>

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

namespace {

using namespace recede;
using testing::HasSubstr;
using testing::ThrowsMessage;

// A ball in the middle of a unit cube.
double ball(const Vec3& point) { return 0.3 - (point - Vec3(0.5, 0.5, 0.5)).norm(); }

VolumeTexture ball_texture(int n, double ramp_texels = 2) {
  return make_volume(ball, {.size = {n, n, n}, .extent = Vec3::Ones(), .ramp_texels = ramp_texels});
}

TEST(VolumeTexture, IsHalfOnTheSurfaceAndAWholeInside) {
  const VolumeTexture texture = ball_texture(32);
  EXPECT_EQ(texture.ramp, 2.0 / 32);
  EXPECT_EQ(opacity_at(texture, {0.5, 0.5, 0.5}), 1);
  EXPECT_EQ(opacity_at(texture, {0.02, 0.5, 0.5}), 0);
  // Values are rounded to 255ths. The place is half a texel from middles in two directions, where the ball is
  // 2 * (0.5 / 32)^2 / (2 * 0.3) away: of a ramp of 4 / 32, 0.0066.
  EXPECT_NEAR(opacity_at(texture, {0.8, 0.5, 0.5}), 0.5, 0.5 / 255 + 0.0066);
}

TEST(VolumeTexture, HasGradientsOfTheDistance) {
  const VolumeTexture texture = ball_texture(64);
  std::mt19937 random(5);
  std::normal_distribution<double> number;
  for (int n = 0; n < 200; ++n) {
    const Vec3 direction = Vec3(number(random), number(random), number(random)).normalized();
    const Vec3 gradient = opacity_gradient(texture, Vec3(0.5, 0.5, 0.5) + 0.3 * direction);
    // Inwards. Values are rounded by 1/510 over a slope of 1/4 for a texel: 0.5 degrees, for each axis.
    const double cosine = std::clamp(-gradient.normalized().dot(direction), -1.0, 1.0);
    EXPECT_LT(std::acos(cosine), 1.0 * std::numbers::pi / 180);
    EXPECT_NEAR(gradient.norm(), 1 / (2 * texture.ramp), 0.02 / texture.ramp);
  }
}

TEST(VolumeTexture, HasTheSameGradientsAtTexels) {
  for (const bool is_periodic : {true, false}) {
    VolumeTexture texture = make_volume(
        [](const Vec3& p) { return 0.2 * std::sin(7 * p.x() + 5 * p.y()) * std::cos(4 * p.z() - 3 * p.x()); },
        {.size = {9, 6, 5}, .extent = Vec3::Ones(), .is_periodic = is_periodic});
    for (int k = 0; k < 5; ++k)
      for (int j = 0; j < 6; ++j)
        for (int i = 0; i < 9; ++i)
          // Places of texels' middles are rounded.
          EXPECT_LT((detail::texel_gradient(texture, {i, j, k}) -
                     opacity_gradient(texture, texture.middle(i, j, k)))
                        .norm(),
                    1e-12);
  }
  const VolumeTexture one{.size = {1, 1, 1}, .opacity = {{1, 1, 1}, 77}};
  EXPECT_EQ(detail::texel_gradient(one, {0, 0, 0}), Vec3(0, 0, 0));
}

TEST(VolumeTexture, RepeatsOrEnds) {
  VolumeTexture texture = make_volume([](const Vec3& point) { return 0.25 - point.x(); },
                                      {.size = {4, 1, 1}, .extent = {1, 0.25, 0.25}, .ramp_texels = 0.5});
  // Middles at 1/8, 3/8, ...: opacities 1, 0, 0, 0.
  EXPECT_EQ(opacity_at(texture, {0.125, 0.3, 0.7}), 1);
  EXPECT_EQ(opacity_at(texture, {7.125, -2.7, 0.7}), 1);
  EXPECT_EQ(opacity_at(texture, {0.25, 0.5, 0.5}), 0.5);
  EXPECT_EQ(opacity_at(texture, {0, 0.5, 0.5}), 0.5);  // between the first and the last
  texture.is_periodic = false;
  EXPECT_EQ(opacity_at(texture, {0, 0.5, 0.5}), 1);
  EXPECT_EQ(opacity_at(texture, {-5, 0.5, 0.5}), 1);
  EXPECT_EQ(opacity_at(texture, {5, 0.5, 0.5}), 0);
  // One texel along t and r: nothing changes there.
  EXPECT_EQ(opacity_gradient(texture, {0.25, 0.5, 0.5}),
            Vec3(-1 / 0.375, 0, 0));  // from the first to the second gap
}

TEST(VolumeTexture, RefusesWhatItCannotHold) {
  EXPECT_THAT(
      [] {
        make_volume(ball, {.size = {0, 4, 4}});
      },
      ThrowsMessage<OptionError>(HasSubstr("0 texels along an axis")));
  EXPECT_THAT(
      [] {
        make_volume(ball, {.size = {1 << 15, 1 << 15, 1 << 10}});
      },
      ThrowsMessage<OptionError>(HasSubstr("more than the 2147483648")));
  EXPECT_THAT(
      [] {
        make_volume(ball, {.extent = {1, 1, 0}});
      },
      ThrowsMessage<OptionError>(HasSubstr("above 0")));
  const auto hole = [](const Vec3& point) {
    return point.x() > 0.5 && point.y() > 0.5 ? std::numeric_limits<double>::quiet_NaN() : 1;
  };
  EXPECT_THAT(
      [&] {
        make_volume(hole, {.size = {4, 4, 4}});
      },
      ThrowsMessage<InputError>(HasSubstr("not a number at texel (2, 2, 0)")));
  VolumeTexture texture = ball_texture(4);
  texture.opacity = {{4, 4, 3}, 0};
  EXPECT_THAT([&] { validate(texture, "ball"); },
              ThrowsMessage<InputError>(
                  HasSubstr("ball: a volume texture of 4 x 4 x 4 texels has opacities of 4 x 4 x 3")));
}

// Distances that are no larger than they should be: rays step by them.
TEST(ProceduralVolume, ChangesNoFasterThanPlacesDo) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(0, 1);
  for (const ProceduralVolume& volume :
       {chain_mail(), weave(), bubbles({.time = 0.3}), bushes(), bushes({.growth = 0.4})}) {
    for (int n = 0; n < 2000; ++n) {
      const Vec3 a = Vec3(number(random), number(random), number(random)).cwiseProduct(volume.extent);
      const Vec3 b = a + 0.02 * Vec3(number(random) - 0.5, number(random) - 0.5, number(random) - 0.5);
      // Threads bend: distances to them are those across, as if they were straight.
      EXPECT_LE(std::abs(volume.inside(a) - volume.inside(b)), 1.25 * (a - b).norm());
    }
  }
}

TEST(ProceduralVolume, GoesOnAcrossPeriods) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> number(0, 1);
  for (const ProceduralVolume& volume : {chain_mail(), weave(), bark(), bubbles({.time = 7.9}), bushes()}) {
    for (int n = 0; n < 500; ++n) {
      const Vec3 a = Vec3(number(random), number(random), number(random)).cwiseProduct(volume.extent);
      for (int axis = 0; axis < 2; ++axis) {
        const Vec3 b = a + volume.extent[axis] * Vec3::Unit(axis);
        EXPECT_NEAR(volume.inside(a), volume.inside(b), 1e-9);  // rounding of places of a few units
      }
    }
  }
}

// What has grown stays, and there is more of it; nothing is apart from what stands on the ground.
TEST(ProceduralVolume, BushesGrow) {
  std::vector<std::uint8_t> before;
  std::size_t matter_before = 0;
  for (const double growth : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    const VolumeTexture texture = make_volume(bushes({.bushes = 1, .growth = growth}), 48);
    const std::vector<std::uint8_t> opacity = texture.opacity.to_dense();
    std::vector<std::uint8_t> now(opacity.size());
    std::size_t matter = 0, lost = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i] = opacity[i] >= 128;
      matter += now[i];
      lost += !before.empty() && before[i] > now[i];
    }
    EXPECT_EQ(matter == 0, growth == 0);
    EXPECT_GE(matter, matter_before);
    EXPECT_EQ(lost, 0u);
    before = now;
    matter_before = matter;
  }
  EXPECT_THROW(bushes({.bushes = 0}), OptionError);
  EXPECT_THROW(bushes({.growth = 1.5}), OptionError);
}

// A ring is one body, and bodies of neighbours don't touch.
TEST(ProceduralVolume, RingsAreApart) {
  const ProceduralVolume volume = chain_mail({.wire = 0.22});
  // In the middle between a ring and the nearest one of the next row: wires' middles are 0.46 apart.
  const double middle = volume.extent.z() / 2;
  double deepest = -1;
  for (int n = 0; n < 64; ++n) {
    for (int m = 0; m < 64; ++m) {
      const double a = 2 * std::numbers::pi * n / 64, b = 2 * std::numbers::pi * m / 64;
      const auto on_ring = [&](const Vec3& center, double lean, double angle) {
        return Vec3(center + Vec3(std::cos(lean) * std::cos(angle), std::sin(angle),
                                  std::sin(lean) * std::cos(angle)));
      };
      const Vec3 p = on_ring({0, 0, middle}, 0.5, a), q = on_ring({0.65, 1.3, middle}, -0.5, b);
      // Both are in the middle of a wire.
      EXPECT_NEAR(volume.inside(p), 0.22, 1e-12);
      EXPECT_NEAR(volume.inside(q), 0.22, 1e-12);
      deepest = std::max(deepest, 0.22 - (p - q).norm() / 2);
    }
  }
  EXPECT_LT(deepest, 0);
  EXPECT_THROW(chain_mail({.wire = 0.3}), OptionError);
  EXPECT_THROW(weave({.thread = 0}), OptionError);
  EXPECT_THROW(bark({.cracks = 2}), OptionError);
  EXPECT_THROW(bubbles({.bubbles = 0}), OptionError);
}

}  // namespace
