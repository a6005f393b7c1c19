// The exact signs. Doubles are whole numbers of the smallest power of two that divides them all, and so are
// their differences; sums and products of those are then exact in as many limbs as they need. Differences of
// points of one model mostly need one limb, so this costs tens of simple steps.
#include <recede/geometry/detail/plane_predicates.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>

namespace recede::detail {
namespace {

using Limb = std::uint64_t;
__extension__ using TwoLimbs = unsigned __int128;
constexpr int k_limb_bits = 64;

/// A finite double as `mantissa` times 2 to the `exponent`; an odd mantissa, or 0.
struct Parts {
  Limb mantissa = 0;
  int exponent = 0;
  bool is_negative = false;
};

Parts split(double value) {
  constexpr Limb k_fraction = (Limb{1} << 52) - 1;
  const Limb bits = std::bit_cast<Limb>(value);
  const int biased = static_cast<int>((bits >> 52) & 0x7ff);
  const Limb mantissa = biased == 0 ? bits & k_fraction : (bits & k_fraction) | (k_fraction + 1);
  if (mantissa == 0) return {};
  const int zeros = std::countr_zero(mantissa);
  return {mantissa >> zeros, std::max(biased, 1) - 1075 + zeros, (bits >> 63) != 0};
}

/// The largest power of two, as its exponent, that divides all the values.
int common_exponent(std::initializer_list<double> values) {
  int least = 1024;
  for (const double value : values) {
    const Parts parts = split(value);
    if (parts.mantissa != 0) least = std::min(least, parts.exponent);
  }
  return least;
}

/// A whole number: its sign, and limbs with the lowest first.
class Whole {
 public:
  Whole(double value, int unit_exponent) {
    const Parts parts = split(value);
    if (parts.mantissa == 0) return;
    is_negative_ = parts.is_negative;
    const int shift = parts.exponent - unit_exponent;
    const int low = shift / k_limb_bits, bits = shift % k_limb_bits;
    std::fill_n(limbs_.begin(), low, Limb{0});
    limb(low) = parts.mantissa << bits;
    size_ = low + 1;
    const Limb high = bits == 0 ? 0 : parts.mantissa >> (k_limb_bits - bits);
    if (high != 0) limb(size_++) = high;
  }

  int sign() const { return size_ == 0 ? 0 : is_negative_ ? -1 : 1; }

  friend Whole operator+(const Whole& a, const Whole& b) { return sum(a, b, b.is_negative_); }
  friend Whole operator-(const Whole& a, const Whole& b) { return sum(a, b, !b.is_negative_); }
  friend Whole operator*(const Whole& a, const Whole& b) {
    Whole product;
    if (a.size_ == 0 || b.size_ == 0) return product;
    std::fill_n(product.limbs_.begin(), a.size_ + b.size_, Limb{0});
    for (int i = 0; i < a.size_; ++i) {
      Limb carry = 0;
      for (int j = 0; j < b.size_; ++j) {
        const TwoLimbs all = TwoLimbs{a.limb(i)} * b.limb(j) + product.limb(i + j) + carry;
        product.limb(i + j) = static_cast<Limb>(all);
        carry = static_cast<Limb>(all >> k_limb_bits);
      }
      product.limb(i + b.size_) = carry;
    }
    product.size_ = a.size_ + b.size_;
    product.drop_zeros();
    product.is_negative_ = a.is_negative_ != b.is_negative_;
    return product;
  }

 private:
  /// Doubles span 2098 bits or 33 limbs; four factors and their sums take four times that and three more.
  static constexpr std::size_t k_most_limbs = 136;

  Whole() = default;

  Limb& limb(int i) { return limbs_[static_cast<std::size_t>(i)]; }
  const Limb& limb(int i) const { return limbs_[static_cast<std::size_t>(i)]; }
  void drop_zeros() {
    while (size_ > 0 && limb(size_ - 1) == 0) --size_;
  }

  static bool is_smaller_in_size(const Whole& a, const Whole& b) {
    if (a.size_ != b.size_) return a.size_ < b.size_;
    int i = a.size_ - 1;
    while (i >= 0 && a.limb(i) == b.limb(i)) --i;
    return i >= 0 && a.limb(i) < b.limb(i);
  }

  /// a plus the size of b with the given sign.
  static Whole sum(const Whole& a, const Whole& b, bool b_is_negative) {
    const bool swap = is_smaller_in_size(a, b);
    const Whole& large = swap ? b : a;
    const Whole& small = swap ? a : b;
    Whole result;
    result.is_negative_ = swap ? b_is_negative : a.is_negative_;
    result.size_ = large.size_;
    const bool subtract = a.is_negative_ != b_is_negative;
    Limb carry = 0;
    for (int i = 0; i < large.size_; ++i) {
      const Limb other = i < small.size_ ? small.limb(i) : 0;
      const TwoLimbs all =
          subtract ? TwoLimbs{large.limb(i)} - other - carry : TwoLimbs{large.limb(i)} + other + carry;
      result.limb(i) = static_cast<Limb>(all);
      carry = static_cast<Limb>(all >> k_limb_bits) & 1;
    }
    if (carry != 0) result.limb(result.size_++) = carry;
    result.drop_zeros();
    return result;
  }

  std::array<Limb, k_most_limbs> limbs_;  // those from size_ on aren't set
  int size_ = 0;
  bool is_negative_ = false;
};

}  // namespace

int exact_orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  // Lines along an axis are common and simple.
  if ((a.x() == c.x() && b.x() == c.x()) || (a.y() == c.y() && b.y() == c.y())) return 0;
  const int unit = common_exponent({a.x(), a.y(), b.x(), b.y(), c.x(), c.y()});
  const Whole cx(c.x(), unit), cy(c.y(), unit);
  const Whole left = (Whole(a.x(), unit) - cx) * (Whole(b.y(), unit) - cy);
  const Whole right = (Whole(a.y(), unit) - cy) * (Whole(b.x(), unit) - cx);
  return (left - right).sign();
}

int exact_side_of_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const int unit = common_exponent({a.x(), a.y(), b.x(), b.y(), c.x(), c.y(), d.x(), d.y()});
  const Whole dx(d.x(), unit), dy(d.y(), unit);
  const Whole ax = Whole(a.x(), unit) - dx, ay = Whole(a.y(), unit) - dy;
  const Whole bx = Whole(b.x(), unit) - dx, by = Whole(b.y(), unit) - dy;
  const Whole cx = Whole(c.x(), unit) - dx, cy = Whole(c.y(), unit) - dy;
  const Whole from_a = (ax * ax + ay * ay) * (bx * cy - cx * by);
  const Whole from_b = (bx * bx + by * by) * (cx * ay - ax * cy);
  const Whole from_c = (cx * cx + cy * cy) * (ax * by - bx * ay);
  return (from_a + from_b + from_c).sign();
}

}  // namespace recede::detail
