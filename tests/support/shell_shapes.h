// Surfaces that layers are known over.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>

namespace recede::test {

/// Of 2 n m triangles over the unit square.
inline PolygonSoup sheet(int n, int m, const std::function<Vec3(double, double)>& place) {
  PolygonSoup soup;
  for (int j = 0; j <= m; ++j) {
    for (int i = 0; i <= n; ++i)
      soup.positions.push_back(place(static_cast<double>(i) / n, static_cast<double>(j) / m));
  }
  const auto at = [&](int i, int j) { return static_cast<Index>(j * (n + 1) + i); };
  for (int j = 0; j < m; ++j) {
    for (int i = 0; i < n; ++i) {
      soup.add_face(std::array<Index, 3>{at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      soup.add_face(std::array<Index, 3>{at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return soup;
}

/// From -1 to 1, of 12 n^2 triangles; n is a power of two, so that sides meet bit by bit.
inline PolygonSoup cube(int n) {
  PolygonSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const PolygonSoup part = sheet(n, n, [&](double u, double v) {
        Vec3 at;
        at[axis] = side;
        at[(axis + 1) % 3] = side * (2 * u - 1);
        at[(axis + 2) % 3] = 2 * v - 1;
        return at;
      });
      const auto first = static_cast<Index>(soup.positions.size());
      soup.positions.insert(soup.positions.end(), part.positions.begin(), part.positions.end());
      for (std::size_t f = 0; f < part.n_faces(); ++f) {
        const std::span<const Index> corners = part.face(f);
        soup.add_face(std::array<Index, 3>{first + corners[0], first + corners[1], first + corners[2]});
      }
    }
  }
  merge_identical_vertices(soup);
  return soup;
}

inline PolygonSoup ball(int n) {
  PolygonSoup soup = cube(n);
  for (Vec3& position : soup.positions) position.normalize();
  return soup;
}

inline PolygonSoup torus(double large, double small, int n) {
  PolygonSoup soup = sheet(n, n, [&](double u, double v) {
    const double a = 2 * std::numbers::pi * std::fmod(u, 1.0), b = 2 * std::numbers::pi * std::fmod(v, 1.0);
    const double out = large + small * std::cos(b);
    return Vec3(out * std::cos(a), out * std::sin(a), small * std::sin(b));
  });
  merge_identical_vertices(soup);
  return soup;
}

inline PolygonSoup saddle() {
  return sheet(24, 24, [](double u, double v) {
    const double x = 2 * u - 1, y = 2 * v - 1;
    return Vec3(x, y, 0.9 * (x * x - y * y));
  });
}

/// Waves of period 1 over a square from -2 to 2.
inline PolygonSoup corrugated(double amplitude, int n) {
  return sheet(n, n, [&](double u, double v) {
    return Vec3(4 * u - 2, 4 * v - 2, amplitude * std::sin(2 * std::numbers::pi * (4 * u - 2)));
  });
}

}  // namespace recede::test
