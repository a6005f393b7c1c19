#include "displaced_planes.h"
#include "measured_radiance.h"
#include "sanitized.h"
#include "tiled_surfaces.h"
#include <recede/geometry/error.h>
#include <recede/render/appearance.h>
#include <recede/render/image_difference.h>
#include <recede/render/method_shares.h>
#include <recede/render/renderer.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
// Of the square with 16 x 16 maps of 32 x 32 texels: four small triangles to a side of a texel. At two, half
// of the points lie between texels, where heights are means, and 0.6 % more of the slopes in their shade is
// seen.
constexpr int k_fine = 10;
constexpr std::array k_fixed = {Representation::brdf, Representation::bump, Representation::displacement};

Scene scene_of(const PolygonSoup& base, const DisplacementMap& map, int samples = 1 << 15,
               std::optional<int> level = {}) {
  AppearanceOptions appearance;
  appearance.normals.samples = samples;
  if (samples < 1 << 14) {  // tests that don't measure light have small tables
    appearance.reflectance.light_angles = appearance.reflectance.light_azimuths = 8;
    appearance.shading_samples = 256;
  }
  SceneOptions options;
  options.appearance = make_appearance(base, map, appearance);
  DisplacedMeshOptions displacement;
  displacement.level = level;
  return Scene(base, map, displacement, options);
}

/// The middle of the square from -1 to 1, as seen from `angle` off its normal.
Camera camera_above(double angle, double distance = 4, int size = 24, double azimuth = 0.5) {
  Camera camera;
  camera.position = test::direction_at(angle, azimuth) * distance;
  camera.up = Vec3::UnitZ();
  camera.width = camera.height = size;
  camera.field_of_view = 2 * std::atan(0.5 * std::cos(angle) / distance);
  return camera;
}

double mean_of(const Image& image) {
  double sum = 0;
  for (const Rgb& pixel : image.pixels) sum += static_cast<double>(pixel.sum()) / 3;
  return sum / static_cast<double>(image.pixels.size());
}

/// Tables are means over azimuths, and no map looks the same from all.
double mean_from_around(const Scene& scene, double angle, double distance, RenderOptions options,
                        std::optional<double> sun = {}) {
  constexpr int k_azimuths = 24;
  double sum = 0;
  for (int i = 0; i < k_azimuths; ++i) {
    const double azimuth = 2 * k_pi * i / k_azimuths;
    if (sun) {
      options.lighting.directionals = {
          {.toward = test::direction_at(*sun, azimuth + 1), .irradiance = Rgb::Constant(3)}};
    }
    sum += mean_of(render(scene, camera_above(angle, distance, 40, azimuth), options));
  }
  return sum / k_azimuths;
}

/// One lamp at infinity, and nothing else.
RenderOptions lit_by(const Vec3& toward_in_camera, int samples) {
  RenderOptions options;
  options.samples_per_pixel = samples;
  options.camera_light = {
      .toward = toward_in_camera, .lamp = Rgb::Ones(), .sky = Rgb::Constant(0.1f), .ground = Rgb::Zero()};
  return options;
}

TEST(AppearanceScene, IsAsBrightByTheTableAsByTheBumpMapAndByDisplacement) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  // So many copies of the map that those which a picture cuts off don't count.
  const PolygonSoup square = test::tiled_square(16);
  // Round bumps have flat ground between them, whose one normal no redistribution can spread.
  for (const DisplacementMap& map :
       {test::random_waves(1, 0.005), test::rough_ground(2, 0.0025), test::round_bumps(0.012)}) {
    const Scene scene = scene_of(square, map, 1 << 17, k_fine);
    for (const double angle : {0.3, 0.8, 1.3}) {
      for (const Vec3& lamp : {Vec3(-0.55, 0.75, 0.8), Vec3(0.3, 0.9, 0.1)}) {
        RenderOptions options = lit_by(lamp, 4);
        std::array<double, 3> means{};
        for (std::size_t k = 0; k < 3; ++k) {
          options.representation = k_fixed[k];
          means[k] = mean_from_around(scene, angle, 4, options);
        }
        // The goal of the transitions.
        EXPECT_NEAR(means[0] / means[2], 1, 0.005) << angle;
        EXPECT_NEAR(means[1] / means[2], 1, 0.005) << angle;
      }
    }
  }
}

