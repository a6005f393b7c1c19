#include "chart_sphere.h"
#include "sanitized.h"
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/displacement_bake.h>
#include <recede/lod/simplify.h>
#include <recede/render/detail/surface_point.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cmath>
#include <numbers>
#include <random>

namespace recede {
namespace {

using test::chart_sphere;
using test::k_sanitized;
using test::rough_map;

Camera camera_at(const Vec3& position, int size = k_sanitized ? 60 : 200) {
  Camera camera;
  camera.position = position;
  camera.width = camera.height = size;
  return camera;
}

// Heights in waves over the unit square, as fine as texels show them.
DisplacementMap waves(int size, double height, double count) {
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double u = (x + 0.5) / size;
      heights.push_back(static_cast<float>(height * std::sin(2 * std::numbers::pi * count * u)));
    }
  }
  return DisplacementMap(size, size, std::move(heights), MapBorder::periodic);
}

// The square -1..1 in the plane z = 0.
PolygonSoup square() {
  PolygonSoup soup;
  soup.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  soup.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return soup;
}

DisplacedMeshOptions at_level(int level) {
  DisplacedMeshOptions options;
  options.level = level;
  return options;
}

TEST(DisplacedScene, ATracedSurfaceLooksLikeItsSmallTriangles) {
  const PolygonSoup base = chart_sphere(3, {5, -3, 2}, 0.05);
  const DisplacementMap map = rough_map(40, 30, 0, 0.2, MapBorder::clamped, 4);
  SceneOptions facets;
  facets.crease_angle = 0;
  const Scene traced(base, map, at_level(4), facets);
  const Scene tessellated(DisplacedMesh(base, map, at_level(4)).tessellate(), facets);
  Camera camera = camera_at({8, -2, 3});
  camera.target = {5, -3, 2};
  for (const LightTransport transport : {LightTransport::camera, LightTransport::direct}) {
    RenderOptions options;
    options.transport = transport;
    options.lighting = daylight(Vec3::UnitZ());
    options.samples_per_pixel = 4;
    const Image a = render(traced, camera, options), b = render(tessellated, camera, options);
    // Both see the same triangles up to the rounding of their corners; rays near sides may differ.
    EXPECT_LT(compare_images(a, b).rmse, 2e-3);
    EXPECT_GT(compare_images(a, Image(a.width, a.height)).rmse, 0.1);
  }
}

TEST(DisplacedScene, SlopesBetweenTexelsAreSmooth) {
  // Under a sun from above the irradiance is the cosine of the surface's slope, that of the waves.
  constexpr double k_height = 0.02, k_count = 4;
  const Scene scene(square(), waves(128, k_height, k_count), at_level(7));
  Camera camera = camera_at({0, 0, 30}, 101);
  camera.field_of_view = 2 * std::atan(1 / 30.0);
  RenderOptions options;
  options.transport = LightTransport::direct;
  options.lighting = {};
  options.lighting.ambient = 0;
  options.lighting.directionals = {
      {.toward = Vec3::UnitZ(), .irradiance = Rgb::Constant(std::numbers::pi_v<float>)}};
  options.samples_per_pixel = 16;
  const Image image = render(scene, camera, options);
  const double albedo = static_cast<double>(Material{}.base_color[0]);
  for (int x = 5; x < 96; ++x) {
    const double u = (x + 0.5) / 101;
    const double slope =
        k_height * 2 * std::numbers::pi * k_count / 2 * std::cos(2 * std::numbers::pi * k_count * u);
    const double expected = albedo / std::sqrt(1 + slope * slope);
    // Central differences of 32 texels a wave are 0.6 % too flat; a pixel is a mean over a hundredth of the
    // way.
    EXPECT_NEAR(static_cast<double>(image.at(x, 50)[0]), expected, 0.006) << x;
  }
}

TEST(DisplacedScene, SmallTrianglesThatFaceTheLightDoNotShadowThemselves) {
  // Small triangles of a sphere of constant height are the faces of a convex body.
  for (const int level : {0, 3, 6}) {
    for (const double offset : {0.0, 1e3, 1e5}) {
      const Vec3 center = offset * Vec3(1, -0.7, 0.4);
      PolygonSoup base = chart_sphere(3, center);
      for (const Index v : base.corner_vertices)
        base.corner_normals.push_back((base.positions[v] - center).normalized());
      const Scene scene(base, DisplacementMap(2, 2, std::vector<float>(4, 0.1f)), at_level(level));
      std::mt19937 random(5);
      std::normal_distribution<double> normal;
      const auto direction = [&] {
        return Vec3(normal(random), normal(random), normal(random)).normalized();
      };
      std::size_t lit = 0, shadowed = 0;
      for (int k = 0; k < (k_sanitized ? 500 : 20000); ++k) {
        const Vec3 from = 0.9 * direction(), toward = direction();
        const detail::Ray ray{from.cast<float>(), (0.3 * direction() - from).normalized().cast<float>()};
        detail::Hit hit;
        if (!detail::nearest_hit(scene.data(), ray, hit)) continue;
        const detail::SurfacePoint point = detail::surface_point(scene.data(), hit, ray.direction);
        if (point.geometric_normal.dot(toward) <= 0) continue;
        ++lit;
        if (detail::occluded(scene.data(), point.ray_towards(toward))) ++shadowed;
      }
      EXPECT_GT(lit, k_sanitized ? 100u : 5000u);
      EXPECT_EQ(shadowed, 0u) << "level " << level << " offset " << offset;
    }
  }
}

