// Maps of normals that depend on the view, sampled on grids, for shading.
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace recede::detail {

/// Places at which a map is sampled. For each view a square of nodes lies over the disk of equal areas, the
/// normals' (x, y) / sqrt(1 + z), or its middle. In between everything is linear, so that a lookup needs
/// neither angles nor searches, and no jumps.
struct ViewGrids {
  static constexpr int k_views = 24;  ///< evenly by sqrt(1 - cos) of the polar angle: 3.5 to 5 degrees
  static constexpr int k_side = 64;   ///< nodes a side; those outside of the disk stand for its rim

  float scale = 1;             ///< steps of the grid to 1 on the disk
  std::vector<float> nodes{};  ///< two numbers for each: places on the disk

  /// Where the numbers of a node stand.
  static constexpr std::size_t at(int view, int row, int column) {
    return 2 * ((static_cast<std::size_t>(view) * k_side + static_cast<std::size_t>(row)) * k_side +
                static_cast<std::size_t>(column));
  }
  static constexpr float k_middle = (k_side - 1) / 2.0f;
};

/// Grids of `map(normal, view_angle)`, of unit vectors above the horizon in the viewer's frame, for normals
/// up to `reach` from the middle of the disk. Those beyond are taken as next to the border of the grid.
template <class Map>
ViewGrids sample_view_grids(double reach, const Map& map) {
  ViewGrids grids;
  grids.scale = ViewGrids::k_middle / static_cast<float>(reach);
  grids.nodes.resize(ViewGrids::at(ViewGrids::k_views, 0, 0));
  for (int view = 0; view < ViewGrids::k_views; ++view) {
    const double root = static_cast<double>(view) / (ViewGrids::k_views - 1);
    const double angle = std::acos(1 - root * root);
    for (int row = 0; row < ViewGrids::k_side; ++row) {
      for (int column = 0; column < ViewGrids::k_side; ++column) {
        Vec2 place = (Vec2(column, row).array() - ViewGrids::k_middle) / grids.scale;
        place /= std::max(1.0, place.norm());
        const double height = std::max(0.0, 1 - place.squaredNorm());
        const Vec2 level = place * std::sqrt(1 + height);
        const Vec3 mapped = map(Vec3(level.x(), level.y(), height), angle);
        // A millionth further inside: sums of floats don't lead out of the disk.
        const Vec2 to = (1 - 1e-6) / std::sqrt(1 + mapped.z()) * mapped.head<2>();
        float* stored = grids.nodes.data() + ViewGrids::at(view, row, column);
        stored[0] = static_cast<float>(to.x());
        stored[1] = static_cast<float>(to.y());
      }
    }
  }
  return grids;
}

/// The sampled map of a unit normal for a unit direction to the viewer, both in the frame of the surface; so
/// is the result, which has unit length to all digits. Viewers below the horizon are taken as on it.
inline Vec3 look_up(const ViewGrids& grids, const Vec3& normal, const Vec3& toward_viewer) {
  const Vec3& v = toward_viewer;
  const double level = std::sqrt(v.x() * v.x() + v.y() * v.y());
  const double by_level = level > 0 ? 1 / level : 0;
  const double c = level > 0 ? by_level * v.x() : 1, s = by_level * v.y();
  const float low = 1 - std::clamp(static_cast<float>(v.z()), 0.0f, 1.0f);
  const float views = static_cast<float>(ViewGrids::k_views - 1) * std::sqrt(low);
  const int view = std::min(static_cast<int>(views), ViewGrids::k_views - 2);
  const float ahead = views - static_cast<float>(view);

  // Normals below the horizon are those of the same azimuth on it.
  const double x = c * normal.x() + s * normal.y(), y = c * normal.y() - s * normal.x();
  const double length = std::sqrt(normal.z() < 0 ? std::max(1e-300, x * x + y * y) : 1 + normal.z());
  const double to_steps = grids.scale / length;
  const auto step = [&](double coordinate) {
    const float steps = static_cast<float>(coordinate * to_steps) + ViewGrids::k_middle;
    return std::min(std::max(steps, 0.0f), static_cast<float>(ViewGrids::k_side - 1));
  };
  const float across = step(x), down = step(y);
  const int column = std::min(static_cast<int>(across), ViewGrids::k_side - 2);
  const int row = std::min(static_cast<int>(down), ViewGrids::k_side - 2);
  const float right = across - static_cast<float>(column), below = down - static_cast<float>(row);

  // Two nodes side by side are four numbers; there are two rows of two views.
  const float* upper = grids.nodes.data() + ViewGrids::at(view, row, column);
  const float* lower = upper + ViewGrids::at(0, 1, 0);
  const float *next_upper = upper + ViewGrids::at(1, 0, 0), *next_lower = lower + ViewGrids::at(1, 0, 0);
  const float weights[4] = {(1 - ahead) * (1 - below), (1 - ahead) * below, ahead * (1 - below),
                            ahead * below};
  float sums[4];
  for (int k = 0; k < 4; ++k)
    sums[k] = weights[0] * upper[k] + weights[1] * lower[k] + weights[2] * next_upper[k] +
              weights[3] * next_lower[k];
  const double p = sums[0] + right * (sums[2] - sums[0]), q = sums[1] + right * (sums[3] - sums[1]);
  const double height = 1 - (p * p + q * q), scale = std::sqrt(1 + height);
  return {scale * (c * p - s * q), scale * (s * p + c * q), height};
}

}  // namespace recede::detail
