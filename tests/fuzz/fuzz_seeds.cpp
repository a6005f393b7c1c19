#include "fuzz_seeds.h"

#include "displaced_planes.h"
#include "jpegs.h"
#include "pictures.h"
#include "soups.h"
#include "tiled_surfaces.h"
#include "uv_sheet.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/pmesh.h>
#include <recede/render/appearance.h>
#include <recede/render/billboard_reflectance.h>
#include <recede/render/image_io.h>
#include <recede/render/local_pca.h>
#include <recede/render/reflectance_table.h>
#include <recede/render/scattering_table.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/textured_shell_io.h>

namespace recede::test {
namespace {

namespace fs = std::filesystem;

fs::path named(const fs::path& folder, const char* stem, const char* extension) {
  return folder / (std::string(stem) + extension);
}

PolygonSoup saddle() {
  PolygonSoup soup = uv_sheet(4);
  for (Vec3& position : soup.positions) position.z() = position.x() * position.y() / 2;
  return soup;
}

VisibleNormals few_normals() {
  const DisplacementMap map = random_waves(1, 1.4, 8);
  return sample_visible_normals(DisplacedPlane(map, {4, 4}),
                                {.bins = 5, .views = 3, .azimuths = 2, .samples = 100});
}

}  // namespace

void seed_soup(const fs::path& folder, const char* extension) {
  for (const bool attributes : {false, true}) {
    const PolygonSoup soup = random_soup(7, {.attributes = attributes});
    write_soup(named(folder, attributes ? "b" : "a", extension), soup);
    write_soup(named(folder, attributes ? "bt" : "at", extension), soup, {.ascii = true});
  }
}

void seed_pmesh(const fs::path& folder, const char* extension) {
  ProgressiveOptions options;
  options.simplify.target.ratio = 0.1;
  options.simplify.prove_error = false;
  const ProgressiveMesh mesh = build_progressive_mesh(saddle(), options);
  write_pmesh(named(folder, "a", extension), mesh);
  write_pmesh(named(folder, "b", extension), mesh, {.position_bits = 10, .keep_numbering = true});
}

void seed_shell(const fs::path& folder, const char* extension) {
  VolumeMipmap texture;
  texture.surfaces.push_back(make_volume(weave(), 4));
  const TexturedShell shell{.shell = std::make_shared<const Shell>(build_shell(saddle(), {.thickness = 0.2})),
                            .texture = std::make_shared<const VolumeMipmap>(std::move(texture))};
  write_textured_shell(named(folder, "a", extension), shell);
}

void seed_image(const fs::path& folder, const char* extension) {
  Image image(5, 3);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = Rgb(0.1f * static_cast<float>(i), 0.5f, 0.25f);
  write_image(named(folder, "a", extension), image);
}

void seed_jpeg(const fs::path& folder, const char* extension) {
  std::vector<std::array<std::uint16_t, 3>> texels;
  for (std::uint16_t i = 0; i < 200; ++i) texels.push_back({i, static_cast<std::uint16_t>(255 - i), 90});
  write_file_atomically(named(folder, "a", extension), jpeg_of(raster_of(20, 10, texels), 80));
}

fs::path write_small_hierarchy(const fs::path& folder) {
  HierarchyOptions options;
  options.ratios = {0.5};
  options.measure.samples = 100;
  return write_hierarchy(folder, build_hierarchy(repair_to_polygon_mesh(saddle()).mesh, "a", options)).folder;
}

void seed_hierarchy(const fs::path& folder, const char* extension) {
  const fs::path made = write_small_hierarchy(folder / "files");
  fs::copy_file(made / "hierarchy.json", named(folder, "a", extension), fs::copy_options::overwrite_existing);
  fs::remove_all(folder / "files");
}

void seed_pca(const fs::path& folder, const char* extension) {
  std::vector<float> numbers;
  for (int i = 0; i < 60; ++i) numbers.push_back(static_cast<float>(i * i % 17));
  write_local_pca(named(folder, "a", extension),
                  make_local_pca(vectors_in(numbers, 3), {.clusters = 2, .components = 2}));
}

void seed_appearance(const fs::path& folder, const char* extension) {
  AppearanceOptions options;
  options.normals.samples = 64;
  options.normals.bins = options.normals.views = 3;
  options.shading_samples = 16;
  options.reflectance.light_angles = options.reflectance.light_azimuths = 4;
  write_appearance(named(folder, "a", extension),
                   *make_appearance(tiled_square(3), random_waves(4, 0.1, 8), options));
}

void seed_reflectance(const fs::path& folder, const char* extension) {
  const PolygonSoup model = triangulated(saddle());
  BillboardOptions options;
  options.errors = {2};
  const BillboardCloud cloud = build_billboard_clouds(model, options).front();
  const BillboardTextures textures = texture_billboards(model, cloud);
  write_billboard_reflectance(
      named(folder, "a", extension),
      make_billboard_reflectance(model, cloud, textures, {.view_side = 2, .light_side = 2}));
}

void seed_reflectance_table(const fs::path& folder, const char* extension) {
  write_reflectance_table(named(folder, "a", extension),
                          make_reflectance_table(few_normals(), {.light_angles = 3, .light_azimuths = 4}));
}

void seed_scattering_table(const fs::path& folder, const char* extension) {
  const DisplacementMap map = random_waves(1, 1.4, 8);
  write_scattering_table(
      named(folder, "a", extension),
      make_scattering_table(
          DisplacedPlane(map, {4, 4}),
          {.views = 3, .azimuths = 2, .samples = 100, .light_angles = 3, .light_azimuths = 4, .orders = 2}));
}

}  // namespace recede::test
