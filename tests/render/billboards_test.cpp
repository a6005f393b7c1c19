#include "sanitized.h"
#include "uv_ball.h"
#include <recede/geometry/error.h>
#include <recede/render/detail/surface_point.h>
#include <recede/render/renderer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace recede {
namespace {

using test::k_sanitized;
using test::uv_ball;
using Vec3f = Eigen::Vector3f;

// One billboard with heights and opacity in every texel.
BillboardTextures relief(int width, int height, unsigned seed, bool has_holes) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> byte(0, 255);
  BillboardTextures textures;
  textures.error = textures.height_range = 0.2;
  textures.texel = 0.1;
  Billboard billboard;
  billboard.center = Vec3(0.3, -0.2, 0.1);
  billboard.axis_u = Vec3(1, 2, -1).normalized();
  billboard.axis_v = billboard.axis_u.unitOrthogonal();
  billboard.half_sizes = Vec2(0.05 * width, 0.04 * height);
  textures.billboards = {billboard};
  textures.places = {{1, 2, width, height}};
  const int columns = width + 3, rows = height + 4;
  textures.color = {.width = columns, .height = rows, .channels = 4, .srgb = true, .samples = {}};
  textures.normal = {.width = columns, .height = rows, .channels = 3, .samples = {}};
  textures.height = {.width = columns, .height = rows, .channels = 1, .samples = {}};
  for (int i = 0; i < columns * rows; ++i) {
    textures.color.samples.insert(textures.color.samples.end(), {200, 100, 50});
    textures.color.samples.push_back(static_cast<std::uint16_t>(has_holes ? byte(random) : 255));
    textures.normal.samples.insert(textures.normal.samples.end(), {128, 128, 255});
    // So that heights stay within their room beyond the outer texels' middles, too.
    textures.height.samples.push_back(static_cast<std::uint16_t>(96 + byte(random) / 4));
  }
  return textures;
}

double at_texel(const Raster& raster, const BillboardPlace& place, int x, int y, int channel) {
  x = std::clamp(x, 0, place.width - 1);
  y = std::clamp(y, 0, place.height - 1);
  return raster.at(place.x + x, place.y + y, channel) / 255.0;
}

// Bilinear between the middles of texels; x and y are texels from the upper left corner.
double blended(const Raster& raster, const BillboardPlace& place, double x, double y, int channel) {
  const int column = static_cast<int>(std::floor(x - 0.5)), row = static_cast<int>(std::floor(y - 0.5));
  const double u = x - 0.5 - column, v = y - 0.5 - row;
  const auto at = [&](int i, int j) { return at_texel(raster, place, column + i, row + j, channel); };
  return (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
}

// Beyond the outer middles they go on as before them.
double height_at(const BillboardTextures& textures, double x, double y) {
  const BillboardPlace& place = textures.places[0];
  const int column = std::clamp(static_cast<int>(std::floor(x - 0.5)), 0, place.width - 2),
            row = std::clamp(static_cast<int>(std::floor(y - 0.5)), 0, place.height - 2);
  const double u = x - 0.5 - column, v = y - 0.5 - row;
  const auto at = [&](int i, int j) { return at_texel(textures.height, place, column + i, row + j, 0); };
  const double share =
      (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
  return (2 * share - 1) * textures.height_range;
}

// The surface of heights, each texel in parts.
PolygonSoup tessellated(const BillboardTextures& textures, int parts) {
  const Billboard& billboard = textures.billboards[0];
  const BillboardPlace& place = textures.places[0];
  PolygonSoup soup;
  const int columns = place.width * parts, rows = place.height * parts;
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double x = static_cast<double>(i) / parts, y = static_cast<double>(j) / parts;
      soup.positions.push_back(billboard.center +
                               (2 * x / place.width - 1) * billboard.half_sizes.x() * billboard.axis_u +
                               (1 - 2 * y / place.height) * billboard.half_sizes.y() * billboard.axis_v +
                               height_at(textures, x, y) * billboard.normal());
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto a = static_cast<Index>(j * (columns + 1) + i), below = a + static_cast<Index>(columns + 1);
      soup.add_face(std::array<Index, 3>{a, below, below + 1});
      soup.add_face(std::array<Index, 3>{a, below + 1, a + 1});
    }
  }
  return soup;
}

