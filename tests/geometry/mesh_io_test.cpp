// What holds for all formats alike: dispatch, progress, damaged files, and real models.
#include "input_errors.h"
#include "pictures.h"
#include "simple_soups.h"
#include "soups.h"

#include <fmt/format.h>

#include <algorithm>
#include <random>

namespace recede::test {
namespace {

using testing::HasSubstr;

// A file of every format and encoding, small enough for thousands of damaged copies.
std::vector<std::filesystem::path> write_samples(const TempFolder& folder) {
  std::vector<std::filesystem::path> paths;
  const PolygonSoup soup = random_soup(7);
  const auto write = [&](const char* name, const WriteOptions& options = {}) {
    paths.push_back(folder / name);
    write_soup(paths.back(), soup, options);
  };
  write("a.obj");
  write("text.ply", {.ascii = true});
  write("binary.ply");
  write("text.stl", {.ascii = true});
  write("binary.stl");
  write("a.off");
  write("a.gltf");
  write("a.glb");
  return paths;
}

// Reading either succeeds with a soup that keeps all its promises, or throws an error of one line.
void expect_soup_or_error(const std::filesystem::path& path) {
  try {
    const PolygonSoup soup = read_soup(path);
    EXPECT_NO_THROW(validate(soup, "soup"));
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(path.parent_path().string()));
  }
}

class CountingProgress : public Progress {
 public:
  void update(std::string_view stage, double fraction) override {
    EXPECT_EQ(stage, "read");
    EXPECT_GE(fraction, last_);
    EXPECT_LE(fraction, 1.0);
    last_ = fraction;
    ++calls_;
  }
  bool cancel_requested() const override { return calls_ >= cancel_after_; }
  int calls_ = 0;
  int cancel_after_ = 1000;
  double last_ = 0.0;
};

TEST(MeshIo, ChoosesTheFormatByExtensionInAnyCase) {
  EXPECT_EQ(read_text("A.OBJ", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").n_faces(), 1u);
  EXPECT_EQ(read_text("A.Off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").n_faces(), 1u);
}

TEST(MeshIo, NamesTheKnownExtensionsForAnUnknownOne) {
  EXPECT_EQ(complaint("a.fbx", ""),
            "a.fbx: unknown kind of mesh file; known are .obj .ply .stl .off .gltf .glb");
  EXPECT_THROW(write_soup("a", two_triangles()), InputError);
}

TEST(MeshIo, SaysWhenAFileIsMissingOrAFolder) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "folder.ply");
  EXPECT_THROW(read_soup(folder / "absent.ply"), InputError);
  EXPECT_THROW(read_soup(folder / "folder.ply"), InputError);
  EXPECT_THROW(write_soup(folder / "no/such/folder/a.ply", two_triangles()), InputError);
}

TEST(MeshIo, WritesAndReadsHalfEdgeMeshes) {
  const TempFolder folder;
  const PolygonSoup soup = two_triangles();
  write_mesh(folder / "a.obj", to_polygon_mesh(soup));
  const MeshFromSoup back = read_mesh(folder / "a.obj");
  EXPECT_EQ(back.mesh.n_faces(), 2u);
  EXPECT_EQ(back.mesh.n_edges(), 5u);
}

TEST(MeshIo, MergesTheRepeatedCornersOfStl) {
  const TempFolder folder;
  write_soup(folder / "a.stl", two_triangles());
  EXPECT_EQ(read_mesh(folder / "a.stl").mesh.n_edges(), 5u);
}

TEST(MeshIo, RefusesToWriteSoupsWithWrongIndices) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  soup.corner_vertices[0] = 4;
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.off", "a.glb"}) {
    EXPECT_THROW(write_soup(folder / name, soup), InputError);
    EXPECT_FALSE(std::filesystem::exists(folder / name));
  }
}

