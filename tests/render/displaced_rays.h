// A square to displace, and rays around the unit sphere.
#pragma once

#include "ray_leaks.h"
#include <recede/geometry/displacement_map.h>
#include <recede/geometry/polygon_soup.h>

#include <array>
#include <random>
#include <vector>

namespace recede::test {

/// The square 0..1 x 0..1 at z = 0, with texture coordinates x, y.
inline PolygonSoup unit_square() {
  PolygonSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.add_face(std::array<Index, 4>{0, 1, 2, 3});
  soup.corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  return soup;
}

inline DisplacementMap flat_map(float height) { return DisplacementMap(2, 2, std::vector<float>(4, height)); }

struct Ray {
  Vec3 origin, direction;
};

/// From around the unit sphere at `center` to a point in it.
inline Ray random_ray(std::mt19937& random, const Vec3& center) {
  const Vec3 from = center + 1.6 * random_direction(random);
  const Vec3 to = center + 1.2 * random_direction(random);
  return {from, to - from};
}

}  // namespace recede::test