TEST(DisplacedScene, PicturesHaveTheSameBytesForAnyNumberOfThreads) {
  const auto picture = [] {
    const Scene scene(chart_sphere(2, Vec3::Zero()), rough_map(40, 30, 0, 0.2, MapBorder::clamped, 4),
                      at_level(4));
    RenderOptions options;
    options.transport = LightTransport::path;
    options.lighting = daylight(Vec3::UnitY());
    return render(scene, camera_at({0, 1, 3}), options);
  };
  const Image all = picture();
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Image single = picture();
  ASSERT_EQ(all.pixels.size(), single.pixels.size());
  for (std::size_t k = 0; k < all.pixels.size(); ++k) ASSERT_EQ(all.pixels[k], single.pixels[k]);
}

TEST(DisplacedScene, ACameraAmongTheBumpsSeesADefinedPicture) {
  const Scene scene(square(), waves(64, 0.5, 3), at_level(6));
  Camera camera = camera_at({0.1, 0.2, 0.1});
  camera.target = {1, 0.3, 0};
  camera.up = Vec3::UnitZ();
  for (const LightTransport transport : {LightTransport::camera, LightTransport::path}) {
    RenderOptions options;
    options.transport = transport;
    options.lighting = daylight(Vec3::UnitZ());
    for (const Rgb& pixel : render(scene, camera, options).pixels) ASSERT_TRUE(pixel.allFinite());
  }
}

TEST(DisplacedScene, ColoursAreThoseOfTheBase) {
  PolygonSoup base = square();
  base.vertex_colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 1, 0, 1}, {1, 0, 0, 1}};
  const Scene scene(base, waves(16, 0.01, 1), at_level(4));
  Camera camera = camera_at({0, 0, 30}, 50);
  camera.field_of_view = 2 * std::atan(1 / 30.0);
  const Image image = render(scene, camera);
  EXPECT_GT(image.at(2, 25)[0], 5 * image.at(2, 25)[1]);
  EXPECT_GT(image.at(47, 25)[1], 5 * image.at(47, 25)[0]);
  EXPECT_NEAR(image.at(25, 25)[0] / image.at(25, 25)[1], 1, 0.1);
}

TEST(DisplacedScene, TheGroundTouchesTheLowestHeights) {
  SceneOptions options;
  options.ground = Ground{.up = Vec3::UnitZ()};
  const Scene scene(square(), waves(64, 0.25, 2), at_level(5), options);
  const detail::SceneData& data = scene.data();
  const detail::Ray down{Eigen::Vector3f(0.9f, 0.9f, 1), Eigen::Vector3f(0, 0, -1)};
  detail::Hit hit;
  ASSERT_TRUE(detail::nearest_hit(data, down, hit));
  EXPECT_EQ(hit.part.object, 1u);
  // Longest side 2, so that heights of 1/4 are 1/8 there; bounds of heights may lie a little lower.
  EXPECT_NEAR(static_cast<double>(hit.distance), 1 + 0.125, 0.01);
}

TEST(DisplacedScene, BakedMapsLookAlikeTracedAndTessellated) {
  const PolygonSoup fine = make_displaced_sphere(20000, true);
  SimplifyOptions coarser;
  coarser.target.ratio = 0.02;
  MapOptions maps;
  maps.size = 256;
  const BakedMaps baked = bake_maps(fine, simplify(fine, coarser).soup, maps);
  const Scene traced(baked, {}), tessellated(dice_surface(baked)), bare(baked.surface), input(fine);
  const Camera camera = camera_at({2, 1.5, 2.5});
  const auto flip = [&](const Scene& a, const Scene& b) {
    return compute_flip(render(a, camera), render(b, camera)).mean;
  };
  EXPECT_LT(flip(traced, tessellated), 0.3 * flip(bare, tessellated));
  EXPECT_LT(flip(traced, input), 0.5 * flip(bare, input));
  BakedMaps without = baked;
  without.displacement = {};
  without.float_displacement = {};
  EXPECT_THROW(Scene(without, DisplacedMeshOptions{}), InputError);
}

}  // namespace
}  // namespace recede
