// Light that surfaces pass on, shadows at the limits of float, and pictures without holes.
#include "measured_radiance.h"
#include "shapes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/render/detail/sample_stream.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_degree = k_pi / 180;

Lighting sun_from(const Vec3& toward, double irradiance) {
  Lighting lighting;
  lighting.directionals.push_back(
      {.toward = toward, .irradiance = Rgb::Constant(static_cast<float>(irradiance))});
  return lighting;
}

// Flat facets: light is followed by the surface's own normals.
Scene flat(const PolygonSoup& soup) { return Scene(soup, {.crease_angle = 0}); }

// A lamp in the middle of a hollow sphere lights its wall evenly, and so does every bounce: the radiance is
// that of the first one times a geometric series of the albedo.
TEST(PathTracer, AHollowSphereGathersTheSeriesOfItsAlbedo) {
  Lighting lighting;
  lighting.points.push_back({.position = Vec3::Zero(), .intensity = Rgb::Constant(static_cast<float>(k_pi))});
  for (const double albedo : {0.3, 0.8}) {
    const Scene scene = flat(with_albedo(make_sphere(Vec3::Zero(), 1, 128, 64), albedo));
    for (const int bounces : {0, 1, 2, 5, 60}) {
      const MeasuredRadiance seen =
          measure_radiance(scene, {0.2, 0.1, 0}, {0.3, 0.5, 0.4}, path_light(lighting, bounces), 2048);
      double series = 0;
      for (int k = 0; k <= bounces; ++k) series += std::pow(albedo, k);
      // Facets cut corners: the wall is nearer than 1 by (pi / 64)^2 / 2 at most.
      EXPECT_NEAR(seen.mean, albedo * series, seen.tolerance() + 0.003 * albedo * series)
          << albedo << ", " << bounces;
    }
    const MeasuredRadiance all =
        measure_radiance(scene, {0.2, 0.1, 0}, {0.3, 0.5, 0.4}, path_light(lighting, 1000), 2048);
    const double expected = albedo / (1 - albedo);
    EXPECT_NEAR(all.mean, expected, all.tolerance() + 0.003 * expected) << "paths end by chance, fairly";
  }
}

