// Layers of prisms for tests.
#pragma once

#include "simple_soups.h"
#include <recede/shells/shell_validity.h>

#include <cmath>
#include <random>
#include <vector>

namespace recede::test {

struct Layer {
  std::vector<Vec3> bottom, top;
  std::vector<Index> triangles;

  std::size_t n_triangles() const { return triangles.size() / 3; }
};

inline ShellValidity check(const Layer& layer, const ShellCheckOptions& options = {}) {
  return check_shell(layer.bottom, layer.top, layer.triangles, options);
}

/// Both positions of each vertex, moved by a function.
template <typename Move>
Layer moved(Layer layer, Move&& move) {
  for (Vec3& p : layer.bottom) p = move(p);
  for (Vec3& p : layer.top) p = move(p);
  return layer;
}

inline Layer joined(Layer a, const Layer& b) {
  const auto shift = static_cast<Index>(a.bottom.size());
  a.bottom.insert(a.bottom.end(), b.bottom.begin(), b.bottom.end());
  a.top.insert(a.top.end(), b.top.begin(), b.top.end());
  for (const Index v : b.triangles) a.triangles.push_back(v + shift);
  return a;
}

/// A sphere around the origin of 8 * 4^`cuts` triangles that face outward, with a random radius between
/// (1 - relief) and 1 times `radius`; the tops lie at `height` times the bottoms.
inline Layer sphere_layer(int cuts, double radius, double relief, double height, unsigned seed) {
  Layer layer;
  const PolygonSoup sphere = octahedral_sphere(cuts);
  layer.bottom = sphere.positions;
  layer.triangles = sphere.corner_vertices;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> between(1 - relief, 1);
  for (Vec3& p : layer.bottom) {
    p *= radius * between(random);
    layer.top.push_back(height * p);
  }
  return layer;
}

/// A sheet of 2 n m triangles that face up: vertex (i, j) lies at `place(i, j, 0)`, its top at
/// `place(i, j, 1)`.
template <typename Place>
Layer sheet_layer(Index n, Index m, Place&& place) {
  Layer layer;
  for (Index j = 0; j <= m; ++j) {
    for (Index i = 0; i <= n; ++i) {
      layer.bottom.push_back(place(i, j, 0));
      layer.top.push_back(place(i, j, 1));
      if (i == n || j == m) continue;
      const Index a = j * (n + 1) + i, b = a + n + 1;
      for (const Index v : {a, a + 1, b + 1, a, b + 1, b}) layer.triangles.push_back(v);
    }
  }
  return layer;
}

/// All coordinates rounded to whole numbers.
inline Layer whole(const Layer& layer) {
  return moved(layer,
               [](const Vec3& p) { return Vec3(std::round(p.x()), std::round(p.y()), std::round(p.z())); });
}

}  // namespace recede::test
