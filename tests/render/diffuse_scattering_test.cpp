#include "traced_plane.h"
#include <recede/geometry/error.h>
#include <recede/render/diffuse_scattering.h>
#include <recede/render/virtual_goniometer.h>

#include <gtest/gtest.h>

#include <numeric>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double mean_radiance(const ScatteredLight& light, double albedo, int last) {
  double sum = 0;
  for (std::size_t place = 0; place < light.orders[0].size(); ++place)
    sum += albedo * light.irradiance(place, albedo, last) / static_cast<double>(light.orders[0].size());
  return sum;
}

TEST(DiffuseScattering, SendsOutAllOfAnEvenSkyWhenNothingIsAbsorbed) {
  const DisplacementMap maps[] = {test::groove(16), test::rough_ground(3, 2, 10),
                                  test::random_waves(2, 1.4, 16)};
  for (const DisplacementMap& map : maps) {
    const DisplacedPlane plane(map, {1.0 * map.columns(), 1.0 * map.rows()});
    // Few directions are as good as many: weights sum to 1.
    for (const int directions : {20, 128}) {
      const DiffuseTransport transport(compute_visibility(plane, {.directions = directions}));
      const ScatteredLight light = scatter_light(transport, transport.sky(), 60);
      for (std::size_t place = 0; place < transport.place_count(); ++place)
        EXPECT_NEAR(light.irradiance(place, 1), 1, 1e-9) << "closed by a mean after 60 orders";
      // Whatever the last order is, the mean over the plane comes out.
      for (const int orders : {1, 2, 5}) {
        EXPECT_NEAR(mean_radiance(scatter_light(transport, transport.sky(), orders), 1, 0), 1, 1e-12);
      }
    }
  }
}

TEST(DiffuseScattering, HasTheNumbersOfTheGrooveUnderAnEvenSky) {
  const DisplacementMap map = test::groove(32);
  const DiffuseTransport transport(compute_visibility(DisplacedPlane(map, {1, 1}), {.directions = 100}));
  const ScatteredLight light = scatter_light(transport, transport.sky(), 5);
  // One scattering, two, all: measured with 32 texels by another program, to a hundredth.
  EXPECT_NEAR(mean_radiance(light, 0.5, 1), 0.361, 0.01);
  EXPECT_NEAR(mean_radiance(light, 0.5, 2), 0.408, 0.01);
  EXPECT_NEAR(mean_radiance(light, 0.5, 0), 0.417, 0.01);
  // The first is the albedo times sin(45 degrees).
  EXPECT_NEAR(mean_radiance(light, 0.8, 1), 0.8 * std::sqrt(0.5), 0.003);
  EXPECT_NEAR(mean_radiance(light, 0.8, 1), 0.578, 0.013);
  EXPECT_NEAR(mean_radiance(light, 0.8, 2), 0.699, 0.01);
  EXPECT_NEAR(mean_radiance(light, 0.8, 0), 0.740, 0.01);
}

TEST(DiffuseScattering, ShadowsTheGrooveUpToTheLine) {
  // Light across the groove at 30 degrees of elevation: (1 - tan e) / (1 + tan e) of the lit facet is dark.
  const DisplacementMap map = test::groove(512);
  const DisplacedPlane plane(map, {1, 1});
  const HeightFieldVisibility visibility = compute_visibility(plane, {.directions = 6, .rows = 1});
  const Vec3 light = test::direction_at(60 * k_pi / 180, 0);
  const std::vector<double> lit = direct_light(
      visibility, light, [&](std::size_t place) { return is_open(plane, visibility, place, light); });
  std::size_t facing = 0, dark = 0;
  for (std::size_t place = 0; place < lit.size(); ++place) {
    if (visibility.normals[place].dot(light) <= 0) {
      EXPECT_EQ(lit[place], 0);
      continue;
    }
    ++facing;
    dark += lit[place] == 0;
    if (lit[place] > 0) {
      EXPECT_NEAR(lit[place], std::cos(15 * k_pi / 180), 1e-6);
    }
  }
  EXPECT_EQ(facing, 256U);
  EXPECT_NEAR(static_cast<double>(dark) / 256, 0.268, 1.0 / 256);
}

