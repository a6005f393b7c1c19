// Progressive meshes in files and streams.
#include "hard_cases.h"
#include "input_errors.h"
#include "meshes.h"
#include "pictures.h"
#include "progressive.h"
#include "soups.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/pmesh.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

namespace recede {
namespace {

ProgressiveMesh decode(const std::string& bytes) {
  PmeshReader reader("test.pmesh");
  reader.feed(bytes);
  EXPECT_TRUE(reader.is_complete());
  return reader.mesh();
}

PolygonSoup level_of(const ProgressiveMesh& mesh, std::size_t level) {
  ProgressiveCursor cursor(mesh);
  cursor.move_to(level);
  return cursor.soup();
}

/// With its numbering, the file gives back the input and every level.
void expect_round_trip(const PolygonSoup& input, const ProgressiveMesh& mesh) {
  const ProgressiveMesh back = decode(encode_pmesh(mesh, {.keep_numbering = true}));
  ASSERT_EQ(back.n_splits(), mesh.n_splits());
  test::expect_same_bits(level_of(back, back.n_splits()), input);
  for (const std::size_t level : {std::size_t{0}, mesh.n_splits() / 3, mesh.n_splits() / 2}) {
    test::expect_same_bits(level_of(back, level), level_of(mesh, level));
  }
  EXPECT_EQ(back.level_faces, mesh.level_faces);
  for (std::size_t i = 0; i < mesh.n_levels(); ++i) {
    EXPECT_GE(back.level_errors[i], mesh.level_errors[i]);
    EXPECT_LE(back.level_errors[i], mesh.level_errors[i] * (1 + 1e-3) + 1e-37);
  }
  EXPECT_EQ(back.errors_are_proved, mesh.errors_are_proved);
}

TEST(Pmesh, RestoresRandomPolygonsWithAllAttributes) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const PolygonSoup soup = test::random_soup(seed, {.scalars = true, .floats = seed % 2 == 0});
    for (const ProgressiveOptions& options : test::all_ways()) {
      SCOPED_TRACE(seed);
      expect_round_trip(soup, build_progressive_mesh(soup, options));
    }
  }
}

TEST(Pmesh, PicturesOfBaseColoursStandBesideTheFile) {
  PolygonSoup soup = test::random_soup(3, {.scalars = true, .floats = true});
  soup.materials = {{"skin", Vec4::Ones(), "maps/skin.png"}, {"same", Vec4::Ones(), "skin.png"}};
  soup.materials[0].base_color_picture = test::png_of(test::four_colors());
  soup.materials[1].base_color_picture = test::png_of(test::four_quarters());
  soup.face_materials.assign(soup.n_faces(), 1);
  const ProgressiveMesh mesh = build_progressive_mesh(soup);
  EXPECT_EQ(mesh.materials, soup.materials);
  const test::TempFolder folder;
  write_pmesh(folder / "a.pmesh", mesh);
  const ProgressiveMesh back = read_pmesh(folder / "a.pmesh");
  ASSERT_EQ(back.materials.size(), 2u);
  EXPECT_EQ(back.materials[0].base_color_texture, "skin.png");
  EXPECT_EQ(back.materials[1].base_color_texture, "a_skin.png") << "another picture has the name";
  for (std::size_t m = 0; m < 2; ++m) {
    ASSERT_TRUE(back.materials[m].base_color_picture);
    EXPECT_EQ(*back.materials[m].base_color_picture, *soup.materials[m].base_color_picture);
  }
  std::filesystem::remove(folder / "skin.png");
  const std::vector<Material> without = read_pmesh(folder / "a.pmesh").materials;
  EXPECT_FALSE(without[0].base_color_picture);
  EXPECT_EQ(without[0].base_color_texture, "skin.png");
}

class PmeshHardCases : public testing::TestWithParam<test::HardCase> {};

TEST_P(PmeshHardCases, ComeBackFromFiles) {
  const PolygonSoup& soup = GetParam().soup;
  if (!GetParam().refusal.empty()) {
    EXPECT_THROW(build_progressive_mesh(soup), InputError);
    return;
  }
  for (ProgressiveOptions options : test::all_ways()) {
    expect_round_trip(soup, build_progressive_mesh(soup, options));
    options.simplify.drop_parts = true;
    if (options.simplify.cost == CostPolicy::volume && soup.n_faces() > 0)
      options.simplify.join_distance = 0.01 * bounding_box(soup).diagonal().norm();
    expect_round_trip(soup, build_progressive_mesh(soup, options));
  }
}
INSTANTIATE_TEST_SUITE_P(All, PmeshHardCases, testing::ValuesIn(test::hard_cases()), test::case_name);

TEST(Pmesh, KeepsAChangeOfTheSignOfAZero) {
  const PolygonSoup soup = test::grid(4, true);
  ProgressiveMesh mesh =
      build_progressive_mesh(soup, test::options_for(CostPolicy::volume, VertexPlacement::half_edge));
  ASSERT_GT(mesh.n_splits(), 0u);
  // Vertices of this level don't move, but for the one of the first split, whose z was -0.
  for (const VertexSplit& split : mesh.splits) {
    const Vec3& place = mesh.positions[split.kept];
    mesh.position_changes.push_back({place, place});
  }
  mesh.colors.assign(mesh.positions.size(), Vec4(0, 0, 0, 1));
  mesh.color_changes.assign(mesh.n_splits(), {mesh.colors[0], mesh.colors[0]});
  const Index kept = mesh.splits[0].kept;
  mesh.positions[kept].z() = mesh.position_changes[0].coarse.z() = -0.0;
  mesh.colors[kept].x() = mesh.color_changes[0].coarse.x() = -0.0;
  const ProgressiveMesh back = decode(encode_pmesh(mesh, {.keep_numbering = true}));
  for (const std::size_t level : {std::size_t{0}, std::size_t{1}, mesh.n_splits()})
    test::expect_same_bits(level_of(back, level), level_of(mesh, level));
}

