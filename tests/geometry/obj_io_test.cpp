#include "input_errors.h"
#include "soups.h"

namespace recede::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

const std::string k_square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

std::vector<Index> corners_of(const PolygonSoup& soup, std::size_t face) {
  return {soup.face(face).begin(), soup.face(face).end()};
}

TEST(ObjReader, KeepsPolygonsWithMoreThanThreeSides) {
  const PolygonSoup soup = read_text("a.obj", k_square + "v 0.5 2 0\nf 1 2 3 5 4\nf 1 2 3\n");
  ASSERT_EQ(soup.n_faces(), 2u);
  EXPECT_THAT(corners_of(soup, 0), ElementsAre(0, 1, 2, 4, 3));
  EXPECT_THAT(corners_of(soup, 1), ElementsAre(0, 1, 2));
  EXPECT_EQ(soup.positions[4], Vec3(0.5, 2, 0));
  EXPECT_THAT(soup.corner_uvs, IsEmpty());
  EXPECT_THAT(soup.corner_normals, IsEmpty());
  EXPECT_THAT(soup.face_materials, IsEmpty());
}

TEST(ObjReader, CountsNegativeIndicesFromTheEnd) {
  const PolygonSoup soup = read_text("a.obj", k_square + "f -4 -3 -2\nv 5 5 5\nf -1 -2 -3\n");
  EXPECT_THAT(corners_of(soup, 0), ElementsAre(0, 1, 2));
  EXPECT_THAT(corners_of(soup, 1), ElementsAre(4, 3, 2));
}

TEST(ObjReader, ReadsAllFormsOfCornersInOneFile) {
  const PolygonSoup soup = read_text("a.obj", k_square +
                                                  "vt 0.25 0.75\nvt 1\nvn 0 0 1\nf 1 2 3\nf 1/1 2/2 3/-1\n"
                                                  "f 1//1 2//1 3//-1\nf 1/1/1 2/2/1 4/1/1\n");
  EXPECT_THAT(soup.corner_uvs, ElementsAre(Vec2(0, 0), Vec2(0, 0), Vec2(0, 0),        //
                                           Vec2(0.25, 0.75), Vec2(1, 0), Vec2(1, 0),  //
                                           Vec2(0, 0), Vec2(0, 0), Vec2(0, 0),        //
                                           Vec2(0.25, 0.75), Vec2(1, 0), Vec2(0.25, 0.75)));
  const Vec3 up(0, 0, 1), none(0, 0, 0);
  EXPECT_THAT(soup.corner_normals, ElementsAre(none, none, none, none, none, none, up, up, up, up, up, up));
}

TEST(ObjReader, ReadsVertexColours) {
  const PolygonSoup soup =
      read_text("a.obj", "v 0 0 0\nv 1 0 0 0.25 0.5 1\nv 0 1 0 0 0 0 0.5\nv 1 1 0 1\nf 1 2 3\n");
  EXPECT_THAT(soup.vertex_colors,
              ElementsAre(Vec4(1, 1, 1, 1), Vec4(0.25, 0.5, 1, 1), Vec4(0, 0, 0, 0.5), Vec4(1, 1, 1, 1)));
}

TEST(ObjReader, TakesMaterialsFromTheLibraryBesideIt) {
  const TempFolder folder;
  folder.write("my mats.mtl",
               "# two\r\nnewmtl wood\r\nKd 0.5 0.25 0.125\r\nd 0.5\nmap_Kd -s 2 2 1 oak.png\n\n"
               "newmtl two words\nKd 1 0 0\nmap_Kd a texture.png\nTr 0.25\nillum 2\n");
  const auto path =
      folder.write("a.obj", "mtllib my mats.mtl\n" + k_square +
                                "f 1 2 3\nusemtl two words\nf 1 2 4\nusemtl wood\nf 1 3 4\nusemtl absent\n"
                                "f 2 3 4\nusemtl wood\nf 2 3 1\nusemtl (null)\nf 1 4 3\n");
  const PolygonSoup soup = read_soup(path);
  EXPECT_THAT(soup.face_materials, ElementsAre(k_no_index, 0, 1, 2, 1, k_no_index));
  ASSERT_EQ(soup.materials.size(), 3u);
  EXPECT_EQ(soup.materials[0], (Material{"two words", {1, 0, 0, 0.75}, "a texture.png"}));
  EXPECT_EQ(soup.materials[1], (Material{"wood", {0.5, 0.25, 0.125, 0.5}, "oak.png"}));
  EXPECT_EQ(soup.materials[2], (Material{"absent", {0.8, 0.8, 0.8, 1.0}, ""}));
}