TEST(MeshIo, ReportsProgressAndStopsWhenAsked) {
  const TempFolder folder;
  for (const auto& path : write_samples(folder)) {
    SCOPED_TRACE(path.filename());
    CountingProgress progress;
    read_soup(path, &progress);
    EXPECT_GE(progress.calls_, 2);
    EXPECT_EQ(progress.last_, 1.0);
    CountingProgress cancelling;
    cancelling.cancel_after_ = 1;
    EXPECT_THROW(read_soup(path, &cancelling), Cancelled);
  }
}

TEST(DamagedFiles, CutAnywhereGiveAnErrorOrAValidSoup) {
  const TempFolder folder;
  for (const auto& path : write_samples(folder)) {
    SCOPED_TRACE(path.filename());
    const std::string whole = read_whole_file(path);
    const std::size_t step = std::max<std::size_t>(1, whole.size() / 700);
    for (std::size_t size = 0; size < whole.size(); size += step) {
      expect_soup_or_error(
          folder.write("cut" + path.filename().string(), std::string_view(whole).substr(0, size)));
    }
  }
}

TEST(DamagedFiles, WithRandomBytesGiveAnErrorOrAValidSoup) {
  const TempFolder folder;
  for (const auto& path : write_samples(folder)) {
    SCOPED_TRACE(path.filename());
    const std::string whole = read_whole_file(path);
    for (unsigned seed = 0; seed < 500; ++seed) {
      SCOPED_TRACE(seed);
      std::mt19937 random(seed);
      std::string damaged = whole;
      // Headers are a small part of a file; every second copy is damaged there.
      const std::size_t span = seed % 2 == 0 ? damaged.size() : std::min<std::size_t>(damaged.size(), 400);
      for (unsigned i = 0; i < 1 + seed % 8; ++i)
        damaged[random() % span] = static_cast<char>(random() % 256);
      expect_soup_or_error(folder.write("damaged" + path.filename().string(), damaged));
    }
  }
}

TEST(DamagedFiles, WithDigitsAndBlanksExchangedGiveAnErrorOrAValidSoup) {
  const TempFolder folder;
  constexpr std::string_view k_characters = "0123456789-.e /\n\"[]{},";
  for (const auto& path : write_samples(folder)) {
    SCOPED_TRACE(path.filename());
    const std::string whole = read_whole_file(path);
    for (unsigned seed = 0; seed < 500; ++seed) {
      SCOPED_TRACE(seed);
      std::mt19937 random(seed);
      std::string damaged = whole;
      for (unsigned i = 0; i < 1 + seed % 4; ++i)
        damaged[random() % damaged.size()] = k_characters[random() % k_characters.size()];
      expect_soup_or_error(folder.write("damaged" + path.filename().string(), damaged));
    }
  }
}

TEST(RealModels, ReadInEveryFormatAsTheSameTriangles) {
  const std::filesystem::path path = std::filesystem::path(RECEDE_DATA) / "meshes/bunny00.off";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is missing; ./dev data fetches it";
  const TempFolder folder;
  const PolygonSoup bunny = read_soup(path);
  EXPECT_EQ(bunny.positions.size(), 37706u);
  EXPECT_EQ(bunny.n_faces(), 75408u);
  for (const char* name : {"a.obj", "a.ply", "a.off"}) {
    write_soup(folder / name, bunny);
    expect_equal(read_soup(folder / name), bunny);
  }
  for (const char* name : {"a.stl", "a.glb", "a.gltf"}) {
    write_soup(folder / name, bunny);
    const PolygonSoup back = read_soup(folder / name);
    ASSERT_EQ(back.n_corners(), bunny.n_corners());
    for (std::size_t i = 0; i < bunny.n_corners(); ++i) {
      const Vec3& expected = bunny.positions[bunny.corner_vertices[i]];
      ASSERT_EQ(back.positions[back.corner_vertices[i]], Vec3(expected.unaryExpr(&detail::rounded_to_float)));
    }
  }
}

