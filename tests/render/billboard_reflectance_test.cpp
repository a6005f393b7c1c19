#include "sanitized.h"
#include "temp_folder.h"
#include "uv_ball.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/render/detail/tracing.h>
#include <recede/render/renderer.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace recede {
namespace {

using test::k_sanitized;
using test::uv_ball;

constexpr double k_pi = std::numbers::pi;

// Faces upwards.
void add_square(PolygonSoup& soup, const Vec3& middle, double half) {
  const auto first = static_cast<Index>(soup.positions.size());
  for (const Vec2& corner : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)})
    soup.positions.push_back(middle + half * Vec3(corner.x(), corner.y(), 0));
  soup.add_face(std::array<Index, 4>{first, first + 1, first + 2, first + 3});
}

void paint(PolygonSoup& soup, const Vec3& color) {
  soup.materials = {
      {.name = "matt", .base_color = {color.x(), color.y(), color.z(), 1}, .base_color_texture = ""}};
  soup.face_materials.assign(soup.n_faces(), 0);
}

struct Made {
  BillboardCloud cloud;
  std::shared_ptr<const BillboardTextures> textures;
  std::shared_ptr<const BillboardReflectance> reflectance;

  PlacedBillboards placed() const { return {.textures = textures, .reflectance = reflectance}; }
};

// Compressed as little as can be, but for what is asked.
BillboardReflectanceOptions nearly_exact() {
  return {.radiance = {.clusters = 64, .components = 16}, .largest_share = 100};
}

Made make(const PolygonSoup& model, double error, bool is_two_sided,
          const BillboardReflectanceOptions& options = nearly_exact(),
          const BillboardTextureOptions& texturing = {}) {
  BillboardOptions billboards;
  billboards.errors = {error};
  billboards.is_two_sided = is_two_sided;
  Made made;
  made.cloud = build_billboard_clouds(model, billboards).front();
  made.textures = std::make_shared<BillboardTextures>(texture_billboards(model, made.cloud, texturing));
  made.reflectance = std::make_shared<BillboardReflectance>(
      make_billboard_reflectance(model, made.cloud, *made.textures, options));
  return made;
}

Scene scene_of(const Made& made) {
  const PlacedBillboards placed = made.placed();
  return Scene(std::span<const PolygonSoup>{}, std::span(&placed, 1));
}

Vec3 value_of(const BillboardReflectance& reflectance, std::uint32_t vector, std::size_t view,
              std::size_t light) {
  std::array<float, 3> color;
  reconstruct(reflectance.radiance, vector, color, 3 * (view * reflectance.lights().size() + light));
  return Vec3(static_cast<double>(color[0]), static_cast<double>(color[1]), static_cast<double>(color[2]));
}

TEST(BillboardReflectance, OfAMattSquareIsThatOfItsColourOnTheSideOfTheLight) {
  PolygonSoup model;
  add_square(model, Vec3(3, 2, 1), 1);
  const Vec3 color(0.8, 0.4, 0.2);
  paint(model, color);
  for (const bool is_two_sided : {false, true}) {
    const Made made = make(model, 0.25, is_two_sided);
    const BillboardReflectance& reflectance = *made.reflectance;
    ASSERT_EQ(reflectance.vector_count(), is_two_sided ? 128u : 64u);  // 8 x 8 texels
    const DirectionGrid lights = reflectance.lights();
    for (std::uint32_t vector = 0; vector < reflectance.vector_count(); ++vector) {
      for (std::size_t view = 0; view < 49; ++view) {
        ASSERT_EQ(reflectance.opacity[49 * vector + view], 255);
        for (std::size_t light = 0; light < lights.size(); light += 7) {
          const Vec3 expected = std::max(0.0, lights.direction(light).z()) / k_pi * color;
          // Halves, of the values and of what they are made from.
          ASSERT_LT((value_of(reflectance, vector, view, light) - expected).norm(), 3e-4);
        }
      }
    }
  }
}

