// textured_shell TEXTURE OUTPUT.png [MODEL THICKNESS PERIODS]: a volume texture (chain-mail, weave, bark,
// bubbles or bushes) in a shell around a torus, or around a model in a file: THICKNESS as a share of its
// longest side, and PERIODS of the texture across its atlas.
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/render/image_io.h>
#include <recede/render/renderer.h>
#include <recede/shells/procedural_volumes.h>

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <string>

namespace {

using namespace recede;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Around the y axis, with texture coordinates once around each way.
PolygonSoup make_torus(int around, int across) {
  constexpr double k_radius = 1, k_tube = 0.42;
  PolygonSoup torus;
  const auto vertex = [&](int i, int j) { return static_cast<Index>((i % around) * across + j % across); };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / across;
      const double radius = k_radius + k_tube * std::cos(b);
      torus.positions.emplace_back(radius * std::cos(a), -k_tube * std::sin(b), radius * std::sin(a));
    }
  }
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      torus.add_face(std::array{vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      for (const auto& [di, dj] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
        torus.corner_uvs.emplace_back((i + di) * 1.0 / around, (j + dj) * 1.0 / across);
    }
  }
  return torus;
}

ProceduralVolume volume_named(const std::string& name) {
  if (name == "chain-mail") return chain_mail();
  if (name == "weave") return weave();
  if (name == "bark") return bark();
  if (name == "bubbles") return bubbles();
  if (name == "bushes") return bushes();
  throw OptionError("there is no texture " + name);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3 && argc != 6) {
    std::cerr << "usage: textured_shell TEXTURE OUTPUT.png [MODEL THICKNESS PERIODS]\n";
    return 2;
  }
  const ProceduralVolume volume = volume_named(argv[1]);
  // As many as make periods about as long both ways.
  VolumeCoordinates coordinates{
      .repeat = {std::round(30 / volume.extent.x()), std::round(12 / volume.extent.y())}};
  double thickness = 0.06;
  PolygonSoup base;
  if (argc == 6) {
    thickness = std::stod(argv[4]);
    const double periods = std::stod(argv[5]);
    PolygonSoup model = read_soup(argv[3]);
    merge_identical_vertices(model);
    const AtlasResult atlas = make_atlas(model);
    base = atlas.soup;
    thickness *= bounding_box(base).sizes().maxCoeff();
    coordinates.repeat = {periods, periods * volume.extent.x() / volume.extent.y()};
  } else {
    base = make_torus(96, 40);
  }

  Clock::time_point start = Clock::now();
  PlacedVolume placed;
  placed.textured.shell = std::make_shared<const Shell>(build_shell(base, {.thickness = thickness}));
  std::cout << fmt::format("shell: {:.2f} s, {}\n", seconds_since(start),
                           placed.textured.shell->is_valid() ? "valid" : "not valid");
  start = Clock::now();
  placed.textured.texture = std::make_shared<const VolumeMipmap>(make_mipmap(make_volume(volume, 64)));
  placed.textured.coordinates = coordinates;
  std::cout << fmt::format("texture: {:.2f} s\n", seconds_since(start));

  start = Clock::now();
  const bool is_metal = volume.color == nullptr;
  placed.color = is_metal ? Rgb(0.62f, 0.63f, 0.66f) : Rgb(0.7f, 0.7f, 0.7f);
  PolygonSoup solid = base;
  solid.materials.assign(1, Material{});
  solid.materials[0].base_color = is_metal ? Vec4(0.25, 0.08, 0.07, 1) : Vec4(0.12, 0.10, 0.09, 1);
  solid.face_materials.assign(solid.n_faces(), 0);
  const Camera camera = camera_in_front(base.positions, Vec3::UnitY(), std::numbers::pi / 6, 800, 600);
  placed.view = volume_view(camera);
  const Scene scene(std::span(&solid, 1), std::span<const PlacedVolume>(&placed, 1));
  std::cout << fmt::format("scene: {:.2f} s\n", seconds_since(start));
  start = Clock::now();
  const Image image = render(scene, camera, {.samples_per_pixel = 4});
  std::cout << fmt::format("picture: {:.2f} s\n", seconds_since(start));
  write_image(argv[2], image);
} catch (const std::logic_error&) {
  std::cerr << "textured_shell: THICKNESS and PERIODS are numbers\n";
  return 2;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
