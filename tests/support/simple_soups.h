// Small shapes for tests and benchmarks.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace recede::test {

inline PolygonSoup soup_of(std::vector<Vec3> positions, const std::vector<std::vector<Index>>& faces) {
  PolygonSoup soup;
  soup.positions = std::move(positions);
  for (const auto& face : faces) soup.add_face(face);
  return soup;
}

/// n x n quads over the unit square in the plane z = 0, or twice as many triangles.
inline PolygonSoup grid(Index n, bool triangles = false) {
  PolygonSoup soup;
  for (Index i = 0; i <= n; ++i) {
    for (Index j = 0; j <= n; ++j) soup.positions.emplace_back(double(i) / n, double(j) / n, 0);
  }
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j) {
      const Index a = i * (n + 1) + j, b = a + n + 1;
      if (triangles) {
        soup.add_face(std::vector<Index>{a, b, b + 1});
        soup.add_face(std::vector<Index>{a, b + 1, a + 1});
      } else {
        soup.add_face(std::vector<Index>{a, b, b + 1, a + 1});
      }
    }
  }
  return soup;
}

/// The unit sphere: an octahedron whose triangles were cut in four `rounds` times, 8 * 4^rounds of them that
/// face outward.
inline PolygonSoup octahedral_sphere(int rounds) {
  PolygonSoup soup =
      soup_of({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
              {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
  for (int round = 0; round < rounds; ++round) {
    PolygonSoup finer;
    finer.positions = soup.positions;
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<Index>(finer.positions.size()));
      if (is_new) finer.positions.push_back((soup.positions[a] + soup.positions[b]).normalized());
      return entry->second;
    };
    for (std::size_t f = 0; f < soup.n_faces(); ++f) {
      const Index a = soup.face(f)[0], b = soup.face(f)[1], c = soup.face(f)[2];
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const std::vector<Index>& face :
           {std::vector<Index>{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
        finer.add_face(face);
    }
    soup = std::move(finer);
  }
  return soup;
}

/// A sheet of hexagons over part of the plane, bent into a bowl: every interior vertex has three faces.
inline PolygonSoup hexagon_sheet(int n) {
  PolygonSoup soup;
  std::map<std::pair<int, int>, Index> known;
  const auto vertex = [&](int x, int y) {  // in units of half a side and half a height
    const auto [place, is_new] = known.try_emplace({x, y}, static_cast<Index>(soup.positions.size()));
    if (is_new) {
      const double u = 0.5 * x, v = 0.8660254037844386 * y;
      soup.positions.emplace_back(u, v, 0.01 * (u * u + v * v));
    }
    return place->second;
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int x = 3 * i, y = 2 * j + i % 2;
      soup.add_face(std::vector<Index>{vertex(x + 2, y), vertex(x + 1, y + 1), vertex(x - 1, y + 1),
                                       vertex(x - 2, y), vertex(x - 1, y - 1), vertex(x + 1, y - 1)});
    }
  }
  return soup;
}

/// A prism over a regular polygon of `n` sides: two n-gons and n quads.
inline PolygonSoup prism(Index n) {
  PolygonSoup soup;
  for (int z = 0; z < 2; ++z) {
    for (Index i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      soup.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    }
  }
  std::vector<Index> bottom, top;
  for (Index i = 0; i < n; ++i) {
    bottom.push_back(n - 1 - i);
    top.push_back(n + i);
    soup.add_face(std::vector<Index>{i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  soup.add_face(bottom);
  soup.add_face(top);
  return soup;
}

/// A tube of three sides, open at its foot and closed by a triangle at its tip: rings `height` apart. A map
/// of it shrinks with every ring.
inline PolygonSoup finger(Index rings, double height) {
  PolygonSoup soup;
  for (Index ring = 0; ring < rings; ++ring) {
    for (int i = 0; i < 3; ++i)
      soup.positions.emplace_back(std::cos(2.1 * i), std::sin(2.1 * i), height * ring);
  }
  soup.add_face(std::vector<Index>{3 * rings - 3, 3 * rings - 2, 3 * rings - 1});
  for (Index ring = 0; ring + 1 < rings; ++ring) {
    for (Index i = 0; i < 3; ++i) {
      const Index a = 3 * ring + i, b = 3 * ring + (i + 1) % 3;
      soup.add_face(std::vector<Index>{a, b, b + 3});
      soup.add_face(std::vector<Index>{a, b + 3, a + 3});
    }
  }
  return soup;
}

}  // namespace recede::test