Scene scene_of(const BillboardTextures& textures,
               std::vector<Eigen::Affine3d> placements = {Eigen::Affine3d::Identity()}) {
  const PlacedBillboards placed{std::make_shared<BillboardTextures>(textures), std::move(placements)};
  return Scene(std::span<const PolygonSoup>{}, std::span<const PlacedBillboards>(&placed, 1));
}

// In the scaled scene, from all around to near its middle.
detail::Ray random_ray(std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Vec3 from = 2 * Vec3(normal(random), normal(random), normal(random)).normalized();
  const Vec3 to = 0.15 * Vec3(normal(random), normal(random), normal(random));
  detail::Ray ray;
  ray.origin = from.cast<float>();
  ray.direction = (to - from).normalized().cast<float>();
  return ray;
}

TEST(Billboards, RaysMeetTheSurfaceOfHeights) {
  const BillboardTextures textures = relief(16, 12, 3, false);
  const Scene scene = scene_of(textures);
  // With the same frame for its rays: that of the billboards' box, whatever the heights in it are.
  PolygonSoup fine = tessellated(textures, k_sanitized ? 16 : 40);
  for (Vec3& position : fine.positions) position = scene.data().scaled(position);
  const Scene brute(fine);
  std::mt19937 random(9);
  int n_hits = 0, n_different = 0;
  for (int i = 0; i < 4000; ++i) {
    const detail::Ray ray = random_ray(random);
    detail::Ray scaled = ray;
    scaled.origin = brute.data().scaled(ray.origin.cast<double>()).cast<float>();
    detail::Hit hit, expected;
    const bool is_hit = detail::nearest_hit(scene.data(), ray, hit),
               is_expected = detail::nearest_hit(brute.data(), scaled, expected);
    EXPECT_EQ(detail::occluded(scene.data(), ray), is_hit);
    n_hits += is_hit ? 1 : 0;
    const double distance = static_cast<double>(expected.distance) / brute.data().scale;
    // Small triangles leave the bilinear surface by less than a thousandth of the model; where rays graze it,
    // they may meet another part.
    if (is_hit != is_expected || (is_hit && std::abs(static_cast<double>(hit.distance) - distance) > 2e-3))
      ++n_different;
  }
  EXPECT_GT(n_hits, 1500);
  EXPECT_LT(n_different, 20);
}

TEST(Billboards, RaysPassWhereTheyAreTransparent) {
  const BillboardTextures textures = relief(16, 12, 5, true);
  const BillboardPlace& place = textures.places[0];
  const Scene scene = scene_of(textures);
  std::mt19937 random(4);
  int n_hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const detail::Ray ray = random_ray(random);
    detail::Hit hit;
    if (!detail::nearest_hit(scene.data(), ray, hit)) continue;
    ++n_hits;
    const double x = static_cast<double>(hit.u), y = static_cast<double>(hit.v);
    EXPECT_GE(blended(textures.color, place, x, y, 3), 0.5 - 1e-5);  // floats
    // The hit is on the ray, and at the height of its texel.
    const Billboard& billboard = textures.billboards[0];
    const Vec3 scaled = (ray.origin + hit.distance * ray.direction).cast<double>();
    const Vec3 at = scaled / scene.data().scale + scene.data().center - billboard.center;
    EXPECT_NEAR(at.dot(billboard.normal()), height_at(textures, x, y), 1e-5);
    EXPECT_NEAR(at.dot(billboard.axis_u), (2 * x / place.width - 1) * billboard.half_sizes.x(), 1e-5);
  }
  EXPECT_GT(n_hits, 500);
}

TEST(Billboards, StandWhereTheyArePlaced) {
  const PolygonSoup model = uv_ball(20);
  const BillboardTextures textures =
      texture_billboards(model, build_billboard_clouds(model, {.errors = {0.02}}).front());
  const Eigen::Affine3d placement =
      Eigen::Translation3d(3, 0, 0) * Eigen::AngleAxisd(1, Vec3::UnitZ()) * Eigen::Scaling(2.0);
  const Scene scene = scene_of(textures, {Eigen::Affine3d::Identity(), placement});
  const auto distance_from_above = [&](double x, double y) {
    detail::Ray ray;
    ray.origin = scene.data().scaled(Vec3(x, y, 5)).cast<float>();
    ray.direction = Vec3f(0, 0, -1);
    detail::Hit hit;
    if (!detail::nearest_hit(scene.data(), ray, hit)) return 0.0;
    return static_cast<double>(hit.distance) / scene.data().scale;
  };
  EXPECT_NEAR(distance_from_above(0, 0), 4.5, 0.02);
  EXPECT_NEAR(distance_from_above(3, 0), 4, 0.04);
  EXPECT_EQ(distance_from_above(1.5, 0), 0);
}

