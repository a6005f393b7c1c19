#include "displaced_planes.h"
#include "input_errors.h"
#include "sanitized.h"
#include "temp_folder.h"
#include "tiled_surfaces.h"
#include <recede/geometry/error.h>
#include <recede/render/appearance.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

AppearanceOptions quick(int samples = 8192) {
  AppearanceOptions options;
  options.normals.samples = samples;
  options.shading_samples = 256;
  return options;
}

TEST(Appearance, OfAFlatMapIsThatOfAFlatSurface) {
  const DisplacementMap flat(4, 4, std::vector<float>(16, 2.0f), MapBorder::periodic);
  const auto appearance = make_appearance(test::tiled_square(1), flat, quick());
  EXPECT_EQ(appearance->wavelength(), 0);
  const Vec3 viewer = test::direction_at(1, 0.4), light = test::direction_at(0.7, 2);
  EXPECT_LT((appearance->mean_normal(viewer) - Vec3::UnitZ()).norm(), 1e-9);
  // Of 31 angles, linear in between: a quarter of the square of half a step.
  EXPECT_NEAR(appearance->unshadowed(viewer, light), std::cos(0.7), 4e-4);
  EXPECT_EQ(appearance->unshadowed(viewer, {0.6, 0, -0.8}), 0);
  EXPECT_LT((appearance->bump_normal(Vec3::UnitZ(), viewer) - Vec3::UnitZ()).norm(), 1e-9);
}

TEST(Appearance, OfAFlatMapHasNoShadowsAndPassesNothingOn) {
  const DisplacementMap flat(4, 4, std::vector<float>(16, 2.0f), MapBorder::periodic);
  const auto appearance = make_appearance(test::tiled_square(1), flat, quick());
  const Rgb albedo(0.9f, 0.5f, 0);
  for (const double angle : {0.0, 0.7, 1.3}) {
    for (const double displaced : {0.0, 0.3, 1.0}) {
      const Rgb shading = appearance->shading(albedo, test::direction_at(1, 0.4),
                                              test::direction_at(angle, 2), true, displaced);
      // Of the cosine over itself, both by tables of normals in bins.
      EXPECT_LT((shading - Rgb::Ones()).norm(), 1e-6f) << shading.transpose();
    }
  }
  EXPECT_EQ(appearance->shading(albedo, {0, 0, 1}, {0.6, 0, -0.8}, true), Rgb(Rgb::Zero()));
}

TEST(Appearance, ShadesLightThatComesLow) {
  const auto appearance = make_appearance(test::tiled_square(1), test::random_waves(2, 0.5), quick());
  const Rgb white = Rgb::Ones();
  const Vec3 viewer(0, 0, 1);
  const auto at = [&](double angle, bool passed_on, double displaced) {
    return appearance->shading(white, viewer, test::direction_at(angle, 0), passed_on, displaced).x();
  };
  EXPECT_NEAR(at(0, false, 0), 1, 0.02);  // from above nothing is in the shade, but for chance
  EXPECT_LT(at(1.3, false, 0), 0.8);
  EXPECT_LT(at(1.4, false, 0), at(1.1, false, 0));
  EXPECT_GT(at(0.5, true, 0), at(0.5, false, 0) + 0.02);
  // What is left to do for a surface that shades a part itself lies between all and nothing.
  EXPECT_GT(at(1.3, false, 0.5), at(1.3, false, 0));
  EXPECT_GT(at(1.3, false, 0.9), at(1.3, false, 0.5));
  EXPECT_EQ(at(1.3, false, 1), 1);
}

