#include "input_errors.h"
#include "soups.h"

#include <fmt/format.h>

#include <cmath>

namespace recede::test {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string k_facet =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n endloop\nendfacet\n";

// A unit square as one polygon, with everything that STL and OFF can't hold.
PolygonSoup square_with_everything() {
  PolygonSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {5, 5, 5}};
  soup.add_face(std::vector<Index>{0, 1, 2, 3});
  soup.corner_uvs.assign(4, Vec2(0, 0));
  soup.corner_normals.assign(4, Vec3(0, 0, 1));
  soup.vertex_colors.assign(5, Vec4(1, 0.5, 0, 1));
  soup.materials = {{"wood", {1, 1, 1, 1}, ""}};
  soup.face_materials = {0};
  soup.feature_edges = {{0, 1}};
  return soup;
}

TEST(StlReader, ReadsSeveralSolidsOfText) {
  const PolygonSoup soup = read_text(
      "a.stl", "solid one two\n" + k_facet + "endsolid one two\r\nSOLID\n" + k_facet + "endsolid\n");
  EXPECT_EQ(soup.n_faces(), 2u);
  EXPECT_EQ(soup.positions.size(), 6u) << "every facet has corners of its own";
  EXPECT_EQ(soup.positions[4], Vec3(1, 0, 0));
  EXPECT_THAT(soup.corner_normals, IsEmpty());
}

TEST(StlReader, ReadsFacetNormalsThatAreNoNumbers) {
  EXPECT_EQ(
      read_text(
          "a.stl",
          "solid\nfacet normal -nan(ind) nan inf\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
          "endloop\nendfacet\nendsolid\n")
          .n_faces(),
      1u);
}

TEST(StlReader, KnowsBinaryFilesThatStartWithSolid) {
  const TempFolder folder;
  write_soup(folder / "a.stl", two_triangles());
  std::string content = read_whole_file(folder / "a.stl");
  content.replace(0, 11, "solid facet");
  EXPECT_EQ(read_text("b.stl", content).n_faces(), 2u);
  EXPECT_THAT(complaint("b.stl", content.substr(0, 150)),
              HasSubstr("byte 150: the header promises 2 facets, but the file ends after 1"));
}

TEST(StlReader, NamesThePlaceAndReasonOfEveryDefect) {
  EXPECT_EQ(complaint("a.stl", "solid\n" + k_facet),
            "a.stl:9: the file ends where facet or endsolid should stand");
  EXPECT_EQ(complaint("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\nvertex"),
            "a.stl:5: 'vertex' isn't a number");
  EXPECT_EQ(
      complaint("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n"),
      "a.stl:6: facet with 2 corners");
  EXPECT_EQ(complaint("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 inf\n"),
            "a.stl:4: the position of vertex 0 isn't finite");
  EXPECT_EQ(complaint("a.stl", "solid\nfacets\n"), "a.stl:2: 'facets' where facet or endsolid should stand");
  EXPECT_EQ(complaint("a.stl", "something short"),
            "a.stl: byte 15: the file ends inside the header of a binary STL file");
}

TEST(StlWriter, CutsPolygonsAndSaysWhatIsMissing) {
  const TempFolder folder;
  const WriteResult result = write_soup(folder / "a.stl", square_with_everything());
  EXPECT_THAT(
      result.written_without,
      ElementsAre("1 polygon with more than three corners (cut into triangles)", "1 vertex that no face uses",
                  "texture coordinates", "normals", "vertex colours", "1 material", "1 feature edge",
                  "shared vertices (every triangle repeats its corners)"));
  EXPECT_EQ(result.bytes, 84u + 2u * 50u);
  const PolygonSoup back = read_soup(folder / "a.stl");
  EXPECT_EQ(back.n_faces(), 2u);
  EXPECT_DOUBLE_EQ(vector_area(back, 0).z() + vector_area(back, 1).z(), 1.0);
}

TEST(StlWriter, RefusesPositionsOutsideTheRangeOfFloats) {
  const TempFolder folder;
  PolygonSoup soup = two_triangles();
  soup.positions[2].x() = 1e39;
  EXPECT_THROW(write_soup(folder / "a.stl", soup), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder / "a.stl"));
}

TEST(StlRoundTrip, KeepsEveryTriangleInBothEncodings) {
  const TempFolder folder;
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    const bool ascii = seed % 2 == 0;
    const PolygonSoup soup = random_soup(seed, {.attributes = false, .floats = !ascii});
    write_soup(folder / "a.stl", soup, {.ascii = ascii});
    const PolygonSoup back = read_soup(folder / "a.stl");
    const std::vector<Index> triangles = triangulate(soup);
    ASSERT_EQ(back.n_corners(), triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
      EXPECT_EQ(back.positions[i], soup.positions[triangles[i]]);
  }
}

TEST(OffReader, ReadsPolygonsCommentsAndColoursOfFaces) {
  const PolygonSoup soup =
      read_text("a.off",
                "# first\nOFF # keyword\n\n5 2 # no edges\n0 0 0\n1 0 0 # b\n#\n1 1 0\n0 1 0\n0.5 2 0\n"
                "5 0 1 2 4 3 255 0 0\n3 0 1 2 0.5 0.5 0.5 1\n");
  EXPECT_THAT(soup.face_offsets, ElementsAre(0, 5, 8));
  EXPECT_THAT(soup.corner_vertices, ElementsAre(0, 1, 2, 4, 3, 0, 1, 2));
}

