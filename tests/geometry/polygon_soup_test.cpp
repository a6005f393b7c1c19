#include "meshes.h"
#include <recede/geometry/error.h>
#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/polygon_soup.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace recede {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

using test::soup_of;

/// Unit cube of six quads, outward.
PolygonSoup cube() {
  return soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
                 {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}});
}

TEST(PolygonSoup, NamesTheVertexThatIsNotFinite) {
  PolygonSoup soup = cube();
  soup.positions[5].y() = std::numeric_limits<double>::quiet_NaN();
  try {
    validate(soup, "cube.ply");
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "cube.ply: the position of vertex 5 isn't finite");
  }
}

TEST(PolygonSoup, RefusesIndicesOutOfRange) {
  PolygonSoup soup = cube();
  soup.corner_vertices[3] = 8;
  EXPECT_THROW(validate(soup, "cube"), InputError);
}

TEST(PolygonSoup, MergesVerticesAtTheSamePositionWhateverTheSignOfZero) {
  PolygonSoup soup =
      soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, {{0, 1, 2}, {3, 4, 5}});
  const RepairStep step = merge_identical_vertices(soup);
  EXPECT_EQ(step.changed, 2u);
  EXPECT_EQ(soup.positions.size(), 4u);
  EXPECT_THAT(soup.corner_vertices, ElementsAre(0, 1, 2, 0, 2, 3));
}

TEST(PolygonSoup, SaysHowManyColoursAMergeLost) {
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}}, {{0, 1, 2}, {3, 1, 2}});
  soup.vertex_colors = {{1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}};
  EXPECT_THAT(merge_identical_vertices(soup).detail, HasSubstr("1 of them had another colour"));
  EXPECT_EQ(soup.vertex_colors.size(), 3u);
}

//   2---1        A face 0 1 1 2 3 repeats a neighbour; 0 1 2 0 3 4 visits 0 twice and becomes two triangles.
TEST(PolygonSoup, SplitsFacesThatVisitAVertexTwice) {
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}},
                             {{0, 1, 2, 0, 3, 4}, {0, 1, 1, 2}, {0, 1, 0, 1}});
  const RepairStep step = remove_degenerate_faces(soup);
  EXPECT_EQ(step.changed, 3u);
  ASSERT_EQ(soup.n_faces(), 3u);
  EXPECT_THAT(soup.face(0), ElementsAre(0, 1, 2));
  EXPECT_THAT(soup.face(1), ElementsAre(0, 3, 4));
  EXPECT_THAT(soup.face(2), ElementsAre(0, 1, 2));
}

TEST(PolygonSoup, RemovesFacesThatRepeatAnotherButNotOpposedOnes) {
  PolygonSoup soup = soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 2, 0}, {0, 2, 1}});
  EXPECT_EQ(remove_duplicate_faces(soup).changed, 1u);
  EXPECT_EQ(soup.n_faces(), 2u);
}

TEST(PolygonSoup, TurnsTheSmallerSideOfAPart) {
  PolygonSoup soup = cube();
  std::reverse(soup.corner_vertices.begin(), soup.corner_vertices.begin() + 4);
  EXPECT_EQ(orient_consistently(soup).changed, 1u);
  EXPECT_LT(vector_area(soup, 0).z(), 0);
  EXPECT_EQ(split_non_manifold(soup).changed, 0u);
}

TEST(PolygonMesh, KeepsTheSoupThroughTheHalfEdges) {
  const PolygonSoup soup = cube();
  const PolygonSoup back = to_soup(to_polygon_mesh(soup));
  EXPECT_EQ(back.corner_vertices, soup.corner_vertices);
  EXPECT_EQ(back.face_offsets, soup.face_offsets);
}

TEST(PolygonMesh, KeepsEveryAttributeThroughTheHalfEdges) {
  PolygonSoup soup = cube();
  soup.materials = {{"red", {1, 0, 0, 1}, ""}, {"blue", {0, 0, 1, 1}, "blue.png"}};
  for (std::size_t c = 0; c < soup.n_corners(); ++c) {
    const auto number = static_cast<double>(c);
    soup.corner_uvs.emplace_back(number, -number);
    soup.corner_normals.emplace_back(0, number, 1);
  }
  for (std::size_t v = 0; v < soup.positions.size(); ++v)
    soup.vertex_colors.emplace_back(double(v) / 8, 0, 0, 1);
  soup.face_materials = {0, 1, k_no_index, 0, 1, 1};
  soup.feature_edges = {{0, 1}, {1, 2}};
  const PolygonSoup back = to_soup(to_polygon_mesh(soup));
  EXPECT_EQ(back.corner_uvs, soup.corner_uvs);
  EXPECT_EQ(back.corner_normals, soup.corner_normals);
  EXPECT_EQ(back.vertex_colors, soup.vertex_colors);
  EXPECT_EQ(back.face_materials, soup.face_materials);
  EXPECT_EQ(back.materials, soup.materials);
  EXPECT_EQ(back.feature_edges, soup.feature_edges);
}

