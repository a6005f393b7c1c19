// Direct light against closed forms.
#include "measured_radiance.h"
#include "shapes.h"
#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

Lighting sun_from(const Vec3& toward, double irradiance, double angular_radius = 0) {
  Lighting lighting;
  lighting.directionals.push_back({.toward = toward,
                                   .irradiance = Rgb::Constant(static_cast<float>(irradiance)),
                                   .angular_radius = angular_radius});
  return lighting;
}

Lighting sky_of(Image radiance) {
  Lighting lighting;
  lighting.environment = EnvironmentLight{.radiance = std::move(radiance)};
  return lighting;
}

TEST(Lights, APointLightFallsOffWithTheSquareOfItsDistance) {
  for (const double size : {1.0, 1e3, 1e-4}) {
    for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(1e3, -1e3, 500)}) {
      const Scene scene(with_albedo(make_floor(5 * size, offset), 0.5));
      Lighting lighting;
      lighting.points.push_back({.position = offset + size * Vec3(1, 0, 2), .intensity = Rgb::Constant(7)});
      const MeasuredRadiance seen =
          measure_radiance(scene, offset + size * Vec3(-1, 1, 3), offset, direct_light(lighting), 16);
      // I cos / r^2 with r^2 = 5 and cos = 2 / r; the albedo over pi of it leaves. Offsets of a thousand cost
      // double precision little, but the camera's pixel covers several places.
      const double expected = 0.5 / k_pi * 7 * 2 / (std::pow(5, 1.5) * size * size);
      EXPECT_NEAR(seen.mean, expected, 2e-5 * expected) << size;
    }
  }
}

TEST(Lights, APointLightIsAsBrightOnModelsOfAnySize) {
  // So far away and so strong that the irradiance is 3.5 on all of the model.
  for (const double size : {1e-30, 1e-21, 1e-12, 1e6}) {
    const Scene scene(with_albedo(make_floor(size), 0.5));
    const double distance = std::max(1.0, 10 * size);
    Lighting lighting;
    lighting.points.push_back({.position = {0, 0, distance},
                               .intensity = Rgb::Constant(static_cast<float>(3.5 * distance * distance))});
    const MeasuredRadiance seen =
        measure_radiance(scene, {0, size, 3 * size}, {0, 0, 0}, direct_light(lighting), 16);
    EXPECT_NEAR(seen.mean, 0.5 / k_pi * 3.5, 1e-5) << size;  // some steps of float
  }
}

TEST(Lights, ADirectionalLightFollowsTheCosineWithAnyAngularRadius) {
  const Scene scene(with_albedo(make_floor(1), 0.5));
  for (const double slope : {0.2, 1.0, 5.0}) {
    const Vec3 toward = Vec3(0, 1, slope).normalized();
    const double expected = 0.5 * 3 * toward.z() / k_pi;
    for (const double radius : {0.0, 0.02, 0.15}) {
      const MeasuredRadiance seen =
          measure_radiance(scene, {1, 0, 2}, {0, 0, 0}, direct_light(sun_from(toward, 3, radius)), 256);
      EXPECT_NEAR(seen.mean, expected, seen.tolerance()) << slope << " " << radius;
    }
  }
}

TEST(Lights, ASunOfSomeSizeCastsAPenumbraThatIsHalfLitInItsMiddle) {
  // A blade over the half x < 0, and a sun straight above: the shadow's border lies at x = 0.
  PolygonSoup blade = make_floor(2, {-2, 0, 1});
  const std::vector<PolygonSoup> soups{with_albedo(make_floor(5), 1), with_albedo(blade, 1)};
  const Scene scene{std::span<const PolygonSoup>(soups)};
  const double radius = 0.1;
  const RenderOptions options = direct_light(sun_from(Vec3::UnitZ(), k_pi, radius));
  const auto at = [&](double x) { return measure_radiance(scene, {3, 0, 1.5}, {x, 0.0, 0}, options, 1024); };
  EXPECT_NEAR(at(0).mean, 0.5, at(0).tolerance() + 1e-3);
  EXPECT_EQ(at(-1.2 * std::tan(radius)).mean, 0);
  EXPECT_NEAR(at(1.2 * std::tan(radius)).mean, 1, 1e-5);
}

// Form factor of a rectangle, seen from a place under its corner that looks straight up (Howell's catalogue,
// B-3).
double corner_form_factor(double width, double depth, double height) {
  const double a = width / height, b = depth / height;
  const double p = std::sqrt(1 + a * a), q = std::sqrt(1 + b * b);
  return (a / p * std::atan(b / p) + b / q * std::atan(a / q)) / (2 * k_pi);
}

