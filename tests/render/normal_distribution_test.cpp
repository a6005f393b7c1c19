#include "cancelling.h"
#include "displaced_planes.h"
#include <recede/geometry/error.h>
#include <recede/render/hemisphere_square.h>
#include <recede/render/normal_distribution.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numeric>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

std::size_t bin_of(const Vec3& normal, int bins) {
  const Vec2 place = bins * hemisphere_to_square(normal);
  return static_cast<std::size_t>(std::min(static_cast<int>(place.x()), bins - 1) * bins +
                                  std::min(static_cast<int>(place.y()), bins - 1));
}

void expect_distributions(const VisibleNormals& normals) {
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    const auto shares = normals.slice(slice);
    EXPECT_NEAR(std::accumulate(shares.begin(), shares.end(), 0.0), 1, 1e-12) << slice;
  }
}

TEST(VisibleNormals, SumToOneForEveryView) {
  const DisplacementMap map = test::random_waves(1, 1.4);
  const DisplacedPlane plane(map, {32, 32});
  for (const bool smooth : {false, true}) {
    const VisibleNormals normals = sample_visible_normals(plane, {.samples = 3000, .smooth = smooth});
    EXPECT_EQ(normals.shares.size(), 32u * 31 * 31);
    EXPECT_EQ(normals.missed, 0u);
    EXPECT_NO_THROW(validate(normals));
    expect_distributions(normals);
  }
  expect_distributions(sample_visible_normals(plane, {.bins = 8, .views = 5, .azimuths = 3, .samples = 500}));
}

TEST(VisibleNormals, OfAFlatPlaneAreOneBin) {
  const DisplacementMap map(1, 1, {0.3F}, MapBorder::periodic);
  const VisibleNormals normals = sample_visible_normals(DisplacedPlane(map, {2, 1}), {.samples = 100});
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    EXPECT_EQ(normals.slice(slice)[15 * 31 + 15], 1) << slice;
    EXPECT_EQ(normals.noise[slice], 0) << slice;
  }
  EXPECT_EQ(normals.normal_of_bin(15 * 31 + 15), Vec3(0, 0, 1));
}

TEST(VisibleNormals, FromStraightAboveAreTheNormalsOfTheMap) {
  const DisplacementMap map = test::random_waves(4, 1.4);
  const DisplacedPlane plane(map, {32, 32});
  const VisibleNormals normals = sample_visible_normals(plane, {.views = 1, .azimuths = 2});
  for (int azimuth = 0; azimuth < 2; ++azimuth) {
    std::vector<double> own(normals.bin_count(), 0.0);
    test::for_places(plane, 1 << 20, [&](const Vec2& place, double) {
      const Vec3 normal = plane.normal_at(place.cwiseQuotient(plane.sides()));
      own[bin_of(test::turned(normal, -azimuth * k_pi), 31)] += 0x1p-20;
    });
    // These places have an error of their own, far less than that of the samples.
    const std::size_t slice = normals.slice_of(0, azimuth);
    EXPECT_LT(total_variation(normals.slice(slice), own), 2 * normals.noise[slice] + 1e-3);
    EXPECT_LT(normals.noise[slice], 0.01);
  }
}

