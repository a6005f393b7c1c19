#include "sanitized.h"
#include "temp_folder.h"
#include "traced_plane.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/scattering_table.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_degree = k_pi / 180;

TEST(ScatteringTable, OfAFlatPlaneIsTheCosineOfTheLight) {
  const DisplacementMap map(1, 1, {0}, MapBorder::periodic);
  const ScatteringTable table =
      make_scattering_table(DisplacedPlane(map, {1, 1}), {.views = 5, .samples = 64, .places = 3});
  for (const double view : {0.0, 0.4, 1.3}) {
    for (int row = 0; row <= 30; ++row) {
      const ScatteringTable::Series series = table.series(view, row * 3 * k_degree, 2);
      EXPECT_NEAR(series[0], std::cos(row * 3 * k_degree), 1e-12);
      for (std::size_t k = 1; k < series.size(); ++k) EXPECT_EQ(series[k], 0);
    }
  }
  EXPECT_EQ(table.hits_again, 0);
  EXPECT_EQ(table.series(0.3, 1.6, 0)[0], 0) << "below the horizon";
  EXPECT_EQ(table.series(Vec3(0, 0, 1), Vec3(1, 0, -0.01).normalized())[0], 0);
}

/// Both the direct light and the sums for two albedos, for views of up to 80 degrees and several lights.
void expect_agreement(const DisplacementMap& map, const Vec2& sides) {
  const DisplacedPlane plane(map, sides);
  const ScatteringTable table = make_scattering_table(plane);
  // On either side of the viewer and opposite; 75 degrees leaves next to nothing lit at the far side.
  const std::pair<double, double> lights[] = {{20, 1.2}, {45, 0}, {45, 2.7}, {60, 1.2}, {60, 2.7}, {75, 0.4}};
  for (const double view : {0.0, 45.0, 70.0, 80.0}) {
    for (const auto& [light, azimuth] : lights) {
      const test::TracedLight traced =
          test::trace_light(plane, view * k_degree, light * k_degree, azimuth, 30'000);
      const ScatteringTable::Series series = table.series(view * k_degree, light * k_degree, azimuth);
      for (const double albedo : {0.5, 0.8}) {
        const double expected = traced.sum(albedo);
        // 3 %, and the noise of 30 000 paths: a thousandth where little is lit.
        EXPECT_NEAR(table.sum(series, albedo), expected, 0.03 * expected + 0.001)
            << view << ' ' << light << ' ' << azimuth << ' ' << albedo;
      }
    }
  }
}

TEST(ScatteringTable, AgreesWithTracedPathsOnWaves) { expect_agreement(test::random_waves(1, 1.4), {8, 8}); }
TEST(ScatteringTable, AgreesWithTracedPathsInGrooves) { expect_agreement(test::groove(32), {1, 1}); }
TEST(ScatteringTable, AgreesWithTracedPathsOnRoundBumps) { expect_agreement(test::round_bumps(1), {6, 6}); }
TEST(ScatteringTable, AgreesWithTracedPathsWhereEveryTexelIsAtRandom) {
  expect_agreement(test::rough_ground(3, 0.7), {24, 24});
}
TEST(ScatteringTable, AgreesWithTracedPathsOnAMapOfMoreTexelsThanPlaces) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  expect_agreement(test::random_waves(1, 5.6, 128), {32, 32});
}

TEST(ScatteringTable, KnowsTheAzimuthsOfGrooves) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const DisplacementMap map = test::groove(32);
  const DisplacedPlane plane(map, {1, 1});
  const ScatteringTable table = make_scattering_table(plane, {.azimuths = 8});
  for (const double view_azimuth : {0.0, k_pi / 4, k_pi / 2}) {
    for (const double light_azimuth : {0.0, 2.0}) {
      const double view = 50 * k_degree, light = 51 * k_degree;
      const test::TracedLight traced =
          test::trace_light(plane, view, light, light_azimuth, 30'000, view_azimuth);
      const double expected = traced.sum(0.8);
      EXPECT_NEAR(table.sum(table.series(view, light, light_azimuth, view_azimuth), 0.8), expected,
                  0.03 * expected);
      const Rgb value = table.value(Rgb(0.8F, 0.8F, 0.8F), test::direction_at(view, view_azimuth),
                                    test::direction_at(light, view_azimuth + light_azimuth));
      EXPECT_NEAR(value.x(), expected, 0.03 * expected);
      EXPECT_EQ(value.x(), value.y());
    }
  }
}