// What scatters all light can't be told from the light around it, however many times a path meets it; a path
// that slipped through the surface would be caught inside, and come back black. Triangles only: quads that
// aren't flat have a shading normal of their own, which costs light.
TEST(PathTracer, WhiteModelsVanishInWhiteLight) {
  Lighting lighting;
  lighting.environment = EnvironmentLight{.radiance = Image(1, 1, Rgb::Ones())};
  for (const PolygonSoup& model :
       {make_displaced_sphere(20'000, true), triangulated(make_teapot(12, 0.02))}) {
    const Scene scene = flat(with_albedo(model, 1));
    const Camera camera = camera_in_front(model.positions, Vec3::UnitZ(), 0.6, 64, 64);
    RenderOptions options = path_light(lighting, 1000);
    options.samples_per_pixel = 16;
    for (const Rgb& pixel : render(scene, camera, options).pixels)
      EXPECT_NEAR(pixel.x(), 1, 1e-5f) << model.n_faces();
  }
}

TEST(PathTracer, ANeighbourColoursWhatItFaces) {
  PolygonSoup wall = make_floor(1, {0, 0, 0});
  for (Vec3& position : wall.positions) position = Vec3(-1, position.y(), 1 + position.x());
  wall.materials.push_back({.name = "red", .base_color = Vec4(0.9, 0.05, 0.05, 1), .base_color_texture = ""});
  wall.face_materials.assign(1, 0);
  const std::vector<PolygonSoup> soups{with_albedo(make_floor(1), 0.8), wall};
  const Scene scene{std::span<const PolygonSoup>(soups)};
  const Camera camera{.position = {2, 0, 3},
                      .target = {-0.8, 0, 0},
                      .up = Vec3::UnitZ(),
                      .field_of_view = 0.01,
                      .width = 2,
                      .height = 2};
  RenderOptions options = path_light(sun_from({1, 0, 1}, k_pi), 2);
  options.samples_per_pixel = 256;
  const Rgb color = render(scene, camera, options).at(0, 0);
  EXPECT_GT(color.x(), 1.2f * color.y());
  EXPECT_EQ(color.y(), color.z());
}

TEST(PathTracer, AllWaysToFindLightHaveTheSameMean) {
  const Scene scene = flat(with_albedo(make_sphere(Vec3::Zero(), 1, 24, 12, 0.2), 0.7));
  Lighting lighting;
  lighting.areas.push_back({.corner = {1.5, -1, 0.5},
                            .first_edge = {0, 2, 0},
                            .second_edge = {0, 0, 1},
                            .radiance = Rgb::Constant(4),
                            .two_sided = true});
  Image sky(8, 4);
  for (std::size_t i = 0; i < sky.pixels.size(); ++i)
    sky.pixels[i] = Rgb::Constant(static_cast<float>((i * 7 % 11)) * 0.2f);
  lighting.environment = EnvironmentLight{.radiance = sky};
  for (const int bounces : {0, 3}) {
    std::vector<MeasuredRadiance> seen;
    for (const LightSampling sampling :
         {LightSampling::both, LightSampling::lights, LightSampling::surface}) {
      RenderOptions options = path_light(lighting, bounces);
      options.light_sampling = sampling;
      seen.push_back(measure_radiance(scene, {2, 1, 4}, {0.2, 0.1, 0}, options, 8192));
    }
    for (const std::size_t other : {1u, 2u}) {
      const double error = std::hypot(seen[0].standard_error, seen[other].standard_error);
      EXPECT_NEAR(seen[0].mean, seen[other].mean, 4 * error) << bounces << " " << other;
    }
    EXPECT_LT(seen[0].standard_error, 0.02 * seen[0].mean) << "else the comparison says nothing";
  }
}

// ---- shadows ----

TEST(Shadows, ASphereAndAFloorCastNoneOnThemselves) {
  for (const double offset : {0.0, 1e3, 1e5}) {
    const Vec3 place(offset, -offset, offset);
    const Scene sphere = flat(with_albedo(make_sphere(place, 0.5, 200, 100), 1));
    const Camera camera{
        .position = place + Vec3(0, 0, 2), .target = place, .field_of_view = 0.6, .width = 64, .height = 64};
    for (const Vec3& toward : {Vec3(0, 0, 1), Vec3(1, 0.2, 0.3), Vec3(0.3, -1, 0.05)}) {
      RenderOptions with_shadows = direct_light(sun_from(toward, k_pi));
      with_shadows.samples_per_pixel = 64;
      RenderOptions without = with_shadows;
      without.transport = LightTransport::camera;
      without.camera_light = {
          .toward = toward, .lamp = Rgb::Ones(), .sky = Rgb::Zero(), .ground = Rgb::Zero()};
      const Image lit = render(sphere, camera, with_shadows), plain = render(sphere, camera, without);
      int dark = 0;
      // Both patterns of samples see a sphere of small facets alike to a hundredth, but for its outline.
      for (int y = 20; y < 44; ++y) {
        for (int x = 20; x < 44; ++x) dark += lit.at(x, y).x() < plain.at(x, y).x() - 0.01f ? 1 : 0;
      }
      EXPECT_EQ(dark, 0) << offset << ": " << toward.transpose();
    }
    const Scene floor = flat(with_albedo(make_floor(0.5, place), 1));
    for (const double elevation : {90.0, 10.0, 0.5}) {
      const Vec3 toward(std::cos(elevation * k_degree), 0.0, std::sin(elevation * k_degree));
      const Camera above{.position = place + Vec3(0.1, 0.2, 2),
                         .target = place,
                         .field_of_view = 0.3,
                         .width = 64,
                         .height = 64};
      const Image lit = render(floor, above, direct_light(sun_from(toward, k_pi)));
      const float expected = static_cast<float>(toward.z());
      for (const Rgb& pixel : lit.pixels)
        ASSERT_NEAR(pixel.x(), expected, 1e-5f) << offset << " " << elevation;
    }
  }
}

TEST(Shadows, FallThroughGapsOfATenThousandthOfTheSize) {
  for (const double offset : {0.0, 1e5}) {
    const Vec3 place(offset, offset, offset);
    constexpr double k_gap = 1e-4;
    const std::vector<PolygonSoup> soups{with_albedo(make_floor(0.5, place), 1),
                                         with_albedo(make_floor(0.5, place + Vec3(0, 0, k_gap)), 1)};
    const Scene both{std::span<const PolygonSoup>(soups)}, alone(soups[0]);
    // The camera stands in the gap.
    const Camera camera{.position = place + Vec3(0, 0, k_gap / 2),
                        .target = place + Vec3(0.001, 0, 0),
                        .up = Vec3::UnitY(),
                        .field_of_view = 0.04,
                        .width = 32,
                        .height = 32};
    for (const Vec3& toward : {Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(1, 1, 0.2)}) {
      const RenderOptions options = direct_light(sun_from(toward, k_pi));
      for (const Rgb& pixel : render(both, camera, options).pixels) ASSERT_EQ(pixel.x(), 0) << offset;
      for (const Rgb& pixel : render(alone, camera, options).pixels) ASSERT_GT(pixel.x(), 0.1f) << offset;
    }
  }
}

// Triangles a hundred thousand times longer than high, with their top above the middle, so that no two sides
// span the plane well: float leaves their normals uncertain by degrees, and rays that start on them may be on
// the wrong side.
TEST(Shadows, FlatTrianglesDoNotHideTheirOwnLight) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal_number;
  const auto random_direction = [&] {
    return Vec3(normal_number(random), normal_number(random), normal_number(random)).normalized();
  };
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 along = random_direction(), across = along.cross(random_direction()).normalized();
    const Vec3 normal = along.cross(across);
    constexpr double k_height = 1e-5;
    PolygonSoup flat_triangle;
    flat_triangle.positions = {Vec3::Zero(), along, 0.47 * along + k_height * across};
    flat_triangle.add_face(std::array<Index, 3>{0, 1, 2});
    const Scene scene = flat(with_albedo(flat_triangle, 1));
    const Vec3 middle = 0.49 * along + 0.4 * k_height * across;
    const Camera camera{.position = middle + normal,
                        .target = middle,
                        .up = across,
                        .field_of_view = 2e-6,
                        .width = 4,
                        .height = 4};
    // From the half of all directions that is surely in front.
    Vec3 toward = random_direction();
    if (toward.dot(normal) < 0) toward = -toward;
    toward = (toward + normal).normalized();
    const Image lit = render(scene, camera, direct_light(sun_from(toward, k_pi)));
    for (const Rgb& pixel : lit.pixels) ASSERT_GT(pixel.x(), 0.3f) << trial;
  }
}

