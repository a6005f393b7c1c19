// Random points and edges against brute force; few coordinates make many points equal, on lines and on
// circles.
#include "delaunay_checks.h"
#include "input_errors.h"
#include <recede/geometry/detail/triangle_walk.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

using test::Edges;
using On = TriangleLocation::On;

constexpr int k_ranges[] = {3, 6, 12, 50, 1 << 20};

TEST(ConstrainedDelaunayRandom, HoldsWhatItPromises) {
  std::mt19937 random(1);
  for (int round = 0; round < 1500; ++round) {
    const auto points = test::random_points(1 + random() % 40, k_ranges[round % 5], random);
    const Edges edges = test::random_edges(random() % 40, points, random);
    const ConstrainedDelaunay mesh(points, edges);
    SCOPED_TRACE(round);
    for (Index v = 0; v < points.size(); ++v) {
      const auto first = std::find(points.begin(), points.end(), points[v]) - points.begin();
      EXPECT_EQ(mesh.first_equal(v), static_cast<Index>(first));
    }
    if (mesh.triangles().empty()) continue;
    test::expect_valid(mesh, edges);
    test::expect_empty_circles(mesh, edges);
    ASSERT_FALSE(testing::Test::HasFailure());
  }
}

TEST(ConstrainedDelaunayRandom, EdgesAcrossManyTrianglesAreInserted) {
  std::mt19937 random(2);
  for (int round = 0; round < 30; ++round) {
    const auto points = test::random_points(600, round % 2 == 0 ? 30 : 1 << 20, random);
    const Edges edges = test::random_edges(40, points, random);
    SCOPED_TRACE(round);
    test::expect_valid(ConstrainedDelaunay(points, edges), edges);
    ASSERT_FALSE(testing::Test::HasFailure());
  }
}

TEST(ConstrainedDelaunayRandom, EdgesAreRefusedJustWhereTwoCrossApartFromVertices) {
  std::mt19937 random(3);
  int refused = 0;
  for (int round = 0; round < 1000; ++round) {
    const auto points = test::random_points(4 + random() % 10, k_ranges[round % 5], random);
    Edges edges;
    for (int i = 0; i < 3; ++i) {
      const std::array<Index, 2> edge{static_cast<Index>(random() % points.size()),
                                      static_cast<Index>(random() % points.size())};
      if (points[edge[0]] != points[edge[1]]) edges.push_back(edge);
    }
    std::vector<std::string> crossings;
    for (std::size_t f = 0; f < edges.size(); ++f) {
      for (std::size_t e = 0; e < f; ++e) {
        if (!test::cross_nowhere_at_a_vertex(points, edges[e], edges[f])) continue;
        crossings.push_back("edge " + std::to_string(e) + " from");
        crossings.push_back("edge " + std::to_string(f) + " from");
      }
    }
    const std::string error = test::error_text([&] { ConstrainedDelaunay(points, edges); });
    ASSERT_EQ(error.empty(), crossings.empty()) << round << ' ' << error;
    if (error.empty()) continue;
    ++refused;
    const auto is_named = [&](const std::string& name) { return error.find(name) != error.npos; };
    EXPECT_GE(std::count_if(crossings.begin(), crossings.end(), is_named), 2) << error;
  }
  EXPECT_GT(refused, 100);
}

/// How often the loops run round a point, counter-clockwise, which isn't on them: crossings of a ray to the
/// right. Everything is three times as large, to hold middles of triangles.
int winding_number(const Vec2& three_times, const std::vector<Vec2>& points, const Edges& edges) {
  int number = 0;
  for (const auto& edge : edges) {
    const Vec2 a = 3 * points[edge[0]], b = 3 * points[edge[1]];
    const bool up = a.y() <= three_times.y() && b.y() > three_times.y();
    const bool down = b.y() <= three_times.y() && a.y() > three_times.y();
    const int side = test::whole_orientation(a, b, three_times);
    if (up && side > 0) ++number;
    if (down && side < 0) --number;
  }
  return number;
}