TEST(BillboardReflectance, HasTheShadowsOfOtherPartsOfTheModel) {
  PolygonSoup model;
  add_square(model, Vec3(0, 0, 0), 1);
  add_square(model, Vec3(0, 0, 1), 1);
  paint(model, Vec3::Ones());
  BillboardReflectanceOptions options = nearly_exact();
  options.bounces = 0;
  const Made made = make(model, 0.25, false, options);
  const BillboardReflectance& reflectance = *made.reflectance;
  const DirectionGrid lights = reflectance.lights();
  int n_shadowed = 0, n_lit = 0;
  for (std::size_t b = 0; b < 2; ++b) {
    const Billboard& billboard = made.textures->billboards[b];
    ASSERT_GT(billboard.normal().z(), 0.99);
    const BillboardPlace& place = made.textures->places[b];
    const std::uint32_t vector =
        reflectance.vectors[static_cast<std::size_t>((place.y + 4) * reflectance.width + place.x + 2)];
    const Vec3 at = billboard.center + (2 * 2.5 / place.width - 1) * billboard.axis_u +
                    (1 - 2 * 4.5 / place.height) * billboard.axis_v;
    for (std::size_t light = 0; light < lights.size(); ++light) {
      const Vec3 local = lights.direction(light);
      const Vec3 toward =
          local.x() * billboard.axis_u + local.y() * billboard.axis_v + local.z() * billboard.normal();
      double expected = std::max(0.0, local.z()) / k_pi;
      if (expected > 0 && at.z() < 0.5) {
        const double beside = (at + toward / toward.z()).head<2>().cwiseAbs().maxCoeff();
        if (std::abs(beside - 1) < 0.2) continue;  // not the same for all of the texel
        ++(beside < 1 ? n_shadowed : n_lit);
        if (beside < 1) expected = 0;
      }
      for (const std::size_t view : {std::size_t{0}, std::size_t{24}, std::size_t{33}}) {
        // 16 directions lose some of the shadows' borders.
        EXPECT_NEAR(value_of(reflectance, vector, view, light).x(), expected, 0.001);
      }
    }
  }
  EXPECT_GT(n_shadowed, 10);
  EXPECT_GT(n_lit, 5);
}

TEST(BillboardReflectance, HidesAndShowsGapsByTheView) {
  // Two halves of a square at two heights: seen from the lower one's side they part.
  PolygonSoup model;
  for (const double side : {-1.0, 1.0}) add_square(model, Vec3(side, 0, -0.2 * side), 1);
  const Made made =
      make(model, 0.3, true, {.light_side = 1, .shaded = 1, .bounces = 0}, {.texels_per_error = 3});
  ASSERT_EQ(made.textures->billboards.size(), 1u);
  const Scene scene = scene_of(made);
  const auto is_seen = [&](const Vec3& from, double x) {
    detail::Ray ray;
    ray.origin = scene.data().scaled(Vec3(x, 0.1, 0) + 5 * from).cast<float>();
    ray.direction = (-from).normalized().cast<float>();
    detail::Hit hit;
    const bool is_hit = detail::nearest_hit(scene.data(), ray, hit);
    EXPECT_EQ(detail::occluded(scene.data(), ray), is_hit);
    return is_hit;
  };
  EXPECT_FALSE(is_seen(Vec3(1, 0, 1), 0));
  EXPECT_FALSE(is_seen(Vec3(-1, 0, -1), 0));  // the same way, from behind
  EXPECT_TRUE(is_seen(Vec3(-1, 0, 1), 0));
  EXPECT_TRUE(is_seen(Vec3(0, 0, 1), 0.1));
  EXPECT_TRUE(is_seen(Vec3(1, 0, 1), 0.6));
  EXPECT_TRUE(is_seen(Vec3(1, 0, 1), -0.6));
}

// Two walls at a right angle, one of them red.
PolygonSoup corner() {
  PolygonSoup model;
  model.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {1, 1, 2}, {1, -1, 2}};
  model.add_face(std::array<Index, 4>{0, 1, 2, 3});
  model.add_face(std::array<Index, 4>{1, 5, 4, 2});
  model.materials = {{.name = "white", .base_color = {0.8, 0.8, 0.8, 1}, .base_color_texture = ""},
                     {.name = "red", .base_color = {0.8, 0.1, 0.1, 1}, .base_color_texture = ""}};
  model.face_materials = {0, 1};
  return model;
}

Camera camera_at(const Vec3& position, int size) {
  Camera camera;
  camera.position = position;
  camera.up = Vec3::UnitZ();
  camera.width = camera.height = size;
  return camera;
}

double mean_difference(const Image& a, const Image& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i)
    sum += static_cast<double>((a.pixels[i] - b.pixels[i]).cwiseAbs().sum()) / 3;
  return sum / static_cast<double>(a.pixels.size());
}