TEST(AppearanceScene, StaysAsBrightWhileDisplacementGrows) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const Scene scene = scene_of(test::tiled_square(16), test::random_waves(1, 0.005), 1 << 17, k_fine);
  const double angle = 1.2;
  RenderOptions options = lit_by({-0.3, 0.9, -0.2}, 4);
  options.representation = Representation::displacement;
  const double displaced = mean_from_around(scene, angle, 40, options);
  options.representation = Representation::automatic;
  const auto& [e1, e2, e3, e4] = k_transition_values;
  for (const double share : {0.01, 0.25, 0.5, 0.75, 0.99}) {
    // From 40 away, T is nearly the same all over the square.
    const double value = e3 + share * (e4 - e3);
    options.transition =
        TransitionOptions{.unit = 40 * (value * (std::cos(angle) + 0.1) + 5), .threshold = 5};
    EXPECT_NEAR(mean_from_around(scene, angle, 40, options) / displaced, 1, 0.005) << share;
  }
  for (const double share : {0.01, 0.5, 0.99}) {
    const double value = e1 + share * (e2 - e1);
    options.transition =
        TransitionOptions{.unit = 40 * (value * (std::cos(angle) + 0.1) + 5), .threshold = 5};
    EXPECT_NEAR(mean_from_around(scene, angle, 40, options) / displaced, 1, 0.005) << share;
  }
}

TEST(AppearanceScene, RidgesLookAsTheyDoFromEachAzimuth) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const PolygonSoup square = test::tiled_square(16);
  const DisplacementMap ridges =
      test::map_of(32, [](double u, double) { return 0.012 * std::sin(2 * k_pi * u); });
  AppearanceOptions appearance;
  appearance.normals = {.bins = 61, .azimuths = 8, .samples = 1 << 15};
  SceneOptions options;
  options.appearance = make_appearance(square, ridges, appearance);
  DisplacedMeshOptions displacement;
  displacement.level = k_fine;
  const Scene scene(square, ridges, displacement, options);
  RenderOptions drawing = lit_by({0.1, 0.9, 0.2}, 4);
  std::array<double, 2> displaced{};
  for (std::size_t i = 0; i < 2; ++i) {
    // Pictures of 4 ridges side by side, or of 8 one behind the other: none is cut off.
    Camera camera = camera_above(k_pi / 3, 400, 64, static_cast<double>(i) * k_pi / 2);
    camera.field_of_view = 2 * std::atan(0.25 / 400);
    const auto mean = [&](Representation representation) {
      drawing.representation = representation;
      return mean_of(render(scene, camera, drawing));
    };
    displaced[i] = mean(Representation::displacement);
    // Ridges crowd along a line in the square of normals, narrower than a bin.
    EXPECT_NEAR(mean(Representation::brdf) / displaced[i], 1, 0.01) << i;
    EXPECT_NEAR(mean(Representation::bump) / displaced[i], 1, 0.01) << i;
  }
  EXPECT_GT(std::abs(displaced[0] / displaced[1] - 1), 0.05);  // so that a mean over azimuths would be off
}

TEST(AppearanceScene, AutomaticIsDisplacementNearbyAndTheTableFarAway) {
  const Scene scene = scene_of(test::tiled_torus(24, 12, 10, 4), test::random_waves(1, 0.05), 2048);
  Camera camera;
  camera.position = {0, -3, 2};
  camera.width = camera.height = test::k_sanitized ? 40 : 120;
  RenderOptions options;
  const auto picture = [&](Representation representation, double distance) {
    options.representation = representation;
    options.transition = transition_around(distance);
    return render(scene, camera, options);
  };
  const Image displaced = picture(Representation::displacement, 1), table = picture(Representation::brdf, 1);
  EXPECT_EQ(picture(Representation::automatic, 100).pixels, displaced.pixels);
  EXPECT_EQ(picture(Representation::automatic, 0.1).pixels, table.pixels);
  EXPECT_EQ(picture(Representation::automatic, 0).pixels, table.pixels);
  EXPECT_GT(compare_images(displaced, table).rmse, 0.02);
}