TEST(Appearance, LampsWithoutShadowsLightSlopesBeyondTheHorizon) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const DisplacementMap map = test::random_waves(1, 1.4 / 16);
  const auto appearance = make_appearance(test::tiled_square(1), map, quick(65'536));
  const DisplacedPlane plane(map, {2, 2}, PlaneNormals::smooth);
  for (const double view_angle : {0.4, 1.1}) {
    for (const Vec3& light : {Vec3(-0.9, 0.3, 0.2), Vec3(0.8, 0.3, -0.1), Vec3(-0.7, 0.7, -0.3)}) {
      const Vec3 unit = light.normalized();
      double sum = 0, count = 0;
      Vec3 normals = Vec3::Zero();
      test::for_seen_normals(plane, view_angle, 1 << 16,
                             [&](const Vec3& normal, double, const DisplacedPlane::Hit&) {
                               sum += std::max(0.0, normal.dot(unit));
                               normals += normal;
                               ++count;
                             });
      const Vec3 viewer = test::direction_at(view_angle, 0);
      // Bins of the square are 0.06 wide; the table's error on such waves is 0.2 % of full light.
      EXPECT_NEAR(appearance->unshadowed(viewer, unit), sum / count, 0.003);
      EXPECT_LT((appearance->mean_normal(viewer) - normals / count).norm(), 0.005);
    }
  }
}

TEST(Appearance, OfAMapThatEndsIsThatOfItsMirrorImages) {
  // A slope of 1 along u, at whose ends the border's texels go on.
  std::vector<float> heights;
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 64; ++x) heights.push_back(static_cast<float>(x) / 32);
  }
  const DisplacementMap ramp(64, 8, heights);
  AppearanceOptions options = quick(1 << 15);
  options.shading = false;
  const auto appearance = make_appearance(test::tiled_square(1), ramp, options);
  // From above half of the normals lean to one side, half to the other; all other views show more of those
  // that lean towards them, never others. Texels at the ends have half the slope or none.
  const VisibleNormals& normals = appearance->normals();
  double leaning = 0;
  for (std::size_t bin = 0; bin < normals.bin_count(); ++bin) {
    const Vec3 normal = normals.normal_of_bin(bin);
    if (std::abs(normal.z() - std::sqrt(0.5)) < 0.06) leaning += normals.slice(0)[bin];
  }
  EXPECT_NEAR(leaning, 62.0 / 64, 0.02);
  EXPECT_LT(appearance->mean_normal(Vec3::UnitZ()).head<2>().norm(), 0.01);
  EXPECT_GT(appearance->mean_normal(test::direction_at(1.2, 0.3)).dot(test::direction_at(k_pi / 2, 0.3)),
            0.2);
}

TEST(Appearance, OnlyTexelsThatTheSurfaceCoversCount) {
  // Rough on the left half of the map, flat on the right, which alone the surface has.
  const DisplacementMap rough = test::rough_ground(1, 0.2, 32);
  std::vector<float> heights;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) heights.push_back(x < 16 ? static_cast<float>(rough.texel(x, y)) : 0.1f);
  }
  PolygonSoup surface = test::tiled_square(1);
  for (Vec2& uv : surface.corner_uvs) uv.x() = 0.6 + 0.4 * uv.x();
  AppearanceOptions options = quick();
  options.shading = false;
  const auto appearance = make_appearance(surface, DisplacementMap(32, 32, heights), options);
  for (std::size_t slice = 0; slice < appearance->normals().slice_count(); ++slice)
    EXPECT_EQ(appearance->normals().slice(slice)[appearance->normals().bin_count() / 2], 1);
  EXPECT_EQ(appearance->wavelength(), 0);
  for (Vec2& uv : surface.corner_uvs) uv.x() += 2;
  EXPECT_THROW(make_appearance(surface, DisplacementMap(32, 32, heights), quick()), InputError);
}

TEST(Appearance, TakesSpikesAndWallsAndMapsOfOneTexel) {
  std::vector<float> spike(64 * 64, 0.0f);
  spike[100] = 2;  // 32 times as high as a texel is wide
  for (const DisplacementMap& map :
       {DisplacementMap(64, 64, spike, MapBorder::periodic), DisplacementMap(64, 64, spike),
        test::rough_ground(3, 2, 16), DisplacementMap(1, 1, {3}, MapBorder::periodic)}) {
    AppearanceOptions options = quick(2048);
    options.reflectance.light_angles = options.reflectance.light_azimuths = 8;
    const auto appearance = make_appearance(test::tiled_square(1), map, options);
    EXPECT_TRUE(std::isfinite(appearance->wavelength()));
    for (const double angle : {0.0, 0.8, 1.5, k_pi / 2}) {
      const Vec3 viewer = test::direction_at(angle, 1);
      EXPECT_TRUE(appearance->mean_normal(viewer).allFinite());
      const double value = appearance->unshadowed(viewer, test::direction_at(1, 0));
      EXPECT_TRUE(value >= 0 && value <= 1) << value;
      for (const double displaced : {0.0, 0.5}) {
        const Rgb shading =
            appearance->shading(Rgb::Constant(0.8f), viewer, test::direction_at(1, 0), true, displaced);
        EXPECT_TRUE(shading.allFinite() && shading.minCoeff() >= 0) << shading;
      }
      EXPECT_NEAR(appearance->bump_normal(Vec3::UnitZ(), viewer).norm(), 1, 1e-9);
    }
  }
}

