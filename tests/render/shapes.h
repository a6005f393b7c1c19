// Shapes that the tests of render/ look at.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cmath>
#include <numbers>

namespace recede {

// Axis-aligned cube of six quads, outward orientation.
inline PolygonSoup make_cube(const Vec3& center, double side) {
  PolygonSoup soup;
  soup.positions.resize(8);
  for (int i = 0; i < 8; ++i) {
    const Vec3 unit_corner(i & 1, i >> 1 & 1, i >> 2);
    soup.positions[static_cast<std::size_t>(i)] = center + side * (unit_corner - Vec3::Constant(0.5));
  }
  const std::array<std::array<Index, 4>, 6> faces{
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& face : faces) soup.add_face(face);
  return soup;
}

// Sphere of quads between meridians and parallels (triangles at the poles, which lie on the z axis).
// `bump` pushes vertices outwards by up to this share of the radius, in waves.
inline PolygonSoup make_sphere(const Vec3& center, double radius, Index around, Index down, double bump = 0) {
  PolygonSoup soup;
  soup.positions.resize(2 + std::size_t{around} * (down - 1));
  std::size_t next = 0;
  const auto add_point = [&](double theta, double phi) {
    const Vec3 direction(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    const double wave = std::sin(5 * phi) * std::sin(theta) * std::sin(7 * theta);
    soup.positions[next++] = center + radius * (1 + bump * wave) * direction;
  };
  add_point(0, 0);
  for (Index row = 1; row < down; ++row) {
    for (Index column = 0; column < around; ++column) {
      add_point(std::numbers::pi * row / down, 2 * std::numbers::pi * column / around);
    }
  }
  add_point(std::numbers::pi, 0);
  const Index south = static_cast<Index>(soup.positions.size() - 1);
  const auto at = [&](Index row, Index column) { return 1 + (row - 1) * around + column % around; };
  for (Index column = 0; column < around; ++column) {
    soup.add_face(std::array<Index, 3>{0, at(1, column), at(1, column + 1)});
    for (Index row = 1; row + 1 < down; ++row) {
      soup.add_face(std::array<Index, 4>{at(row, column), at(row + 1, column), at(row + 1, column + 1),
                                         at(row, column + 1)});
    }
    soup.add_face(std::array<Index, 3>{at(down - 1, column), south, at(down - 1, column + 1)});
  }
  return soup;
}

}  // namespace recede
