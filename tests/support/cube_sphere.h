// A closed surface of bilinear patches that any point near its middle sees without folds.
#pragma once

#include <recede/geometry/bilinear_patch.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

namespace recede::test {

struct CubeSphere {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::size_t, 4>> faces;  ///< p00, p10, p01, p11
  struct Edge {
    std::size_t from, to;
    std::vector<std::size_t> faces;
  };
  std::vector<Edge> edges;

  BilinearPatch patch(std::size_t face) const {
    const auto& corner = faces[face];
    return {vertices[corner[0]], vertices[corner[1]], vertices[corner[2]], vertices[corner[3]]};
  }
};

/// The unit sphere around `center` as 6 n^2 patches between the lattice points on a cube's faces; every
/// vertex lies between 1 - relief and 1 from the middle. Faces start at different corners and run both ways
/// round.
inline CubeSphere make_cube_sphere(int n, double relief, const Vec3& center, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> radius(1 - relief, 1);
  CubeSphere sphere;
  std::map<std::array<int, 3>, std::size_t> numbers;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] = numbers.try_emplace(at, sphere.vertices.size());
    if (is_new) {
      Vec3 direction;
      for (std::size_t k = 0; k < 3; ++k) {
        direction[static_cast<Eigen::Index>(k)] = std::tan(0.25 * std::numbers::pi * (2.0 * at[k] / n - 1));
      }
      sphere.vertices.push_back(center + radius(random) * direction.normalized());
    }
    return entry->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const int side : {0, n}) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const auto corner = [&](int di, int dj) {
            std::array<int, 3> at{};
            at[axis] = side;
            at[(axis + 1) % 3] = i + di;
            at[(axis + 2) % 3] = j + dj;
            return vertex(at);
          };
          const int flip_i = static_cast<int>(random() % 2), flip_j = static_cast<int>(random() % 2);
          std::array<std::size_t, 4> face{corner(flip_i, flip_j), corner(1 - flip_i, flip_j),
                                          corner(flip_i, 1 - flip_j), corner(1 - flip_i, 1 - flip_j)};
          if (random() % 2 == 0) std::swap(face[1], face[2]);
          sphere.faces.push_back(face);
        }
      }
    }
  }
  std::map<std::pair<std::size_t, std::size_t>, std::vector<std::size_t>> faces_of;
  for (std::size_t f = 0; f < sphere.faces.size(); ++f) {
    const auto& c = sphere.faces[f];
    for (const auto& [a, b] :
         {std::pair(c[0], c[1]), std::pair(c[0], c[2]), std::pair(c[1], c[3]), std::pair(c[2], c[3])}) {
      faces_of[std::minmax(a, b)].push_back(f);
    }
  }
  for (const auto& [ends, faces] : faces_of) sphere.edges.push_back({ends.first, ends.second, faces});
  return sphere;
}

}  // namespace recede::test
