#include "cancelling.h"
#include "shapes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/shading_normals.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace recede {
namespace {

Camera front_camera(double distance, int side) {
  return {.position = Vec3(0, 0, distance), .field_of_view = 0.6, .width = side, .height = side};
}

// White material, one lamp behind the camera, nothing else.
RenderOptions head_light() {
  RenderOptions options;
  options.background = Rgb::Zero();
  options.camera_light = {
      .toward = Vec3::UnitZ(), .lamp = Rgb::Ones(), .sky = Rgb::Zero(), .ground = Rgb::Zero()};
  return options;
}

PolygonSoup white(PolygonSoup soup) {
  soup.materials.push_back({.name = "white", .base_color = Vec4::Ones(), .base_color_texture = ""});
  soup.face_materials.assign(soup.n_faces(), 0);
  return soup;
}

// Sum of all pixels' red, for pictures that are 1 on the model and 0 elsewhere.
double covered_pixels(const Image& image) {
  double sum = 0;
  for (const Rgb& pixel : image.pixels) sum += static_cast<double>(pixel.x());
  return sum;
}

RenderOptions silhouette() {
  RenderOptions options = head_light();
  options.camera_light.lamp = Rgb::Zero();
  options.camera_light.sky = options.camera_light.ground = Rgb::Ones();
  options.samples_per_pixel = 16;
  return options;
}

TEST(Renderer, ASphereCoversTheDiscOfItsTangentCone) {
  const Scene scene(white(make_sphere(Vec3::Zero(), 1, 256, 128)));
  const Camera camera = front_camera(6, 200);
  const double diameter = projected_diameter(camera, 1);
  const double disc = std::numbers::pi / 4 * diameter * diameter;
  EXPECT_NEAR(covered_pixels(render(scene, camera, silhouette())), disc, 0.003 * disc);
}

TEST(Renderer, ACubeSeenFromTheFrontCoversItsNearFace) {
  const Scene scene(white(make_cube(Vec3::Zero(), 1)));
  const Camera camera = front_camera(3, 120);
  // The near face lies at depth 2.5.
  const double side = 1 / (2.5 * 2 * std::tan(0.3)) * 120;
  EXPECT_NEAR(covered_pixels(render(scene, camera, silhouette())), side * side, 0.01 * side * side);
}

TEST(Renderer, SmoothNormalsShadeASphereByTheCosine) {
  const Scene scene(white(make_sphere(Vec3::Zero(), 1, 256, 128)));
  const Camera camera{.position = Vec3(0, 0, 1000), .field_of_view = 0.0025, .width = 101, .height = 101};
  RenderOptions options = head_light();
  options.samples_per_pixel = 1;
  const Image image = render(scene, camera, options);
  for (const int x : {50, 60, 70, 80, 85}) {
    const double offset = (x - 50) * 1000 * 2 * std::tan(0.00125) / 101;
    EXPECT_NEAR(image.at(x, 50).x(), std::sqrt(1 - offset * offset), 0.004) << x;
  }
}

TEST(Renderer, ACubeIsShadedFlatAndEachFaceByItsOwnNormal) {
  const Scene scene(white(make_cube(Vec3::Zero(), 1)));
  const Camera camera{.position = Vec3(4, 0, 4), .field_of_view = 0.3, .width = 100, .height = 100};
  RenderOptions options = head_light();
  const Image image = render(scene, camera, options);
  const float expected = static_cast<float>(std::cos(std::numbers::pi / 4));
  for (const int x : {20, 35, 65, 80}) EXPECT_NEAR(image.at(x, 50).x(), expected, 1e-6f) << x;
}

TEST(Renderer, BothSidesOfASurfaceLookAlike) {
  PolygonSoup soup = make_sphere(Vec3::Zero(), 1, 32, 16);
  const Camera camera = front_camera(5, 64);
  const Image outside = render(Scene(soup), camera);
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    std::reverse(soup.corner_vertices.begin() + soup.face_offsets[face],
                 soup.corner_vertices.begin() + soup.face_offsets[face + 1]);
  }
  EXPECT_LT(compare_images(outside, render(Scene(soup), camera)).rmse, 2e-3);
}

TEST(Renderer, GivenNormalsAndColoursAreUsed) {
  PolygonSoup soup = white(make_cube(Vec3::Zero(), 1));
  soup.materials[0].base_color = Vec4(0.5, 0.25, 1, 1);
  soup.vertex_colors.assign(soup.positions.size(), Vec4(1, 0.5, 0, 1));
  soup.corner_normals.assign(soup.n_corners(), Vec3(0, std::sin(0.5), std::cos(0.5)));
  RenderOptions options = head_light();
  const Rgb middle = render(Scene(soup), front_camera(3, 11), options).at(5, 5);
  EXPECT_TRUE(middle.isApprox(Rgb(0.5f, 0.125f, 0) * static_cast<float>(std::cos(0.5)), 1e-4f)) << middle;
}

TEST(Renderer, TheNumberOfThreadsDoesNotChangeABit) {
  // Flat facets: where a ray meets two of them on their common edge, the choice would show.
  const PolygonSoup soup = make_sphere(Vec3::Zero(), 1, 300, 150, 0.05);
  RenderOptions options;
  options.wireframe = Wireframe{};
  const auto picture = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return render(Scene(soup, {.crease_angle = 0}), front_camera(5, 300), options);
  };
  EXPECT_TRUE(picture(1).pixels == picture(2).pixels);
}

