#include <recede/shells/detail/front_direction.h>

#include <algorithm>
#include <cstddef>

namespace recede::detail {

namespace {

Vec3 axis_by_steps(std::span<const Vec3> normals, Vec3 axis) {
  constexpr int k_steps = 64;
  for (int step = 0; step < k_steps; ++step) {
    const Vec3& farthest =
        *std::min_element(normals.begin(), normals.end(),
                          [&](const Vec3& a, const Vec3& b) { return a.dot(axis) < b.dot(axis); });
    const Vec3 next = axis + (farthest - axis) / (step + 2);
    if (!(next.norm() > 0)) break;
    axis = next.normalized();
  }
  return axis;
}

// The narrowest cone touches two or three of the normals.
Vec3 axis_by_search(std::span<const Vec3> normals, Vec3 axis) {
  double best = least_cosine(normals, axis);
  const auto consider = [&](const Vec3& direction) {
    const Vec3 unit = direction.stableNormalized();
    const double least = least_cosine(normals, unit);
    if (!(least > best)) return;
    best = least;
    axis = unit;
  };
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t j = i + 1; j < normals.size(); ++j) {
      consider(normals[i] + normals[j]);
      for (std::size_t k = j + 1; k < normals.size(); ++k) {
        const Vec3 across = (normals[j] - normals[i]).cross(normals[k] - normals[i]);
        consider(across);
        consider(-across);
      }
    }
  }
  return axis;
}

}  // namespace

double least_cosine(std::span<const Vec3> normals, const Vec3& direction) {
  double least = 1;
  for (const Vec3& normal : normals) least = std::min(least, normal.dot(direction));
  return least;
}

Vec3 axis_of_normals(std::span<const Vec3> normals, const Vec3& start) {
  const Vec3 axis = axis_by_steps(normals, start);
  // Steps come within some hundredths of the best cosine. The search takes the fourth power of the number.
  constexpr double k_hardly = 0.1;
  constexpr std::size_t k_most_normals = 64;
  return least_cosine(normals, axis) > k_hardly || normals.size() > k_most_normals
             ? axis
             : axis_by_search(normals, axis);
}

}  // namespace recede::detail