TEST(BillboardReflectance, GivesPicturesOfTheModelUnderTheSun) {
  const PolygonSoup model = corner();
  BillboardReflectanceOptions options = nearly_exact();
  options.shaded = 8;
  const Made made = make(model, 0.2, false, options);
  const Scene original(model), billboards = scene_of(made);
  const Camera camera = camera_at(Vec3(-3, -2, 4), 40);
  RenderOptions drawing;
  drawing.transport = LightTransport::path;
  drawing.max_bounces = 1;
  drawing.samples_per_pixel = 64;
  drawing.background = Rgb::Zero();
  const auto drawn_under = [&](const Scene& scene, const Vec3& sun) {
    drawing.lighting.directionals = {{.toward = sun, .irradiance = Rgb::Constant(3)}};
    return render(scene, camera, drawing);
  };
  const Image black(40, 40);
  const Image lit = drawn_under(original, Vec3(-1, -0.5, 1.2));
  EXPECT_GT(mean_difference(lit, black), 0.1);
  // Outlines may be a texel off.
  EXPECT_LT(mean_difference(lit, drawn_under(billboards, Vec3(-1, -0.5, 1.2))),
            0.05 * mean_difference(lit, black));
  // From behind the wall: borders of its shadow are as soft as lights are far from each other, but there is
  // as much light.
  const double shadowed = mean_difference(drawn_under(original, Vec3(1, 0.3, 1.2)), black);
  EXPECT_LT(shadowed, 0.03);
  EXPECT_NEAR(mean_difference(drawn_under(billboards, Vec3(1, 0.3, 1.2)), black), shadowed, 0.15 * shadowed);
}

TEST(BillboardReflectance, PassesLightFromFaceToFace) {
  const PolygonSoup model = corner();
  BillboardReflectanceOptions options = nearly_exact();
  options.shaded = 8;
  const auto floor_color = [&](int bounces) {
    options.bounces = bounces;
    const Made made = make(model, 0.25, false, options);
    RenderOptions drawing;
    drawing.transport = LightTransport::direct;
    drawing.lighting = {.directionals = {{.toward = Vec3(-1, 0, 0.05)}}, .ambient = 0};
    drawing.samples_per_pixel = 16;
    const Image image = render(scene_of(made), camera_at(Vec3(0.7, 0, 6), 41), drawing);
    return image.at(20, 20);
  };
  const Rgb direct = floor_color(0), passed = floor_color(1);
  // Grazing light, and the red wall that it meets at a right angle.
  EXPECT_NEAR(direct.x(), direct.y(), 1e-6);
  EXPECT_GT(passed.x() - direct.x(), 0.05f);
  EXPECT_GT(passed.x() - direct.x(), 4 * (passed.y() - direct.y()));
}

TEST(BillboardReflectance, LightOfTheCameraIsThatOnTheModel) {
  const PolygonSoup model = uv_ball(20);
  const Made made = make(model, 0.06, false, {.light_side = 5, .samples = 2, .shaded = 1, .bounces = 0});
  const Camera camera = camera_at(Vec3(1, 2, 3), 60);
  const Image a = render(Scene(model), camera), b = render(scene_of(made), camera);
  // Pixels at the outline, and values between lights.
  EXPECT_LT(mean_difference(a, b), 0.03);
}

TEST(BillboardReflectance, RaysThatLeaveMeetOtherPlacementsAlone) {
  PolygonSoup model;
  add_square(model, Vec3(0, 0, 0), 1);
  add_square(model, Vec3(0, 0, 1), 1);
  const Made made = make(model, 0.25, false, {.view_side = 2, .light_side = 2});
  ASSERT_EQ(made.textures->billboards.size(), 2u);
  const auto is_shadowed = [&](const PlacedBillboards& placed) {
    const Scene scene(std::span<const PolygonSoup>{}, std::span(&placed, 1));
    detail::Ray ray;
    ray.origin = scene.data().scaled(Vec3(0.1, 0.2, -3)).cast<float>();
    ray.direction = Eigen::Vector3f(0, 0, 1);
    detail::Hit hit;
    EXPECT_TRUE(detail::nearest_hit(scene.data(), ray, hit));
    ray.origin += hit.distance * ray.direction;
    ray.from = hit.part;
    return detail::occluded(scene.data(), ray);
  };
  PlacedBillboards placed = made.placed();
  EXPECT_FALSE(is_shadowed(placed));
  placed.placements.push_back(Eigen::Affine3d(Eigen::Translation3d(0, 0, 5)));
  EXPECT_TRUE(is_shadowed(placed));
  EXPECT_TRUE(is_shadowed({.textures = made.textures}));
}

