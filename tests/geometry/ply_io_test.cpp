#include "input_errors.h"
#include "soups.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace recede::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

template <class Value>
std::string bytes_of(Value value, bool big_endian) {
  std::string bytes(sizeof(Value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(Value));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

// A quad with properties of every type, among them some that are unknown.
std::string binary_quad(bool big_endian) {
  std::string text = fmt::format(
      "ply\r\nformat binary_{}_endian 1.0\r\ncomment made by hand\r\nobj_info 1\r\nelement vertex 4\r\n"
      "property float32 x\r\nproperty short y\r\nproperty double z\r\nproperty list uchar short history\r\n"
      "property uchar red\r\nproperty ushort green\r\nproperty float blue\r\n"
      "element camera 1\r\nproperty list uint double matrix\r\nproperty char kind\r\n"
      "element face 1\r\nproperty int flags\r\nproperty list ushort uint vertex_index\r\nend_header\r\n",
      big_endian ? "big" : "little");
  for (int v = 0; v < 4; ++v) {
    text += bytes_of(static_cast<float>(v == 1 || v == 2) + 0.5f, big_endian);
    text += bytes_of(static_cast<std::int16_t>(v >= 2 ? -300 : 0), big_endian);
    text += bytes_of(0.1, big_endian);
    text += bytes_of(static_cast<std::uint8_t>(v), big_endian);
    for (int i = 0; i < v; ++i) text += bytes_of(static_cast<std::int16_t>(7), big_endian);
    text += bytes_of(static_cast<std::uint8_t>(51), big_endian);
    text += bytes_of(static_cast<std::uint16_t>(255), big_endian);
    text += bytes_of(0.25f, big_endian);
  }
  text +=
      bytes_of(std::uint32_t{2}, big_endian) + bytes_of(1.0, big_endian) + bytes_of(2.0, big_endian) + '\1';
  text += bytes_of(std::int32_t{-1}, big_endian) + bytes_of(std::uint16_t{4}, big_endian);
  for (std::uint32_t v = 0; v < 4; ++v) text += bytes_of(v, big_endian);
  return text;
}

const std::string k_ascii_head =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const std::string k_ascii_face = "element face 1\nproperty list uchar int vertex_indices\n";
const std::string k_ascii_vertices = "0 0 0\n1 0 0\n0 1 0\n";

TEST(PlyReader, ReadsBothByteOrdersAndSkipsWhatItDoesNotKnow) {
  for (const bool big_endian : {false, true}) {
    SCOPED_TRACE(big_endian);
    const PolygonSoup soup = read_text("a.ply", binary_quad(big_endian));
    EXPECT_THAT(soup.positions, ElementsAre(Vec3(0.5, 0, 0.1), Vec3(1.5, 0, 0.1), Vec3(1.5, -300, 0.1),
                                            Vec3(0.5, -300, 0.1)));
    EXPECT_THAT(soup.corner_vertices, ElementsAre(0, 1, 2, 3));
    EXPECT_THAT(soup.face_offsets, ElementsAre(0, 4));
    ASSERT_EQ(soup.vertex_colors.size(), 4u);
    EXPECT_EQ(soup.vertex_colors[3], Vec4(0.2, 1.0, 0.25, 1.0));
  }
}

TEST(PlyReader, ReadsTextWithPolygonsEdgesAndUnknownElements) {
  const PolygonSoup soup =
      read_text("a.ply",
                "ply\nformat ascii 1.0\nelement thing 2\nproperty list int int whatever\nelement vertex "
                "5\nproperty double x\n"
                "property double y\nproperty double z\nelement face 2\nproperty list uchar int "
                "vertex_indices\nproperty float quality\n"
                "element edge 1\nproperty int vertex1\nproperty int vertex2\nproperty uchar "
                "crease\nend_header\n2 1 2\n0\n0 0 0\n"
                "1 0 0\n1 1 0\n0 1 0\n0.5 2 0\n5 0 1 2 4 3 0.5\n3 0 1 2 1e-3\n3 4 255\n");
  EXPECT_THAT(soup.corner_vertices, ElementsAre(0, 1, 2, 4, 3, 0, 1, 2));
  EXPECT_THAT(soup.feature_edges, ElementsAre(Pair(3, 4)));
}

TEST(PlyReader, CopiesAttributesOfVerticesToCorners) {
  for (const auto& [u, v] : {std::pair("s", "t"), std::pair("u", "v"), std::pair("texture_u", "texture_v"),
                             std::pair("texture_s", "texture_t")}) {
    const PolygonSoup soup = read_text(
        "a.ply",
        k_ascii_head +
            fmt::format("property float nx\nproperty float ny\nproperty float nz\nproperty float {}\n"
                        "property float {}\n",
                        u, v) +
            k_ascii_face + "end_header\n0 0 0 0 0 1 0.25 0.5\n1 0 0 0 1 0 0 1\n0 1 0 1 0 0 1 0\n3 2 0 1\n");
    EXPECT_THAT(soup.corner_uvs, ElementsAre(Vec2(1, 0), Vec2(0.25, 0.5), Vec2(0, 1)));
    EXPECT_THAT(soup.corner_normals, ElementsAre(Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 1, 0)));
  }
}

TEST(PlyReader, ReadsCornerTextureCoordinatesOfFacesThatHaveThem) {
  const PolygonSoup soup =
      read_text("a.ply",
                "ply\nformat ascii 1.0\ncomment TextureFile skin one.png\nelement vertex 3\nproperty float "
                "x\nproperty float y\n"
                "property float z\nelement face 3\nproperty list uchar float texcoord\nproperty list uchar "
                "int vertex_indices\n"
                "property int texnumber\nend_header\n" +
                    k_ascii_vertices + "0 3 0 1 2 -1\n6 0 0 1 0 0 1 3 0 1 2 0\n0 3 2 1 0 0\n");
  const Vec2 none(0, 0);
  EXPECT_THAT(soup.corner_uvs,
              ElementsAre(none, none, none, Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), none, none, none));
  EXPECT_THAT(soup.face_materials, ElementsAre(k_no_index, 0, 0));
  ASSERT_EQ(soup.materials.size(), 1u);
  EXPECT_EQ(soup.materials[0].base_color_texture, "skin one.png");
}

