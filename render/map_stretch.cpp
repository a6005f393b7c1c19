#include <recede/geometry/error.h>
#include <recede/render/map_stretch.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

namespace recede {

MapStretch measure_stretch(const PolygonSoup& surface) {
  validate(surface, "displaced surface");
  if (surface.corner_uvs.empty()) throw InputError("a surface without texture coordinates has no stretch");
  std::vector<Index> corners;
  triangulate(surface, nullptr, &corners);
  Vec2 sums = Vec2::Zero(), squares = Vec2::Zero();
  double area = 0;
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const auto side = [&](std::size_t k) {
      return std::pair<Vec3, Vec2>(surface.positions[surface.corner_vertices[corners[t + k]]] -
                                       surface.positions[surface.corner_vertices[corners[t]]],
                                   surface.corner_uvs[corners[t + k]] - surface.corner_uvs[corners[t]]);
    };
    const auto [first, uv_first] = side(1);
    const auto [second, uv_second] = side(2);
    const double turn = uv_first.x() * uv_second.y() - uv_first.y() * uv_second.x();
    const Vec2 lengths((uv_second.y() * first - uv_first.y() * second).norm() / std::abs(turn),
                       (uv_first.x() * second - uv_second.x() * first).norm() / std::abs(turn));
    const double weight = first.cross(second).norm() / 2;
    if (!(weight > 0) || !lengths.allFinite()) continue;
    area += weight;
    sums += weight * lengths;
    squares += weight * lengths.cwiseAbs2();
  }
  if (!(area > 0) || !(sums.minCoeff() > 0))
    throw InputError("all texture coordinates of a surface lie on a line");
  MapStretch stretch;
  stretch.sides = sums / area;
  const Vec2 variance = squares / area - stretch.sides.cwiseAbs2();
  stretch.spread = variance.cwiseMax(0.0).cwiseSqrt().cwiseQuotient(stretch.sides);
  return stretch;
}

double mean_wavelength(const DisplacementMap& map, const Vec2& sides, const std::vector<bool>& counted) {
  const Vec2 steps = sides.cwiseQuotient(Vec2(map.columns(), map.rows()));
  const auto counts = [&](int x, int y) {
    return counted.empty() || counted[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.columns()) +
                                      static_cast<std::size_t>(x)];
  };
  double count = 0, sum = 0, squares = 0, slopes = 0;
  const double first = map.texel(0, 0);
  for (int y = 0; y < map.rows(); ++y) {
    for (int x = 0; x < map.columns(); ++x) {
      const int right = map.column(x + 1), below = map.row(y + 1);
      if (!counts(x, y) || !counts(right, y) || !counts(x, below)) continue;
      const double height = map.texel(x, y) - first;  // small numbers keep their digits
      count += 1;
      sum += height;
      squares += height * height;
      slopes += Vec2(map.texel(right, y) - first - height, map.texel(x, below) - first - height)
                    .cwiseQuotient(steps)
                    .squaredNorm();
    }
  }
  if (!(slopes > 0)) return 0;
  return 2 * std::numbers::pi * std::sqrt(std::max(squares - sum * sum / count, 0.0) / slopes);
}

std::vector<bool> covered_texels(const PolygonSoup& surface, int columns, int rows) {
  std::vector<bool> covered(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  std::vector<Index> corners;
  triangulate(surface, nullptr, &corners);
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    std::array<Vec2, 3> places;  // in texels, whose middles are whole
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2& uv = surface.corner_uvs[corners[t + k]];
      places[k] = Vec2(uv.x() * columns - 0.5, (1 - uv.y()) * rows - 0.5);
    }
    const double area = cross(places[1] - places[0], places[2] - places[0]);
    if (area == 0) continue;
    const Vec2 least = places[0].cwiseMin(places[1]).cwiseMin(places[2]);
    const Vec2 most = places[0].cwiseMax(places[1]).cwiseMax(places[2]);
    const auto inside = [](double coordinate, int count) {
      return static_cast<int>(std::clamp(coordinate, 0.0, count - 1.0));
    };
    for (int y = inside(std::ceil(least.y()), rows); y <= inside(most.y(), rows); ++y) {
      for (int x = inside(std::ceil(least.x()), columns); x <= inside(most.x(), columns); ++x) {
        const Vec2 at(x, y);
        const double first = cross(places[1] - at, places[2] - at) / area;
        const double second = cross(places[2] - at, places[0] - at) / area;
        if (first >= 0 && second >= 0 && first + second <= 1) {
          covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(x)] = true;
        }
      }
    }
  }
  return covered;
}

}  // namespace recede