TEST(Renderer, AModelFarFromTheOriginOrVerySmallLooksTheSame) {
  const Image here = render(Scene(make_sphere(Vec3::Zero(), 1, 64, 32, 0.1)), front_camera(5, 128));
  const auto moved_and_scaled = [&](const Vec3& offset, double scale) {
    Camera camera = front_camera(5, 128);
    camera.position = camera.position * scale + offset;
    camera.target = offset;
    return compare_images(here, render(Scene(make_sphere(offset, scale, 64, 32, 0.1)), camera));
  };
  EXPECT_LT(moved_and_scaled(Vec3(1e6, -1e6, 1e6), 1).rmse, 1e-6);
  EXPECT_LT(moved_and_scaled(Vec3::Zero(), 1e-9).rmse, 1e-6);
  EXPECT_LT(moved_and_scaled(Vec3::Zero(), 1e9).rmse, 1e-6);
}

TEST(Renderer, AModelOfAFewPixelsKeepsItsCoverageFromVeryFar) {
  const Scene scene(white(make_sphere(Vec3::Zero(), 1, 128, 64)));
  const Camera camera{.position = Vec3(0, 0, 1e5), .field_of_view = 1e-4, .width = 16, .height = 16};
  RenderOptions options = silhouette();
  options.samples_per_pixel = 64;
  const double diameter = projected_diameter(camera, 1);
  const double disc = std::numbers::pi / 4 * diameter * diameter;
  EXPECT_NEAR(covered_pixels(render(scene, camera, options)), disc, 0.02 * disc);
}

TEST(Renderer, WireframeDarkensSidesButNotDiagonals) {
  const PolygonSoup soup = white(make_cube(Vec3::Zero(), 1));
  RenderOptions options = head_light();
  const Camera camera = front_camera(3, 301);
  const Image plain = render(Scene(soup), camera, options);
  options.wireframe = Wireframe{.width = 2, .darkness = 1};
  const Image lines = render(Scene(soup), camera, options);
  const int half_side = static_cast<int>(0.5 / (2.5 * 2 * std::tan(0.3)) * 301);
  EXPECT_LT(lines.at(150 + half_side, 150).x(), 0.5f * plain.at(150 + half_side, 150).x());
  // Both diagonals of the near face are as bright as without lines.
  for (const int offset : {0, 20, 45, 70}) {
    EXPECT_EQ(lines.at(150 + offset, 150 + offset), plain.at(150 + offset, 150 + offset));
    EXPECT_EQ(lines.at(150 + offset, 150 - offset), plain.at(150 + offset, 150 - offset));
  }
}

TEST(Renderer, EverySampleCountCoversThePixelEvenly) {
  const Scene scene(white(make_cube(Vec3::Zero(), 1)));
  // The edge of the near face cuts the middle column somewhere; coverage is right to within one sample
  // column.
  const Camera camera{
      .position = Vec3(0.5, 0, 3), .target = Vec3(0.5, 0, 0), .field_of_view = 0.1, .width = 3, .height = 3};
  for (const int samples : {1, 2, 3, 4, 5, 9, 16, 100}) {
    RenderOptions options = silhouette();
    options.samples_per_pixel = samples;
    EXPECT_NEAR(render(scene, camera, options).at(1, 1).x(), 0.5, 0.5 / samples + 1e-5) << samples;
  }
}

TEST(Renderer, OptionsOutOfRangeAreRefused) {
  const Scene scene(make_cube(Vec3::Zero(), 1));
  RenderOptions options;
  options.samples_per_pixel = 0;
  EXPECT_THROW(render(scene, front_camera(3, 4), options), OptionError);
  EXPECT_THROW(Scene(PolygonSoup{}), InputError);
}

TEST(Renderer, CancellingStopsThePicture) {
  test::Cancelling cancelling;
  const Scene scene(make_cube(Vec3::Zero(), 1));
  EXPECT_THROW(render(scene, front_camera(3, 4), {}, &cancelling), Cancelled);
}

TEST(ShadingNormals, CreasesSplitThemAndSmoothEdgesShareThem) {
  const PolygonSoup cube = make_cube(Vec3::Zero(), 2);
  const std::vector<Vec3> flat = shading_normals(cube, 0.7);
  const std::vector<Vec3> smooth = shading_normals(cube, 1.7);  // more than the cube's right angles
  for (std::size_t face = 0; face < 6; ++face) {
    for (Index corner = cube.face_offsets[face]; corner < cube.face_offsets[face + 1]; ++corner) {
      EXPECT_TRUE(flat[corner].isApprox(vector_area(cube, face).normalized(), 1e-12));
      EXPECT_TRUE(smooth[corner].isApprox(cube.positions[cube.corner_vertices[corner]].normalized(), 1e-12));
    }
  }
}

TEST(ShadingNormals, FacesWithoutAreaTakeTheirNeighboursNormalOrNone) {
  PolygonSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  soup.add_face(std::array<Index, 3>{0, 1, 2});
  for (const Vec3& normal : shading_normals(soup, 0.7)) EXPECT_TRUE(normal.isZero(0));
}

}  // namespace
}  // namespace recede
