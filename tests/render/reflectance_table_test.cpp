#include "displaced_planes.h"
#include "temp_folder.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/render/detail/sample_stream.h>
#include <recede/render/reflectance_table.h>

#include <gtest/gtest.h>

#include <numeric>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_degree = k_pi / 180;

VisibleNormals flat_normals(int bins = 31) {
  const DisplacementMap map(1, 1, {0}, MapBorder::periodic);
  return sample_visible_normals(DisplacedPlane(map, {1, 1}), {.bins = bins, .views = 8, .samples = 10});
}

TEST(ReflectanceTable, OfAFlatPlaneIsTheCosineOfTheLight) {
  const ReflectanceTable table = make_reflectance_table(flat_normals());
  for (const double view : {0.0, 0.3, 1.2, 1.57}) {
    for (int row = 0; row <= 30; ++row) {
      const double light = row * 3 * k_degree;
      EXPECT_NEAR(table.value(view, light, 1.1), std::cos(light), 1e-14);
      // Between knots 3 degrees apart a cosine lies above the line by a 2900th at most.
      EXPECT_NEAR(table.value(view, std::min(light + 0.02, k_pi / 2), 4), std::cos(light + 0.02),
                  4e-4 + 0.02 * (row == 30));
    }
  }
  EXPECT_EQ(table.value(0.3, 1.6, 0), 0) << "below the horizon";
  EXPECT_EQ(table.value(Vec3(0, 0, 1), Vec3(1, 0, -0.01).normalized()), 0);
}

TEST(ReflectanceTable, OfAFlatPlaneHasAMirrorsLobe) {
  const ReflectanceTable reflection =
      make_reflectance_table(flat_normals(), {.lobe = FacetLobe::reflection, .exponent = 10});
  const ReflectanceTable half =
      make_reflectance_table(flat_normals(), {.lobe = FacetLobe::half_vector, .exponent = 10});
  // On knots: view 2 of 8 at 16.875 degrees, light 5 of 30 at 15, opposite the viewer and on its side.
  const double view = 1.5 * 11.25 * k_degree, light = 15 * k_degree;
  EXPECT_NEAR(reflection.value(view, light, k_pi), std::pow(std::cos(view - light), 10), 1e-12);
  EXPECT_NEAR(reflection.value(view, light, 0), std::pow(std::cos(view + light), 10), 1e-12);
  EXPECT_NEAR(half.value(view, light, k_pi), std::pow(std::cos((view - light) / 2), 10), 1e-12);
  EXPECT_NEAR(half.value(view, light, 0), std::pow(std::cos((view + light) / 2), 10), 1e-12);
}

