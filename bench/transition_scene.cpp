#include "transition_scene.h"

#include <recede/render/renderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

constexpr double k_pi = std::numbers::pi;

PolygonSoup make_torus() {
  constexpr int k_around = 96, k_tube = 48, k_tiles_around = 60, k_tiles_tube = 25;
  PolygonSoup soup;
  for (int i = 0; i < k_around; ++i) {
    for (int j = 0; j < k_tube; ++j) {
      const double a = 2 * k_pi * i / k_around, b = 2 * k_pi * j / k_tube;
      const double radius = 1 + 0.4 * std::cos(b);
      soup.positions.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.4 * std::sin(b));
    }
  }
  const auto at = [](int i, int j) { return static_cast<Index>(i % k_around * k_tube + j % k_tube); };
  for (int i = 0; i < k_around; ++i) {
    for (int j = 0; j < k_tube; ++j) {
      soup.add_face(std::array<Index, 4>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      for (const auto& [p, q] : std::array<std::array<int, 2>, 4>{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}}) {
        soup.corner_uvs.emplace_back(static_cast<double>(k_tiles_around) * (i + p) / k_around,
                                     static_cast<double>(k_tiles_tube) * (j + q) / k_tube);
      }
    }
  }
  return soup;
}

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
    : base(make_torus()),
      map(make_waves()),
      appearance(make_appearance(base, map, options)),
      scene(base, map, {}, SceneOptions{.appearance = appearance}),
      bare(base) {}

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

}  // namespace recede::bench
