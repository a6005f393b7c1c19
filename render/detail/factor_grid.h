// A function of two directions that depends on their angles and on the angle between their azimuths, sampled
// for lookups without trigonometric functions.
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace recede::detail {

/// Linear between nodes at even steps of sqrt(1 - z) of both unit vectors and of the cosine between their
/// azimuths. Directions to both sides of the other's azimuth count alike; below the horizon as on it.
class FactorGrid {
 public:
  FactorGrid() = default;
  /// `function` of two unit vectors, the first in the plane of x and z.
  template <class Function>
  explicit FactorGrid(const Function& function) {
    values_.reserve(static_cast<std::size_t>(k_angles * k_angles * k_azimuths));
    for (int i = 0; i < k_angles; ++i) {
      for (int j = 0; j < k_angles; ++j) {
        for (int k = 0; k < k_azimuths; ++k) {
          const double c = 2.0 * k / (k_azimuths - 1) - 1;
          const Vec3 first = at(i, 1, 0), second = at(j, c, std::sqrt(std::max(0.0, 1 - c * c)));
          const Vec3 mirrored(second.x(), -second.y(), second.z());
          values_.push_back(static_cast<float>((function(first, second) + function(first, mirrored)) / 2));
        }
      }
    }
  }

  bool is_empty() const { return values_.empty(); }

  double operator()(const Vec3& first, const Vec3& second) const {
    const double levels = first.head<2>().squaredNorm() * second.head<2>().squaredNorm();
    const double along = first.head<2>().dot(second.head<2>());
    const double cosine = levels > 0 ? std::clamp(along / std::sqrt(levels), -1.0, 1.0) : 0.0;
    const Place i = place(std::sqrt(1 - std::clamp(first.z(), 0.0, 1.0)), k_angles);
    const Place j = place(std::sqrt(1 - std::clamp(second.z(), 0.0, 1.0)), k_angles);
    const Place k = place((cosine + 1) / 2, k_azimuths);
    const auto along_azimuth = [&](int a, int b) {
      const float* row = values_.data() + (a * k_angles + b) * k_azimuths + k.node;
      return static_cast<double>(row[0]) +
             k.fraction * (static_cast<double>(row[1]) - static_cast<double>(row[0]));
    };
    const auto along_second = [&](int a) {
      const double lower = along_azimuth(a, j.node);
      return lower + j.fraction * (along_azimuth(a, j.node + 1) - lower);
    };
    const double lower = along_second(i.node);
    return lower + i.fraction * (along_second(i.node + 1) - lower);
  }

 private:
  static constexpr int k_angles = 28, k_azimuths = 13;

  static Vec3 at(int node, double x, double y) {
    const double radius = static_cast<double>(node) / (k_angles - 1), z = 1 - radius * radius;
    const double level = std::sqrt(std::max(0.0, 1 - z * z));
    return {level * x, level * y, z};
  }
  struct Place {
    int node = 0;
    double fraction = 0;
  };
  static Place place(double share, int nodes) {
    const double steps = share * (nodes - 1);
    const int node = std::min(static_cast<int>(steps), nodes - 2);
    return {node, steps - node};
  }

  std::vector<float> values_;  // by first angle, second angle, azimuth
};

}  // namespace recede::detail