TEST(ObjReader, DoesWithoutAMaterialLibraryThatIsMissing) {
  const PolygonSoup soup = read_text("a.obj", "mtllib nowhere.mtl\n" + k_square + "usemtl wood\nf 1 2 3\n");
  ASSERT_EQ(soup.materials.size(), 1u);
  EXPECT_EQ(soup.materials[0].name, "wood");
}

TEST(ObjReader, NamesTheLineOfADefectiveMaterialLibrary) {
  const TempFolder folder;
  folder.write("a.mtl", "newmtl wood\nKd 0.5 x 0\n");
  const auto path = folder.write("a.obj", "mtllib a.mtl\n" + k_square + "usemtl wood\nf 1 2 3\n");
  try {
    read_soup(path);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a.mtl:2: 'x' isn't a number"));
  }
}

TEST(ObjReader, ReadsPolylinesAsFeatureEdges) {
  const PolygonSoup soup = read_text("a.obj", k_square + "vt 0 0\nf 1 2 3 4\nl 1 2 -2\nl 3/1 4/1\n");
  EXPECT_THAT(soup.feature_edges, ElementsAre(Pair(0, 1), Pair(1, 2), Pair(2, 3)));
}

TEST(ObjReader, AcceptsContinuedLinesCommentsAndWindowsLineEnds) {
  const PolygonSoup soup =
      read_text("a.obj",
                "# comment\r\no thing\r\ng a b\r\ns off\r\nv 0 0 \\\r\n 0\r\nv +1 0 0 # right\r\n"
                "v 1e0 1.0E+0 0\r\n\r\nf 1 \\\n 2 \\\n3");
  EXPECT_THAT(soup.positions, ElementsAre(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)));
  EXPECT_EQ(soup.n_faces(), 1u);
}

TEST(ObjReader, AcceptsVerticesBehindTheFacesThatUseThem) {
  const PolygonSoup soup = read_text("a.obj", "f 1/1 2/1 3/1\n" + k_square + "vt 0.5 0.5\n");
  EXPECT_THAT(corners_of(soup, 0), ElementsAre(0, 1, 2));
  EXPECT_EQ(soup.corner_uvs[2], Vec2(0.5, 0.5));
}

TEST(ObjReader, TreatsNormalsThatAreNoNumbersAsAbsent) {
  const PolygonSoup soup = read_text("a.obj", k_square + "vn nan nan nan\nvn 0 0 1\nf 1//1 2//2 3//2\n");
  EXPECT_EQ(soup.corner_normals[0], Vec3(0, 0, 0));
  EXPECT_EQ(soup.corner_normals[1], Vec3(0, 0, 1));
}