TEST(BillboardReflectance, OfATreeTakesAHundredthAndIsOffByLess) {
  const PolygonSoup tree = make_tree({.leaves = k_sanitized ? 10u : 40u});
  const Made made = make(tree, k_sanitized ? 0.8 : 0.5, true,
                         {.view_side = 5, .samples = 2, .shaded = 2, .radiance = {.components = 4}});
  const BillboardReflectance& reflectance = *made.reflectance;
  const auto raw = static_cast<double>(raw_bytes(reflectance));
  // One cluster is the least.
  EXPECT_LT(static_cast<double>(bytes(reflectance)), (k_sanitized ? 0.1 : 0.01) * raw);
  EXPECT_LT(reflectance.error.rms, 0.06);
  EXPECT_GT(reflectance.error.range, 0.1);
}

TEST(BillboardReflectance, IsTheSameForAnyThreadsAndMemory) {
  const PolygonSoup tree = make_tree({.leaves = 10});
  const BillboardReflectanceOptions few{.view_side = 3, .light_side = 3, .samples = 2, .shaded = 2};
  const Made made = make(tree, 1, true, few);
  BillboardReflectanceOptions without_memory = few;
  without_memory.memory = 0;
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  for (const BillboardReflectanceOptions& options : {few, without_memory}) {
    const Made again = make(tree, 1, true, options);
    EXPECT_EQ(again.reflectance->vectors, made.reflectance->vectors);
    EXPECT_EQ(again.reflectance->opacity, made.reflectance->opacity);
    EXPECT_EQ(again.reflectance->radiance.parts, made.reflectance->radiance.parts);
    EXPECT_EQ(again.reflectance->radiance.weights, made.reflectance->radiance.weights);
  }
}

TEST(BillboardReflectance, ComesBackFromItsFile) {
  PolygonSoup model;
  add_square(model, Vec3::Zero(), 1);
  const Made made = make(model, 0.5, true, {.view_side = 2, .light_side = 3});
  const test::TempFolder folder;
  const auto path = folder / "square.reflectance";
  write_billboard_reflectance(path, *made.reflectance);
  const BillboardReflectance back = read_billboard_reflectance(path);
  EXPECT_EQ(back.view_side, 2);
  EXPECT_EQ(back.light_side, 3);
  EXPECT_EQ(back.width, made.textures->color.width);
  EXPECT_EQ(back.height, made.textures->color.height);
  EXPECT_TRUE(back.is_two_sided);
  EXPECT_EQ(back.vectors, made.reflectance->vectors);
  EXPECT_EQ(back.opacity, made.reflectance->opacity);
  EXPECT_EQ(back.radiance.parts, made.reflectance->radiance.parts);
  EXPECT_EQ(back.error.rms, made.reflectance->error.rms);

  const std::string bytes = read_whole_file(path);
  for (std::size_t size = 0; size < bytes.size(); size += 101) {
    write_file_atomically(path, std::string_view(bytes).substr(0, size));
    EXPECT_THROW(read_billboard_reflectance(path), InputError) << size;
  }
}

TEST(BillboardReflectance, RefusesWhatCantBe) {
  PolygonSoup model;
  add_square(model, Vec3::Zero(), 1);
  const Made made = make(model, 1, false, {.view_side = 2, .light_side = 2});
  for (const BillboardReflectanceOptions& options :
       {BillboardReflectanceOptions{.view_side = 0}, BillboardReflectanceOptions{.light_side = 33},
        BillboardReflectanceOptions{.samples = 0}, BillboardReflectanceOptions{.shaded = 0},
        BillboardReflectanceOptions{.bounces = -1}, BillboardReflectanceOptions{.largest_share = 0},
        BillboardReflectanceOptions{.memory = -1}})
    EXPECT_THROW(make_billboard_reflectance(model, made.cloud, *made.textures, options), OptionError);
  EXPECT_THROW(make_billboard_reflectance(model, BillboardCloud{}, *made.textures), InputError);
  BillboardCloud impostor = made.cloud;
  impostor.is_impostor = true;
  EXPECT_THROW(make_billboard_reflectance(model, impostor, *made.textures), InputError);
  EXPECT_THROW(make_billboard_reflectance(PolygonSoup{}, made.cloud, *made.textures), InputError);
  PolygonSoup large = model;
  add_square(large, Vec3(5, 0, 0), 2);
  PlacedBillboards wrong = make(large, 0.5, false, {.view_side = 2, .light_side = 2}).placed();
  wrong.textures = made.textures;
  EXPECT_THROW(Scene(std::span<const PolygonSoup>{}, std::span(&wrong, 1)), InputError);
}

}  // namespace
}  // namespace recede