TEST(PlyReader, ReadsMaterialsFromComments) {
  const PolygonSoup soup = read_text(
      "a.ply",
      "ply\nformat ascii 1.0\ncomment material of the statue: marble\n"
      "comment material 0 \"say \\\"oak\\\"\" 0.5 0.25 0 1 \"oak wood.png\"\ncomment material 1 plain name\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nproperty int material_index\nend_header\n" +
          k_ascii_vertices + "3 0 1 2 1\n3 0 2 1 2\n");
  ASSERT_EQ(soup.materials.size(), 3u);
  EXPECT_EQ(soup.materials[0], (Material{"say \"oak\"", {0.5, 0.25, 0, 1}, "oak wood.png"}));
  EXPECT_EQ(soup.materials[1].name, "plain name");
  EXPECT_EQ(soup.materials[2].name, "material_2");
  EXPECT_THAT(soup.face_materials, ElementsAre(1, 2));
}

TEST(PlyReader, NamesThePlaceAndReasonOfEveryDefect) {
  const std::string head = k_ascii_head + k_ascii_face + "end_header\n";
  EXPECT_EQ(complaint("a.ply", "plyx\n"), "a.ply:1: isn't a PLY file (it doesn't start with 'ply')");
  EXPECT_EQ(complaint("a.ply", "ply\nformat ascii 2.0\n"), "a.ply:2: unknown PLY version '2.0'");
  EXPECT_EQ(complaint("a.ply", "ply\nformat ascii 1.0\nelement vertex x\n"),
            "a.ply:3: the number of elements is 'x'");
  EXPECT_EQ(complaint("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty long x\n"),
            "a.ply:4: unknown property type 'long'");
  EXPECT_EQ(complaint("a.ply", k_ascii_head), "a.ply:7: the header has no end_header");
  EXPECT_EQ(complaint("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty int a\nend_header\n1\n"),
            "a.ply: the header names no element 'vertex'");
  EXPECT_EQ(complaint("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nend_header\n1\n"),
            "a.ply:6: vertices have no property 'y'");
  EXPECT_EQ(complaint("a.ply", head + k_ascii_vertices + "3 0 1 3\n"),
            "a.ply:13: vertex 3 is out of range (there are 3)");
  EXPECT_EQ(complaint("a.ply", head + k_ascii_vertices + "3 0 1 -1\n"),
            "a.ply:13: vertex -1 is out of range (there are 3)");
  EXPECT_EQ(complaint("a.ply", head + k_ascii_vertices + "2 0 1\n"), "a.ply:13: face 0 has 2 corners");
  EXPECT_EQ(complaint("a.ply", head + k_ascii_vertices + "3 0 1\n"), "a.ply:14: the file ends too early");
  EXPECT_EQ(complaint("a.ply", head + "0 0 0\n0 zero 0\n0 1 0\n"), "a.ply:11: 'zero' isn't a number");
  EXPECT_THAT(complaint("a.ply", head + "0 0 inf\n1 0 0\n0 1 0\n3 0 1 2\n"), HasSubstr("0"));
  EXPECT_THAT(complaint("a.ply",
                        "ply\nformat ascii 1.0\nelement vertex 0\nelement tristrips 1\n"
                        "property list int int vertex_indices\nend_header\n"),
              HasSubstr("tristrips"));
}