TEST(ScatteringTable, IsThatOfARealSurface) {
  const DisplacementMap map = test::random_waves(1, 1.4);
  const ScatteringTable table = make_scattering_table(DisplacedPlane(map, {8, 8}));
  const ReflectanceTable with_light_between = reflectance_of(table, 1);
  const ReflectanceTable without = reflectance_of(table, 0);
  EXPECT_EQ(without.values[7], table.values[7 * 4]);
  const ReflectanceViolations all = measure_violations(with_light_between);
  // Nothing is lost and nothing won; a table without shadows has 1.1 here.
  EXPECT_NEAR(all.most_scattered, 1, 0.02);
  EXPECT_NEAR(all.most_gathered, 1, 0.02);
  EXPECT_LT(all.reciprocity_rms, 0.02);
  // Half of the light that meets this surface is lost when places are black to each other.
  EXPECT_LT(measure_violations(without).most_gathered, 0.9);
  EXPECT_NEAR(reflectance_of(table, 0.5).value(0.4, 0.9, 1) * 0.5, table.sum(table.series(0.4, 0.9, 1), 0.5),
              1e-12);
  EXPECT_THROW(reflectance_of(table, 1.01), OptionError);
  EXPECT_THROW(reflectance_of(ScatteringTable{}, 0.5), InputError);
}

TEST(ScatteringTable, ClosesItsSeriesWhateverTheLastOrderIs) {
  const DisplacementMap map = test::random_waves(1, 1.4);
  const DisplacedPlane plane(map, {8, 8});
  const ScatteringTable few = make_scattering_table(plane, {.views = 4, .samples = 1000, .orders = 4});
  const ScatteringTable many = make_scattering_table(plane, {.views = 4, .samples = 1000, .orders = 8});
  for (int i = 0; i < 60; ++i) {
    const ScatteringTable::Series a = few.series(0.02 * i, 1.3 - 0.02 * i, 0.1 * i);
    const ScatteringTable::Series b = many.series(0.02 * i, 1.3 - 0.02 * i, 0.1 * i);
    EXPECT_EQ(a[1], b[1]);
    EXPECT_GE(b[6], 0);
    // The rest after four orders is 1 % of the whole here, its estimate right to a half.
    EXPECT_NEAR(few.sum(a, 0.8), many.sum(b, 0.8), 0.006 * many.sum(b, 0.8));
  }
}

TEST(ScatteringTable, IsTheSameForAnyNumberOfThreads) {
  const DisplacementMap map = test::random_waves(1, 1.4, 16);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return make_scattering_table(DisplacedPlane(map, {4, 4}), {.views = 3,
                                                               .azimuths = 2,
                                                               .samples = 500,
                                                               .light_angles = 9,
                                                               .light_azimuths = 8,
                                                               .directions = 40});
  };
  EXPECT_EQ(with(1).values, with(2).values);
}

TEST(ScatteringTable, IsTheSameAfterWritingAndReading) {
  const test::TempFolder folder;
  const DisplacementMap map = test::random_waves(1, 1.4, 8);
  const ScatteringTable table = make_scattering_table(
      DisplacedPlane(map, {4, 4}),
      {.views = 3, .azimuths = 2, .samples = 100, .light_angles = 5, .light_azimuths = 6, .orders = 3});
  const auto path = folder.path() / "waves.table";
  write_scattering_table(path, table);
  const ScatteringTable back = read_scattering_table(path);
  EXPECT_EQ(back.views, 3);
  EXPECT_EQ(back.azimuths, 2);
  EXPECT_EQ(back.light_angles, 5);
  EXPECT_EQ(back.light_azimuths, 6);
  EXPECT_EQ(back.orders, 3);
  EXPECT_EQ(back.hits_again, table.hits_again);
  EXPECT_EQ(back.values, table.values);
  EXPECT_THROW(read_reflectance_table(path), InputError) << "another kind of table";
  write_reflectance_table(folder.path() / "one.table", reflectance_of(table, 0.5));
  EXPECT_THROW(read_scattering_table(folder.path() / "one.table"), InputError);

  const std::string bytes = read_whole_file(path);
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{40}, bytes.size() - 8}) {
    write_file_atomically(path, bytes.substr(0, size));
    EXPECT_THROW(read_scattering_table(path), InputError) << size;
  }
  for (const std::size_t at : {std::size_t{0}, std::size_t{22}, std::size_t{37}, std::size_t{48}}) {
    std::string wrong = bytes;
    wrong[at] = static_cast<char>(0xff);
    write_file_atomically(path, wrong);
    EXPECT_THROW(read_scattering_table(path), InputError) << at;
  }
  ScatteringTable no_values = table;
  no_values.values.pop_back();
  EXPECT_THROW(write_scattering_table(path, no_values), InputError);
}

TEST(ScatteringTable, RefusesOptionsOutOfRange) {
  const DisplacementMap map(1, 1, {0}, MapBorder::periodic);
  const DisplacedPlane plane(map, {1, 1});
  EXPECT_THROW(make_scattering_table(plane, {.views = 0}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.azimuths = 3}), OptionError) << "of 64 of the light";
  EXPECT_THROW(make_scattering_table(plane, {.samples = 1}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.light_angles = 1}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.orders = 9}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.directions = 5}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.places = 0}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.azimuths = 1024, .light_azimuths = 1024}), OptionError);
  EXPECT_THROW(make_scattering_table(plane, {.samples = 1 << 24}), OptionError);
}

}  // namespace
}  // namespace recede