TEST(Shadows, ShadingNormalsLetNoLightThroughTheSurface) {
  PolygonSoup floor = with_albedo(make_floor(1), 1);
  floor.corner_normals.assign(floor.n_corners(), Vec3(1, 0, 1).normalized());
  const Scene scene(floor);
  const auto seen = [&](const Vec3& toward) {
    return measure_radiance(scene, {0, 0, 3}, {0, 0, 0}, direct_light(sun_from(toward, k_pi)), 4).mean;
  };
  EXPECT_EQ(seen({1, 0, -0.2}), 0) << "below the face, before the normal";
  EXPECT_GT(seen({1, 0, 0.2}), 0.5);
  EXPECT_EQ(seen({-1, 0, 0.2}), 0) << "above the face, behind the normal";
}

// ---- pictures without holes ----

bool all_finite(const Image& image) {
  return std::all_of(image.pixels.begin(), image.pixels.end(),
                     [](const Rgb& pixel) { return pixel.allFinite() && pixel.minCoeff() >= 0; });
}

TEST(PathTracer, NoPixelIsEverWithoutANumber) {
  PolygonSoup soup = with_albedo(make_sphere(Vec3::Zero(), 1, 16, 8), 1);
  // Faces without area: three times one vertex, and three in a line.
  const auto first = static_cast<Index>(soup.positions.size());
  for (const double x : {0.5, 1.0, 1.5}) soup.positions.emplace_back(x, 0, 1);
  soup.add_face(std::array<Index, 3>{0, 0, 0});
  soup.add_face(std::array<Index, 3>{first, first + 1, first + 2});
  soup.face_materials.assign(soup.n_faces(), 0);
  const Scene scene(soup, {.ground = Ground{}});
  Lighting lighting = daylight();
  for (const Vec3& position : {Vec3(soup.positions[20]), Vec3(0, 0, 1), Vec3(0, 0, 0), Vec3(1e30, 0, 0)})
    lighting.points.push_back({.position = position, .intensity = Rgb::Constant(1e15f)});
  // In the ground's own plane, and across the sphere.
  lighting.areas.push_back({.corner = {-1, -1, -1},
                            .first_edge = {2, 0, 0},
                            .second_edge = {0, 0, 2},
                            .radiance = Rgb::Constant(1e15f)});
  for (const Vec3& eye : {Vec3(0, 0.5, 4), Vec3(0, 0, 0), Vec3(0.1, -1, 0), Vec3(soup.positions[20])}) {
    for (const bool black_sky : {false, true}) {
      if (black_sky) lighting.environment->radiance = Image(4, 2);
      for (const LightSampling sampling :
           {LightSampling::both, LightSampling::lights, LightSampling::surface}) {
        RenderOptions options = path_light(lighting, 3);
        options.light_sampling = sampling;
        const Camera camera{.position = eye,
                            .target = eye + Vec3(0.1, -0.1, -1),
                            .field_of_view = 1.5,
                            .width = 24,
                            .height = 24};
        ProgressiveRender picture(scene, camera, options);
        picture.add_samples(8);
        EXPECT_TRUE(all_finite(picture.image())) << eye.transpose();
        EXPECT_TRUE(all_finite(picture.standard_error())) << eye.transpose();
      }
    }
  }
}

