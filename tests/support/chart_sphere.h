// A sphere of charts, and rough maps for it.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace recede::test {

/// A sphere of unit radius: 6 n^2 quads in six charts that lie apart in the unit square, each turned by
/// another quarter, so that heights differ along all sides of the cube. `warp` moves texture coordinates
/// within a chart, so that quads aren't parallelograms there.
inline PolygonSoup chart_sphere(int n, const Vec3& center, double warp = 0) {
  PolygonSoup soup;
  for (int chart = 0; chart < 6; ++chart) {
    const int axis = chart / 2;
    const double side = chart % 2 == 0 ? 1 : -1;
    const auto add = [&](int i, int j) {
      const auto tangent = [&](int k) {
        if (k == 0 || k == n) return k == 0 ? -1.0 : 1.0;  // the same on all faces, without rounding
        return std::tan(std::numbers::pi / 4 * (2.0 * k - n) / n);
      };
      Vec3 place;
      place[axis] = side;
      place[(axis + 1) % 3] = side * tangent(i);
      place[(axis + 2) % 3] = tangent(j);
      Vec2 uv(static_cast<double>(i) / n, static_cast<double>(j) / n);
      uv += warp * Vec2(std::sin(9 * uv.y()) * uv.x(), std::sin(7 * uv.x()) * uv.y());
      for (int turn = 0; turn < chart % 4; ++turn) uv = Vec2(1 - uv.y(), uv.x());
      soup.corner_vertices.push_back(static_cast<Index>(soup.positions.size()));
      soup.positions.push_back(center + place / place.norm());
      soup.corner_uvs.emplace_back((chart % 3 + 0.1 + 0.8 * uv.x()) / 3,
                                   (chart / 3 + 0.1 + 0.8 * uv.y()) / 2);
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        add(i, j);
        add(i + 1, j);
        add(i + 1, j + 1);
        add(i, j + 1);
        soup.face_offsets.push_back(static_cast<Index>(soup.corner_vertices.size()));
      }
    }
  }
  return soup;
}

/// Heights without any smoothness, from `low` to `high`.
inline DisplacementMap rough_map(int columns, int rows, double low, double high, MapBorder border,
                                 unsigned seed) {
  std::mt19937 random(seed);
  Raster raster;
  raster.width = columns;
  raster.height = rows;
  raster.bits = 16;
  for (int k = 0; k < columns * rows; ++k)
    raster.samples.push_back(static_cast<std::uint16_t>(random() & 0xffff));
  return DisplacementMap(raster, high - low, low, border);
}

/// The same in floats.
inline DisplacementMap rough_float_map(int columns, int rows, double low, double high, MapBorder border,
                                       unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> height(static_cast<float>(low), static_cast<float>(high));
  std::vector<float> heights(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  for (float& h : heights) h = height(random);
  return DisplacementMap(columns, rows, std::move(heights), border);
}

}  // namespace recede::test
