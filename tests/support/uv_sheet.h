// Sheets of quads with texture coordinates.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <utility>

namespace recede::test {

/// A square of sides 2 around the origin, z up, cut into n x n quads, with texture coordinates from `least`
/// to `most`.
inline PolygonSoup uv_sheet(int n, double least = 0, double most = 1) {
  PolygonSoup soup;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) soup.positions.emplace_back(2.0 * i / n - 1, 2.0 * j / n - 1, 0);
  const auto along = [&](int i) { return least + (most - least) * i / n; };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const auto at = [&](int di, int dj) { return static_cast<Index>((j + dj) * (n + 1) + i + di); };
      soup.add_face(std::array{at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
      for (const auto& [di, dj] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)})
        soup.corner_uvs.emplace_back(along(i + di), along(j + dj));
    }
  }
  return soup;
}

}  // namespace recede::test