TEST(AppearanceScene, TheEnvelopeHidesNothingThatStandsOut) {
  // All that is seen is nearer than 3.9, up to where all is displaced; the far side isn't, so that the
  // envelope is asked.
  const Scene scene = scene_of(test::tiled_torus(24, 12, 5, 2), test::random_waves(5, 0.15), 2048);
  Camera camera;
  camera.position = {0, -2.2, 1.8};
  camera.width = camera.height = test::k_sanitized ? 40 : 160;
  RenderOptions options;
  options.representation = Representation::displacement;
  const Image displaced = render(scene, camera, options);
  options.representation = Representation::automatic;
  options.transition = TransitionOptions{.unit = 0.39, .threshold = -1};
  EXPECT_EQ(render(scene, camera, options).pixels, displaced.pixels);
}

TEST(AppearanceScene, TheEnvelopeHoldsHeightsOverTrianglesWhoseCornersPointApart) {
  // A tube of six sides, on which plateaus stand: between corners, directions are made unit length, and
  // heights stand out farther than a triangle between the corners that were moved.
  const DisplacementMap plateaus = test::map_of(16, [](double u, double) { return u < 0.5 ? 0.0 : 0.4; });
  const Scene scene = scene_of(test::tiled_torus(8, 6, 4, 1), plateaus, 2048, 5);
  Camera camera;
  camera.position = {0, -4, 1.8};
  camera.width = camera.height = test::k_sanitized ? 40 : 160;
  RenderOptions options;
  options.representation = Representation::displacement;
  const Image displaced = render(scene, camera, options);
  options.representation = Representation::automatic;
  // All that is seen is nearer than 6.3, up to where all is displaced; the far end of the sphere around it
  // isn't, so that each ray decides for itself.
  options.transition = TransitionOptions{.unit = 0.63, .threshold = -1};
  EXPECT_EQ(render(scene, camera, options).pixels, displaced.pixels);
}

TEST(AppearanceScene, AnEyeBetweenEnvelopeAndHeightsSeesHeights) {
  const DisplacementMap map = test::map_of(32, [](double u, double) { return u < 0.5 ? 0.0 : 0.4; });
  const Scene scene = scene_of(test::tiled_square(1), map, 2048);
  Camera camera;
  camera.position = {-0.5, 0, 0.2};  // over the low half, below the envelope
  camera.target = {1, 0.01, 0.15};   // the step
  camera.up = Vec3::UnitZ();
  camera.width = camera.height = 32;
  RenderOptions options;
  options.representation = Representation::displacement;
  const Image displaced = render(scene, camera, options);
  options.representation = Representation::automatic;
  options.transition = transition_around(0.3);
  EXPECT_EQ(render(scene, camera, options).at(16, 16), displaced.at(16, 16));
  EXPECT_NE(displaced.at(16, 16), options.background);
}

