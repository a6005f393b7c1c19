#include <recede/lod/detail/map_texels.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

// Bilinear lookup reads texels less than 1 away in both directions, so less than the root of 2; the rest is
// room for rounding.
constexpr double k_reach = 1.5;
constexpr int k_band = 16;  // rows

/// A triangle among texels, whose middles have whole coordinates.
struct TexelTriangle {
  std::array<Vec2, 3> corners;  // clockwise or not

  double squared_distance(const Vec2& p) const {
    double least = std::numeric_limits<double>::infinity();
    int left = 0, right = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 &a = corners[k], &b = corners[(k + 1) % 3];
      const Vec2 side = b - a, to = p - a;
      const double turn = side.x() * to.y() - side.y() * to.x();
      left += turn >= 0 ? 1 : 0;
      right += turn <= 0 ? 1 : 0;
      const double length = side.squaredNorm();
      const double share = length > 0 ? std::clamp(side.dot(to) / length, 0.0, 1.0) : 0;
      least = std::min(least, (to - share * side).squaredNorm());
    }
    return left == 3 || right == 3 ? 0 : least;
  }

  /// Extends `low` and `high` to what lies between two heights.
  void columns_between(double top, double bottom, double& low, double& high) const {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 &a = corners[k], &b = corners[(k + 1) % 3];
      if (std::max(a.y(), b.y()) < top || std::min(a.y(), b.y()) > bottom) continue;
      const double rise = b.y() - a.y();
      for (const double y : {std::clamp(a.y(), top, bottom), std::clamp(b.y(), top, bottom)}) {
        const double share = rise != 0 ? (y - a.y()) / rise : 0;
        for (const double x :
             rise != 0 ? std::array{a.x() + share * (b.x() - a.x()), a.x() + share * (b.x() - a.x())}
                       : std::array{a.x(), b.x()}) {
          low = std::min(low, x);
          high = std::max(high, x);
        }
      }
    }
  }
};

class OwnerSearch {
 public:
  OwnerSearch(const MapTriangles& triangles, int size)
      : size_(size), bands_(static_cast<std::size_t>((size + k_band - 1) / k_band)) {
    triangles_.resize(triangles.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      double top = size, bottom = -1;
      for (std::size_t k = 0; k < 3; ++k) {
        triangles_[t].corners[k] = texel_coordinates(triangles.uv(t, k), size);
        top = std::min(top, triangles_[t].corners[k].y());
        bottom = std::max(bottom, triangles_[t].corners[k].y());
      }
      const auto band_at = [&](double y) {
        return static_cast<std::size_t>(std::clamp(y, 0.0, size - 1.0)) / k_band;
      };
      for (std::size_t band = band_at(top - k_reach); band <= band_at(bottom + k_reach); ++band)
        bands_[band].push_back(static_cast<Index>(t));
    }
  }

  TexelOwners run() {
    const auto n = static_cast<std::size_t>(size_) * static_cast<std::size_t>(size_);
    owners_.triangles.assign(n, k_no_index);
    owners_.inside.assign(n, 0);
    tbb::parallel_for(std::size_t{0}, bands_.size(), [this](std::size_t band) {
      const int first = static_cast<int>(band) * k_band;
      std::vector<double> best(static_cast<std::size_t>(size_) * k_band, k_reach * k_reach);
      for (const Index t : bands_[band]) {
        for (int y = first; y < std::min(first + k_band, size_); ++y)
          claim(t, y, best.data() + static_cast<std::size_t>(y - first) * static_cast<std::size_t>(size_));
      }
    });
    return std::move(owners_);
  }

 private:
  void claim(Index t, int y, double* best) {
    double low = size_, high = -1;
    triangles_[t].columns_between(y - k_reach, y + k_reach, low, high);
    const int end = static_cast<int>(std::min(high + k_reach, size_ - 1.0));
    for (int x = static_cast<int>(std::max(low - k_reach, 0.0)); x <= end; ++x) {
      const double distance = triangles_[t].squared_distance(Vec2(x, y));
      if (!(distance < best[x])) continue;
      best[x] = distance;
      const std::size_t texel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(x);
      owners_.triangles[texel] = t;
      owners_.inside[texel] = distance == 0 ? 1 : 0;
    }
  }

  int size_;
  std::vector<TexelTriangle> triangles_;
  std::vector<std::vector<Index>> bands_;
  TexelOwners owners_;
};

}  // namespace

Vec2 texel_coordinates(const Vec2& uv, int size) { return {uv.x() * size - 0.5, (1 - uv.y()) * size - 0.5}; }

Vec2 uv_of_texel(std::size_t texel, int size) {
  const auto row = static_cast<std::size_t>(size);
  return {(static_cast<double>(texel % row) + 0.5) / size,
          1 - (static_cast<double>(texel / row) + 0.5) / size};
}

Footprint footprint_of(const Vec2& uv, int size) {
  const Vec2 place = texel_coordinates(uv, size);
  const double left = std::floor(place.x()), top = std::floor(place.y());
  const double x = place.x() - left, y = place.y() - top;
  const auto texel = [&](double column, double row) {
    const auto in_map = [&](double value) { return static_cast<Index>(std::clamp(value, 0.0, size - 1.0)); };
    return in_map(row) * static_cast<Index>(size) + in_map(column);
  };
  return {{texel(left, top), texel(left + 1, top), texel(left, top + 1), texel(left + 1, top + 1)},
          {(1 - x) * (1 - y), x * (1 - y), (1 - x) * y, x * y}};
}

TexelOwners own_texels(const MapTriangles& triangles, int size) { return OwnerSearch(triangles, size).run(); }

}  // namespace recede::detail
