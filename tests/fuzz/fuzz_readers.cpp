// Readers fed with bytes that a fuzzer invents (libFuzzer): `./dev fuzz`. What a reader takes must keep its
// promises, and what it refuses it must refuse by `recede::Error` in one line; all else is a finding.
//
//   fuzz_readers --reader=NAME CORPUS...    names are those of k_readers
//   fuzz_readers --seeds=FOLDER             writes a small file of each kind into FOLDER/NAME/ instead
#include "soups.h"
#include <recede/geometry/error.h>
#include <recede/geometry/exr.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/point_cloud.h>
#include <recede/geometry/raster.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/pmesh.h>
#include <recede/render/image_io.h>
#include <recede/render/local_pca.h>
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/textured_shell_io.h>

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace {

namespace fs = std::filesystem;
using namespace recede;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

void take_soup(const fs::path& file) {
  const PolygonSoup soup = read_soup(file);
  validate(soup, "what was read");
  if (soup.n_faces() > 2000) return;
  validate(to_soup(repair_to_polygon_mesh(soup).mesh), "what was repaired");
}

void take_points(const fs::path& file) { validate(read_point_cloud(file), "what was read"); }

void take_pmesh(const fs::path& file) {
  const ProgressiveMesh mesh = read_pmesh(file);
  ProgressiveCursor cursor(mesh);
  cursor.move_to(mesh.n_splits());
  validate(cursor.soup(), "the finest level");
  cursor.move_to(0);
  validate(cursor.soup(), "the base");
}

void take_shell(const fs::path& file) {
  const TexturedShell shell = read_textured_shell(file, {.make_mipmap = false});
  validate(shell.shell->base, "the base");
  require(shell.layer().tops.size() == shell.shell->base.positions.size(), "a top for each vertex");
}

void take_png(const fs::path& file) {
  const Raster raster = read_png(file);
  require(raster.width > 0 && raster.height > 0, "a picture has pixels");
}

void take_exr(const fs::path& file) {
  const FloatRaster raster = read_exr(file);
  require(raster.width > 0 && raster.height > 0, "a picture has pixels");
}

void take_hierarchy(const fs::path& file) {
  // The folder's files are there but for what a fuzzer writes.
  const LodHierarchy hierarchy = read_hierarchy(file.parent_path());
  require(!hierarchy.levels.empty(), "a hierarchy has levels");
}

void take_pca(const fs::path& file) { read_local_pca(file); }

void seed_soup(const fs::path& folder, const char* extension) {
  for (const bool attributes : {false, true}) {
    const PolygonSoup soup = test::random_soup(7, {.attributes = attributes});
    for (const bool ascii : {false, true})
      write_soup(folder / ((attributes ? "b" : "a") + std::string(ascii ? "t" : "") + extension), soup,
                 {.ascii = ascii});
  }
}

PolygonSoup sheet() {
  PolygonSoup soup;
  constexpr int k_side = 4;
  for (int j = 0; j <= k_side; ++j)
    for (int i = 0; i <= k_side; ++i) soup.positions.emplace_back(i, j, i * j % 3);
  for (Index j = 0; j < k_side; ++j) {
    for (Index i = 0; i < k_side; ++i) {
      const Index a = j * (k_side + 1) + i, b = a + k_side + 1;
      soup.add_face(std::array<Index, 4>{a, a + 1, b + 1, b});
    }
  }
  for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(soup.positions[v].head<2>() / k_side);
  return soup;
}

void seed_pmesh(const fs::path& folder, const char* extension) {
  ProgressiveOptions options;
  options.simplify.target.ratio = 0.1;
  options.simplify.prove_error = false;
  const ProgressiveMesh mesh = build_progressive_mesh(sheet(), options);
  write_pmesh(folder / (std::string("a") + extension), mesh);
  write_pmesh(folder / (std::string("b") + extension), mesh, {.position_bits = 10, .keep_numbering = true});
}

void seed_shell(const fs::path& folder, const char* extension) {
  VolumeMipmap texture;
  texture.surfaces.push_back(make_volume(weave(), 4));
  const TexturedShell shell{.shell = std::make_shared<const Shell>(build_shell(sheet(), {.thickness = 0.2})),
                            .texture = std::make_shared<const VolumeMipmap>(std::move(texture))};
  write_textured_shell(folder / (std::string("a") + extension), shell);
}

void seed_image(const fs::path& folder, const char* extension) {
  Image image(5, 3);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = Rgb(0.1f * static_cast<float>(i), 0.5f, 0.25f);
  write_image(folder / (std::string("a") + extension), image);
}

void seed_hierarchy(const fs::path& folder, const char*) {
  HierarchyOptions options;
  options.ratios = {0.5};
  options.measure.samples = 100;
  const fs::path made =
      write_hierarchy(folder / "files", build_hierarchy(repair_to_polygon_mesh(sheet()).mesh, "a", options))
          .folder;
  fs::copy_file(made / "hierarchy.json", folder / "hierarchy.json", fs::copy_options::overwrite_existing);
  fs::remove_all(folder / "files");
}

void seed_pca(const fs::path& folder, const char* extension) {
  std::vector<float> numbers;
  for (int i = 0; i < 60; ++i) numbers.push_back(static_cast<float>(i * i % 17));
  write_local_pca(folder / (std::string("a") + extension),
                  make_local_pca(vectors_in(numbers, 3), {.clusters = 2, .components = 2}));
}

struct Reader {
  const char* name;
  const char* extension;
  void (*take)(const fs::path& file);
  void (*write_seeds)(const fs::path& folder, const char* extension);
};

constexpr Reader k_readers[] = {
    {"obj", ".obj", take_soup, seed_soup},       {"ply", ".ply", take_soup, seed_soup},
    {"stl", ".stl", take_soup, seed_soup},       {"off", ".off", take_soup, seed_soup},
    {"gltf", ".gltf", take_soup, seed_soup},     {"glb", ".glb", take_soup, seed_soup},
    {"points", ".ply", take_points, seed_soup},  {"pmesh", ".pmesh", take_pmesh, seed_pmesh},
    {"shell", ".shell", take_shell, seed_shell}, {"png", ".png", take_png, seed_image},
    {"exr", ".exr", take_exr, seed_image},       {"hierarchy", ".json", take_hierarchy, seed_hierarchy},
    {"pca", ".pca", take_pca, seed_pca}};

const Reader* g_reader = nullptr;
fs::path g_file;

std::string value_of(int argc, char** argv, const std::string& name) {
  for (int i = 1; i < argc; ++i) {
    if (std::strncmp(argv[i], name.c_str(), name.size()) == 0) return argv[i] + name.size();
  }
  return {};
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (const std::string folder = value_of(*argc, *argv, "--seeds="); !folder.empty()) {
    for (const Reader& reader : k_readers) {
      fs::create_directories(fs::path(folder) / reader.name);
      reader.write_seeds(fs::path(folder) / reader.name, reader.extension);
      std::printf("%s\n", reader.name);
    }
    std::exit(0);
  }
  const std::string name = value_of(*argc, *argv, "--reader=");
  for (const Reader& reader : k_readers) {
    if (reader.name == name) g_reader = &reader;
  }
  if (g_reader == nullptr) {
    std::fprintf(stderr, "fuzz_readers: no reader %s\n", name.c_str());
    std::exit(2);
  }
  // In memory, where there is such a folder.
  const fs::path place = fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
  const fs::path folder = place / ("recede-fuzz-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  const bool is_hierarchy = g_reader->take == take_hierarchy;
  g_file = folder / (is_hierarchy ? "hierarchy.json" : std::string("a") + g_reader->extension);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* bytes, std::size_t size) {
  std::ofstream(g_file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  try {
    g_reader->take(g_file);
  } catch (const Error& error) {
    require(std::strchr(error.what(), '\n') == nullptr, "an error is one line");
  }
  return 0;
}