TEST(Lights, ARectangleLightsAFloorByItsFormFactorHoweverItIsSampled) {
  const Scene scene(with_albedo(make_floor(5), 0.8));
  for (const double height : {2.0, 0.3, 0.02}) {
    Lighting lighting;
    // Shines downwards: the edges run clockwise seen from above.
    lighting.areas.push_back({.corner = {0, 0, height},
                              .first_edge = {0, 1.5, 0},
                              .second_edge = {2, 0, 0},
                              .radiance = Rgb::Constant(3)});
    const double expected = 0.8 * 3 * corner_form_factor(2, 1.5, height);
    double noise_of_both = 0, least_noise_of_one = std::numeric_limits<double>::infinity();
    for (const LightSampling sampling :
         {LightSampling::both, LightSampling::lights, LightSampling::surface}) {
      RenderOptions options = direct_light(lighting);
      options.light_sampling = sampling;
      const MeasuredRadiance seen = measure_radiance(scene, {-3, -3, 1}, {0, 0, 0}, options, 4096);
      EXPECT_NEAR(seen.mean, expected, seen.tolerance()) << height << " " << static_cast<int>(sampling);
      if (sampling == LightSampling::both) {
        noise_of_both = seen.standard_error;
      } else {
        least_noise_of_one = std::min(least_noise_of_one, seen.standard_error);
      }
    }
    // It pays for two rays, so it must not be worse than the better one by more than that.
    EXPECT_LT(noise_of_both, 1.5 * least_noise_of_one) << height;
  }
}

TEST(Lights, AreasShineFromTheirFrontOnlyUnlessTwoSided) {
  const Scene scene(with_albedo(make_floor(5), 1));
  AreaLight upwards{.corner = {-1, -1, 1}, .first_edge = {2, 0, 0}, .second_edge = {0, 2, 0}};
  const auto floor_under = [&](const AreaLight& light) {
    Lighting lighting;
    lighting.areas.push_back(light);
    return measure_radiance(scene, {4, 0, 0.5}, {0, 0, 0}, direct_light(lighting), 64).mean;
  };
  EXPECT_EQ(floor_under(upwards), 0);
  upwards.two_sided = true;
  EXPECT_GT(floor_under(upwards), 0.3);
}

TEST(Lights, ACameraSeesAreasAndWhatLiesBehindThem) {
  const Scene scene(with_albedo(make_floor(1), 1));
  Lighting lighting;
  lighting.areas.push_back({.corner = {-1, -1, 1},
                            .first_edge = {2, 0, 0},
                            .second_edge = {0, 2, 0},
                            .radiance = Rgb::Constant(5)});
  const RenderOptions options = direct_light(lighting);
  EXPECT_NEAR(measure_radiance(scene, {0, 0, 3}, {0, 0, 0}, options, 4).mean, 5, 1e-5)
      << "the floor is black";
  EXPECT_EQ(measure_radiance(scene, {0, 0, 0.5}, {0, 0, 3}, options, 4).mean, 0) << "its back is clear";
  EXPECT_EQ(measure_radiance(scene, {5, 0, 3}, {5, 0, 0}, options, 4).mean, 0) << "beside it";
}

TEST(Lights, AWhiteFurnaceShowsNothingButTheAlbedo) {
  const Scene scene(with_albedo(make_cube(Vec3::Zero(), 1), 0.7));
  for (const LightSampling sampling : {LightSampling::both, LightSampling::surface, LightSampling::lights}) {
    RenderOptions options = direct_light(sky_of(Image(1, 1, Rgb::Ones())));
    options.light_sampling = sampling;
    const MeasuredRadiance seen = measure_radiance(scene, {0.3, 0.4, 3}, {0.1, 0.1, 0.5}, options, 256);
    EXPECT_NEAR(seen.mean, 0.7, seen.tolerance());
    // Scattered rays all find the same light: no noise but that of float.
    if (sampling != LightSampling::lights) {
      EXPECT_LT(seen.standard_error, 1e-6);
    }
  }
}

// One texel of a picture of directions, as bright as a sun.
TEST(Lights, AnEnvironmentWithOneBrightTexelIsADirectionalLight) {
  const Scene scene(with_albedo(make_floor(1), 1));
  constexpr int k_width = 256, k_height = 128;
  for (const auto& [column, row] : {std::pair(10, 50), std::pair(200, 40), std::pair(128, 60)}) {
    Image image(k_width, k_height);
    const double top = std::cos(k_pi * row / k_height), below = std::cos(k_pi * (row + 1) / k_height);
    const double solid_angle = 2 * k_pi / k_width * (top - below);
    image.at(column, row) = Rgb::Constant(static_cast<float>(3 / solid_angle));
    Lighting lighting = sky_of(std::move(image));
    lighting.environment->up = Vec3::UnitY();
    lighting.environment->rotation = 0.4;
    // With y up the middle column is -z, columns go on towards +x, and rotations from +z to +x.
    const double polar = k_pi * (row + 0.5) / k_height;
    const double azimuth = 2 * k_pi * ((column + 0.5) / k_width - 0.5) - 0.4;
    const Vec3 toward(std::sin(polar) * std::sin(azimuth), std::cos(polar),
                      -std::sin(polar) * std::cos(azimuth));
    const MeasuredRadiance texel = measure_radiance(scene, {0, 1, 3}, {0, 0, 0}, direct_light(lighting), 256);
    const double expected = 3 / k_pi * std::max(0.0, toward.z());
    // The texel spans 1.4 degrees, over which the cosine changes.
    EXPECT_NEAR(texel.mean, expected, texel.tolerance() + 0.01 * expected) << column;
  }
}