TEST(Appearance, IsTheSameAfterWritingAndReading) {
  const test::TempFolder folder;
  const auto path = folder / "waves.appearance";
  const auto written = make_appearance(test::tiled_square(3), test::random_waves(4, 0.1), quick());
  write_appearance(path, *written);
  const auto read = read_appearance(path);
  EXPECT_EQ(read->normals().shares, written->normals().shares);
  EXPECT_EQ(read->stretch().sides, written->stretch().sides);
  EXPECT_EQ(read->stretch().spread, written->stretch().spread);
  EXPECT_EQ(read->wavelength(), written->wavelength());
  EXPECT_EQ(read->table().values, written->table().values);
  EXPECT_EQ(read->tables().bump_light->values, written->tables().bump_light->values);
  EXPECT_EQ(read->tables().shading->values, written->tables().shading->values);
  EXPECT_EQ(read->tables().shading->hits_again, written->tables().shading->hits_again);
}

TEST(Appearance, RefusesFilesThatArentOne) {
  const test::TempFolder folder;
  const auto path = folder / "waves.appearance";
  AppearanceOptions small = quick(64);
  small.normals.bins = small.normals.views = 3;
  small.reflectance.light_angles = small.reflectance.light_azimuths = 4;
  write_appearance(path, *make_appearance(test::tiled_square(3), test::random_waves(4, 0.1), small));
  const std::string bytes = read_whole_file(path);
  const auto refuses = [&](std::string changed) {
    write_file_atomically(path, changed);
    EXPECT_THROW(read_appearance(path), InputError);
  };
  constexpr std::size_t k_counts = 20, k_lengths = 48, k_shares = 96;
  refuses("");
  refuses(bytes.substr(0, 50));
  refuses(bytes.substr(0, bytes.size() - 1));
  refuses(bytes + "x");
  for (std::size_t count = 0; count < 7; ++count) {
    std::string changed = bytes;
    changed[k_counts + 4 * count + 3] = 1;  // millions
    refuses(changed);
  }
  for (std::size_t length = 0; length < 6; ++length) {
    std::string changed = bytes;
    changed[k_lengths + 8 * length + 7] = static_cast<char>(0xff);  // below 0, or no number
    refuses(changed);
  }
  std::string changed = bytes;
  changed[k_shares + 7] = static_cast<char>(0xbf);
  refuses(changed);
  changed = bytes;
  changed.back() = static_cast<char>(0xbf);  // a factor of light
  refuses(changed);
  write_file_atomically(path, bytes);
  EXPECT_NO_THROW(read_appearance(path));
}

TEST(Appearance, RefusesTablesThatCantBe) {
  const VisibleNormals flat{.bins = 1, .views = 1, .azimuths = 1, .shares = {1, 1}};
  EXPECT_NO_THROW(Appearance({.normals = flat}));
  EXPECT_THROW(Appearance({.stretch = {.sides = {0, 1}}, .normals = flat}), OptionError);
  EXPECT_THROW(Appearance({.stretch = {.sides = {1, NAN}}, .normals = flat}), OptionError);
  EXPECT_THROW(Appearance({.wavelength = -1, .normals = flat}), OptionError);
  EXPECT_THROW(Appearance({.wavelength = INFINITY, .normals = flat}), OptionError);
  EXPECT_THROW(Appearance({.normals = flat, .bump_light = ReflectanceTable{}}), InputError);
  EXPECT_THROW(Appearance({.normals = flat, .shading = ScatteringTable{}}), InputError);
}

}  // namespace
}  // namespace recede