TEST(AppearanceScene, ARayThatMeetsNothingInTheEnvelopeGetsTheMethodOfWhereItLands) {
  // A low field with one spike, past which the eye looks at a far wall of the same surface.
  std::vector<float> heights(64, 0.0f);
  heights[0] = 0.2f;
  const DisplacementMap map(8, 8, heights, MapBorder::periodic);
  PolygonSoup soup = test::tiled_square(1);
  for (const Vec3& corner : {Vec3(20, 3, -3), Vec3(20, -3, -3), Vec3(20, -3, 3), Vec3(20, 3, 3)})
    soup.positions.push_back(corner);
  soup.add_face(std::array<Index, 4>{4, 5, 6, 7});
  soup.corner_uvs.insert(soup.corner_uvs.end(), {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  const Scene scene = scene_of(soup, map, 2048);
  Camera camera;
  camera.position = {-3, -0.5, 0.15};
  camera.target = {20, -0.5, 0.15};
  camera.up = Vec3::UnitZ();
  camera.width = camera.height = 8;
  camera.field_of_view = 0.001;
  RenderOptions options;
  options.show_methods = true;
  options.transition = transition_around(5);  // the field is 2 away, the wall 23
  const Rgb wall = render(scene, camera, options).at(4, 4);
  EXPECT_GT(wall.x(), 0.3f);  // by the table
  EXPECT_EQ(wall.y(), 0);
  camera.target = {0, -0.5, 0};
  const Rgb field = render(scene, camera, options).at(4, 4);
  EXPECT_GT(field.y(), 0.3f);  // displaced
  EXPECT_EQ(field.x(), 0);
}

TEST(AppearanceScene, FalseColoursTellTheMethod) {
  const Scene scene = scene_of(test::tiled_square(1), test::random_waves(1, 0.02), 2048);
  const Camera camera = camera_above(0, 4, 8);
  RenderOptions options;
  options.show_methods = true;
  const auto color_at = [&](double value) {
    // T = value at the distance 4, seen straight.
    options.transition = TransitionOptions{.unit = 4 * (value * 1.1 + 3), .threshold = 3};
    const Rgb color = render(scene, camera, options).at(4, 4);
    return Vec3((color / color.sum()).cast<double>());
  };
  // The eye sees a square of half a unit at 4: cosines of 0.99 and distances within 1 %, so T within 0.04.
  EXPECT_LT((color_at(-1.2) - Vec3(1, 0, 0)).norm(), 1e-6);
  EXPECT_LT((color_at(-0.65) - Vec3(0.5, 0, 0.5)).norm(), 0.1);
  EXPECT_LT((color_at(0) - Vec3(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((color_at(0.65) - Vec3(0, 0.5, 0.5)).norm(), 0.1);
  EXPECT_LT((color_at(1.2) - Vec3(0, 1, 0)).norm(), 1e-6);
}

TEST(AppearanceScene, MethodsAreCountedByPixels) {
  const PolygonSoup base = test::tiled_square(1);
  const DisplacementMap map = test::random_waves(1, 0.02);
  AppearanceOptions small;
  small.normals.samples = 2048;
  small.reflectance.light_angles = small.reflectance.light_azimuths = 8;
  small.shading_samples = 256;
  SceneOptions options;
  options.appearance = make_appearance(base, map, small);
  const Scene alone(base, map, {}, options);
  options.ground = Ground{.up = Vec3::UnitZ()};
  const Scene on_ground(base, map, {}, options);
  Camera camera = camera_above(0, 4, 44);
  camera.field_of_view = 2 * std::atan(0.5);  // a picture twice as wide as the square
  RenderOptions rendering{.transition = TransitionOptions{.unit = 12, .threshold = 3}};  // T is about 0
  for (const Scene* scene : {&alone, &on_ground}) {
    const PictureShares shares = count_methods(*scene, camera, rendering);
    EXPECT_EQ(shares.of(RenderingMethod::bump), 0.25);
    EXPECT_EQ(shares.background, scene == &alone ? 0.75 : 0);
    EXPECT_EQ(shares.others, scene == &alone ? 0 : 0.75);
  }
  rendering.representation = Representation::brdf;
  EXPECT_EQ(count_methods(alone, camera, rendering).of(RenderingMethod::brdf), 0.25);
}

TEST(AppearanceScene, ShadowsAndLightThatBumpsPassOnAreThoseOfTheHeights) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  PolygonSoup square = test::tiled_square(16);
  square.materials.push_back(
      {.name = "matt", .base_color = Vec4(0.8, 0.5, 0.2, 1), .base_color_texture = ""});
  square.face_materials = {0};
  const Scene scene = scene_of(square, test::random_waves(1, 0.008), 1 << 16, k_fine);
  for (const LightTransport transport : {LightTransport::direct, LightTransport::path}) {
    for (const double light : {0.4, 1.2}) {
      RenderOptions options;
      options.samples_per_pixel = transport == LightTransport::path ? 16 : 4;
      options.transport = transport;
      options.max_bounces = 8;
      options.lighting = {};
      options.lighting.ambient = 0;
      const auto mean = [&](Representation representation, double share) {
        // At 40 away, T is nearly the same all over the square.
        const double angle = 0.9, value = 0.3 + share * 0.7;
        options.representation = representation;
        options.transition =
            TransitionOptions{.unit = 40 * (value * (std::cos(angle) + 0.1) + 5), .threshold = 5};
        return mean_from_around(scene, angle, 40, options, light);
      };
      const double displaced = mean(Representation::displacement, 0);
      // The goal is 3 %; chance is in the tables, of some thousand rays for each view, and in paths.
      EXPECT_NEAR(mean(Representation::brdf, 0) / displaced, 1, 0.015) << light;
      EXPECT_NEAR(mean(Representation::bump, 0) / displaced, 1, 0.015) << light;
      EXPECT_NEAR(mean(Representation::automatic, 0.5) / displaced, 1, 0.015) << light;
    }
  }
}

TEST(AppearanceScene, DrawnAndFoundLightHaveOneMeanOnTables) {
  // An environment that is bright on one side: rays to it and rays that the table draws must agree.
  const Scene scene = scene_of(test::tiled_square(4), test::random_waves(1, 0.02), 1 << 14);
  Image sky(16, 8, Rgb::Constant(0.2f));
  for (int y = 0; y < 4; ++y) {
    for (int x = 3; x < 6; ++x) sky.at(x, y) = Rgb::Constant(4.0f);
  }
  for (const Representation representation : {Representation::brdf, Representation::automatic}) {
    std::array<MeasuredRadiance, 3> found;
    for (std::size_t k = 0; k < 3; ++k) {
      RenderOptions options =
          direct_light({.environment = EnvironmentLight{.radiance = sky, .up = Vec3::UnitZ()}});
      options.light_sampling =
          std::array{LightSampling::both, LightSampling::lights, LightSampling::surface}[k];
      options.representation = representation;
      // Halfway between table and bump map at the distance 4, seen from 1 off the normal.
      options.transition = TransitionOptions{.unit = 4 * (-0.65 * (std::cos(1.0) + 0.1) + 3), .threshold = 3};
      found[k] = measure_radiance(scene, test::direction_at(1, 0.5) * 4, {0.01, 0.02, 0}, options,
                                  test::k_sanitized ? 64 : 4096);
    }
    for (std::size_t k = 1; k < 3; ++k)
      EXPECT_NEAR(found[k].mean, found[0].mean, found[k].tolerance() + found[0].tolerance());
  }
}

TEST(AppearanceScene, HasTheSameBytesForAnyNumberOfThreads) {
  const Scene scene = scene_of(test::tiled_torus(24, 12, 10, 4), test::random_waves(1, 0.05), 2048);
  Camera camera;
  camera.position = {0, -3, 2};
  camera.width = camera.height = 64;
  RenderOptions options;
  options.transport = LightTransport::path;
  options.lighting = daylight(Vec3::UnitZ());
  options.samples_per_pixel = 2;
  options.transition = transition_around(3);
  const Image first = render(scene, camera, options);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(render(scene, camera, options).pixels, first.pixels);
}

TEST(AppearanceScene, RefusesTransitionsThatCantBe) {
  const Scene scene = scene_of(test::tiled_square(1), test::random_waves(1, 0.02), 512);
  RenderOptions options;
  options.transition = TransitionOptions{.silhouette = 0};
  EXPECT_THROW(render(scene, camera_above(0), options), OptionError);
  options.transition = TransitionOptions{.threshold = NAN};
  EXPECT_THROW(render(scene, camera_above(0), options), OptionError);
  EXPECT_THROW(transition_around(-1), OptionError);
  EXPECT_THROW(transition_around(INFINITY), OptionError);
  EXPECT_THROW(transition_for_wavelength(1, 0), OptionError);
}

}  // namespace
}  // namespace recede
