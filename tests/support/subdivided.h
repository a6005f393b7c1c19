// What tests of subdivision surfaces ask of the result.
#pragma once

#include <recede/geometry/subdivision_surface.h>

#include <gtest/gtest.h>

#include <vector>

namespace recede::test {

// Sums of a few dozen products of numbers of about 1.
inline constexpr double k_rounding = 1e-13;

inline SubdivisionOptions with_level(int level, SubdivisionScheme scheme = SubdivisionScheme::catmull_clark) {
  SubdivisionOptions options;
  options.level = level;
  options.scheme = scheme;
  return options;
}

/// Every normal by its vertex.
inline std::vector<Vec3> vertex_normals(const PolygonSoup& soup) {
  std::vector<Vec3> normals(soup.positions.size(), Vec3(0, 0, 0));
  for (std::size_t c = 0; c < soup.n_corners(); ++c)
    normals[soup.corner_vertices[c]] = soup.corner_normals[c];
  return normals;
}

inline void expect_one_unit_normal_per_point(const PolygonSoup& soup) {
  const std::vector<Vec3> normals = vertex_normals(soup);
  ASSERT_EQ(soup.corner_normals.size(), soup.n_corners());
  for (std::size_t c = 0; c < soup.n_corners(); ++c) {
    ASSERT_NEAR(soup.corner_normals[c].norm(), 1, 1e-15 * 4);
    ASSERT_EQ(soup.corner_normals[c], normals[soup.corner_vertices[c]]);
  }
}

inline std::size_t nearest_point(const std::vector<Vec3>& points, const Vec3& to) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    if ((points[k] - to).squaredNorm() < (points[best] - to).squaredNorm()) best = k;
  }
  return best;
}

}  // namespace recede::test