TEST(Pmesh, WithoutNumberingHasTheSamePolygonsInAnotherOrder) {
  for (const PolygonSoup& soup : {test::grid(20, true), test::grid(15), test::hexagon_sheet(12)}) {
    const ProgressiveMesh mesh =
        build_progressive_mesh(soup, test::options_for(CostPolicy::volume, VertexPlacement::half_edge));
    for (const bool keep_order : {true, false}) {
      const ProgressiveMesh back = decode(encode_pmesh(mesh, {.keep_order = keep_order}));
      ASSERT_EQ(back.n_splits(), mesh.n_splits());
      EXPECT_EQ(test::polygons_of(level_of(back, back.n_splits())), test::polygons_of(soup));
      EXPECT_EQ(test::polygons_of(level_of(back, 0)), test::polygons_of(level_of(mesh, 0)));
    }
  }
}

TEST(Pmesh, AStreamGivesAMeshAfterEveryBatch) {
  const PolygonSoup soup = make_displaced_sphere(4000, true);
  const ProgressiveMesh mesh =
      build_progressive_mesh(soup, test::options_for(CostPolicy::volume, VertexPlacement::half_edge));
  const std::string bytes = encode_pmesh(mesh);
  PmeshReader reader("stream");
  std::size_t faces = 0;
  for (std::size_t at = 0; at < bytes.size(); at += 97) {
    if (reader.feed(std::string_view(bytes).substr(at, 97)) == 0) continue;
    const ProgressiveMesh so_far = reader.mesh();
    EXPECT_GT(so_far.level_faces.back(), faces);
    faces = so_far.level_faces.back();
    const PolygonSoup level = level_of(so_far, so_far.n_splits());
    validate(level, "level");
    EXPECT_EQ(test::polygons_of(level), test::polygons_of(level_of(mesh, so_far.n_splits())));
  }
  EXPECT_TRUE(reader.is_complete());
  EXPECT_EQ(faces, soup.n_faces());
}

TEST(Pmesh, QuantisedPositionsMoveNoFartherThanTheFileSays) {
  const PolygonSoup soup = make_displaced_sphere(4000, true);
  const ProgressiveMesh mesh =
      build_progressive_mesh(soup, test::options_for(CostPolicy::volume, VertexPlacement::half_edge, true));
  for (const int bits : {1, 8, 14, 30}) {
    PmeshReport report;
    const ProgressiveMesh back =
        decode(encode_pmesh(mesh, {.position_bits = bits, .keep_numbering = true}, &report));
    const PolygonSoup full = level_of(back, back.n_splits());
    double most = 0;
    for (std::size_t v = 0; v < soup.positions.size(); ++v) {
      most = std::max(most, (full.positions[v] - soup.positions[v]).norm());
    }
    EXPECT_LE(most, report.largest_move);
    EXPECT_GE(back.level_errors.back(), report.largest_move);
    EXPECT_EQ(report.positions, "quantised");
  }
}

std::string sample_file() {
  PolygonSoup soup = test::random_soup(3, {.scalars = true});
  return encode_pmesh(
      build_progressive_mesh(soup, test::options_for(CostPolicy::volume, VertexPlacement::optimal)));
}

std::string complaint(const std::string& bytes) {
  return test::error_text([&] {
    const test::TempFolder folder;
    read_pmesh(folder.write("a.pmesh", bytes));
  });
}

TEST(Pmesh, TruncatedAndForeignFilesAreRefusedWithTheByte) {
  const std::string bytes = sample_file();
  EXPECT_EQ(complaint(bytes), "");
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    EXPECT_NE(complaint(bytes.substr(0, n)).find("a.pmesh: byte "), std::string::npos) << n;
  }
  EXPECT_NE(complaint("ply\nformat ascii 1.0\n").find("byte 0: isn't a .pmesh file"), std::string::npos);
  EXPECT_NE(complaint(bytes + "x").find("after the end"), std::string::npos);
  std::string later = bytes;
  later[8] = 2;
  EXPECT_NE(complaint(later).find("version 2"), std::string::npos);
  std::string flipped = bytes;
  flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 4);
  EXPECT_NE(complaint(flipped).find("checksum"), std::string::npos);
}

// Checksums made right again, so that what lies behind them is tried.
TEST(Pmesh, ChangedFilesGiveAnErrorOrAMeshAndNeverMore) {
  std::mt19937 random(5);
  std::vector<std::string> files{sample_file()};
  const PolygonSoup sphere = make_displaced_sphere(600, true), grid = test::grid(8);
  for (const PolygonSoup* soup : {&sphere, &grid}) {
    files.push_back(encode_pmesh(
        build_progressive_mesh(*soup, test::options_for(CostPolicy::volume, VertexPlacement::half_edge)),
        {.keep_numbering = true}));
  }
  std::size_t refused = 0;
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = files[static_cast<std::size_t>(round) % files.size()];
    for (std::size_t changes = 1 + random() % 3; changes > 0; --changes) {
      bytes[random() % bytes.size()] = static_cast<char>(random() % 3 == 0 ? random() : 1u << (random() % 8));
    }
    test::repair_checksums(bytes);
    try {
      PmeshReader reader("fuzz");
      reader.feed(bytes);
      if (!reader.is_complete()) continue;
      const ProgressiveMesh mesh = reader.mesh();
      ProgressiveCursor cursor(mesh);
      cursor.move_to(mesh.n_splits());
      validate(cursor.soup(), "fuzz");
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000u);
}

}  // namespace
}  // namespace recede
