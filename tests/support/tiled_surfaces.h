// Surfaces over which a periodic map repeats.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cmath>
#include <numbers>

namespace recede::test {

/// The square from -1 to 1 in the plane z = 0, with so many copies of a map along each side.
inline PolygonSoup tiled_square(double tiles) {
  PolygonSoup soup;
  soup.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  soup.corner_uvs = {{0, 0}, {tiles, 0}, {tiles, tiles}, {0, tiles}};
  return soup;
}

/// A torus around z: its middle circle has the radius 1, its tube 0.4. Quads, and so many copies of a map
/// around the axis and around the tube.
inline PolygonSoup tiled_torus(int around, int tube, int tiles_around, int tiles_tube) {
  PolygonSoup soup;
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < tube; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / tube;
      const double radius = 1 + 0.4 * std::cos(b);
      soup.positions.emplace_back(radius * std::cos(a), radius * std::sin(a), 0.4 * std::sin(b));
    }
  }
  const auto at = [&](int i, int j) { return static_cast<Index>(i % around * tube + j % tube); };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < tube; ++j) {
      soup.add_face(std::array<Index, 4>{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      for (const auto& [p, q] : std::array<std::array<int, 2>, 4>{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}})
        soup.corner_uvs.emplace_back(1.0 * tiles_around * (i + p) / around,
                                     1.0 * tiles_tube * (j + q) / tube);
    }
  }
  return soup;
}

}  // namespace recede::test
