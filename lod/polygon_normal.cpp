#include <recede/lod/detail/polygon_normal.h>

#include <algorithm>

namespace recede::detail {
namespace {

/// A corner average is nearly zero below this share of the sum of the lengths averaged.
constexpr double k_nearly_zero = 1e-9;
/// A polygon whose vector area is below this share of its squared longest side has none.
constexpr double k_no_area = 1e-12;

}  // namespace

Vec3 twice_vector_area(std::span<const Vec3> points) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    sum += (points[i] - points[0]).cross(points[i + 1] - points[0]);
  }
  return sum;
}

Vec3 vector_area_normal(std::span<const Vec3> points) {
  const Vec3 area = twice_vector_area(points);
  double longest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    longest = std::max(longest, (points[(i + 1) % points.size()] - points[i]).squaredNorm());
  }
  const double length = area.norm();
  return length > k_no_area * longest ? Vec3(area / length) : Vec3(Vec3::Zero());
}

Vec3 corner_average_normal(std::span<const Vec3> points) {
  const Vec3 by_area = vector_area_normal(points);
  // For three and four corners the source's formulas are the vector area.
  if (points.size() <= 4 || by_area.isZero(0)) return by_area;
  Vec3 sum = Vec3::Zero();
  double lengths = 0;
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 turn = (points[(i + 1) % n] - points[i]).cross(points[(i + n - 1) % n] - points[i]);
    sum += turn;
    lengths += turn.norm();
  }
  const double length = sum.norm();
  return length > k_nearly_zero * lengths ? Vec3(sum / length) : by_area;
}

}  // namespace recede::detail
