// Files read a piece at a time hold what they hold when they are read as a whole.
#include "input_errors.h"
#include "soups.h"
#include <recede/geometry/sample_models.h>

#include <fstream>

namespace recede {
namespace {

using test::TempFolder;
namespace fs = std::filesystem;

std::string pieces_complaint(const fs::path& file) {
  return test::error_text([&] { read_soup_in_pieces(file, 3, [](const PolygonSoup&) {}); });
}

/// A face by what it has, wherever its vertices stand in lists.
struct LooseFace {
  std::vector<Vec3> positions, normals;
  std::vector<Vec2> uvs;
  std::vector<Vec4> colors;
  std::vector<double> scalars;
  std::string material;
  bool operator==(const LooseFace&) const = default;
};

void add_loose_faces(const PolygonSoup& soup, std::vector<LooseFace>& faces) {
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    LooseFace& face = faces.emplace_back();
    for (Index c = soup.face_offsets[f]; c < soup.face_offsets[f + 1]; ++c) {
      const Index v = soup.corner_vertices[c];
      face.positions.push_back(soup.positions[v]);
      if (!soup.corner_normals.empty()) face.normals.push_back(soup.corner_normals[c]);
      if (!soup.corner_uvs.empty()) face.uvs.push_back(soup.corner_uvs[c]);
      if (!soup.vertex_colors.empty()) face.colors.push_back(soup.vertex_colors[v]);
      for (const VertexScalar& scalar : soup.vertex_scalars) face.scalars.push_back(scalar.values[v]);
    }
    if (soup.face_materials.empty()) continue;
    const Index material = soup.face_materials[f];
    face.material = material == k_no_index ? "none" : soup.materials[material].name;
  }
}

void expect_same_in_pieces(const fs::path& file, std::size_t most_faces) {
  std::vector<LooseFace> whole, pieces;
  add_loose_faces(read_soup(file), whole);
  ASSERT_EQ(faces_in_pieces(file), whole.size());
  read_soup_in_pieces(file, most_faces, [&](const PolygonSoup& piece) {
    EXPECT_LE(piece.n_faces(), most_faces);
    EXPECT_GT(piece.n_faces(), 0u);
    std::vector<bool> used(piece.positions.size(), false);
    for (const Index v : piece.corner_vertices) used[v] = true;
    EXPECT_EQ(std::count(used.begin(), used.end(), false), 0) << "vertices that no face of the piece uses";
    add_loose_faces(piece, pieces);
  });
  EXPECT_TRUE(pieces == whole);
}

TEST(MeshPieces, OfPlyFilesAreTheWholeWithAllItHas) {
  const TempFolder folder;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    PolygonSoup soup = test::random_soup(seed, {.scalars = true});
    soup.feature_edges.clear();
    const fs::path file = folder / "soup.ply";
    write_soup(file, soup);
    for (const std::size_t most : {1u, 3u, 7u, 1000u}) expect_same_in_pieces(file, most);
  }
}

TEST(MeshPieces, OfStlFilesAreTheWhole) {
  const TempFolder folder;
  const fs::path file = folder / "ball.stl";
  write_soup(file, make_displaced_sphere(500, true));
  for (const std::size_t most : {1u, 97u, 1000u}) expect_same_in_pieces(file, most);
}

TEST(MeshPieces, BigEndianFilesAreReadAlike) {
  const TempFolder folder;
  std::string content =
      "ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n";
  const auto put = [&](std::uint32_t bits) {
    for (int shift = 24; shift >= 0; shift -= 8) content += static_cast<char>(bits >> shift & 0xff);
  };
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f})
    put(std::bit_cast<std::uint32_t>(value));
  for (const auto& face : {std::array{0u, 1u, 2u}, {0u, 2u, 3u}}) {
    content += '\3';
    for (const std::uint32_t v : face) put(v);
  }
  expect_same_in_pieces(folder.write("square.ply", content), 1);
}

TEST(MeshPieces, OtherFilesHaveNone) {
  const TempFolder folder;
  const PolygonSoup soup = test::two_triangles();
  write_soup(folder / "text.ply", soup, {.ascii = true});
  write_soup(folder / "text.stl", soup, {.ascii = true});
  write_soup(folder / "mesh.obj", soup);
  for (const char* name : {"text.ply", "text.stl", "mesh.obj"}) {
    EXPECT_EQ(faces_in_pieces(folder / name), std::nullopt) << name;
    EXPECT_THAT(pieces_complaint(folder / name), testing::HasSubstr("can't be read in pieces")) << name;
  }
  EXPECT_THAT(test::error_text([&] { faces_in_pieces(folder / "missing.ply"); }),
              testing::HasSubstr("missing.ply: No such file"));
}

TEST(MeshPieces, WhatStandsInTheWrongOrderIsNamed) {
  const TempFolder folder;
  PolygonSoup soup = test::two_triangles();
  soup.feature_edges = {{0, 2}};
  write_soup(folder / "edges.ply", soup);
  EXPECT_THAT(pieces_complaint(folder / "edges.ply"), testing::HasSubstr("feature edges"));
  const fs::path turned = folder.write(
      "turned.ply",
      "ply\nformat binary_little_endian 1.0\nelement face 0\nproperty list uchar int vertex_indices\n"
      "element vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n");
  EXPECT_THAT(pieces_complaint(turned), testing::HasSubstr("vertices without lists have to come first"));
}

TEST(MeshPieces, DamagedFilesAreToldWithThePlace) {
  const TempFolder folder;
  write_soup(folder / "ball.ply", make_displaced_sphere(100, true));
  std::string content = read_whole_file(folder / "ball.ply");
  const fs::path cut = folder.write("cut.ply", content.substr(0, content.size() - 5));
  EXPECT_THAT(pieces_complaint(cut), testing::HasSubstr("cut.ply: byte"));
  const std::size_t body = content.find("end_header\n") + 11;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  content.replace(body + 3 * sizeof nan, sizeof nan, reinterpret_cast<const char*>(&nan), sizeof nan);
  EXPECT_THAT(pieces_complaint(folder.write("nan.ply", content)),
              testing::HasSubstr("the position of vertex 1 isn't finite"));
  const std::string values =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\n"
      "property char z\nelement face 5\nproperty list uchar uchar vertex_indices\n"
      "property list uchar char texcoord\nend_header\n" +
      std::string("\0\0\0\1\0\0\0\1\0", 9);
  const std::string whole("\3\0\1\2\6\0\0\1\0\0\1", 11), lacking("\3\0\1\2\4\0\0\1\0", 9);
  EXPECT_THAT(pieces_complaint(folder.write("uvs.ply", values + whole + whole + whole + whole + lacking)),
              testing::HasSubstr("face 4 has 3 corners, but 2 corner values"));
  write_soup(folder / "ball.stl", make_displaced_sphere(100, true));
  content = read_whole_file(folder / "ball.stl");
  const float none = std::numeric_limits<float>::infinity();
  content.replace(84 + 50 + 12, sizeof none, reinterpret_cast<const char*>(&none), sizeof none);
  EXPECT_THAT(pieces_complaint(folder.write("infinite.stl", content)),
              testing::HasSubstr("byte 134: the position of vertex 3 isn't finite"));
}

}  // namespace
}  // namespace recede