TEST(ConstrainedDelaunayRandom, InsideIsWhatLoopsWindRound) {
  std::mt19937 random(4);
  std::size_t seen = 0;
  for (int round = 0; round < 3000; ++round) {
    const auto points = test::random_points(12, k_ranges[1 + round % 4], random);
    Edges edges;
    for (int n = 0; n < 2; ++n) {  // two loops of three to five points
      std::vector<Index> loop(3 + random() % 3);
      for (Index& v : loop) v = static_cast<Index>(random() % points.size());
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const std::array<Index, 2> edge{loop[i], loop[(i + 1) % loop.size()]};
        if (points[edge[0]] != points[edge[1]]) edges.push_back(edge);
      }
    }
    bool cross = false;
    for (const auto& e : edges) {
      for (const auto& f : edges) cross = cross || test::cross_nowhere_at_a_vertex(points, e, f);
    }
    if (cross) continue;
    ConstrainedDelaunay mesh(points, edges);
    for (const InsideRule rule : {InsideRule::even_odd, InsideRule::winding}) {
      mesh.keep_inside(rule);
      for (Index t = 0; t < mesh.triangles().size(); ++t) {
        const auto [a, b, c] = test::corners(mesh, t);
        const int number = winding_number(a + b + c, points, edges);
        ASSERT_EQ(mesh.is_inside(t), rule == InsideRule::even_odd ? number % 2 != 0 : number != 0)
            << round << " triangle " << t << " number " << number;
        if (mesh.is_inside(t)) ++seen;
      }
    }
  }
  EXPECT_GT(seen, 1000u);
}

bool are_same(const DelaunayTriangle& a, const DelaunayTriangle& b) {
  return a.vertices == b.vertices && a.constrained == b.constrained && a.turns == b.turns &&
         a.is_inside == b.is_inside;
}

/// Where a point must be, by a look at every triangle.
InsertionStatus expected_status(const ConstrainedDelaunay& mesh, const Vec2& p) {
  for (Index t = 0; t < mesh.triangles().size(); ++t) {
    const auto c = test::corners(mesh, t);
    if (std::find(c.begin(), c.end(), p) != c.end()) return InsertionStatus::on_vertex;
    int n_left = 0;
    bool is_on_edge = false;
    for (int k = 0; k < 3; ++k) {
      const std::size_t i = static_cast<std::size_t>(DelaunayTriangle::next(k));
      const std::size_t j = static_cast<std::size_t>(DelaunayTriangle::previous(k));
      n_left += test::whole_orientation(c[i], c[j], p) >= 0 ? 1 : 0;
      is_on_edge |= mesh.triangles()[t].is_constrained(k) && test::is_on_segment(c[i], c[j], p);
    }
    if (is_on_edge) return InsertionStatus::on_constrained_edge;
    if (n_left == 3 && mesh.is_inside(t)) return InsertionStatus::inserted;
  }
  return InsertionStatus::outside;
}

TEST(ConstrainedDelaunayRandom, InsertionsChangeTheTrianglesThatTheySay) {
  std::mt19937 random(5);
  std::map<InsertionStatus, int> seen;
  for (int round = 0; round < 1000; ++round) {
    SCOPED_TRACE(round);
    const int range = k_ranges[1 + round % 4];
    const auto points = test::random_points(4 + random() % 12, range, random);
    Edges edges = test::random_edges(random() % 10, points, random);
    const std::size_t once = edges.size();
    for (std::size_t e = 0; e < once && round % 3 == 0; ++e) edges.push_back({edges[e][1], edges[e][0]});
    ConstrainedDelaunay mesh(points, edges);
    if (round % 3 == 0 && mesh.triangles().size() > 1) {
      // Edges there twice bound nothing: all are outside, and nothing can be inserted.
      mesh.keep_inside();
      EXPECT_NE(mesh.insert(test::random_points(1, range, random)[0]).status, InsertionStatus::inserted);
      continue;
    }
    for (const Vec2& p : test::random_points(25, range, random)) {
      const std::vector<DelaunayTriangle> before(mesh.triangles().begin(), mesh.triangles().end());
      const InsertionStatus expected = expected_status(mesh, p);
      const Insertion insertion = mesh.insert(p, static_cast<Index>(random() % 50));
      ASSERT_EQ(insertion.status, expected);
      ++seen[expected];
      if (expected == InsertionStatus::on_vertex) {
        EXPECT_EQ(mesh.point(insertion.vertex), p);
      }
      EXPECT_EQ(insertion.vertex == k_no_index,
                expected == InsertionStatus::outside || expected == InsertionStatus::on_constrained_edge);
      const std::set<Index> changed(mesh.changed().begin(), mesh.changed().end());
      EXPECT_EQ(changed.size(), mesh.changed().size());
      ASSERT_EQ(changed.empty(), expected != InsertionStatus::inserted);
      for (Index t = 0; t < mesh.triangles().size(); ++t) {
        const bool differs = t >= before.size() || !are_same(before[t], mesh.triangles()[t]);
        EXPECT_EQ(changed.count(t) > 0, differs) << "triangle " << t;
        if (differs) {
          EXPECT_EQ(mesh.triangles()[t].vertex(0), insertion.vertex);
        }
      }
    }
    if (mesh.triangles().empty()) continue;
    test::expect_valid(mesh, edges);
    test::expect_empty_circles(mesh, edges);
    ASSERT_FALSE(testing::Test::HasFailure());
  }
  EXPECT_EQ(seen.size(), 4u);
  for (const auto& [status, count] : seen) EXPECT_GT(count, 100) << static_cast<int>(status);
}