TEST(DiffuseScattering, LetsTheSkyBeUneven) {
  const DisplacementMap flat(2, 2, {1, 1, 1, 1}, MapBorder::periodic);
  const DiffuseTransport on_flat(compute_visibility(DisplacedPlane(flat, {1, 1}), {.directions = 1000}));
  for (const double value : on_flat.sky_light([](const Vec3& d) { return d.z(); }))
    EXPECT_NEAR(value, 2.0 / 3, 1e-5) << "the mean of cos^2 over that of cos";
  EXPECT_EQ(on_flat.hits_again(3), 0);

  const DisplacementMap map = test::random_waves(2, 1.4, 16);
  const DiffuseTransport transport(compute_visibility(DisplacedPlane(map, {4, 4})));
  const std::vector<double> even = transport.sky_light([](const Vec3&) { return 1.0; });
  for (std::size_t place = 0; place < even.size(); ++place)
    EXPECT_NEAR(even[place], transport.sky()[place], 1e-6) << "weights are floats";
  // Valleys are darker than crests.
  const HeightFieldVisibility visibility = compute_visibility(DisplacedPlane(map, {4, 4}));
  double low = 0, high = 0;
  int lows = 0, highs = 0;
  for (std::size_t place = 0; place < even.size(); ++place) {
    const bool is_high = visibility.heights[place] > 0;
    (is_high ? high : low) += even[place];
    ++(is_high ? highs : lows);
  }
  EXPECT_GT(high / highs, low / lows + 0.1);
}

TEST(DiffuseScattering, GathersLanesAsIfEachWereAlone) {
  const DisplacementMap map = test::rough_ground(5, 2, 7);
  const DiffuseTransport transport(compute_visibility(DisplacedPlane(map, {7, 7})));
  const std::size_t places = transport.place_count();
  std::vector<double> both(2 * places), first(places), second(places), out(2 * places), alone(places);
  for (std::size_t i = 0; i < places; ++i) {
    both[2 * i] = first[i] = 1.0 / static_cast<double>(i + 1);
    both[2 * i + 1] = second[i] = static_cast<double>(i % 5);
  }
  transport.gather(both, 2, out);
  transport.gather(first, 1, alone);
  for (std::size_t i = 0; i < places; ++i) EXPECT_EQ(out[2 * i], alone[i]);
  transport.gather(second, 1, alone);
  for (std::size_t i = 0; i < places; ++i) EXPECT_EQ(out[2 * i + 1], alone[i]);
}

TEST(DiffuseScattering, ColoursWhiteFacetsBesideRedOnes) {
  // In a groove each facet sees only those that fall the other way.
  const DisplacementMap map = test::groove(32);
  const HeightFieldVisibility visibility = compute_visibility(DisplacedPlane(map, {1, 1}), {.rows = 1});
  const DiffuseTransport transport(visibility);
  std::vector<double> sent, reached(2 * transport.place_count());  // red and green
  for (std::size_t place = 0; place < transport.place_count(); ++place) {
    const bool red = visibility.normals[place].x() > 0;
    sent.push_back(transport.sky()[place]);
    sent.push_back(red ? 0.0 : transport.sky()[place]);
  }
  transport.gather(sent, 2, reached);
  double to_white = 0, to_red = 0;
  for (std::size_t place = 0; place < transport.place_count(); ++place) {
    const double red_light = reached[2 * place], green_light = reached[2 * place + 1];
    if (visibility.normals[place].x() > 0) {
      EXPECT_EQ(red_light, green_light) << "from white facets";
      to_red += red_light;
    } else {
      EXPECT_EQ(green_light, 0) << "from red facets";
      to_white += red_light;
    }
  }
  EXPECT_GT(to_red / 16, 0.15);
  // Facets mirror each other; 128 directions don't quite.
  EXPECT_NEAR(to_red, to_white, 0.03 * to_red);
}

TEST(DiffuseScattering, RefusesOrdersAndIrradiancesOutOfRange) {
  const DisplacementMap map = test::groove(8);
  const DiffuseTransport transport(compute_visibility(DisplacedPlane(map, {1, 1})));
  EXPECT_THROW(scatter_light(transport, transport.sky(), 0), OptionError);
  EXPECT_THROW(scatter_light(transport, transport.sky(), 65), OptionError);
  EXPECT_THROW(scatter_light(transport, {1, 2}), InputError);
  EXPECT_THROW(scatter_light(transport, std::vector<double>(64, std::nan(""))), InputError);
}

