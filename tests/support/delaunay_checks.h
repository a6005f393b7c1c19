// What holds for every constrained Delaunay triangulation, checked by brute force on whole coordinates.
#pragma once

#include "plane_integers.h"
#include <recede/geometry/constrained_delaunay.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace recede::test {

using Edges = std::vector<std::array<Index, 2>>;

inline std::array<Vec2, 3> corners(const ConstrainedDelaunay& mesh, Index triangle) {
  const DelaunayTriangle& t = mesh.triangles()[triangle];
  return {mesh.point(t.vertex(0)), mesh.point(t.vertex(1)), mesh.point(t.vertex(2))};
}

/// Sides name each other, run against each other and agree on the edges upon them.
inline void expect_linked(const ConstrainedDelaunay& mesh) {
  for (Index t = 0; t < mesh.triangles().size(); ++t) {
    const DelaunayTriangle& triangle = mesh.triangles()[t];
    for (int k = 0; k < 3; ++k) {
      const Index across = triangle.side_across(k);
      if (across == k_no_index) continue;
      ASSERT_LT(across / 4, mesh.triangles().size());
      ASSERT_LT(across % 4, 3u);
      const DelaunayTriangle& other = mesh.triangles()[across / 4];
      const int back = static_cast<int>(across % 4);
      ASSERT_EQ(other.side_across(back), 4 * t + static_cast<Index>(k));
      ASSERT_EQ(other.from(back), triangle.to(k));
      ASSERT_EQ(other.to(back), triangle.from(k));
      ASSERT_EQ(other.is_constrained(back), triangle.is_constrained(k));
      ASSERT_EQ(other.turns[across % 4], -triangle.turns[static_cast<std::size_t>(k)]);
    }
  }
}

