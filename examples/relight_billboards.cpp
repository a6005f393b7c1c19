// relight_billboards OUTPUT.png [LEAVES ERROR SAMPLES]: a tree under the sun in the front, from the side and
// from behind (rows) as triangles, as billboards with normal maps, and as billboards with reflectance
// (columns). ERROR is a share of its longest side, SAMPLES those of a pixel.
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/render/image_difference.h>
#include <recede/render/renderer.h>

#include <array>
#include <chrono>
#include <iostream>
#include <stdexcept>
#include <string>

namespace {

using namespace recede;

BillboardCloud make_cloud(const PolygonSoup& tree, double share) {
  BillboardOptions options;
  options.errors = {share * bounding_box(tree).sizes().maxCoeff()};
  options.is_two_sided = true;
  return build_billboard_clouds(tree, options).front();
}

Scene scene_of(const PlacedBillboards& billboards) {
  return Scene(std::span<const PolygonSoup>{}, std::span(&billboards, 1));
}

Image draw(const Scene& scene, const Vec3& sun, int samples) {
  Camera camera;
  camera.position = {0, 5.5, 20};
  camera.target = {0, 5, 0};
  camera.field_of_view = 0.5;
  camera.width = camera.height = 144;
  RenderOptions options;
  options.transport = LightTransport::path;
  options.samples_per_pixel = samples;
  options.background = Rgb::Constant(0.8f);
  options.lighting.directionals = {{.toward = sun, .irradiance = Rgb::Constant(6)}};
  return render(scene, camera, options);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void relight(const std::string& path, std::size_t leaves, double share, int samples) {
  const PolygonSoup tree = make_tree({.leaves = leaves});
  const BillboardCloud cloud = make_cloud(tree, share);
  const auto textures = std::make_shared<const BillboardTextures>(texture_billboards(tree, cloud));
  const auto start = std::chrono::steady_clock::now();
  const auto reflectance = std::make_shared<const BillboardReflectance>(
      make_billboard_reflectance(tree, cloud, *textures, {.shaded = 16}));
  std::cout << textures->billboards.size() << " billboards, " << reflectance->vector_count()
            << " sides of texels: " << raw_bytes(*reflectance) << " bytes in " << bytes(*reflectance)
            << ", off by " << 100 * reflectance->error.rms << " % of the range, after "
            << seconds_since(start) << " s\n";

  const std::array<Scene, 3> scenes{Scene(tree), scene_of({.textures = textures}),
                                    scene_of({.textures = textures, .reflectance = reflectance})};
  Image picture;
  for (const Vec3& sun : {Vec3(0.5, 0.9, 1), Vec3(-1, 0.6, 0.1), Vec3(0.3, 0.8, -1)}) {
    std::vector<Image> row;
    for (const Scene& scene : scenes) row.push_back(draw(scene, sun, samples));
    for (const int pixels : {1, 3}) {
      const auto off_by = [&](std::size_t column) {
        return compare_images(shrink(row[0], pixels), shrink(row[column], pixels)).rmse;
      };
      std::cout << "off by " << off_by(1) << " with normal maps, by " << off_by(2) << " with reflectance, "
                << (pixels == 1 ? "as here\n" : "three times as far away\n");
    }
    const Image beside = side_by_side(row);
    picture.width = beside.width;
    picture.height += beside.height;
    picture.pixels.insert(picture.pixels.end(), beside.pixels.begin(), beside.pixels.end());
  }
  write_png(path, picture);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2 && argc != 5) {
    std::cerr << "usage: relight_billboards OUTPUT.png [LEAVES ERROR SAMPLES]\n";
    return 2;
  }
  const bool is_own = argc == 5;
  relight(argv[1], is_own ? std::stoul(argv[2]) : 60, is_own ? std::stod(argv[3]) : 0.06,
          is_own ? std::stoi(argv[4]) : 4);
} catch (const std::logic_error&) {
  std::cerr << "relight_billboards: LEAVES, ERROR and SAMPLES are numbers\n";
  return 2;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