TEST(VirtualGoniometer, HasTheNumbersOfTheGrooveFromAbove) {
  const DisplacementMap map = test::groove(32);
  const DisplacedPlane plane(map, {1, 1});
  const VirtualGoniometer goniometer(plane, {.orders = 8});
  const Vec3 up = Vec3::UnitZ();
  // pi times the function for all scatterings, measured by another program.
  EXPECT_NEAR(k_pi * goniometer.brdf(up, up, 0.5), 0.416, 0.01);
  EXPECT_NEAR(k_pi * goniometer.brdf(up, up, 0.8), 0.747, 0.01);
  EXPECT_NEAR(goniometer.area_error(up), 0, 1e-12);
  const ScatteredLight light = goniometer.light(up);
  EXPECT_NEAR(0.8 * mean(light.orders[0]), 0.566, 1e-3) << "0.8 sin(45 degrees)";
  EXPECT_NEAR(mean_radiance(light, 0.8, 2), 0.698, 0.01);
  EXPECT_NEAR(mean_radiance(light, 0.8, 3), 0.733, 0.01);
  EXPECT_NEAR(mean_radiance(light, 0.8, 4), 0.743, 0.01);
  EXPECT_EQ(goniometer.brdf(up, -up, 0.5), 0);
  EXPECT_EQ(goniometer.brdf(-up, up, 0.5), 0);
}

TEST(VirtualGoniometer, SeesAsMuchOfTheSurfaceAsOfThePlane) {
  const DisplacementMap map = test::random_waves(1, 1.4, 48);
  const DisplacedPlane plane(map, {8, 8});
  const VirtualGoniometer by_rays(plane), by_ellipses(plane, {.test = OpennessTest::ellipses});
  for (const double angle : {0.0, 0.4, 0.8, 1.1, 1.3}) {
    const Vec3 viewer = test::direction_at(angle, 0.7);
    // Places stand for whole cells, so their outlines are wrong by half a cell.
    EXPECT_NEAR(by_rays.area_error(viewer), 0, 0.03) << angle;
    // Ellipses take one direction in thirteen for what it isn't, most of them low ones.
    EXPECT_NEAR(by_ellipses.area_error(viewer), 0, 0.12) << angle;
  }
}

TEST(VirtualGoniometer, IsReciprocalAndAgreesWithTracedPaths) {
  const DisplacementMap map = test::random_waves(1, 1.4, 48);
  const DisplacedPlane plane(map, {8, 8});
  const VirtualGoniometer goniometer(plane, {.visibility = {.directions = 256}, .orders = 6});
  const Vec3 a = test::direction_at(0.3, 1), b = test::direction_at(0.9, 4);
  const double there = goniometer.brdf(a, b, 0.7), back = goniometer.brdf(b, a, 0.7);
  EXPECT_NEAR(there, back, 0.02 * there);
  const test::TracedLight traced = test::trace_light(plane, 0.3, 0.9, 3, 40'000, 1.0);
  // A hundredth each for the noise of the paths and for places that stand for cells.
  EXPECT_NEAR(k_pi * there * b.z(), traced.sum(0.7), 0.02 * traced.sum(0.7));
}

TEST(VirtualGoniometer, AveragesItsTexturesToItsFunction) {
  const DisplacementMap map = test::random_waves(6, 1.4, 16);
  const DisplacedPlane plane(map, {4, 4});
  const VirtualGoniometer goniometer(plane);
  const Vec3 viewer = test::direction_at(0.8, 2), light = test::direction_at(0.5, 0);
  const Rgb albedo(0.2F, 0.5F, 0.9F);
  const Image texture = goniometer.texture(viewer, light, albedo);
  ASSERT_EQ(texture.width, 16);
  const std::vector<double> areas = goniometer.seen_areas(viewer);
  for (Eigen::Index k = 0; k < 3; ++k) {
    double sum = 0, area = 0;
    for (std::size_t place = 0; place < areas.size(); ++place) {
      EXPECT_TRUE(areas[place] > 0 || texture.pixels[place][k] == 0);
      sum += areas[place] * static_cast<double>(texture.pixels[place][k]);
      area += areas[place];
    }
    const double expected = k_pi * light.z() * goniometer.brdf(viewer, light, static_cast<double>(albedo[k]));
    EXPECT_NEAR(sum / area, expected, 1e-6) << "floats";
  }
  // As many parts as places: the pixels themselves.
  const std::vector<double> parts = goniometer.local_brdfs(viewer, light, 0.5, 16, 16);
  for (std::size_t place = 0; place < parts.size(); ++place)
    EXPECT_NEAR(k_pi * light.z() * parts[place], texture.pixels[place][1], 1e-6);
  const std::vector<Vec3> viewers{viewer, Vec3::UnitZ()};
  const std::vector<Image> field = goniometer.light_field(viewers, light, albedo);
  ASSERT_EQ(field.size(), 2U);
  EXPECT_EQ(field[0].pixels, texture.pixels);
  EXPECT_THROW(goniometer.local_brdfs(viewer, light, 0.5, 17, 1), OptionError);
  EXPECT_THROW(goniometer.local_brdfs(viewer, light, 0.5, 1, 0), OptionError);
  EXPECT_THROW(VirtualGoniometer(plane, {.orders = 0}), OptionError);
}

}  // namespace
}  // namespace recede
