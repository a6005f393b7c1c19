#include <recede/geometry/detail/orientation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace recede::detail {
namespace {

/// A number as a sum of doubles that don't overlap, the smallest first (Shewchuk's expansion).
class Expansion {
 public:
  void add_product(double x, double y) {
    const double product = x * y;
    add(std::fma(x, y, -product));  // exactly what rounding took away
    add(product);
  }

  int sign() const {
    for (std::size_t i = size_; i-- > 0;) {
      if (parts_[i] != 0) return parts_[i] > 0 ? 1 : -1;
    }
    return 0;
  }

 private:
  void add(double value) {
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = value + parts_[i];
      const double other = sum - value;
      parts_[i] = (value - (sum - other)) + (parts_[i] - other);  // Knuth's exact rounding error
      value = sum;
    }
    parts_[size_++] = value;
  }

  std::array<double, 12> parts_;
  std::size_t size_ = 0;
};

}  // namespace

int orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double left = (a.x() - c.x()) * (b.y() - c.y());
  const double right = (a.y() - c.y()) * (b.x() - c.x());
  const double determinant = left - right;
  constexpr double k_error = 3.3306690738754716e-16;  // (3 + 16 epsilon) epsilon, epsilon = 2^-53
  const double bound = k_error * (std::abs(left) + std::abs(right));
  if (determinant > bound) return 1;
  if (-determinant > bound) return -1;
  Expansion exact;
  exact.add_product(a.x(), b.y());
  exact.add_product(-a.x(), c.y());
  exact.add_product(-c.x(), b.y());
  exact.add_product(-a.y(), b.x());
  exact.add_product(a.y(), c.x());
  exact.add_product(c.y(), b.x());
  return exact.sign();
}

namespace {

/// Segments with overlapping x ranges have a common point.
bool touch(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (std::max(a.y(), b.y()) < std::min(c.y(), d.y()) || std::max(c.y(), d.y()) < std::min(a.y(), b.y())) {
    return false;
  }
  return orientation(a, b, c) * orientation(a, b, d) <= 0 && orientation(c, d, a) * orientation(c, d, b) <= 0;
}

/// The side from b to c runs back along the one from a to b.
bool runs_back(const Vec2& a, const Vec2& b, const Vec2& c) {
  return b == c || (orientation(a, b, c) == 0 && (a - b).dot(c - b) > 0);
}

}  // namespace

bool is_simple_polygon(const std::vector<Vec2>& corners) {
  const std::size_t n = corners.size();
  if (n < 3) return false;
  const auto end = [&](std::size_t side) -> const Vec2& { return corners[(side + 1) % n]; };
  const auto left = [&](std::size_t side) { return std::min(corners[side].x(), end(side).x()); };
  const auto right = [&](std::size_t side) { return std::max(corners[side].x(), end(side).x()); };
  std::vector<std::size_t> order(n), active;
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return left(a) < left(b); });
  for (const std::size_t side : order) {
    if (runs_back(corners[side], end(side), end((side + 1) % n))) return false;
    std::erase_if(active, [&](std::size_t other) { return right(other) < left(side); });
    for (const std::size_t other : active) {
      if ((other + 1) % n == side || (side + 1) % n == other) continue;
      if (touch(corners[side], end(side), corners[other], end(other))) return false;
    }
    active.push_back(side);
  }
  return true;
}

}  // namespace recede::detail
