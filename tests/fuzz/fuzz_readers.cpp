// Readers fed with bytes that a fuzzer invents (libFuzzer): `./dev fuzz`. What a reader takes must keep its
// promises, and what it refuses it must refuse by `recede::Error` in one line; all else is a finding.
//
//   fuzz_readers --reader=NAME CORPUS...    names are those of k_readers
//   fuzz_readers --seeds=FOLDER             writes a small file of each kind into FOLDER/NAME/ instead
#include "fuzz_seeds.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/exr.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/point_cloud.h>
#include <recede/geometry/texture.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/pmesh.h>
#include <recede/render/appearance.h>
#include <recede/render/billboard_reflectance.h>
#include <recede/render/local_pca.h>
#include <recede/render/reflectance_table.h>
#include <recede/render/scattering_table.h>
#include <recede/shells/textured_shell_io.h>

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace {

namespace fs = std::filesystem;
using namespace recede;
using namespace recede::test;

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

void take_pieces(const fs::path& file) {
  if (!faces_in_pieces(file)) return;
  std::size_t n = 0;
  read_soup_in_pieces(file, 7, [&](const PolygonSoup& piece) { n += piece.n_faces(); });
  require(n == faces_in_pieces(file), "as many faces as were promised");
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

void take_jpeg(const fs::path& file) {
  const Texture texture(decode_jpeg(read_whole_file(file), file.string()));
  require(texture.color_at({0.3, 0.4}, 0.1).allFinite(), "a texture has colours");
}

void take_exr(const fs::path& file) {
  const FloatRaster raster = read_exr(file);
  require(raster.width > 0 && raster.height > 0, "a picture has pixels");
}

void take_hierarchy(const fs::path& file) {
  // The levels' files are there as they were written.
  const LodHierarchy hierarchy = read_hierarchy(file.parent_path());
  require(!hierarchy.levels.empty(), "a hierarchy has levels");
}

void take_pca(const fs::path& file) { read_local_pca(file); }

void take_appearance(const fs::path& file) {
  require(read_appearance(file)->wavelength() >= 0, "a wavelength isn't below 0");
}

void take_reflectance(const fs::path& file) { read_billboard_reflectance(file); }

void take_reflectance_table(const fs::path& file) {
  const ReflectanceTable table = read_reflectance_table(file);
  require(table.views > 0 && !table.values.empty(), "a table has values");
}

void take_scattering_table(const fs::path& file) {
  const ScatteringTable table = read_scattering_table(file);
  require(table.values.size() == table.slice_count() * table.slice_size(),
          "as many values as its numbers say");
}

struct Reader {
  const char* name;
  const char* extension;
  void (*take)(const fs::path& file);
  void (*write_seeds)(const fs::path& folder, const char* extension);
};

constexpr Reader k_readers[] = {
    {"obj", ".obj", take_soup, seed_soup},
    {"ply", ".ply", take_soup, seed_soup},
    {"stl", ".stl", take_soup, seed_soup},
    {"ply-pieces", ".ply", take_pieces, seed_soup},
    {"stl-pieces", ".stl", take_pieces, seed_soup},
    {"off", ".off", take_soup, seed_soup},
    {"gltf", ".gltf", take_soup, seed_soup},
    {"glb", ".glb", take_soup, seed_soup},
    {"points", ".ply", take_points, seed_soup},
    {"pmesh", ".pmesh", take_pmesh, seed_pmesh},
    {"shell", ".shell", take_shell, seed_shell},
    {"png", ".png", take_png, seed_image},
    {"jpeg", ".jpg", take_jpeg, seed_jpeg},
    {"exr", ".exr", take_exr, seed_image},
    {"hierarchy", ".json", take_hierarchy, seed_hierarchy},
    {"pca", ".pca", take_pca, seed_pca},
    {"appearance", ".appearance", take_appearance, seed_appearance},
    {"reflectance", ".reflectance", take_reflectance, seed_reflectance},
    {"reflectance-table", ".table", take_reflectance_table, seed_reflectance_table},
    {"scattering-table", ".table", take_scattering_table, seed_scattering_table}};

const Reader* g_reader = nullptr;
fs::path g_folder, g_file;

void remove_folder() {
  std::error_code ignored;
  fs::remove_all(g_folder, ignored);
}

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
  g_folder = place / ("recede-fuzz-" + std::to_string(::getpid()));
  fs::create_directories(g_folder);
  std::atexit(remove_folder);
  if (g_reader->take == take_hierarchy) {
    g_file = write_small_hierarchy(g_folder) / "hierarchy.json";
  } else {
    g_file = g_folder / (std::string("a") + g_reader->extension);
  }
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