TEST(PlyReader, SaysWithByteWhereABinaryFileEnds) {
  const std::string whole = binary_quad(false);
  EXPECT_EQ(
      complaint("a.ply", whole.substr(0, whole.size() - 3)),
      fmt::format("a.ply: byte {}: list 'vertex_index' of 4 values runs past the end", whole.size() - 16));
}

TEST(PlyReader, RefusesCountsThatTheFileCannotHold) {
  for (const char* encoding : {"ascii", "binary_little_endian"}) {
    const std::string text = fmt::format(
        "ply\nformat {} 1.0\nelement vertex 4000000000\nproperty float x\n"
        "property float y\nproperty float z\nend_header\n{}",
        encoding, std::string(1000, ' '));
    EXPECT_THAT(complaint("a.ply", text),
                HasSubstr("the header promises 4000000000 elements 'vertex', but the file has 1000"));
  }
  EXPECT_THAT(complaint("a.ply", k_ascii_head + k_ascii_face + "end_header\n" + k_ascii_vertices +
                                     "4000000000 0 1 2\n"),
              HasSubstr("a.ply:13: list 'vertex_indices' of 4000000000 values runs past the end"));
}

TEST(PlyRoundTrip, GivesBackRandomSoupsExactlyInBothEncodings) {
  const TempFolder folder;
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    PolygonSoup soup = random_soup(seed, {.attributes = seed % 5 != 0, .scalars = seed % 2 != 0});
    if (seed % 3 == 1) {  // colours as most programs have them
      for (Vec4& color : soup.vertex_colors) color = (color * 255.0).array().round().matrix() / 255.0;
    }
    EXPECT_THAT(write_soup(folder / "a.ply", soup, {.ascii = seed % 2 == 0}).written_without, IsEmpty());
    expect_equal(read_soup(folder / "a.ply"), soup);
  }
}

TEST(PlyRoundTrip, KeepsFloatsInSinglePrecisionAndSaysWhenDigitsGetLost) {
  const TempFolder folder;
  const PolygonSoup floats = random_soup(3, {.attributes = false, .floats = true});
  EXPECT_THAT(write_soup(folder / "a.ply", floats, {.double_precision = false}).written_without, IsEmpty());
  expect_equal(read_soup(folder / "a.ply"), floats);
  const PolygonSoup doubles = random_soup(3, {.attributes = false});
  EXPECT_THAT(write_soup(folder / "a.ply", doubles, {.double_precision = false}).written_without,
              ElementsAre("double precision (positions rounded to 32-bit floats)"));
}

TEST(PlyRoundTrip, KeepsPolygonsWithHundredsOfSides) {
  const TempFolder folder;
  PolygonSoup soup;
  std::vector<Index> face;
  for (Index i = 0; i < 300; ++i) {
    soup.positions.emplace_back(std::cos(0.02 * i), std::sin(0.02 * i), 0.0);
    face.push_back(i);
  }
  soup.add_face(face);
  write_soup(folder / "a.ply", soup);
  expect_equal(read_soup(folder / "a.ply"), soup);
}

}  // namespace
}  // namespace recede::test