TEST(RealModels, ReadFromAllFilesOfTheCollections) {
  const std::filesystem::path data(RECEDE_DATA);
  if (!std::filesystem::exists(data / "meshes")) GTEST_SKIP() << data << " is missing; ./dev data fetches it";
  std::size_t n = 0;
  for (const auto& folder : {data / "meshes", data / "cad/stl"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".off" && extension != ".stl" && extension != ".ply" && extension != ".obj") continue;
      SCOPED_TRACE(entry.path());
      EXPECT_NO_THROW(EXPECT_GT(read_soup(entry.path()).positions.size(), 0u));
      ++n;
    }
  }
  EXPECT_GT(n, 100u);
}

TEST(Pictures, GoBesideFilesThatHoldNoneAndReplaceNoOthers) {
  PolygonSoup soup = grid(1, true);
  for (const Index v : soup.corner_vertices) soup.corner_uvs.push_back(soup.positions[v].head<2>());
  soup.materials.resize(3);
  soup.materials[0] = {"one", Vec4::Ones(), "left/skin.png"};
  soup.materials[1] = {"two", Vec4::Ones(), "right\\skin.png"};
  soup.materials[2] = {"three", Vec4::Ones(), "left/skin.png"};
  soup.materials[0].base_color_picture = soup.materials[2].base_color_picture = png_of(four_colors());
  soup.materials[1].base_color_picture = png_of(raster_of(1, 1, {{9, 8, 7}}));
  soup.face_materials = {0, 1};
  for (const char* name : {"model.obj", "model.ply"}) {
    const TempFolder folder;
    folder.write("skin.png", "another model's");
    write_soup(folder / name, soup);
    EXPECT_EQ(read_whole_file(folder / "skin.png"), "another model's");
    const std::vector<Material> back = read_mesh(folder / name).mesh.materials;
    for (std::size_t m = 0; m < 2; ++m) {
      ASSERT_TRUE(back[m].base_color_picture) << back[m].base_color_texture;
      EXPECT_EQ(*back[m].base_color_picture, *soup.materials[m].base_color_picture);
    }
    EXPECT_EQ(back[0].base_color_texture, "model_skin.png");
    EXPECT_EQ(back[1].base_color_texture, "model_2_skin.png");
    // Where they are already, nothing is written and names stay.
    std::filesystem::create_directory(folder / "left");
    folder.write("left/skin.png", *soup.materials[0].base_color_picture);
    soup.materials[1].base_color_picture = nullptr;
    write_soup(folder / name, soup);
    EXPECT_EQ(read_soup(folder / name).materials[0].base_color_texture, "left/skin.png");
    EXPECT_EQ(read_soup(folder / name).materials[1].base_color_texture, "right\\skin.png");
    soup.materials[1].base_color_picture = png_of(raster_of(1, 1, {{9, 8, 7}}));
  }
}

TEST(Pictures, OfMeshesAreReadAndMissingOnesAreRepairsThatAreTold) {
  const TempFolder folder;
  folder.write("a.mtl", "newmtl here\nmap_Kd skin.png\nnewmtl gone\nmap_Kd gone.png\n");
  folder.write("skin.png", encode_png(four_colors()));
  folder.write(
      "a.obj",
      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl here\nf 1 2 3\nusemtl gone\nf 2 4 3\n");
  const MeshFromSoup read = read_mesh(folder / "a.obj");
  EXPECT_EQ(*read.mesh.materials[0].base_color_picture, encode_png(four_colors()));
  EXPECT_FALSE(read.mesh.materials[1].base_color_picture);
  const RepairStep& step = read.report.steps.front();
  EXPECT_EQ(step.name, "load_pictures");
  EXPECT_EQ(step.changed, 1u);
  EXPECT_THAT(step.detail, HasSubstr("gone.png: No such file"));
}

}  // namespace
}  // namespace recede::test
