// Control meshes for subdivision.
#pragma once

#include "simple_soups.h"

#include <random>

namespace recede::test {

/// The cube between (-1,-1,-1) and (1,1,1); vertex x + 2 y + 4 z, quads in the order -x x -y y -z z.
inline PolygonSoup control_cube() {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k % 2 * 2 - 1, k / 2 % 2 * 2 - 1, k / 4 * 2 - 1);
  return soup_of(corners,
                 {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
}

/// With texture coordinates: every face a chart of its own, three in a row.
inline PolygonSoup charted_cube() {
  PolygonSoup cube = control_cube();
  for (int face = 0; face < 6; ++face) {
    const Vec2 low((face % 3 + 0.1) / 3, (face / 3 + 0.1) / 2);
    for (const Vec2& at : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)})
      cube.corner_uvs.push_back(low + Vec2(at.x() * 0.8 / 3, at.y() * 0.8 / 2));
  }
  return cube;
}

inline PolygonSoup control_icosahedron() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  return soup_of({{-1, g, 0},
                  {1, g, 0},
                  {-1, -g, 0},
                  {1, -g, 0},
                  {0, -1, g},
                  {0, 1, g},
                  {0, -1, -g},
                  {0, 1, -g},
                  {g, 0, -1},
                  {g, 0, 1},
                  {-g, 0, -1},
                  {-g, 0, 1}},
                 {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                  {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                  {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}});
}

/// Every position moved by at most so much along each axis.
inline PolygonSoup shaken(PolygonSoup soup, double by, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> step(-by, by);
  for (Vec3& position : soup.positions) position += Vec3(step(random), step(random), step(random));
  return soup;
}

}  // namespace recede::test