TEST(ReflectanceTable, OfRidgesIsTheWeightedMeanOfTwoFaces) {
  // Slopes of +-0.5 in turn along u, of equal widths; no face is hidden up to 63 degrees. From azimuth 0 at
  // an angle a they have the shares (1 -+ 0.5 tan a) / 2.
  const DisplacementMap map(2, 1, {0, 1}, MapBorder::periodic);
  const VisibleNormals normals = sample_visible_normals(
      DisplacedPlane(map, {4, 1}), {.bins = 255, .views = 9, .azimuths = 2, .samples = 65'536});
  const ReflectanceTable table = make_reflectance_table(normals);
  const double view = 45 * k_degree;
  for (int row = 0; row <= 30; row += 5) {
    for (const int column : {0, 5, 32, 50}) {
      const Vec3 light = test::direction_at(row * 3 * k_degree, column * k_pi / 32);
      double expected = 0;
      for (const double slope : {-0.5, 0.5})
        expected += (1 - slope) / 2 * std::max(0.0, light.dot(Vec3(-slope, 0, 1).normalized()));
      // Bins are a hundredth wide, their middles up to half of that from the normals.
      EXPECT_NEAR(table.value(view, row * 3 * k_degree, column * k_pi / 32), expected, 6e-3);
    }
  }
}

TEST(ReflectanceTable, TakesVectorsInTheFrameOfTheSurface) {
  const DisplacementMap map = test::random_waves(8, 2, 16, 4);
  const VisibleNormals normals =
      sample_visible_normals(DisplacedPlane(map, {16, 16}), {.views = 6, .azimuths = 4, .samples = 2000});
  const ReflectanceTable table = make_reflectance_table(normals);
  const double view = 40 * k_degree, light = 70 * k_degree;
  for (const double azimuth : {0.0, 1.0, 3.0, 6.0}) {
    EXPECT_NEAR(table.value(test::direction_at(view, azimuth), test::direction_at(light, azimuth + 0.8)),
                table.value(view, light, 0.8, azimuth), 1e-12);
  }
}

TEST(ReflectanceTable, GathersNoMoreThanThereIsAndTellsItsViolations) {
  const ReflectanceViolations flat = measure_violations(make_reflectance_table(flat_normals()));
  EXPECT_LT(flat.reciprocity_max, 1e-12);
  // The trapezoidal rule on 3 degrees errs by some 1e-3.
  EXPECT_NEAR(flat.most_gathered, 1, 1e-3);
  EXPECT_NEAR(flat.most_scattered, 1, 1e-3);

  const DisplacementMap map = test::random_waves(1, 1.4);
  const VisibleNormals normals = sample_visible_normals(DisplacedPlane(map, {32, 32}), {.samples = 20'000});
  const ReflectanceViolations waves = measure_violations(make_reflectance_table(normals));
  EXPECT_LT(waves.most_gathered, 1);
  EXPECT_GT(waves.most_scattered, 1) << "light from aside that crests would take from each other";
  EXPECT_GT(waves.reciprocity_rms, 0.001);
  EXPECT_LT(waves.reciprocity_rms, 0.2);
  EXPECT_GT(waves.reciprocity_max, waves.reciprocity_rms);
}

/// Cells of equal solid angle, as many as `side` squared.
std::size_t cell_of(const Vec3& direction, int side) {
  double turns = std::atan2(direction.y(), direction.x()) / (2 * k_pi);
  turns -= std::floor(turns);
  const int row = std::min(static_cast<int>(direction.z() * side), side - 1);
  return static_cast<std::size_t>(row * side + std::min(static_cast<int>(turns * side), side - 1));
}

TEST(ReflectanceSampler, DrawsDirectionsWithTheDensityThatItSays) {
  const DisplacementMap map = test::random_waves(8, 2, 16, 4);
  const VisibleNormals normals =
      sample_visible_normals(DisplacedPlane(map, {16, 16}), {.views = 6, .azimuths = 4, .samples = 4000});
  for (const FacetLobe lobe : {FacetLobe::diffuse, FacetLobe::half_vector}) {
    const ReflectanceSampler sampler(make_reflectance_table(normals, {.lobe = lobe}));
    for (const Vec3& viewer :
         {test::direction_at(0, 0), test::direction_at(0.7, 2), test::direction_at(1.5, 5)}) {
      constexpr int k_side = 12, k_fine = 40, k_draws = 200'000;
      std::vector<double> expected(k_side * k_side, 0.0), drawn(k_side * k_side, 0.0);
      for (int i = 0; i < k_side * k_fine; ++i) {
        for (int j = 0; j < k_side * k_fine; ++j) {
          const double height = (i + 0.5) / (k_side * k_fine), level = std::sqrt(1 - height * height);
          const double azimuth = (j + 0.5) / (k_side * k_fine) * 2 * k_pi;
          const Vec3 light(level * std::cos(azimuth), level * std::sin(azimuth), height);
          expected[static_cast<std::size_t>(i / k_fine * k_side + j / k_fine)] +=
              sampler.density(viewer, light) * 2 * k_pi / (k_side * k_side * k_fine * k_fine);
        }
      }
      // The middles of a fine grid miss the steps between cells of the table a little.
      EXPECT_NEAR(std::accumulate(expected.begin(), expected.end(), 0.0), 1, 2e-3);
      std::mt19937 random(3);
      std::uniform_real_distribution<double> number(0, 1);
      for (int i = 0; i < k_draws; ++i) {
        const double x = number(random), y = number(random);
        const auto sample = sampler.sample(viewer, {x, y});
        ASSERT_NEAR(sample.toward_light.norm(), 1, 1e-12);
        ASSERT_NEAR(sample.density, sampler.density(viewer, sample.toward_light), 1e-9 * sample.density);
        drawn[cell_of(sample.toward_light, k_side)] += 1;
      }
      double chi_square = 0;
      int degrees = -1;
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        const double count = expected[i] * k_draws;
        if (count < 5) continue;
        chi_square += (drawn[i] - count) * (drawn[i] - count) / count;
        ++degrees;
      }
      // Mean d, variance 2 d: five standard deviations, with the error of the grid beside them.
      EXPECT_LT(chi_square, degrees + 5 * std::sqrt(2.0 * degrees)) << degrees;
      EXPECT_GT(degrees, 20);
    }
  }
}

TEST(ReflectanceSampler, FindsTheEnergyOfATableWithLittleNoise) {
  const DisplacementMap map = test::random_waves(1, 1.4);
  const ReflectanceTable table = make_reflectance_table(
      sample_visible_normals(DisplacedPlane(map, {32, 32}), {.views = 8, .samples = 8000}));
  const ReflectanceSampler sampler(table);
  const Vec3 viewer = test::direction_at(1.1, 0.4);
  double sum = 0, even_sum = 0;
  constexpr int k_count = 1 << 14;
  for (int i = 0; i < k_count; ++i) {
    detail::SampleStream stream(1, 2, static_cast<std::uint32_t>(i));
    const Vec2 random = stream.next_pair();
    const auto sample = sampler.sample(viewer, random);
    const double weight = table.value(viewer, sample.toward_light) / sample.density / k_pi;
    sum += weight / k_count;
    // Value over density is the same everywhere but for the bend of the table within its cells.
    ASSERT_NEAR(weight, 1, 0.35);
    const double level = std::sqrt(1 - random.x() * random.x());
    const Vec3 even(level * std::cos(2 * k_pi * random.y()), level * std::sin(2 * k_pi * random.y()),
                    random.x());
    even_sum += 2 * table.value(viewer, even) / k_count;
  }
  EXPECT_NEAR(sum, even_sum, 2e-3);
}

TEST(ReflectanceSampler, DrawsNothingFromABlackTable) {
  ReflectanceTable table = make_reflectance_table(flat_normals());
  std::fill(table.values.begin(), table.values.end(), 0.0);
  const ReflectanceSampler sampler(table);
  EXPECT_EQ(sampler.sample({0, 0, 1}, {0.3, 0.4}).density, 0);
  EXPECT_EQ(sampler.density({0, 0, 1}, {0, 0, 1}), 0);
}

TEST(ReflectanceTable, IsTheSameAfterWritingAndReading) {
  const test::TempFolder folder;
  const DisplacementMap map = test::random_waves(1, 1.4);
  const ReflectanceTable table =
      make_reflectance_table(sample_visible_normals(DisplacedPlane(map, {32, 32}),
                                                    {.bins = 9, .views = 3, .azimuths = 2, .samples = 500}),
                             {.light_angles = 5, .light_azimuths = 7});
  const auto path = folder.path() / "waves.table";
  write_reflectance_table(path, table);
  const ReflectanceTable back = read_reflectance_table(path);
  EXPECT_EQ(back.views, 3);
  EXPECT_EQ(back.azimuths, 2);
  EXPECT_EQ(back.light_angles, 5);
  EXPECT_EQ(back.light_azimuths, 7);
  EXPECT_EQ(back.values, table.values);

  const std::string bytes = read_whole_file(path);
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, std::size_t{30}, bytes.size() - 1}) {
    write_file_atomically(path, bytes.substr(0, size));
    EXPECT_THROW(read_reflectance_table(path), InputError) << size;
  }
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{19}, std::size_t{22}, std::size_t{24}, std::size_t{29}}) {
    std::string wrong = bytes;
    wrong[at] = static_cast<char>(0xff);
    write_file_atomically(path, wrong);
    EXPECT_THROW(read_reflectance_table(path), InputError) << at;
  }
  std::string not_finite = bytes;
  not_finite.replace(bytes.size() - 8, 8, std::string("\0\0\0\0\0\0\xf8\x7f", 8));
  write_file_atomically(path, not_finite);
  EXPECT_THROW(read_reflectance_table(path), InputError);
  EXPECT_THROW(read_reflectance_table(folder.path() / "none"), InputError);
}

TEST(ReflectanceTable, RefusesOptionsOutOfRange) {
  const VisibleNormals normals = flat_normals(3);
  EXPECT_THROW(make_reflectance_table(normals, {.light_angles = 1}), OptionError);
  EXPECT_THROW(make_reflectance_table(normals, {.light_angles = 1025}), OptionError);
  EXPECT_THROW(make_reflectance_table(normals, {.light_azimuths = 0}), OptionError);
  EXPECT_THROW(make_reflectance_table(normals, {.lobe = FacetLobe::reflection, .exponent = 0}), OptionError);
  EXPECT_THROW(make_reflectance_table({}), InputError);
  const ReflectanceTable table = make_reflectance_table(normals);
  EXPECT_THROW(measure_violations(table, 0), OptionError);
  EXPECT_THROW(measure_violations(table, 1.6), OptionError);
  EXPECT_THROW(ReflectanceSampler(ReflectanceTable{}), InputError);
}

}  // namespace
}  // namespace recede
