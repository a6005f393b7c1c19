#include "measured_radiance.h"
#include "pictures.h"
#include "shapes.h"
#include <recede/geometry/error.h>
#include <recede/render/image_difference.h>

#include <gtest/gtest.h>

#include <array>
#include <numbers>

namespace recede {
namespace {

TEST(Scene, SeveralModelsKeepTheirPlacesAndColours) {
  const std::vector<PolygonSoup> soups{with_albedo(make_cube({-1, 0, 0}, 1), 0.2),
                                       with_albedo(make_cube({1, 0, 0}, 1), 0.9)};
  const Scene scene{std::span<const PolygonSoup>(soups)};
  RenderOptions options;
  options.background = Rgb::Zero();
  options.camera_light = {
      .toward = Vec3::UnitZ(), .lamp = Rgb::Ones(), .sky = Rgb::Zero(), .ground = Rgb::Zero()};
  const auto seen = [&](double x) { return measure_radiance(scene, {x, 0, 5}, {x, 0, 0}, options, 1).mean; };
  EXPECT_NEAR(seen(-1), 0.2, 1e-6);
  EXPECT_NEAR(seen(1), 0.9, 1e-6);
  EXPECT_EQ(seen(0), 0);
  EXPECT_THROW(Scene(std::span<const PolygonSoup>{}), InputError);
  const std::vector<PolygonSoup> with_empty{soups[0], PolygonSoup{}};
  EXPECT_THROW(Scene(std::span<const PolygonSoup>(with_empty)), InputError);
}

TEST(Scene, TheGroundTouchesTheModelsFromBelowAndReceivesTheirShadow) {
  for (const Vec3& up : {Vec3(0, 0, 1), Vec3(0, 2, 0), Vec3(1, 2, 3)}) {
    const Vec3 y = up.normalized(), x = y.unitOrthogonal();
    const Vec3 middle(100, -50, 20);
    const PolygonSoup ball = make_sphere(middle, 1, 64, 32);
    double lowest = 0;
    for (const Vec3& position : ball.positions) lowest = std::min(lowest, (position - middle).dot(y));
    const Scene scene(ball, {.ground = Ground{.up = up, .color = Rgb::Constant(0.25f)}});
    Lighting lighting;
    lighting.directionals.push_back({.toward = y + 0.5 * x, .irradiance = Rgb::Constant(4)});
    const RenderOptions options = direct_light(lighting);
    const double open = 0.25 * 4 / std::sqrt(1.25) / std::numbers::pi;
    // Seen from above, through places on the ground that the ball leaves free.
    const auto seen = [&](double along, double height) {
      const Vec3 target = middle + height * y + along * x;
      return measure_radiance(scene, target + 10 * y, target, options, 4).mean;
    };
    EXPECT_NEAR(seen(3, lowest), open, 1e-5);
    EXPECT_NEAR(seen(-30, lowest), open, 1e-5);
    // The ball's middle shades the place half its height aside, where the ball itself reaches to 1.
    EXPECT_EQ(seen(-1.2, lowest), 0);
    EXPECT_NEAR(seen(-2.2, lowest), open, 1e-5);
    // A lamp one unit above it tells its height.
    Lighting lamp;
    lamp.points.push_back({.position = middle + (lowest + 1) * y + 3 * x, .intensity = Rgb::Ones()});
    const Vec3 below = middle + lowest * y + 3 * x;
    const double lit = measure_radiance(scene, below + 2 * y + y.cross(x), below, direct_light(lamp), 4).mean;
    EXPECT_NEAR(lit, 0.25 / std::numbers::pi, 1e-5);
  }
  EXPECT_THROW(Scene(make_floor(1), {.ground = Ground{.up = Vec3::Zero()}}), OptionError);
}

TEST(Scene, AGroundCostsAModelNoDetail) {
  const PolygonSoup soup = make_sphere({3e4, 0, 0}, 1, 64, 32, 0.1);
  const Camera camera{.position = Vec3(3e4, 0, 5),
                      .target = Vec3(3e4, 0, 0),
                      .field_of_view = 0.2,
                      .width = 40,
                      .height = 40};
  // The whole picture lies on the model. Rays start elsewhere, so float rounds them elsewhere.
  const Image alone = render(Scene(soup), camera);
  const Image with_ground = render(Scene(soup, {.ground = Ground{.up = Vec3::UnitY()}}), camera);
  EXPECT_LT(compare_images(alone, with_ground).rmse, 1e-5);
}

TEST(Scene, TexturesAreFactorsOfBaseColoursAndVertexColours) {
  PolygonSoup soup;
  soup.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  soup.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  soup.materials = {{"skin", {0.5, 0.5, 1, 1}, "skin.png"}};
  soup.materials[0].base_color_picture = test::png_of(test::four_quarters());
  soup.face_materials = {0};
  soup.vertex_colors.assign(4, Vec4(1, 0.5, 1, 1));
  const Camera camera{.position = Vec3(0, 0, 4), .field_of_view = 0.5, .width = 40, .height = 40};
  RenderOptions options;
  options.camera_light = {
      .toward = Vec3::UnitZ(), .lamp = Rgb::Zero(), .sky = Rgb::Ones(), .ground = Rgb::Ones()};
  const Image picture = render(Scene(soup), camera, options);
  const auto expect_color = [&](int x, int y, const Rgb& expected) {
    const Rgb difference = picture.at(x, y) - expected;
    // Samples of textures have 16 bits, and pictures floats.
    EXPECT_LT(difference.cwiseAbs().maxCoeff(), 1e-4f)
        << x << ' ' << y << ": " << picture.at(x, y).transpose();
  };
  expect_color(10, 10, {0.5f, 0, 0});
  expect_color(29, 10, {0, 0.25f, 0});
  expect_color(10, 29, {0, 0, 1});
  expect_color(29, 29, {0.5f, 0.25f, 1});
}

}  // namespace
}  // namespace recede
