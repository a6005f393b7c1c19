#include <recede/geometry/detail/space_predicates.h>
#include <recede/geometry/detail/whole_number.h>
#include <recede/shells/detail/prism.h>

#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

/// Bernstein coefficients of a quadratic polynomial on [0, 1]; the one in the middle is doubled, which saves
/// a division.
template <typename Number>
struct Coefficients {
  Number first, twice_middle, last;
};

/// Whether all lie above 0, or the polynomial does with one in the middle that doesn't.
template <typename Number, typename Discriminant>
bool is_positive(const Coefficients<Number>& q, int orientation, Discriminant&& discriminant_sign) {
  if (orientation * q.first.sign() <= 0 || orientation * q.last.sign() <= 0) return false;
  return orientation * q.twice_middle.sign() >= 0 || discriminant_sign() < 0;
}

Coefficients<WholeNumber> exact_coefficients(const Prism& prism, std::size_t i) {
  const auto& b = prism.bottom;
  const auto& t = prism.top;
  const int unit = common_exponent({&b[0], &b[1], &b[2], &t[0], &t[1], &t[2]});
  const WholeVector b1(b[1], b[0], unit), b2(b[2], b[0], unit), t1(t[1], t[0], unit), t2(t[2], t[0], unit);
  const WholeVector step(t[i], b[i], unit);
  return {determinant(b1, b2, step), determinant(b1, t2, step) + determinant(t1, b2, step),
          determinant(t1, t2, step)};
}

bool is_exactly_positive(const Prism& prism, std::size_t i, int orientation) {
  const Coefficients<WholeNumber> q = exact_coefficients(prism, i);
  return is_positive(q, orientation, [&] {
    const WholeNumber product = q.first * q.last, twice = product + product;
    return (q.twice_middle * q.twice_middle - (twice + twice)).sign();
  });
}

/// The cross product of two sides, and the sum of the sizes of the products in it.
struct SidePair {
  Vec3 normal, size;

  SidePair(const Vec3& u, const Vec3& v) : normal(u.cross(v)) {
    const Vec3 x = u.cwiseAbs(), y = v.cwiseAbs();
    size = {x.y() * y.z() + x.z() * y.y(), x.z() * y.x() + x.x() * y.z(), x.x() * y.y() + x.y() * y.x()};
  }
  SidePair(const SidePair& a, const SidePair& b) : normal(a.normal + b.normal), size(a.size + b.size) {}

  RoundedValue determinant(const Vec3& step) const {
    // Differences, a product, a difference and a sum in the normal: five roundings; then those of a
    // difference, a product and two sums: nine, and a little more, for the bound is rounded as well.
    constexpr double k_error = 11 * (0.5 * std::numeric_limits<double>::epsilon());
    // Above what products lose that are too small for a double: 2^-1075 for each, times the third factor.
    constexpr double k_underflow = std::numeric_limits<double>::min();
    const Vec3 length = step.cwiseAbs();
    return {normal.dot(step), k_error * size.dot(length) + k_underflow * (1 + length.sum())};
  }
};

}  // namespace

bool has_one_orientation(const Prism& prism, bool is_inward) {
  const auto& b = prism.bottom;
  const auto& t = prism.top;
  const int orientation = is_inward ? -1 : 1;
  const Vec3 b1 = b[1] - b[0], b2 = b[2] - b[0], t1 = t[1] - t[0], t2 = t[2] - t[0];
  const SidePair below(b1, b2), above(t1, t2), between(SidePair(b1, t2), SidePair(t1, b2));
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 step = t[i] - b[i];
    const int first = orientation * below.determinant(step).sign();
    const int last = orientation * above.determinant(step).sign();
    if (first < 0 || last < 0) return false;
    const int middle = orientation * between.determinant(step).sign();
    if (first > 0 && last > 0 && middle > 0) continue;
    if (!is_exactly_positive(prism, i, orientation)) return false;
  }
  return true;
}

}  // namespace recede::detail