TEST(OffReader, FindsTheCountsOnTheFirstLine) {
  EXPECT_EQ(read_text("a.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").n_faces(), 1u);
  EXPECT_EQ(read_text("a.off", "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").n_faces(), 1u);
}

TEST(OffReader, ReadsColoursAsWholeNumbersOrFractions) {
  const std::string faces = "3 0 1 2\n";
  EXPECT_THAT(read_text("a.off", "COFF\n3 1 0\n0 0 0 255 51 0 0\n1 0 0 1 1 1\n0 1 0 0 0 0 255\n" + faces)
                  .vertex_colors,
              ElementsAre(Vec4(1, 0.2, 0, 0), Vec4(1.0 / 255, 1.0 / 255, 1.0 / 255, 1), Vec4(0, 0, 0, 1)));
  EXPECT_THAT(
      read_text("a.off", "COFF\n3 1 0\n0 0 0 0.5 1 0\n1 0 0 1 1 1 0.5\n0 1 0 0 0 0\n" + faces).vertex_colors,
      ElementsAre(Vec4(0.5, 1, 0, 1), Vec4(1, 1, 1, 0.5), Vec4(0, 0, 0, 1)));
}

TEST(OffReader, ReadsNormalsAndTextureCoordinatesOfVertices) {
  const PolygonSoup soup = read_text("a.off",
                                     "STCNOFF\n3 1 0\n0 0 0 0 0 1 1 0 0 0.25 0.5\n1 0 0 0 1 0 0 1 0 1 0\n"
                                     "0 1 0 1 0 0 0 0 1 0.5 0 1\n3 2 0 1\n");
  EXPECT_THAT(soup.corner_uvs, ElementsAre(Vec2(0, 1), Vec2(0.25, 0.5), Vec2(1, 0)));
  EXPECT_THAT(soup.corner_normals, ElementsAre(Vec3(1, 0, 0), Vec3(0, 0, 1), Vec3(0, 1, 0)));
  EXPECT_THAT(soup.vertex_colors, ElementsAre(Vec4(1, 0, 0, 1), Vec4(0, 1, 0, 1), Vec4(0, 0, 1, 0.5)));
}

TEST(OffReader, NamesTheLineAndReasonOfEveryDefect) {
  EXPECT_EQ(complaint("a.off", "hello\n"), "a.off:1: isn't an OFF file (it doesn't start with OFF)");
  EXPECT_EQ(complaint("a.off", "OFF BINARY\n"),
            "a.off:1: binary OFF isn't supported; write the file as text");
  EXPECT_EQ(complaint("a.off", "4OFF\n"), "a.off:1: 4OFF: vertices in other than three dimensions");
  EXPECT_EQ(complaint("a.off", "OFF\n3 x\n"), "a.off:2: the number of faces is 'x'");
  EXPECT_EQ(complaint("a.off", "OFF\n4000000000 1 0\n0 0 0\n"),
            "a.off:3: the header promises 4000000000 vertices, but the file has room for 1 at most");
  const std::string head = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(complaint("a.off", head + "3 0 1 3\n"), "a.off:6: vertex 3 is out of range (there are 3)");
  EXPECT_EQ(complaint("a.off", head + "3 0 1 -1\n"), "a.off:6: a corner is '-1'");
  EXPECT_EQ(complaint("a.off", head + "3 0 1\n2\n"), "a.off:6: face 0 has 2 of its 3 corners");
  EXPECT_EQ(complaint("a.off", head + "2 0 1     \n"), "a.off:6: face 0 has 2 corners");
  EXPECT_EQ(complaint("a.off", "OFF\n3 0 0\n0 0 0\n1 0 nan\n0 1 0\n"),
            "a.off:4: the position of vertex 1 isn't finite");
  EXPECT_EQ(complaint("a.off", "OFF\n2 0 0\n0 0 0\n0 1          \n"), "a.off:4: a number is missing");
  EXPECT_EQ(complaint("a.off", "OFF\n2 0 0\n0 0 0\n#          \n"), "a.off:5: the file ends before vertex 1");
  EXPECT_THAT(complaint("a.off", "OFF\n1 0 0\n0 0 0 1 1 1\n"), HasSubstr("a.off:3: more numbers"));
}

TEST(OffWriter, SaysWhatIsMissing) {
  const TempFolder folder;
  EXPECT_THAT(write_soup(folder / "a.off", square_with_everything()).written_without,
              ElementsAre("texture coordinates", "normals", "1 material", "1 feature edge"));
}

TEST(OffRoundTrip, GivesBackPolygonsAndColoursExactly) {
  const TempFolder folder;
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    PolygonSoup soup = random_soup(seed, {.attributes = false});
    if (seed % 2 == 0) soup.vertex_colors = random_soup(seed).vertex_colors;
    soup.vertex_colors.resize(seed % 2 == 0 ? soup.positions.size() : 0, Vec4(0, 1, 0, 1));
    EXPECT_THAT(write_soup(folder / "a.off", soup).written_without, IsEmpty());
    expect_equal(read_soup(folder / "a.off"), soup);
  }
}

}  // namespace
}  // namespace recede::test