TEST(ConstrainedDelaunayRandom, InsertionsEndAsTheWholeBuiltAtOnce) {
  std::mt19937 random(6);
  for (int round = 0; round < 20; ++round) {
    // A square with a notch as the border, then points inside it: coordinates so many that no four points
    // lie on a circle, which would leave a choice.
    constexpr int k_size = 1 << 24;
    const std::vector<Vec2> border = {
        {0, 0}, {k_size, 1}, {k_size - 3, k_size}, {k_size / 2, k_size / 7}, {1, k_size - 5}};
    const Edges edges = {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 0}};
    ConstrainedDelaunay mesh(border, edges);
    mesh.keep_inside();
    std::vector<Vec2> all = border;
    for (const Vec2& p : test::random_points(800, k_size, random)) {
      const Insertion insertion = mesh.insert(p, mesh.changed().empty() ? 0 : mesh.changed()[0]);
      if (insertion.status == InsertionStatus::inserted) all.push_back(p);
    }
    ConstrainedDelaunay at_once(all, edges);
    at_once.keep_inside();
    EXPECT_GT(all.size(), 300u);
    EXPECT_EQ(test::vertex_sets(mesh), test::vertex_sets(at_once)) << round;
    EXPECT_EQ(test::vertex_sets(mesh, true), test::vertex_sets(at_once, true)) << round;
    test::expect_valid(mesh, edges);
  }
}

TEST(ConstrainedDelaunayRandom, AWalkEndsWhereALookAtEveryTriangleDoes) {
  std::mt19937 random(7);
  for (int round = 0; round < 100; ++round) {
    const auto points = test::random_points(60, round % 2 == 0 ? 20 : 1 << 20, random);
    const ConstrainedDelaunay mesh(points, test::random_edges(60, points, random));
    for (const Vec2& p : test::random_points(50, round % 2 == 0 ? 22 : 1 << 20, random)) {
      const auto everywhere = detail::look_everywhere(p, mesh.points(), mesh.triangles());
      const TriangleLocation walked = mesh.locate(p, static_cast<Index>(random() % 80));
      ASSERT_EQ(walked.on, everywhere.on);
      if (walked.on == On::face) {
        EXPECT_EQ(walked.triangle, everywhere.triangle);
      }
      if (walked.on == On::vertex) {
        EXPECT_EQ(mesh.point(mesh.triangles()[walked.triangle].vertex(walked.corner)), p);
      }
      if (walked.on == On::side) {
        const DelaunayTriangle& triangle = mesh.triangles()[walked.triangle];
        EXPECT_TRUE(test::is_on_segment(mesh.point(triangle.from(walked.corner)),
                                        mesh.point(triangle.to(walked.corner)), p));
      }
    }
    EXPECT_FALSE(detail::walk_to(points[0], 0, 0, mesh.points(), mesh.triangles())) << "without a step";
  }
}

}  // namespace
}  // namespace recede