TEST(Lights, EnvironmentsAreSeenTheRightWayRound) {
  // Red ahead, green to the right, blue above.
  Image image(4, 4, Rgb(0.1f, 0.1f, 0.1f));
  for (const int row : {1, 2}) image.at(2, row) = Rgb(1, 0, 0), image.at(3, row) = Rgb(0, 1, 0);
  for (int column = 0; column < 4; ++column) image.at(column, 0) = Rgb(0, 0, 1);
  for (const Vec3& up : {Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    const Scene scene(make_cube(Vec3(0, 0, 0), 1e-3));
    Lighting lighting = sky_of(image);
    lighting.environment->up = up;
    const Vec3 front = front_of(up), right = up.cross(front);
    const auto towards = [&](const Vec3& direction) {
      const Camera camera{.position = direction,
                          .target = 2 * direction,
                          .up = up + 0.1 * front,
                          .field_of_view = 1e-3,
                          .width = 1,
                          .height = 1};
      RenderOptions options = direct_light(lighting);
      options.samples_per_pixel = 4;
      return render(scene, camera, options).at(0, 0);
    };
    // Middles of texels: half a column beside the middle, and a quarter turn on.
    EXPECT_TRUE(towards(-front + right).isApprox(Rgb(1, 0, 0), 0.02f));
    EXPECT_TRUE(towards(front + right).isApprox(Rgb(0, 1, 0), 0.02f));
    EXPECT_TRUE(towards(up).isApprox(Rgb(0, 0, 1), 0.02f));
    lighting.environment->rotation = k_pi / 2;
    EXPECT_TRUE(towards(-right - front).isApprox(Rgb(1, 0, 0), 0.02f)) << "counter-clockwise from above";
    lighting.environment->visible = false;
    EXPECT_TRUE(towards(up).isZero(0)) << "the background";
  }
}

TEST(Lights, TheAmbientConstantIsScatteredByTheAlbedo) {
  const Scene scene(with_albedo(make_floor(1), 0.6));
  RenderOptions options = direct_light({});
  EXPECT_EQ(Lighting{}.ambient, 0.1);
  options.lighting.ambient = 0.1;
  EXPECT_NEAR(measure_radiance(scene, {0, 0, 2}, {0, 0, 0}, options, 1).mean, 0.06, 1e-7);
  options.transport = LightTransport::path;
  EXPECT_EQ(measure_radiance(scene, {0, 0, 2}, {0, 0, 0}, options, 1).mean, 0) << "paths find all there is";
}

TEST(Lights, ALightThatCannotBeIsRefused) {
  const Scene scene(make_floor(1));
  const auto refuse = [&](const Lighting& lighting) {
    EXPECT_THROW(measure_radiance(scene, {0, 0, 2}, {0, 0, 0}, direct_light(lighting), 1), OptionError);
  };
  const float infinite = std::numeric_limits<float>::infinity();
  const double not_a_number = std::numeric_limits<double>::quiet_NaN();
  Lighting lighting;
  lighting.points = {{.intensity = Rgb(-1, 0, 0)}};
  refuse(lighting);
  lighting.points = {{.position = Vec3(not_a_number, 0, 0)}};
  refuse(lighting);
  refuse(sun_from(Vec3::Zero(), 1));
  refuse(sun_from(Vec3::UnitX(), not_a_number));
  refuse(sun_from(Vec3::UnitX(), 1, 1.6));
  lighting = {};
  lighting.areas = {{.first_edge = {1, 0, 0}, .second_edge = {2, 0, 0}}};
  refuse(lighting);
  lighting.areas = {{.radiance = Rgb(1, infinite, 1)}};
  refuse(lighting);
  refuse(sky_of(Image()));
  lighting = sky_of(Image(1, 1));
  lighting.environment->up.setZero();
  refuse(lighting);
  lighting = sky_of(Image(1, 1));
  lighting.environment->scale = -1;
  refuse(lighting);
  lighting = sky_of(Image(1, 1, Rgb::Constant(2)));
  lighting.environment->scale = 1e15;
  refuse(lighting);
  EXPECT_THROW(daylight(Vec3::Zero()), OptionError);
  RenderOptions options = direct_light({});
  options.lighting.ambient = not_a_number;
  EXPECT_THROW(measure_radiance(scene, {0, 0, 2}, {0, 0, 0}, options, 1), OptionError);
  Image broken(3, 2);
  broken.at(2, 1).y() = infinite;
  try {
    measure_radiance(scene, {0, 0, 2}, {0, 0, 0}, direct_light(sky_of(broken)), 1);
    FAIL() << "infinite light was accepted";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "environment: the pixel in column 2, row 1 isn't finite");
  }
}

}  // namespace
}  // namespace recede
