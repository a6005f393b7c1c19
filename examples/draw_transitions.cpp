// draw_transitions METHODS.png WAY.png: a torus of waves drawn by what each ray needs: true colours, false
// colours of the methods, and what each costs. Then the same from farther and farther away.
#include <recede/geometry/error.h>
#include <recede/render/appearance.h>
#include <recede/render/method_shares.h>
#include <recede/render/renderer.h>

#include <array>
#include <chrono>
#include <cmath>
#include <iostream>
#include <numbers>

namespace {

/// Around z, over which the map repeats 60 times one way and 25 times the other.
recede::PolygonSoup make_torus() {
  constexpr int around = 96, tube = 48;
  recede::PolygonSoup soup;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < tube; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / tube;
      const double radius = 1 + 0.4 * std::cos(b);
      soup.positions.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.4 * std::sin(b));
    }
  }
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < tube; ++j) {
      std::array<recede::Index, 4> corners{};
      for (std::size_t k = 0; k < 4; ++k) {
        const int p = i + (k == 1 || k == 2 ? 1 : 0), q = j + (k >= 2 ? 1 : 0);
        corners[k] = static_cast<recede::Index>(p % around * tube + q % tube);
        soup.corner_uvs.emplace_back(60.0 * p / around, 25.0 * q / tube);
      }
      soup.add_face(corners);
    }
  }
  return soup;
}

/// Crossing waves, 0.004 high.
recede::DisplacementMap make_waves() {
  constexpr int size = 64;
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double u = 2 * std::numbers::pi * x / size, v = 2 * std::numbers::pi * y / size;
      heights.push_back(static_cast<float>(
          0.002 * (std::sin(3 * u + v) + std::sin(2 * v - 2 * u + 1) + 0.6 * std::sin(4 * v + u))));
    }
  }
  return recede::DisplacementMap(size, size, std::move(heights), recede::MapBorder::periodic);
}

recede::Image draw(const recede::Scene& scene, const recede::Camera& camera, recede::Representation how,
                   bool methods = false) {
  recede::RenderOptions options;
  options.samples_per_pixel = 16;
  options.representation = how;
  options.show_methods = methods;
  const auto start = std::chrono::steady_clock::now();
  recede::Image image = recede::render(scene, camera, options);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  if (!methods)
    std::cout << (how == recede::Representation::automatic ? ", " : "") << seconds.count() << " s";
  return image;
}

/// Displacement everywhere, what each ray needs, and the methods in false colours.
std::array<recede::Image, 3> draw_three(const recede::Scene& scene, const recede::Camera& camera) {
  using recede::Representation;
  std::array<recede::Image, 3> images{draw(scene, camera, Representation::displacement),
                                      draw(scene, camera, Representation::automatic),
                                      draw(scene, camera, Representation::automatic, true)};
  const recede::PictureShares shares = recede::count_methods(scene, camera);
  std::cout << "; displaced in " << 100 * shares.of(recede::RenderingMethod::displacement)
            << " % of the pixels\n";
  return images;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::cerr << "usage: draw_transitions METHODS.png WAY.png\n";
    return 2;
  }
  const recede::PolygonSoup base = make_torus();
  const recede::DisplacementMap map = make_waves();
  const std::shared_ptr<const recede::Appearance> appearance = recede::make_appearance(base, map);
  recede::SceneOptions options;
  options.appearance = appearance;
  const recede::Scene scene(base, map, {}, options);

  recede::Camera camera;
  camera.position = {-0.75, -1.05, 0.75};
  camera.target = {0.15, -0.55, -0.15};
  camera.up = {0, 0, 1};
  camera.width = camera.height = 260;
  // Two pixels cover a wave at 0.8 away.
  camera.field_of_view = 2 * std::atan(appearance->wavelength() / (2 * 0.8) * camera.height / 2);
  recede::write_png(argv[1], recede::side_by_side(draw_three(scene, camera)));

  std::vector<recede::Image> columns;
  for (const double distance : {0.45, 0.75, 1.0, 1.5, 4.0}) {
    // In units of the distance at which two pixels cover a wave.
    constexpr double unit = 5;
    constexpr int size = 96;
    camera.target = {0, -1.1, 0.38};
    camera.position = camera.target + distance * unit * recede::Vec3(0, -0.75, 0.66).normalized();
    camera.field_of_view = 2 * std::atan(appearance->wavelength() / (2 * unit) * size / 2);
    camera.width = camera.height = size;
    std::cout << distance << ": ";
    const std::array<recede::Image, 3> three = draw_three(scene, camera);
    recede::Image column(size, 3 * size);
    for (int y = 0; y < 3 * size; ++y) {
      for (int x = 0; x < size; ++x)
        column.at(x, y) = three[static_cast<std::size_t>(y / size)].at(x, y % size);
    }
    columns.push_back(std::move(column));
  }
  recede::write_png(argv[2], recede::side_by_side(columns));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
