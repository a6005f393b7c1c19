// Bases and maps for tests of displaced surfaces.
#pragma once

#include "simple_soups.h"
#include <recede/geometry/displacement_map.h>

#include <cmath>
#include <random>
#include <vector>

namespace recede::test {

/// `octahedral_sphere` with normals. Each octant has its own part of the map where `one_chart`; else each
/// triangle has one of its own, so that every edge is a seam.
inline PolygonSoup sphere_base(int rounds, bool one_chart = true) {
  PolygonSoup soup = octahedral_sphere(rounds);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> number(0, 1);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const Vec2 shift = one_chart ? Vec2(0, 0) : Vec2(0.7 * number(random), 0.7 * number(random));
    for (const Index v : soup.face(f)) {
      const Vec3& p = soup.positions[v];
      soup.corner_normals.push_back(p);
      const double sum = p.cwiseAbs().sum();
      soup.corner_uvs.emplace_back(
          Vec2(0.5 + 0.5 * p.x() / sum, 0.5 + 0.5 * p.y() / sum) * (one_chart ? 1 : 0.3) + shift);
    }
  }
  return soup;
}

/// The square from -1 to 1 in the plane z = 0, upwards, as n x n pairs of triangles.
inline PolygonSoup plane_base(Index n) {
  PolygonSoup soup = grid(n, true);
  for (const Index v : soup.corner_vertices) {
    soup.corner_uvs.emplace_back(soup.positions[v].x(), soup.positions[v].y());
    soup.corner_normals.emplace_back(Vec3::UnitZ());
  }
  for (Vec3& p : soup.positions) p = 2 * p - Vec3(1, 1, 0);
  return soup;
}

/// Independent heights from `least` to `most`: as rough as a map can be.
inline DisplacementMap noise_map(int columns, int rows, double least, double most, unsigned seed = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> height(least, most);
  std::vector<float> heights;
  for (int i = 0; i < columns * rows; ++i) heights.push_back(static_cast<float>(height(random)));
  return {columns, rows, std::move(heights)};
}

/// Midpoint displacement: mountains of about `height`, 2^steps + 1 texels a side.
inline DisplacementMap mountain_map(int steps, double height, unsigned seed = 7) {
  const int last = 1 << steps, size = last + 1;
  std::mt19937 random(seed);
  std::normal_distribution<double> change;
  std::vector<double> h(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 0.0);
  const auto at = [&](int x, int y) -> double& {
    return h[static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x)];
  };
  double amplitude = 0.4 * height;
  for (int step = last; step > 1; step /= 2, amplitude *= 0.55) {
    const int half = step / 2;
    for (int y = 0; y < last; y += step) {
      for (int x = 0; x < last; x += step) {
        at(x + half, y + half) = (at(x, y) + at(x + step, y) + at(x, y + step) + at(x + step, y + step)) / 4 +
                                 amplitude * change(random);
      }
    }
    for (int y = 0; y <= last; y += half) {
      for (int x = (y / half) % 2 == 0 ? half : 0; x <= last; x += step) {
        double sum = 0, n = 0;
        for (const auto& [dx, dy] : {std::pair(half, 0), {-half, 0}, {0, half}, {0, -half}}) {
          if (x + dx < 0 || x + dx > last || y + dy < 0 || y + dy > last) continue;
          sum += at(x + dx, y + dy);
          ++n;
        }
        at(x, y) = sum / n + 0.7 * amplitude * change(random);
      }
    }
  }
  return {size, size, std::vector<float>(h.begin(), h.end())};
}

}  // namespace recede::test