// Three triangles on the edge 0-1: no half-edge can have two opposites.
TEST(PolygonMesh, SplitsAnEdgeOfThreeFacesAndMergingUndoesIt) {
  PolygonSoup soup =
      soup_of({{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}}, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  const auto before = soup.corner_vertices;
  EXPECT_THROW(to_polygon_mesh(soup), InputError);
  EXPECT_EQ(split_non_manifold(soup).changed, 4u);
  EXPECT_EQ(to_polygon_mesh(soup).n_faces(), 3u);
  EXPECT_EQ(merge_identical_vertices(soup).changed, 4u);
  EXPECT_EQ(soup.corner_vertices, before);
}

// Two triangles that touch in vertex 0 alone.
TEST(PolygonMesh, SplitsABowTieVertex) {
  PolygonSoup soup =
      soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 0, 0}, {-1, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
  EXPECT_THROW(to_polygon_mesh(soup), InputError);
  EXPECT_EQ(split_non_manifold(soup).changed, 1u);
  const MeshSummary summary = summarize(to_polygon_mesh(soup));
  EXPECT_EQ(summary.components, 2u);
  EXPECT_EQ(summary.split_vertices, 1u);
  EXPECT_EQ(summary.border_loops, 2u);
}

// A strip of five triangles closed with a half turn.
TEST(PolygonMesh, OpensAMoebiusStrip) {
  std::vector<Vec3> positions;
  for (int i = 0; i < 5; ++i) positions.emplace_back(std::cos(1.2566 * i), std::sin(1.2566 * i), i);
  PolygonSoup soup = soup_of(positions, {{0, 1, 2}, {1, 2, 3}, {2, 3, 4}, {3, 4, 0}, {4, 0, 1}});
  const MeshFromSoup result = repair_to_polygon_mesh(soup);
  EXPECT_EQ(result.mesh.n_faces(), 5u);
  EXPECT_EQ(summarize(result.mesh).border_loops, 1u);
}

TEST(PolygonMesh, MarksTheTwelveEdgesOfACube) {
  PolygonMesh mesh = to_polygon_mesh(cube());
  EXPECT_EQ(mark_feature_edges(mesh, 1.5), 12u);
  EXPECT_EQ(mark_feature_edges(mesh, 1.6), 0u);
}

TEST(PolygonMesh, SummarizesACube) {
  const MeshSummary summary = summarize(to_polygon_mesh(cube()));
  EXPECT_EQ(summary.vertices, 8u);
  EXPECT_EQ(summary.edges, 12u);
  EXPECT_EQ(summary.quads, 6u);
  EXPECT_EQ(summary.border_edges, 0u);
  EXPECT_EQ(summary.components, 1u);
  EXPECT_DOUBLE_EQ(summary.area, 6);
}

TEST(Triangulate, CutsAConcavePolygonInsideItself) {
  // An L: the fan from corner 0 is right here, so start it where the fan would leave the polygon.
  PolygonSoup soup =
      soup_of({{2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 0, 0}}, {{0, 1, 2, 3, 4, 5}});
  std::vector<Index> faces, corners;
  const std::vector<Index> triangles = triangulate(soup, &faces, &corners);
  ASSERT_EQ(triangles.size(), 12u);
  double area = 0;
  for (std::size_t t = 0; t < 4; ++t) {
    const Vec3 a = soup.positions[triangles[3 * t]], b = soup.positions[triangles[3 * t + 1]],
               c = soup.positions[triangles[3 * t + 2]];
    const double signed_area = 0.5 * (b - a).cross(c - a).z();
    EXPECT_GT(signed_area, 0);
    area += signed_area;
  }
  EXPECT_DOUBLE_EQ(area, 3);
}

// A star of 4000 corners, every second one turning inward: its area is that of its triangles, and it takes no
// time.
TEST(Triangulate, CutsALargeStarIntoTrianglesOfItsOwnArea) {
  constexpr Index n = 4000;
  PolygonSoup soup;
  std::vector<Index> face;
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n, r = i % 2 == 0 ? 1 : 0.5;
    soup.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    face.push_back(i);
  }
  soup.add_face(face);
  const std::vector<Index> triangles = triangulate(soup);
  ASSERT_EQ(triangles.size(), 3 * (n - 2));
  double area = 0;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    const Vec3 a = soup.positions[triangles[t]], b = soup.positions[triangles[t + 1]],
               c = soup.positions[triangles[t + 2]];
    const double signed_area = 0.5 * (b - a).cross(c - a).z();
    EXPECT_GE(signed_area, 0);
    area += signed_area;
  }
  // 4000 sums of areas of size 1.
  EXPECT_NEAR(area, vector_area(soup, 0).norm(), 1e-12);
}

TEST(Triangulate, CutsAConcaveQuadAtItsReflexCorner) {
  PolygonSoup soup = soup_of({{0, 0, 0}, {2, -1, 0}, {0.5, 0, 0}, {2, 1, 0}}, {{1, 2, 3, 0}});
  const std::vector<Index> triangles = triangulate(soup);
  const Vec3 first = soup.positions[triangles[1]] - soup.positions[triangles[0]];
  const Vec3 second = soup.positions[triangles[2]] - soup.positions[triangles[0]];
  EXPECT_NE(first.cross(second).norm(), 0);
  for (std::size_t t = 0; t < 2; ++t) {
    EXPECT_TRUE(std::count(triangles.begin() + 3 * long(t), triangles.begin() + 3 * long(t) + 3, 0) == 1);
    EXPECT_TRUE(std::count(triangles.begin() + 3 * long(t), triangles.begin() + 3 * long(t) + 3, 2) == 1);
  }
}

}  // namespace
}  // namespace recede
