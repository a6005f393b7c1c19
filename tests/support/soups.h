// Soups for tests: hand-sized ones, and random ones with all attributes.
#pragma once

#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/polygon_soup.h>

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace recede::test {

/// Polygons over random vertices, three to seven corners each; indices, attributes and materials from a seed.
struct RandomSoupOptions {
  /// All attribute lists, materials and feature edges; else positions and faces only.
  bool attributes = true;
  bool scalars = false;  ///< and two named scalars
  bool floats = false;   ///< every number fits a 32-bit float
};
inline PolygonSoup random_soup(unsigned seed, const RandomSoupOptions& options = {}) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto real = [&] {
    return options.floats ? static_cast<double>(static_cast<float>(unit(random))) : unit(random);
  };
  const auto index = [&](std::size_t n) { return static_cast<Index>(random() % n); };
  PolygonSoup soup;
  const std::size_t n_vertices = 8 + random() % 20, n_faces = 1 + random() % 20;
  for (std::size_t v = 0; v < n_vertices; ++v)
    soup.positions.emplace_back(real() - 0.5, 1e3 * real(), 1e-7 * real());
  if (options.floats) {
    for (Vec3& position : soup.positions) position = position.unaryExpr(&detail::rounded_to_float);
  }
  for (std::size_t f = 0; f < n_faces; ++f) {
    std::vector<Index> face(3 + random() % 5);
    const Index first = index(n_vertices);
    for (std::size_t i = 0; i < face.size(); ++i) face[i] = static_cast<Index>((first + i) % n_vertices);
    soup.add_face(face);
  }
  if (!options.attributes) return soup;
  for (std::size_t c = 0; c < soup.n_corners(); ++c) {
    soup.corner_uvs.emplace_back(real(), real());
    soup.corner_normals.push_back(Vec3(real() + 0.1, real(), real()).normalized());
  }
  for (std::size_t v = 0; v < n_vertices; ++v)
    soup.vertex_colors.emplace_back(real(), real(), real(), real());
  for (const char* name : {"quality", "temperature"}) {
    if (!options.scalars) break;
    VertexScalar& scalar = soup.vertex_scalars.emplace_back();
    scalar.name = name;
    for (std::size_t v = 0; v < n_vertices; ++v) scalar.values.push_back(real());
  }
  soup.materials = {{"red oak", {0.5, 0.25, 0.125, 1.0}, "oak planks.png"},
                    {"glass", {0.1, 0.2, 0.3, 0.4}, ""}};
  for (std::size_t f = 0; f < n_faces; ++f) soup.face_materials.push_back(f == 0 ? 0 : f == 1 ? 1 : index(2));
  if (n_faces > 3) soup.face_materials.back() = k_no_index;
  for (int e = 0; e < 5; ++e)
    soup.feature_edges.emplace_back(index(n_vertices - 1), static_cast<Index>(n_vertices - 1));
  return soup;
}

/// Two triangles that share an edge: the unit square in the plane z = 0.
inline PolygonSoup two_triangles() {
  PolygonSoup soup;
  soup.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.add_face(std::vector<Index>{0, 1, 2});
  soup.add_face(std::vector<Index>{0, 2, 3});
  return soup;
}

/// Equal in every list, bit by bit but for the sign of zeros.
inline void expect_equal(const PolygonSoup& a, const PolygonSoup& b) {
  EXPECT_EQ(a.positions, b.positions);
  EXPECT_EQ(a.face_offsets, b.face_offsets);
  EXPECT_EQ(a.corner_vertices, b.corner_vertices);
  EXPECT_EQ(a.corner_uvs, b.corner_uvs);
  EXPECT_EQ(a.corner_normals, b.corner_normals);
  EXPECT_EQ(a.vertex_colors, b.vertex_colors);
  EXPECT_TRUE(a.vertex_scalars == b.vertex_scalars);
  EXPECT_EQ(a.face_materials, b.face_materials);
  EXPECT_EQ(a.materials.size(), b.materials.size());
  EXPECT_TRUE(a.materials == b.materials);
  EXPECT_EQ(a.feature_edges, b.feature_edges);
}

}  // namespace recede::test
