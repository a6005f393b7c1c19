// light_a_box OUTPUT.png [NOISE]: a room of coloured walls under one lamp, by the camera's light, by direct
// light, and by paths of light until the noise is below NOISE.
#include <recede/geometry/error.h>
#include <recede/geometry/polygon_soup.h>
#include <recede/render/image_io.h>
#include <recede/render/progressive_render.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

using namespace recede;

/// A parallelogram with a matt colour.
PolygonSoup make_wall(const Vec3& corner, const Vec3& first, const Vec3& second, const Vec3& color) {
  PolygonSoup wall;
  wall.positions = {corner, corner + first, corner + first + second, corner + second};
  wall.add_face(std::array<Index, 4>{0, 1, 2, 3});
  wall.materials.push_back(
      {.name = "matt", .base_color = {color.x(), color.y(), color.z(), 1}, .base_color_texture = ""});
  wall.face_materials = {0};
  return wall;
}

/// A block that stands on the floor y = 0, turned about its middle.
void add_block(std::vector<PolygonSoup>& walls, const Vec3& foot, const Vec3& size, double angle) {
  const Vec3 color(0.75, 0.75, 0.75);
  const Eigen::AngleAxisd turn(angle, Vec3::UnitY());
  const Vec3 x = turn * Vec3(size.x(), 0, 0), y(0, size.y(), 0), z = turn * Vec3(0, 0, size.z());
  const Vec3 corner = foot - (x + z) / 2;
  walls.push_back(make_wall(corner + y, z, x, color));
  walls.push_back(make_wall(corner, x, y, color));
  walls.push_back(make_wall(corner + z, x, y, color));
  walls.push_back(make_wall(corner, z, y, color));
  walls.push_back(make_wall(corner + x, z, y, color));
}

/// Two units wide, high and deep, open to the front.
std::vector<PolygonSoup> make_room() {
  const Vec3 white(0.75, 0.75, 0.75), red(0.63, 0.06, 0.05), green(0.14, 0.45, 0.09);
  const Vec3 wide(2, 0, 0), high(0, 2, 0), deep(0, 0, 2);
  std::vector<PolygonSoup> walls{
      make_wall({-1, 0, -1}, wide, high, white), make_wall({-1, 0, -1}, deep, wide, white),
      make_wall({-1, 2, -1}, wide, deep, white), make_wall({-1, 0, -1}, high, deep, red),
      make_wall({1, 0, -1}, deep, high, green)};
  add_block(walls, {-0.35, 0, -0.35}, {0.6, 1.2, 0.6}, 0.3);
  add_block(walls, {0.38, 0, 0.35}, {0.6, 0.6, 0.6}, -0.3);
  return walls;
}

std::vector<Image> draw(const Scene& scene, double noise) {
  const Camera camera{
      .position = {0, 1, 4.9}, .target = {0, 1, 0}, .field_of_view = 0.53, .width = 264, .height = 264};
  RenderOptions options;
  options.background = Rgb::Zero();
  options.samples_per_pixel = 64;
  std::vector<Image> pictures{render(scene, camera, options)};

  options.lighting.areas.push_back({.corner = {-0.25, 1.99, -0.25},
                                    .first_edge = {0.5, 0, 0},
                                    .second_edge = {0, 0, 0.5},
                                    .radiance = {17, 12, 6}});
  options.transport = LightTransport::direct;
  pictures.push_back(render(scene, camera, options));

  options.transport = LightTransport::path;
  options.max_bounces = 8;
  options.noise = noise;
  ProgressiveRender paths(scene, camera, options);
  paths.add_samples(4096);
  pictures.push_back(paths.image());

  const FloatRaster counts = paths.sample_counts();
  double samples = 0;
  for (const float count : counts.samples) samples += static_cast<double>(count);
  float error = 0, brightest = 0;
  for (const Rgb& pixel : paths.standard_error().pixels) error = std::max(error, pixel.maxCoeff());
  for (const Rgb& pixel : pictures[2].pixels) brightest = std::max(brightest, pixel.maxCoeff());
  std::cout << samples / static_cast<double>(counts.samples.size())
            << " samples for each pixel, standard errors up to " << error / brightest
            << " of the brightest\n";
  return pictures;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) {
    std::cerr << "usage: light_a_box OUTPUT.png [NOISE]\n";
    return 2;
  }
  const std::vector<recede::PolygonSoup> room = make_room();
  const recede::Scene scene{std::span<const recede::PolygonSoup>(room)};
  recede::write_image(argv[1], recede::side_by_side(draw(scene, argc == 3 ? std::stod(argv[2]) : 0.01)));
} catch (const std::logic_error&) {
  std::cerr << "light_a_box: NOISE isn't a number\n";
  return 2;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