TEST(SampleStream, EveryPowerOfTwoFillsAllBoxesOfThatShareOnce) {
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(17, 3)}) {
    for (const int pair : {0, 1, 5}) {
      for (int bits = 0; bits <= 8; ++bits) {
        for (int columns_bits = 0; columns_bits <= bits; ++columns_bits) {
          const int columns = 1 << columns_bits, rows = 1 << (bits - columns_bits);
          std::set<std::pair<int, int>> boxes;
          for (std::uint32_t sample = 0; sample < 1u << bits; ++sample) {
            detail::SampleStream stream(x, y, sample);
            Vec2 point = stream.next_pair();
            for (int skip = 0; skip < pair; ++skip) point = stream.next_pair();
            EXPECT_TRUE(point.minCoeff() >= 0 && point.maxCoeff() < 1);
            boxes.emplace(static_cast<int>(point.x() * columns), static_cast<int>(point.y() * rows));
          }
          ASSERT_EQ(boxes.size(), std::size_t{1} << bits) << bits << " " << columns_bits;
        }
      }
    }
  }
}

TEST(SampleStream, PixelsAndPairsAreUnlikeEachOther) {
  // Correlation of two streams of a thousand numbers: less than 4 / sqrt(1024) by chance.
  const auto correlation = [](int pixel, int pair, int other_pixel, int other_pair) {
    double sum = 0;
    for (std::uint32_t sample = 0; sample < 1024; ++sample) {
      detail::SampleStream a(pixel, 0, sample), b(other_pixel, 0, sample);
      Vec2 first, second;
      for (int i = 0; i <= pair; ++i) first = a.next_pair();
      for (int i = 0; i <= other_pair; ++i) second = b.next_pair();
      sum += (first.x() - 0.5) * (second.x() - 0.5) * 12 / 1024;
    }
    return std::abs(sum);
  };
  for (int k = 1; k < 6; ++k) {
    EXPECT_LT(correlation(0, 0, k, 0), 0.125) << k;
    EXPECT_LT(correlation(0, 0, 0, k), 0.125) << k;
  }
  EXPECT_NEAR(correlation(3, 2, 3, 2), 1, 1e-3);
}

}  // namespace
}  // namespace recede