TEST(Billboards, OfAClosedBodyLeaveNoGaps) {
  const PolygonSoup model = uv_ball(40);
  for (const double error : {0.01, 0.04}) {
    const Scene scene =
        scene_of(texture_billboards(model, build_billboard_clouds(model, {.errors = {error}}).front()));
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 20'000; ++i) {
      const Vec3 from = Vec3(normal(random), normal(random), normal(random)).normalized();
      // Anywhere but near the outline.
      const Vec3 to = 0.9 * 0.5 * Vec3(normal(random), normal(random), normal(random)).normalized();
      const Vec3 across = to - to.dot(from) * from;
      detail::Ray ray;
      ray.origin = scene.data().scaled(across + 2 * from).cast<float>();
      ray.direction = (-from).cast<float>();
      detail::Hit hit;
      ASSERT_TRUE(detail::nearest_hit(scene.data(), ray, hit)) << across.transpose() << " at " << error;
      const double height = 2 - static_cast<double>(hit.distance) / scene.data().scale;
      EXPECT_NEAR(height, std::sqrt(0.25 - across.squaredNorm()), 4 * error);
    }
  }
}

TEST(Billboards, LookLikeTheirModel) {
  PolygonSoup model = uv_ball(40);
  for (const Vec3& position : model.positions)
    model.vertex_colors.emplace_back(position.x() + 0.5, position.y() + 0.5, 0.5, 1);
  const auto textures = std::make_shared<BillboardTextures>(
      texture_billboards(model, build_billboard_clouds(model, {.errors = {0.01}}).front()));
  const PlacedBillboards placed{textures};
  const Scene original(model),
      cloud(std::span<const PolygonSoup>{}, std::span<const PlacedBillboards>(&placed, 1));
  Camera camera;
  camera.position = Vec3(1, 2, 3);
  camera.width = camera.height = 60;
  const Image a = render(original, camera), b = render(cloud, camera);
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) sum += (a.pixels[i] - b.pixels[i]).cwiseAbs().sum() / 3;
  // Of the pixels at the outline some are half wrong; elsewhere colours vary little within a texel.
  EXPECT_LT(sum / static_cast<double>(a.pixels.size()), 1e-3);
}

TEST(Billboards, CastShadows) {
  PolygonSoup model;
  model.positions = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
  model.add_face(std::array<Index, 4>{0, 1, 2, 3});
  const PlacedBillboards placed{std::make_shared<BillboardTextures>(
      texture_billboards(model, build_billboard_clouds(model, {.errors = {0.1}}).front()))};
  PolygonSoup floor;
  floor.positions = {{-4, -4, 0}, {4, -4, 0}, {4, 4, 0}, {-4, 4, 0}};
  floor.add_face(std::array<Index, 4>{0, 1, 2, 3});
  const Scene scene(std::span<const PolygonSoup>(&floor, 1), std::span<const PlacedBillboards>(&placed, 1));
  Camera camera;
  camera.position = Vec3(0, -8, 3);
  camera.up = Vec3::UnitZ();
  camera.target = Vec3::Zero();
  camera.width = camera.height = 64;
  RenderOptions options;
  options.transport = LightTransport::direct;
  options.lighting.directionals = {{.toward = Vec3(0, 0, 1)}};
  options.lighting.ambient = 0;
  const Image image = render(scene, camera, options);
  EXPECT_EQ(image.at(32, 32).maxCoeff(), 0);    // the floor below the square
  EXPECT_GT(image.at(4, 40).maxCoeff(), 0.1f);  // beside its shadow
}

TEST(Billboards, ThatAreNoneCantBeDrawn) {
  const BillboardTextures textures = relief(4, 4, 1, false);
  EXPECT_THROW(scene_of(textures, {}), InputError);
  EXPECT_THROW(scene_of(BillboardTextures{}), InputError);
  EXPECT_THROW(scene_of(textures, {Eigen::Affine3d(Eigen::Scaling(Vec3(1, 1, 0)))}), InputError);
}

}  // namespace
}  // namespace recede
