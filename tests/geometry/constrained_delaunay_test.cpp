#include "delaunay_checks.h"
#include "input_errors.h"
#include <recede/geometry/constrained_delaunay.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/parameterization.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

namespace recede {
namespace {

using test::Edges;
using test::vertex_sets;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::size_t n_inside(const ConstrainedDelaunay& mesh) {
  std::size_t n = 0;
  for (const DelaunayTriangle& triangle : mesh.triangles()) n += triangle.is_inside ? 1 : 0;
  return n;
}

std::int64_t twice_area_inside(const ConstrainedDelaunay& mesh) {
  std::int64_t area = 0;
  for (Index t = 0; t < mesh.triangles().size(); ++t) {
    const auto [a, b, c] = test::corners(mesh, t);
    if (mesh.is_inside(t)) area += test::twice_area(a, b, c);
  }
  return area;
}

Edges loop(Index begin, Index end) {
  Edges edges;
  for (Index v = begin; v < end; ++v) edges.push_back({v, v + 1 == end ? begin : v + 1});
  return edges;
}

//  3-----2
//  |     |
//  |   4 |
//  0-----1
const std::vector<Vec2> k_square = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};

TEST(ConstrainedDelaunay, OfNoPointsOrPointsOnALineHasNoTriangles) {
  EXPECT_THAT(ConstrainedDelaunay({}).triangles(), IsEmpty());
  EXPECT_THAT(ConstrainedDelaunay(std::vector<Vec2>{{1, 2}}).triangles(), IsEmpty());
  // 1---3---0,4---2
  const std::vector<Vec2> line = {{4, 2}, {0, 0}, {6, 3}, {2, 1}, {4, 2}};
  ConstrainedDelaunay mesh(line, Edges{{1, 2}, {0, 3}});
  EXPECT_THAT(mesh.triangles(), IsEmpty());
  EXPECT_EQ(mesh.n_vertices(), 5u);
  EXPECT_EQ(mesh.first_equal(4), 0u);
  EXPECT_EQ(mesh.first_equal(3), 3u);
  mesh.keep_inside();
  EXPECT_EQ(mesh.insert({1, 1}).status, InsertionStatus::outside);
  EXPECT_EQ(mesh.locate({2, 1}).on, TriangleLocation::On::outside);
}

TEST(ConstrainedDelaunay, TakesTheDiagonalThatIsShorterOrGiven) {
  //     3
  //  0     2
  //     1
  const std::vector<Vec2> kite = {{0, 2}, {5, 0}, {10, 2}, {5, 4}};
  EXPECT_THAT(vertex_sets(ConstrainedDelaunay(kite)),
              ElementsAre(std::array<Index, 3>{0, 1, 3}, std::array<Index, 3>{1, 2, 3}));
  const ConstrainedDelaunay mesh(kite, Edges{{0, 2}});
  EXPECT_THAT(vertex_sets(mesh), ElementsAre(std::array<Index, 3>{0, 1, 2}, std::array<Index, 3>{0, 2, 3}));
  test::expect_valid(mesh, {{0, 2}});
}

TEST(ConstrainedDelaunay, KeepsWhatALoopEncloses) {
  //  3-----------2
  //  |  7-----6  |
  //  |  |     |  |
  //  |  4-----5  |
  //  0-----------1
  std::vector<Vec2> points = {{0, 0}, {8, 0}, {8, 8}, {0, 8}, {2, 2}, {6, 2}, {6, 6}, {2, 6}};
  Edges edges = loop(0, 4);
  for (const auto& edge : loop(4, 8)) edges.push_back({edge[1], edge[0]});  // clockwise
  for (const InsideRule rule : {InsideRule::even_odd, InsideRule::winding}) {
    ConstrainedDelaunay mesh(points, edges);
    test::expect_valid(mesh, edges);
    EXPECT_EQ(n_inside(mesh), 10u) << "all before the loops were looked at";
    mesh.keep_inside(rule);
    EXPECT_EQ(n_inside(mesh), 8u);
    EXPECT_EQ(twice_area_inside(mesh), 2 * (64 - 16));
    EXPECT_EQ(mesh.insert({4, 4.5}).status, InsertionStatus::outside) << "in the hole";
    EXPECT_EQ(mesh.insert({9, 1}).status, InsertionStatus::outside);
    EXPECT_EQ(mesh.insert({4, 2}).status, InsertionStatus::on_constrained_edge);
    EXPECT_EQ(mesh.insert({4, 0}).status, InsertionStatus::on_constrained_edge);
    EXPECT_EQ(mesh.insert({4, 1}).status, InsertionStatus::inserted);
  }
}

TEST(ConstrainedDelaunay, RulesDifferWhereLoopsRunTheSameWay) {
  std::vector<Vec2> points = {{0, 0}, {8, 0}, {8, 8}, {0, 8}, {2, 2}, {6, 2}, {6, 6}, {2, 6}};
  Edges edges = loop(0, 4);
  for (const auto& edge : loop(4, 8)) edges.push_back(edge);
  ConstrainedDelaunay mesh(points, edges);
  mesh.keep_inside(InsideRule::even_odd);
  EXPECT_EQ(twice_area_inside(mesh), 2 * (64 - 16));
  mesh.keep_inside(InsideRule::winding);
  EXPECT_EQ(twice_area_inside(mesh), 2 * 64) << "round the inner square twice";
}

TEST(ConstrainedDelaunay, AnEdgeThereTwiceBoundsNothingAndIsKept) {
  std::vector<Vec2> points = k_square;
  points.insert(points.end(), {{1, 1}, {3, 2}});
  Edges edges = loop(0, 4);
  edges.insert(edges.end(), {{4, 5}, {5, 4}});
  for (const InsideRule rule : {InsideRule::even_odd, InsideRule::winding}) {
    ConstrainedDelaunay mesh(points, edges);
    mesh.keep_inside(rule);
    EXPECT_EQ(twice_area_inside(mesh), 2 * 16);
    EXPECT_EQ(mesh.insert({2, 1.5}).status, InsertionStatus::on_constrained_edge);
  }
}

TEST(ConstrainedDelaunay, LoopsThatDontCloseAreRefusedWithTheirPoint) {
  ConstrainedDelaunay open(k_square, Edges{{0, 1}, {1, 2}, {2, 3}});
  EXPECT_EQ(test::error_text([&] { open.keep_inside(); }), "the edges at point 0 don't close a loop");
  ConstrainedDelaunay against(k_square, Edges{{0, 1}, {2, 1}, {2, 3}, {3, 0}});
  EXPECT_EQ(test::error_text([&] { against.keep_inside(InsideRule::winding); }),
            "the edges at point 1 don't close a loop");
  EXPECT_EQ(n_inside(against), 2u) << "nothing was changed";
  against.keep_inside();
  EXPECT_EQ(twice_area_inside(against), 2 * 16);
}

TEST(ConstrainedDelaunay, AnEdgeThroughVerticesIsMadeOfPieces) {
  //        5
  //  0---1---2---3
  //        4
  const std::vector<Vec2> points = {{0, 0}, {4, 0}, {8, 0}, {12, 0}, {6, -9}, {6, 9}};
  for (const Edges& edges : {Edges{{0, 3}}, Edges{{3, 0}, {1, 3}}}) {
    ConstrainedDelaunay mesh(points, edges);
    test::expect_valid(mesh, edges);
    EXPECT_THAT(test::pieces_of(mesh, edges), SizeIs(3));
    EXPECT_EQ(mesh.insert({6, 0}).status, InsertionStatus::on_constrained_edge);
    EXPECT_EQ(mesh.insert({4, 0}).status, InsertionStatus::on_vertex);
  }
}

TEST(ConstrainedDelaunay, EdgesThatCrossAreRefusedWithBothNames) {
  //  3   2
  //    x
  //  0   1
  const auto crossing = [](const std::vector<Vec2>& points, const Edges& edges) {
    return test::error_text([&] { ConstrainedDelaunay(points, edges); });
  };
  EXPECT_EQ(crossing(k_square, {{0, 1}, {0, 2}, {1, 3}}),
            "edge 1 from point 0 to 2 and edge 2 from point 1 to 3 cross");
  std::vector<Vec2> with_middle = k_square;
  with_middle.emplace_back(2, 2);
  EXPECT_EQ(crossing(with_middle, {{0, 1}, {0, 2}, {1, 3}}), "") << "they meet in point 4";
  // An edge of several pieces is named as it was given.
  std::vector<Vec2> long_edge = {{0, 0}, {4, 0}, {8, 0}, {12, 0}, {6, -9}, {6, 9}};
  EXPECT_EQ(crossing(long_edge, {{3, 0}, {4, 5}}),
            "edge 0 from point 3 to 0 and edge 1 from point 4 to 5 cross");
  EXPECT_EQ(crossing(long_edge, {{0, 1}, {3, 2}, {1, 2}, {4, 5}}),
            "edge 2 from point 1 to 2 and edge 3 from point 4 to 5 cross")
      << "not those on the same line";
}

TEST(ConstrainedDelaunay, EdgesWithoutLengthOrPointsAreRefused) {
  std::vector<Vec2> points = k_square;
  points.push_back(k_square[1]);
  const auto complaint = [&](const Edges& edges) {
    return test::error_text([&] { ConstrainedDelaunay(points, edges); });
  };
  EXPECT_EQ(complaint({{0, 1}, {2, 2}}), "edge 1 has equal ends, points 2 and 2");
  EXPECT_EQ(complaint({{1, 4}}), "edge 0 has equal ends, points 1 and 4");
  EXPECT_EQ(complaint({{0, 5}}), "edge 0 has point 5 of 5");
  EXPECT_EQ(complaint(Edges(32768, {2, 3})), "more than 32767 edges lie upon edge 32767");
  points[2].y() = std::nan("");
  EXPECT_EQ(complaint({}), "point 2 isn't finite");
}

TEST(ConstrainedDelaunay, EqualPointsAreOneVertex) {
  std::vector<Vec2> points;
  for (int copy = 0; copy < 3; ++copy) points.insert(points.end(), k_square.begin(), k_square.end());
  points.emplace_back(-0.0, 0.0);
  const ConstrainedDelaunay mesh(points, Edges{{4, 10}});
  test::expect_valid(mesh, {{0, 2}});
  EXPECT_THAT(mesh.triangles(), SizeIs(2));
  for (Index v = 0; v < 12; ++v) EXPECT_EQ(mesh.first_equal(v), v % 4);
  EXPECT_EQ(mesh.first_equal(12), 0u);
}

TEST(ConstrainedDelaunay, InsertsInAFaceOnASideAndOnTheBorder) {
  ConstrainedDelaunay mesh(k_square);
  ASSERT_EQ(mesh.insert({2, 2}).vertex, 4u) << "on the diagonal";
  EXPECT_THAT(mesh.changed(), SizeIs(4));
  test::expect_valid(mesh);
  ASSERT_EQ(mesh.insert({2, 1}).status, InsertionStatus::inserted) << "in a face";
  EXPECT_THAT(mesh.changed(), SizeIs(3));
  test::expect_valid(mesh);
  ASSERT_EQ(mesh.insert({2, 0}).status, InsertionStatus::inserted) << "on the border, which is no edge";
  EXPECT_THAT(mesh.changed(), SizeIs(2));
  test::expect_valid(mesh);
  EXPECT_EQ(mesh.insert({2, 1}).vertex, 5u);
  EXPECT_EQ(mesh.insert({2, -1e-300}).status, InsertionStatus::outside);
  EXPECT_EQ(mesh.insert({2, std::nan("")}).status, InsertionStatus::outside);
  EXPECT_THAT(mesh.changed(), IsEmpty());
  EXPECT_EQ(mesh.n_vertices(), 7u);
}

TEST(ConstrainedDelaunay, AStarHasTheAreaOfItsOutline) {
  // Tips at 1000, clefts at 10: the hull is far larger.
  constexpr Index k_tips = 50;
  std::vector<Vec2> points;
  std::int64_t twice_area = 0;
  for (Index i = 0; i < 2 * k_tips; ++i) {
    const double angle = std::numbers::pi * i / k_tips, radius = i % 2 == 0 ? 1000 : 10;
    points.emplace_back(std::round(radius * std::cos(angle)), std::round(radius * std::sin(angle)));
  }
  for (Index i = 0; i < points.size(); ++i) {
    twice_area += test::twice_area({0, 0}, points[i], points[(i + 1) % points.size()]);
  }
  const Edges edges = loop(0, 2 * k_tips);
  ConstrainedDelaunay mesh(points, edges);
  test::expect_valid(mesh, edges);
  mesh.keep_inside();
  EXPECT_EQ(n_inside(mesh), points.size() - 2);
  EXPECT_EQ(twice_area_inside(mesh), twice_area);
}

TEST(ConstrainedDelaunay, AGridOfSquaresIsCutInHalves) {
  constexpr int k_side = 300;
  std::vector<Vec2> points;
  for (int i = 0; i < k_side; ++i) {
    for (int j = 0; j < k_side; ++j) points.emplace_back(i, j);
  }
  // Across the whole, through one vertex in each row that it meets.
  const Edges edges = {{0, k_side * 150 - 1}};
  const ConstrainedDelaunay mesh(points, edges);
  EXPECT_THAT(mesh.triangles(), SizeIs(2 * (k_side - 1) * (k_side - 1)));
  test::expect_valid(mesh, edges);
  const ConstrainedDelaunay again(points, edges);
  EXPECT_EQ(vertex_sets(again), vertex_sets(mesh));
}

TEST(ConstrainedDelaunay, AHundredThousandPointsAreDelaunay) {
  std::mt19937 random(4);
  const ConstrainedDelaunay mesh(test::random_points(100000, 1 << 25, random));
  test::expect_valid(mesh);
}

TEST(ConstrainedDelaunay, FlatAndFarPointsKeepTheirOrder) {
  // A strip of height 1e-300 and length 1e300: two rows of points that almost touch.
  std::vector<Vec2> strip;
  for (int i = 0; i < 20; ++i) {
    strip.emplace_back(i * 1e299, 0);
    strip.emplace_back(i * 1e299, 1e-300);
  }
  Edges outline;
  for (Index i = 0; i + 2 < 40; i += 2) outline.insert(outline.end(), {{i, i + 2}, {i + 1, i + 3}});
  outline.insert(outline.end(), {{0, 1}, {38, 39}});
  ConstrainedDelaunay flat(strip, outline);
  test::expect_linked(flat);
  flat.keep_inside();
  EXPECT_THAT(flat.triangles(), SizeIs(38));
  EXPECT_EQ(n_inside(flat), 38u);
  EXPECT_EQ(flat.insert({1.5e299, 0.5e-300}).status, InsertionStatus::inserted);
  EXPECT_EQ(flat.insert({1.5e299, 0}).status, InsertionStatus::on_constrained_edge);
  EXPECT_EQ(flat.insert({1.5e299, 1.01e-300}).status, InsertionStatus::outside);

  // Units in the last place far from the origin, as a grid of which every other point is one unit off.
  std::vector<Vec2> moved, near;
  for (int i = 0; i < 400; ++i) {
    near.emplace_back(i % 20, i / 20 + i % 2);
    moved.push_back(near.back() + Vec2(0x1p52, 0x1p52));
  }
  EXPECT_EQ(vertex_sets(ConstrainedDelaunay(moved)), vertex_sets(ConstrainedDelaunay(near)));
}

TEST(ConstrainedDelaunay, PointsAFewUnitsOffALineMakeTriangles) {
  std::vector<Vec2> points;
  std::size_t n_off = 0;
  for (int i = 0; i <= 99; ++i) {
    const double x = 0.1 * i;
    points.emplace_back(x, i % 3 == 1 ? std::nextafter(x, i % 2 == 0 ? 100.0 : -100.0) : x);
    n_off += i % 3 == 1 ? 1 : 0;
  }
  const Edges edges = {{0, 99}};
  const ConstrainedDelaunay mesh(points, edges);
  test::expect_linked(mesh);
  std::size_t n_border = 0, n_pieces = 0;
  for (const DelaunayTriangle& triangle : mesh.triangles()) {
    for (int k = 0; k < 3; ++k) {
      if (triangle.neighbour(k) == k_no_index) ++n_border;
      if (triangle.is_constrained(k)) ++n_pieces;
    }
  }
  EXPECT_EQ(mesh.triangles().size(), 2 * (points.size() - 1) - n_border);
  // The edge passes through the other points, and has triangles on both sides but at the border.
  EXPECT_GE(n_pieces, points.size() - n_off - 1);
  EXPECT_LE(n_pieces, 2 * (points.size() - n_off - 1));
}

TEST(ConstrainedDelaunay, AllEdgesOfARealSurfaceInThePlaneGiveItsTriangles) {
  const std::filesystem::path path = std::filesystem::path(RECEDE_DATA) / "meshes/lion-head.off";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no models; ./dev data fetches them";
  const PolygonSoup soup = read_soup(path.string());
  const std::vector<Index> corners = triangulate(soup);
  const Parameterization map = parameterize_disk(soup.positions, corners, {.border = DiskBorder::circle});
  ASSERT_EQ(map.flipped, 0u);
  Edges edges;
  std::set<std::array<Index, 3>> expected;
  for (std::size_t c = 0; c < corners.size(); c += 3) {
    std::array<Index, 3> v{corners[c], corners[c + 1], corners[c + 2]};
    for (std::size_t k = 0; k < 3; ++k) edges.push_back({v[k], v[(k + 1) % 3]});
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    expected.insert(v);
  }
  // Inner edges are there in both directions, those of the border once.
  ConstrainedDelaunay mesh(map.uvs, edges);
  test::expect_linked(mesh);
  mesh.keep_inside(InsideRule::winding);
  EXPECT_EQ(vertex_sets(mesh, true), expected);
}

}  // namespace
}  // namespace recede
