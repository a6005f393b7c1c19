// forest OUTPUT.png [TREES]: thousands of trees in one picture, TREES (64) along a side of the forest, each
// by the billboards that its distance needs.
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/billboard_texture.h>
#include <recede/render/image_io.h>
#include <recede/render/renderer.h>

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <numbers>
#include <random>
#include <stdexcept>

namespace {

using namespace recede;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Clouds of a tree, finest first: by clusters near by, and by a few planes where those are small.
std::vector<std::shared_ptr<const BillboardTextures>> clouds_of(const PolygonSoup& tree) {
  std::vector<std::shared_ptr<const BillboardTextures>> clouds;
  const double size = bounding_box(tree).sizes().maxCoeff();
  for (const double share : {0.01, 0.04, 0.08}) {
    BillboardOptions options{.errors = {share * size}, .is_two_sided = true};
    if (share > 0.01) options.method = BillboardMethod::plane_cover;
    const BillboardCloud cloud = build_billboard_clouds(tree, options).front();
    clouds.push_back(
        std::make_shared<const BillboardTextures>(texture_billboards(tree, cloud, {.texels_per_error = 2})));
    std::cout << fmt::format("error {:.2g}: {} billboards, {} texels\n", cloud.error, cloud.billboards.size(),
                             clouds.back()->n_texels());
  }
  return clouds;
}

/// One tree in each cell of a grid, anywhere in it and turned anyhow.
std::vector<Eigen::Affine3d> places_of(int n_along, double spacing) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<Eigen::Affine3d> places;
  for (int row = 0; row < n_along; ++row) {
    for (int column = 0; column < n_along; ++column) {
      const double x = spacing * (column - n_along / 2 + number(random)),
                   z = -spacing * (row + number(random));
      places.push_back(Eigen::Translation3d(x, 0, z) *
                       Eigen::AngleAxisd(2 * std::numbers::pi * number(random), Vec3::UnitY()) *
                       Eigen::Scaling(0.8 + 0.5 * number(random)));
    }
  }
  return places;
}

/// The coarsest cloud whose error is at most a pixel and a half from there.
std::size_t choose_cloud(const std::vector<std::shared_ptr<const BillboardTextures>>& clouds, double distance,
                         double pixel) {
  constexpr double k_pixels = 1.5;
  std::size_t chosen = 0;
  for (std::size_t i = 0; i < clouds.size(); ++i) {
    if (clouds[i]->error <= k_pixels * pixel * distance) chosen = i;
  }
  return chosen;
}

void draw_forest(const char* file, int n_along) {
  const PolygonSoup tree = make_tree();
  const auto clouds = clouds_of(tree);
  Camera camera{.position = {0, 26, 40}, .target = {0, 6, -70}, .width = 880, .height = 440};
  const CameraFrame frame = frame_of(camera);
  std::vector<PlacedBillboards> forest;
  for (const auto& cloud : clouds) forest.push_back({cloud, {}});
  for (const Eigen::Affine3d& place : places_of(n_along, 9)) {
    const double distance = (place.translation() - camera.position).norm();
    forest[choose_cloud(clouds, distance, frame.pixel)].placements.push_back(place);
  }
  std::erase_if(forest, [](const PlacedBillboards& placed) { return placed.placements.empty(); });
  const auto start = Clock::now();
  SceneOptions options;
  options.ground = Ground{.color = Rgb(0.12f, 0.2f, 0.06f)};
  const Scene scene(std::span<const PolygonSoup>{}, forest, options);
  const double building = seconds_since(start);
  RenderOptions rendering{.samples_per_pixel = 4, .background = rgb_from_hex(0xb8d0e8)};
  rendering.transport = LightTransport::direct;
  rendering.lighting = recede::daylight();
  rendering.lighting.environment->visible = false;
  const auto first = Clock::now();
  const Image picture = render(scene, camera, rendering);
  std::size_t n_trees = 0, n_billboards = 0;
  for (const PlacedBillboards& placed : forest) {
    n_trees += placed.placements.size();
    n_billboards += placed.placements.size() * placed.textures->billboards.size();
  }
  std::cout << fmt::format("{} trees of {} billboards; ready in {:.2g} s, drawn in {:.2g} s\n", n_trees,
                           n_billboards, building, seconds_since(first));
  write_png(file, shrink(picture, 2));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 3) {
    std::cerr << "usage: forest OUTPUT.png [TREES]\n";
    return 2;
  }
  draw_forest(argv[1], argc == 3 ? std::stoi(argv[2]) : 64);
} catch (const std::logic_error&) {
  std::cerr << "forest: TREES isn't a number\n";
  return 2;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