TEST(ObjReader, NamesLineAndReasonOfEveryDefect) {
  EXPECT_EQ(complaint("a.obj", k_square + "f 1 2 5\n"), "a.obj:5: vertex 5 is out of range (there are 4)");
  EXPECT_EQ(complaint("a.obj", k_square + "f 1 2 -5\n"), "a.obj:5: vertex -5 is out of range (there are 4)");
  EXPECT_EQ(complaint("a.obj", k_square + "f 0 1 2\n"), "a.obj:5: vertex 0 is out of range (there are 4)");
  EXPECT_EQ(complaint("a.obj", k_square + "vt 0 0\nf 1/1 2/2 3/1\n"),
            "a.obj:6: texture coordinate 2 is out of range (there are 1)");
  EXPECT_EQ(complaint("a.obj", k_square + "f 1//1 2//1 3//1\n"),
            "a.obj:5: normal 1 is out of range (there are 0)");
  EXPECT_EQ(complaint("a.obj", k_square + "f 1 2\n"), "a.obj:5: face with 2 corners");
  EXPECT_EQ(complaint("a.obj", k_square + "f 1 2 3x\n"), "a.obj:5: malformed reference: unexpected 'x'");
  EXPECT_EQ(complaint("a.obj", k_square + "f 1 2 x\n"), "a.obj:5: malformed reference 'x'");
  EXPECT_EQ(complaint("a.obj", k_square + "f 1 2 99999999999999999999\n"),
            "a.obj:5: malformed reference '99999999999999999999'");
  EXPECT_EQ(complaint("a.obj", "v 0 0 1.5e\n"), "a.obj:1: '1.5e' isn't a number");
  EXPECT_EQ(complaint("a.obj", "v 0 0\n"), "a.obj:1: vertex with 2 numbers");
  EXPECT_EQ(complaint("a.obj", "\n\\\n\nv 0 0 0\nv 0 nan 0\n"),
            "a.obj:5: the position of vertex 2 isn't finite");
  EXPECT_EQ(complaint("a.obj", "v 0 1e999 0\n"), "a.obj:1: the position of vertex 1 isn't finite");
  EXPECT_EQ(complaint("a.obj", "v 0 0 0\nvn 1 0\n"), "a.obj:2: a number is missing");
  EXPECT_EQ(complaint("a.obj", "v 0 0 0\nff 1 2 3\n"), "a.obj:2: unknown statement 'ff'");
  EXPECT_EQ(complaint("a.obj", "v 0 0 0\nl 1\n"), "a.obj:2: polyline with 1 vertex");
  EXPECT_EQ(complaint("a.obj", "v 0 0 0\nsurf 0 1 0 1 1\n"),
            "a.obj:2: free-form geometry (surf) isn't supported");
  EXPECT_EQ(complaint("a.obj", "# nothing\n"), "a.obj: holds no vertices");
  EXPECT_EQ(complaint("a.obj", k_square + "vt nan 0\nf 1/1 2/1 3/1\n"),
            "a.obj: the texture coordinate of corner 0 isn't finite");
}

TEST(ObjWriter, SharesEqualAttributesAndLeavesOutAbsentNormals) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  soup.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
  soup.corner_normals.assign(6, Vec3(0, 0, 1));
  soup.corner_normals[5].setZero();
  EXPECT_THAT(write_soup(folder / "a.obj", soup).written_without, IsEmpty());
  EXPECT_EQ(
      read_whole_file(folder / "a.obj"),
      "# Written by Recede\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
      "f 1/1/1 2/2/1 3/3/1\nf 1/1/1 3/3/1 4/4\n");
  expect_equal(read_soup(folder / "a.obj"), soup);
}

TEST(ObjWriter, WritesAMaterialFileBesideItAndSaysWhichNamesChanged) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  soup.materials = {{"", {1, 0, 0, 1}, ""}, {"a\nb", {0, 1, 0, 1}, ""}};
  soup.face_materials = {0, 1};
  const WriteResult result = write_soup(folder / "a.obj", soup);
  EXPECT_THAT(result.written_without,
              ElementsAre("2 material names (changed to be distinct words on a line)"));
  EXPECT_EQ(result.bytes,
            std::filesystem::file_size(folder / "a.obj") + std::filesystem::file_size(folder / "a.mtl"));
  const PolygonSoup back = read_soup(folder / "a.obj");
  EXPECT_EQ(back.materials[0], (Material{"material", {1, 0, 0, 1}, ""}));
  EXPECT_EQ(back.materials[1], (Material{"a b", {0, 1, 0, 1}, ""}));
}

TEST(ObjRoundTrip, GivesBackRandomSoupsExactly) {
  const TempFolder folder;
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    const PolygonSoup soup = random_soup(seed);
    EXPECT_THAT(write_soup(folder / "a.obj", soup).written_without, IsEmpty());
    const PolygonSoup back = read_soup(folder / "a.obj");
    if (soup.n_faces() > 3) {
      expect_equal(back, soup);
    } else {
      EXPECT_EQ(back.positions, soup.positions);  // with few faces, a material may go unused
    }
  }
}

}  // namespace
}  // namespace recede::test
