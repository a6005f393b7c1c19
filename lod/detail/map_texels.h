// Texels of baked maps: which triangle of the coarse surface each belongs to, how they are looked up, and how
// those without a triangle are filled.
#pragma once

#include <recede/lod/detail/map_surface.h>

#include <tbb/parallel_for.h>

#include <array>
#include <vector>

namespace recede::detail {

/// A place of the map in texels, whose middles have whole coordinates; y grows downwards.
Vec2 texel_coordinates(const Vec2& uv, int size);
/// The middle of a texel, its number row by row.
Vec2 uv_of_texel(std::size_t texel, int size);

/// The four texels that bilinear lookup reads, and what each counts. At the border of the map some are the
/// same.
struct Footprint {
  std::array<Index, 4> texels;
  std::array<double, 4> weights;
};
Footprint footprint_of(const Vec2& uv, int size);

/// For each texel whether its middle lies in a triangle, and the nearest triangle (that of lowest number
/// among equals) when it is near enough to be read by bilinear lookup at one of its points; else none.
struct TexelOwners {
  std::vector<Index> triangles;  ///< size x size
  std::vector<char> inside;      ///< size x size
};
TexelOwners own_texels(const MapTriangles& triangles, int size);

/// Gives every texel without a value the mean of those that have one in the smallest square of a pyramid that
/// holds any. Means over squares of the pyramid don't change.
template <typename Value>
void fill_holes(std::vector<Value>& values, std::vector<char> known, int width, int height) {
  if (width * height == 1) return;
  const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
  const auto at = [](int x, int y, int row) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(row) + static_cast<std::size_t>(x);
  };
  const Value zero = 0 * values.front();
  std::vector<Value> means(at(0, half_height, half_width), zero);
  std::vector<char> known_means(means.size(), 0);
  bool complete = true;
  for (int y = 0; y < half_height; ++y) {
    for (int x = 0; x < half_width; ++x) {
      int count = 0;
      Value sum = zero;
      for (int below = 2 * y; below < std::min(2 * y + 2, height); ++below) {
        for (int right = 2 * x; right < std::min(2 * x + 2, width); ++right) {
          complete = complete && known[at(right, below, width)] != 0;
          if (known[at(right, below, width)] == 0) continue;
          sum += values[at(right, below, width)];
          ++count;
        }
      }
      if (count == 0) continue;
      means[at(x, y, half_width)] = sum / static_cast<float>(count);
      known_means[at(x, y, half_width)] = 1;
    }
  }
  if (complete) return;
  fill_holes(means, std::move(known_means), half_width, half_height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (known[at(x, y, width)] == 0) values[at(x, y, width)] = means[at(x / 2, y / 2, half_width)];
    }
  }
}

}  // namespace recede::detail
