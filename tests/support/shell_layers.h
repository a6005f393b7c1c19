// Layers of prisms for tests.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/shells/shell_validity.h>

#include <cmath>
#include <map>
#include <random>
#include <utility>
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
  layer.bottom = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  layer.triangles = {0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5};
  for (int cut = 0; cut < cuts; ++cut) {
    std::map<std::pair<Index, Index>, Index> middles;
    const auto middle = [&](Index a, Index b) {
      const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), layer.bottom.size());
      if (is_new) layer.bottom.push_back((layer.bottom[a] + layer.bottom[b]).normalized());
      return entry->second;
    };
    std::vector<Index> finer;
    for (std::size_t t = 0; t < layer.triangles.size(); t += 3) {
      const Index a = layer.triangles[t], b = layer.triangles[t + 1], c = layer.triangles[t + 2];
      const Index ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      for (const Index v : {a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca}) finer.push_back(v);
    }
    layer.triangles = std::move(finer);
  }
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
