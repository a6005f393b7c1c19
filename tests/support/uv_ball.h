// A ball for tests of billboards.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cmath>
#include <numbers>

namespace recede::test {

/// Triangles of a ball of diameter 1, by rings.
inline PolygonSoup uv_ball(Index n_rings) {
  PolygonSoup soup;
  const Index n = 2 * n_rings;
  for (Index i = 0; i <= n_rings; ++i) {
    for (Index j = 0; j < n; ++j) {
      const double down = std::numbers::pi * i / n_rings, around = 2 * std::numbers::pi * j / n;
      soup.positions.emplace_back(std::sin(down) * std::cos(around) / 2,
                                  std::sin(down) * std::sin(around) / 2, std::cos(down) / 2);
    }
  }
  for (Index i = 0; i < n_rings; ++i) {
    for (Index j = 0; j < n; ++j) {
      const Index a = i * n + j, b = i * n + (j + 1) % n, c = a + n, d = b + n;
      if (i > 0) soup.add_face(std::array<Index, 3>{a, c, b});
      if (i + 1 < n_rings) soup.add_face(std::array<Index, 3>{b, c, d});
    }
  }
  return soup;
}

}  // namespace recede::test
