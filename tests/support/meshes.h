// Meshes for tests, and what must hold for every result of simplification.
#pragma once

#include "simple_soups.h"
#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/sample_models.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace recede::test {

inline PolygonMesh mesh_of(const PolygonSoup& soup) { return repair_to_polygon_mesh(soup).mesh; }

/// How often each undirected edge of a soup occurs.
inline std::map<std::pair<Index, Index>, int> edge_counts(const PolygonSoup& soup) {
  std::map<std::pair<Index, Index>, int> counts;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto face = soup.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      ++counts[std::minmax(face[i], face[(i + 1) % face.size()])];
    }
  }
  return counts;
}

/// No polygon visits a vertex twice, has fewer than three corners, has no area, isn't finite, or occurs
/// twice; and no edge has more faces than `most_faces_on_edge`.
inline void expect_sound(const PolygonMesh& mesh, int most_faces_on_edge = 2) {
  PolygonSoup soup = to_soup(mesh);
  merge_identical_vertices(soup);
  std::set<std::vector<Index>> seen;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    std::vector<Index> vertices(soup.face(f).begin(), soup.face(f).end());
    ASSERT_GE(vertices.size(), 3u);
    std::sort(vertices.begin(), vertices.end());
    EXPECT_EQ(std::adjacent_find(vertices.begin(), vertices.end()), vertices.end()) << "face " << f;
    EXPECT_TRUE(seen.insert(vertices).second) << "face " << f << " occurs twice";
    EXPECT_GT(vector_area(soup, f).norm(), 0) << "face " << f;
  }
  for (const Vec3& p : soup.positions) EXPECT_TRUE(p.allFinite());
  for (const auto& [edge, count] : edge_counts(soup)) {
    EXPECT_LE(count, most_faces_on_edge) << edge.first << "-" << edge.second;
  }
}

}  // namespace recede::test
