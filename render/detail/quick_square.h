// The square of directions for shading: the maps of hemisphere_square.h to nine digits, without calls of
// trigonometric functions and without jumps.
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace recede::detail {

/// Exchanges two numbers or not, without a jump, which couldn't be foreseen.
inline void exchange_if(bool condition, double& a, double& b) {
  const auto bits_a = std::bit_cast<std::uint64_t>(a), bits_b = std::bit_cast<std::uint64_t>(b);
  const std::uint64_t changed = (bits_a ^ bits_b) & (0 - static_cast<std::uint64_t>(condition));
  a = std::bit_cast<double>(bits_a ^ changed);
  b = std::bit_cast<double>(bits_b ^ changed);
}

/// 4 / pi atan(x) for 0 <= x <= 1, to 2e-10: the odd polynomial of degree 21 with the least largest error.
inline double quick_arctangent(double x) {
  const double u = x * x, u2 = u * u, u4 = u2 * u2;
  const double low =
      1.2732395404984038 - 0.4244127837723895 * u + u2 * (0.25463682924028158 - 0.18174771526203792 * u);
  const double middle =
      0.14042115121575133 - 0.11094833374186455 * u + u2 * (0.083287461097526869 - 0.053588310785909823 * u);
  const double high = 0.026060523804796457 - 0.0081421056311639581 * u + u2 * 0.0011937435149813047;
  return std::min(1.0, x * (low + u4 * (middle + u4 * high)));
}

/// tan(pi / 8 x) for 0 <= x <= 1, to 4e-10: of degree 9.
inline double quick_tangent(double x) {
  const double u = x * x, u2 = u * u;
  return x * (0.39269908569276646 + 0.02018629910826716 * u +
              u2 * (0.0012456330492718311 + 7.6749072588721322e-05 * u + u2 * 5.7950849964361669e-06));
}

/// The angle of a point from the x axis, for x and y >= 0, in right angles: 0 to 1.
inline double quick_angle(double x, double y) {
  const double larger = std::max(x, y), smaller = std::min(x, y);
  const double half = larger > 0 ? 0.5 * quick_arctangent(smaller / larger) : 0.0;
  return 0.5 - std::copysign(0.5 - half, x - y);
}

/// `hemisphere_to_square`; differs from it by less than 1e-9.
inline Vec2 quick_hemisphere_to_square(const Vec3& direction) {
  const double x = direction.x(), y = direction.y();
  const double along_x = std::abs(x), along_y = std::abs(y);
  const double inside = std::min(1.0, std::sqrt((x * x + y * y) / (1 + std::max(direction.z(), 0.0))));
  const double larger = std::max(along_x, along_y), smaller = std::min(along_x, along_y);
  if (!(larger > 0)) return {0.5, 0.5};
  double p = direction.z() < 0 ? 1.0 : inside;
  double q = p * quick_arctangent(smaller / larger);
  exchange_if(along_y > along_x, p, q);
  return {0.5 + 0.5 * std::copysign(p, x), 0.5 + 0.5 * std::copysign(q, y)};
}

/// `square_to_hemisphere`; differs from it by less than 1e-9, and has unit length to all digits.
inline Vec3 quick_square_to_hemisphere(const Vec2& place) {
  const double p = 2 * place.x() - 1, q = 2 * place.y() - 1;
  const double along_p = std::abs(p), along_q = std::abs(q);
  const double radius = std::max(along_p, along_q), smaller = std::min(along_p, along_q);
  // Cosine and sine by the tangent of half of the angle: their squares sum to 1 whatever it is.
  const double tangent = quick_tangent(radius > 0 ? smaller / radius : 0.0), square = tangent * tangent;
  const double level = radius * std::sqrt(std::max(0.0, 2 - radius * radius)) / (1 + square);
  double x = level * (1 - square), y = level * 2 * tangent;
  exchange_if(along_p <= along_q, x, y);
  return {std::copysign(x, p), std::copysign(y, q), std::max(0.0, 1 - radius * radius)};
}

}  // namespace recede::detail