/// Triangles turn to the left, and no unconstrained side has the opposite vertex across in its circle, which
/// makes the whole one constrained Delaunay (Lee and Lin 1986).
inline void expect_locally_delaunay(const ConstrainedDelaunay& mesh) {
  for (Index t = 0; t < mesh.triangles().size(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    ASSERT_GT(twice_area(a, b, c), 0) << "triangle " << t;
    for (int k = 0; k < 3; ++k) {
      const Index across = mesh.triangles()[t].side_across(k);
      if (across == k_no_index || mesh.triangles()[t].is_constrained(k)) continue;
      const Index apex = mesh.triangles()[across / 4].vertices[across % 4];
      ASSERT_LE(whole_side_of_circle(a, b, c, mesh.point(apex)), 0) << "triangle " << t << " side " << k;
    }
  }
}

/// By the definition: a vertex in a circle is hidden behind an edge from the triangle's middle.
inline void expect_empty_circles(const ConstrainedDelaunay& mesh, const Edges& edges) {
  for (Index t = 0; t < mesh.triangles().size(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const Vec2 middle = a + b + c;  // three times it: everything is three times as large
    for (Index v = 0; v < mesh.n_vertices(); ++v) {
      const Vec2& p = mesh.point(v);
      if (whole_side_of_circle(a, b, c, p) <= 0) continue;
      const bool is_hidden = std::any_of(edges.begin(), edges.end(), [&](const auto& edge) {
        const Vec2 from = 3 * mesh.point(edge[0]), to = 3 * mesh.point(edge[1]);
        return whole_orientation(from, to, middle) * whole_orientation(from, to, 3 * p) < 0 &&
               whole_orientation(middle, 3 * p, from) * whole_orientation(middle, 3 * p, to) <= 0;
      });
      EXPECT_TRUE(is_hidden) << "vertex " << v << " in the circle of triangle " << t;
    }
  }
}

/// The pieces between vertices of which edges are made.
inline std::set<std::pair<Index, Index>> pieces_of(const ConstrainedDelaunay& mesh, const Edges& edges) {
  std::set<std::pair<Index, Index>> pieces;
  for (const auto& [a, b] : edges) {
    std::vector<std::pair<double, Index>> on_edge;
    for (Index v = 0; v < mesh.n_vertices(); ++v) {
      const Vec2 &from = mesh.point(a), &to = mesh.point(b), &p = mesh.point(v);
      if (mesh.first_equal(v) == v && is_on_segment(from, to, p)) {
        on_edge.emplace_back((p - from).squaredNorm(), v);
      }
    }
    std::sort(on_edge.begin(), on_edge.end());
    for (std::size_t i = 1; i < on_edge.size(); ++i) {
      pieces.insert(std::minmax(on_edge[i - 1].second, on_edge[i].second));
    }
  }
  return pieces;
}

/// The constrained sides are the pieces of edges, no more and no less.
inline void expect_edges(const ConstrainedDelaunay& mesh, const Edges& edges) {
  std::set<std::pair<Index, Index>> sides;
  for (const DelaunayTriangle& triangle : mesh.triangles()) {
    for (int k = 0; k < 3; ++k) {
      if (triangle.is_constrained(k)) sides.insert(std::minmax(triangle.from(k), triangle.to(k)));
    }
  }
  EXPECT_EQ(sides, pieces_of(mesh, edges));
}

/// Twice the area of the convex hull (A. M. Andrew's monotone chain 1979).
inline std::int64_t twice_hull_area(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](const Vec2& a, const Vec2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::int64_t area = 0;
  for (int half = 0; half < 2; ++half) {
    std::vector<Vec2> chain;
    for (const Vec2& p : points) {
      while (chain.size() > 1 && twice_area(chain[chain.size() - 2], chain.back(), p) <= 0) chain.pop_back();
      chain.push_back(p);
    }
    for (std::size_t i = 1; i < chain.size(); ++i) area += twice_area(points[0], chain[i - 1], chain[i]);
    std::reverse(points.begin(), points.end());
    if (half == 0) area += twice_area(points[0], points.back(), points[0]);  // both halves share that side
  }
  return area;
}

/// The triangles fill the convex hull once, and Euler counts them.
inline void expect_fills_hull(const ConstrainedDelaunay& mesh) {
  std::int64_t area = 0;
  std::size_t n_border = 0;
  std::set<Index> used;
  for (Index t = 0; t < mesh.triangles().size(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    area += twice_area(a, b, c);
    for (int k = 0; k < 3; ++k) {
      used.insert(mesh.triangles()[t].vertex(k));
      if (mesh.triangles()[t].neighbour(k) == k_no_index) ++n_border;
    }
  }
  EXPECT_EQ(area, twice_hull_area({mesh.points().begin(), mesh.points().end()}));
  if (mesh.triangles().empty()) return;
  EXPECT_EQ(mesh.triangles().size(), 2 * (used.size() - 1) - n_border);
  for (Index v = 0; v < mesh.n_vertices(); ++v) EXPECT_EQ(used.count(v) > 0, mesh.first_equal(v) == v) << v;
}

inline void expect_valid(const ConstrainedDelaunay& mesh, const Edges& edges = {}) {
  expect_linked(mesh);
  expect_locally_delaunay(mesh);
  expect_fills_hull(mesh);
  expect_edges(mesh, edges);
}

/// The triangles by their vertices, each from the lowest on.
inline std::set<std::array<Index, 3>> vertex_sets(const ConstrainedDelaunay& mesh, bool only_inside = false) {
  std::set<std::array<Index, 3>> sets;
  for (const DelaunayTriangle& triangle : mesh.triangles()) {
    if (only_inside && !triangle.is_inside) continue;
    std::array<Index, 3> v = triangle.vertices;
    std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
    sets.insert(v);
  }
  return sets;
}

inline std::vector<Vec2> random_points(std::size_t n, int range, std::mt19937& random) {
  std::vector<Vec2> points(n);
  for (Vec2& p : points) {
    const auto coordinate = [&] { return static_cast<double>(random() % static_cast<unsigned>(range)); };
    p.x() = coordinate();
    p.y() = coordinate();
  }
  return points;
}

/// Whether edges cross where there is no vertex.
inline bool cross_nowhere_at_a_vertex(const std::vector<Vec2>& points, const std::array<Index, 2>& e,
                                      const std::array<Index, 2>& f) {
  const Vec2 &a = points[e[0]], &b = points[e[1]], &c = points[f[0]], &d = points[f[1]];
  return cross(a, b, c, d) && std::none_of(points.begin(), points.end(), [&](const Vec2& p) {
           return is_on_segment(a, b, p) && is_on_segment(c, d, p);
         });
}

/// Edges between random points, as far as they don't cross those before.
inline Edges random_edges(std::size_t tries, const std::vector<Vec2>& points, std::mt19937& random) {
  Edges edges;
  for (std::size_t i = 0; i < tries; ++i) {
    const std::array<Index, 2> edge{static_cast<Index>(random() % points.size()),
                                    static_cast<Index>(random() % points.size())};
    if (points[edge[0]] == points[edge[1]]) continue;
    const bool is_free = std::none_of(edges.begin(), edges.end(), [&](const auto& other) {
      return cross_nowhere_at_a_vertex(points, edge, other);
    });
    if (is_free) edges.push_back(edge);
  }
  return edges;
}

}  // namespace recede::test