TEST(VisibleNormals, OfRidgesFollowTheirProjectedAreasUntilTheirBacksAreHidden) {
  // Teeth along u: seven texels up by 1/7 of a height each, one down. Of a slope m, a view at angle a sees
  // width x (1 - m tan a), if other teeth don't hide it: as long as tan a is less than 1 / the steepest
  // slope.
  const DisplacementMap map(8, 1, {0, 1, 2, 3, 4, 5, 6, 7}, MapBorder::periodic);
  const DisplacedPlane plane(map, {80, 10});  // slopes of 0.1 and -0.7
  const VisibleNormals normals =
      sample_visible_normals(plane, {.views = 45, .azimuths = 4, .samples = 20'000});
  const auto share = [&](int view, int azimuth, double slope) {
    const Vec3 normal = test::turned(Vec3(-slope, 0, 1).normalized(), -azimuth * k_pi / 2);
    return normals.slice(normals.slice_of(view, azimuth))[bin_of(normal, 31)];
  };
  for (int view = 0; view <= 45; ++view) {
    const double tangent = std::tan(normals.view_angle(view));
    // From where u grows to (azimuth 0) the steep faces look to the viewer and hide none; long ones turn
    // away. Shares are of areas that grow together, so that they sum to 1 in any case.
    const double steep = std::min(1.0, (1 + 0.7 * tangent) / 8);
    EXPECT_NEAR(share(view, 0, -0.7), steep, 2e-3) << view;
    EXPECT_NEAR(share(view, 0, 0.1), 1 - steep, 2e-3) << view;
    // From the other side they are hidden beyond the angle at which a ray runs along them.
    const double back = std::max(0.0, (1 - 0.7 * tangent) / 8);
    EXPECT_NEAR(share(view, 2, -0.7), back, 2e-3) << view;
    EXPECT_NEAR(share(view, 2, 0.1), 1 - back, 2e-3) << view;
    // Along the ridges nothing changes.
    EXPECT_NEAR(share(view, 1, -0.7), 0.125, 2e-3) << view;
    EXPECT_NEAR(share(view, 3, 0.1), 0.875, 2e-3) << view;
  }
}

TEST(VisibleNormals, OfASineWaveHaveTheShadowOfItsCrests) {
  // One wave along u with slopes up to 0.5 pi: from 32.5 degrees on crests hide what is behind.
  const int texels = 256;
  const DisplacementMap map =
      test::map_of(texels, [](double u, double) { return 0.25 * std::sin(2 * k_pi * u); });
  const DisplacedPlane plane(map, {1, 1});
  const VisibleNormals normals =
      sample_visible_normals(plane, {.bins = 15, .views = 12, .azimuths = 2, .samples = 60'000});
  int views_with_shadow = 0;
  for (int view = 0; view <= 12; ++view) {
    const double tangent = std::tan(normals.view_angle(view));
    std::vector<double> expected(normals.bin_count(), 0.0);
    const int steps = 100'000;
    double horizon = -1e300, hidden = 0, sum = 0;
    // The viewer stands where x grows to. A ray to there goes up by 1 / tan a, so a place is seen when no
    // place farther on has a greater h tan a - x. The first of two periods only makes the horizon.
    for (int i = 2 * steps - 1; i >= 0; --i) {
      const double x = (i + 0.5) / steps;
      const Vec2 uv(x - std::floor(x), 0.5);
      const double slope = map.derivative_at(uv).x(), level = map.height_at(uv) * tangent - x;
      const bool seen = level > horizon;
      horizon = std::max(horizon, level);
      if (i >= steps) continue;
      const double share = seen ? (1 - slope * tangent) / steps : 0;
      hidden += seen ? 0 : 1.0 / steps;
      sum += share;
      expected[bin_of(Vec3(-slope, 0, 1).normalized(), 15)] += share;
    }
    if (hidden > 0) ++views_with_shadow;
    EXPECT_NEAR(sum, 1, 1e-3) << "what is seen covers the picture";
    EXPECT_LT(total_variation(normals.slice(normals.slice_of(view, 0)), expected), 4e-3) << view;
    EXPECT_EQ(hidden > 0.001, tangent * 0.5 * k_pi > 1) << view;
  }
  EXPECT_GE(views_with_shadow, 7);
}

TEST(VisibleNormals, ForViewsInBetweenAreMixed) {
  const ViewMix front = mix_for_view(9, 1, 0);
  EXPECT_EQ(front.count, 1);
  EXPECT_EQ(front.slices[0], 0u);
  // Nine views are at 5, 15, ... 85 degrees.
  const auto expect_mix = [](double degrees, std::size_t slice, double next_weight) {
    const ViewMix mix = mix_for_view(9, 1, degrees * k_pi / 180, 1.3);
    double weight_of_next = 0, sum = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k) {
      EXPECT_TRUE(mix.slices[k] == slice || mix.slices[k] == slice + 1) << degrees;
      if (mix.slices[k] == slice + 1) weight_of_next += mix.weights[k];
      sum += mix.weights[k];
    }
    EXPECT_NEAR(weight_of_next, next_weight, 1e-12) << degrees;
    EXPECT_NEAR(sum, 1, 1e-15);
  };
  expect_mix(2, 0, 0.4);
  expect_mix(5, 0, 1);
  expect_mix(12, 1, 0.7);
  expect_mix(84, 8, 0.9);
  expect_mix(88, 8, 1);
  expect_mix(150, 8, 1);
  // Four azimuths: 315 degrees lie between the last and the first; -45 is the same.
  for (const double azimuth : {1.75 * k_pi, -0.25 * k_pi}) {
    const ViewMix around = mix_for_view(9, 4, 15 * k_pi / 180, azimuth);
    double at_last = 0, at_first = 0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(around.count); ++k) {
      if (around.slices[k] == 2 * 4 + 3) at_last += around.weights[k];
      if (around.slices[k] == 2 * 4) at_first += around.weights[k];
    }
    EXPECT_NEAR(at_last, 0.5, 1e-12);
    EXPECT_NEAR(at_first, 0.5, 1e-12);
  }
}

TEST(VisibleNormals, AreTheSameForAnyNumberOfThreads) {
  const DisplacementMap map = test::random_waves(1, 1.4);
  const DisplacedPlane plane(map, {32, 32});
  const VisibleNormalsOptions options{.bins = 15, .views = 4, .samples = 20'000, .smooth = true};
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return sample_visible_normals(plane, options);
  };
  const VisibleNormals one = with_threads(1), four = with_threads(4);
  EXPECT_EQ(one.shares, four.shares);
  EXPECT_EQ(one.noise, four.noise);
}

TEST(VisibleNormals, TellTheirNoise) {
  // Twice the said noise holds the distance to sixteen times as many samples.
  const DisplacementMap map = test::random_waves(6, 1.4);
  const DisplacedPlane plane(map, {32, 32});
  const VisibleNormals few = sample_visible_normals(plane, {.views = 6, .samples = 4096});
  const VisibleNormals many = sample_visible_normals(plane, {.views = 6, .samples = 65'536});
  for (std::size_t slice = 0; slice < few.slice_count(); ++slice) {
    const double error = total_variation(few.slice(slice), many.slice(slice));
    EXPECT_LT(error, 2 * few.noise[slice]) << slice;
    EXPECT_GT(error, few.noise[slice] / 2) << slice;
    EXPECT_LT(many.noise[slice], few.noise[slice] / 2) << slice;
  }
}

TEST(VisibleNormals, RefuseWhatCantBeSampled) {
  const DisplacementMap map(2, 2, {0, 1, 1, 0}, MapBorder::periodic);
  const DisplacedPlane plane(map, {1, 1});
  for (const int bad : {0, -3, 1025}) {
    EXPECT_THROW(sample_visible_normals(plane, {.bins = bad}), OptionError);
    EXPECT_THROW(sample_visible_normals(plane, {.views = bad}), OptionError);
    EXPECT_THROW(sample_visible_normals(plane, {.azimuths = bad}), OptionError);
  }
  EXPECT_THROW(sample_visible_normals(plane, {.samples = 1}), OptionError);
  VisibleNormals normals = sample_visible_normals(plane, {.bins = 3, .views = 2, .samples = 10});
  normals.shares[4] = -0.1;
  EXPECT_THROW(validate(normals), InputError);
  normals.shares[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(validate(normals), InputError);
  normals.shares[4] = 2;
  EXPECT_THROW(validate(normals), InputError);
  normals.shares.pop_back();
  EXPECT_THROW(validate(normals), InputError);
}

TEST(VisibleNormals, StopWhenAsked) {
  const DisplacementMap map(1, 1, {0}, MapBorder::periodic);
  test::Cancelling cancelling;
  EXPECT_THROW(sample_visible_normals(DisplacedPlane(map, {1, 1}), {}, &cancelling), Cancelled);
}

}  // namespace
}  // namespace recede
