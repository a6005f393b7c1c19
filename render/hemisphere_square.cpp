#include <recede/render/hemisphere_square.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede {

// The square's diagonals cut square and disk into four wedges. In each, the distance from the middle is that
// along the wedge's axis, and the angle from this axis grows evenly across.
Vec2 hemisphere_to_square(const Vec3& direction) {
  const double x = direction.x(), y = direction.y();
  const double level = std::sqrt(x * x + y * y);
  if (!(level > 0)) return {0.5, 0.5};
  // sqrt(1 - z) without the loss of digits near the pole: 1 - z = level^2 / (1 + z).
  const double z = std::max(direction.z(), 0.0);
  const double radius = direction.z() < 0 ? 1.0 : std::min(1.0, level / std::sqrt(1 + z));
  constexpr double k_wedges = 4 / std::numbers::pi;
  double p, q;
  if (std::abs(x) >= std::abs(y)) {
    p = std::copysign(radius, x);
    q = p * k_wedges * std::atan(y / x);
  } else {
    q = std::copysign(radius, y);
    p = q * k_wedges * std::atan(x / y);
  }
  return {(p + 1) / 2, (q + 1) / 2};
}

Vec3 square_to_hemisphere(const Vec2& place) {
  const double p = 2 * place.x() - 1, q = 2 * place.y() - 1;
  if (p == 0 && q == 0) return Vec3::UnitZ();
  constexpr double k_wedge = std::numbers::pi / 4;
  const bool along_x = std::abs(p) > std::abs(q);
  const double radius = along_x ? p : q;
  const double angle = k_wedge * (along_x ? q / p : p / q);  // from the wedge's axis
  const double level = radius * std::sqrt(std::max(0.0, 2 - radius * radius));
  const double ahead = level * std::cos(angle), aside = level * std::sin(angle);
  const double z = std::max(0.0, 1 - radius * radius);
  return along_x ? Vec3(ahead, aside, z) : Vec3(aside, ahead, z);
}

}  // namespace recede
