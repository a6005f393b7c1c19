#include "transition_scene.h"

#include "tiled_surfaces.h"
#include <recede/render/renderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

constexpr double k_pi = std::numbers::pi;

DisplacementMap make_waves() {
  constexpr int k_size = 64, k_waves = 40;
  constexpr double k_crest = 0.005;
  std::mt19937 random(1);
  std::uniform_int_distribution<int> step(-4, 4);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<double> sums(k_size * k_size, 0.0);
  for (int wave = 0; wave < k_waves; ++wave) {
    const int u = step(random), v = step(random);
    const double phase = 2 * k_pi * number(random), amplitude = u == 0 && v == 0 ? 0 : number(random);
    for (int y = 0; y < k_size; ++y) {
      for (int x = 0; x < k_size; ++x) {
        sums[static_cast<std::size_t>(y * k_size + x)] +=
            amplitude * std::cos(2 * k_pi * (u * x + v * y) / k_size + phase);
      }
    }
  }
  const double most = *std::max_element(sums.begin(), sums.end());
  std::vector<float> heights;
  for (const double sum : sums) heights.push_back(static_cast<float>(k_crest * sum / most));
  return DisplacementMap(k_size, k_size, std::move(heights), MapBorder::periodic);
}

/// With pixels so small that two cover a wave at a distance.
Camera with_pixels(Camera camera, const TransitionScene& scene, double two_pixels, int size) {
  const double pixel = scene.appearance->wavelength() / (2 * two_pixels);
  camera.up = Vec3::UnitZ();
  camera.width = camera.height = size;
  camera.field_of_view = 2 * std::atan(pixel * size / 2);
  return camera;
}

}  // namespace

TransitionScene::TransitionScene(const AppearanceOptions& options)
    : base(test::tiled_torus(96, 48, 60, 25)),
      map(make_waves()),
      appearance(make_appearance(base, map, options)),
      scene(base, map, {}, SceneOptions{.appearance = appearance}),
      bare(base) {}

Scene TransitionScene::plane() const {
  constexpr double k_tiles = 16;
  PolygonSoup square = test::tiled_square(k_tiles);
  square.materials.push_back(
      {.name = "matt", .base_color = Vec4(0.7, 0.7, 0.7, 1), .base_color_texture = ""});
  square.face_materials = {0};
  const double side = 2 / k_tiles;
  std::vector<float> heights;
  for (const float height : map.float_samples())
    heights.push_back(static_cast<float>(side / appearance->stretch().sides.mean()) * height);
  const DisplacementMap waves(map.columns(), map.rows(), std::move(heights), MapBorder::periodic);
  SceneOptions options;
  options.appearance = make_appearance(square, waves);
  DisplacedMeshOptions fine;
  fine.level = 11;  // two small squares to the side of a texel
  return Scene(square, waves, fine, options);
}

double TransitionScene::two_pixels(const Camera& camera) const {
  return transition_for_wavelength(appearance->wavelength(), frame_of(camera).pixel).unit / 2;
}

Camera camera_at(const TransitionScene& scene, double distance, int size) {
  Camera camera;
  camera.target = {0, -1.1, 0.38};  // on the tube
  camera.position = camera.target + 3 * Vec3(0, -0.75, 0.66).normalized();
  return with_pixels(camera, scene, 3 / distance, size);
}

Camera camera_along(const TransitionScene& scene, double farthest, int size) {
  Camera camera;
  camera.position = {-0.7, -1, 0.75};
  camera.target = {0.9, -0.55, 0.2};
  constexpr double k_farthest = 2.1;  // where the tube ends on the other side
  return with_pixels(camera, scene, k_farthest / farthest, size);
}

Image draw(const Scene& scene, const Camera& camera, const DrawnBy& by) {
  RenderOptions options;
  options.samples_per_pixel = by.samples;
  options.representation = by.representation;
  options.transition = by.transition;
  options.background = Rgb::Zero();
  return render(scene, camera, options);
}

double plane_brightness(const Scene& plane, const PlaneView& view) {
  constexpr int k_around = 16, k_size = 32;
  const double distance = 40, polar = view.view * k_pi / 180, light = view.light * k_pi / 180;
  double sum = 0;
  for (int i = 0; i < k_around; ++i) {
    const double azimuth = 2 * k_pi * i / k_around;
    const auto direction = [](double angle, double around) {
      return Vec3(std::sin(angle) * std::cos(around), std::sin(angle) * std::sin(around), std::cos(angle));
    };
    Camera camera;
    camera.position = distance * direction(polar, azimuth);
    camera.up = Vec3::UnitZ();
    camera.width = camera.height = k_size;
    camera.field_of_view = 2 * std::atan(0.5 * std::cos(polar) / distance);
    RenderOptions options;
    options.samples_per_pixel = view.paths ? 16 : 4;
    options.background = Rgb::Zero();
    options.transport = view.paths ? LightTransport::path : LightTransport::direct;
    options.max_bounces = 8;
    options.lighting = {};
    options.lighting.ambient = 0;
    options.lighting.directionals.push_back(
        {.toward = direction(light, azimuth + k_pi / 2), .irradiance = Rgb::Constant(3)});
    options.representation = view.representation;
    if (view.grown) {
      const auto& [e1, e2, e3, e4] = k_transition_values;
      const double value = e3 + *view.grown * (e4 - e3);
      options.transition =
          TransitionOptions{.unit = distance * (value * (std::cos(polar) + 0.1) + 5), .threshold = 5};
    }
    const Image image = render(plane, camera, options);
    for (const Rgb& pixel : image.pixels)
      sum += static_cast<double>(pixel.x()) / static_cast<double>(image.pixels.size());
  }
  return sum / k_around;
}

}  // namespace recede::bench
