// Whole numbers of any size a predicate needs. Doubles are whole numbers of the smallest power of two that
// divides them all, and so are their differences; sums and products of those are then exact in as many limbs
// as they need. Differences of points of one model mostly need one limb, so this costs tens of simple steps.
#pragma once

#include <recede/geometry/vec.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>

namespace recede::detail {

using Limb = std::uint64_t;
__extension__ using TwoLimbs = unsigned __int128;
inline constexpr int k_limb_bits = 64;

/// A finite double as `mantissa` times 2 to the `exponent`; an odd mantissa, or 0.
struct WholeParts {
  Limb mantissa = 0;
  int exponent = 0;
  bool is_negative = false;
};

inline WholeParts whole_parts(double value) {
  constexpr Limb k_fraction = (Limb{1} << 52) - 1;
  const Limb bits = std::bit_cast<Limb>(value);
  const int biased = static_cast<int>((bits >> 52) & 0x7ff);
  const Limb mantissa = biased == 0 ? bits & k_fraction : (bits & k_fraction) | (k_fraction + 1);
  if (mantissa == 0) return {};
  const int zeros = std::countr_zero(mantissa);
  return {mantissa >> zeros, std::max(biased, 1) - 1075 + zeros, (bits >> 63) != 0};
}

/// The largest power of two, as its exponent, that divides all the values.
inline int common_exponent(std::initializer_list<double> values) {
  int least = 1024;
  for (const double value : values) {
    const WholeParts parts = whole_parts(value);
    if (parts.mantissa != 0) least = std::min(least, parts.exponent);
  }
  return least;
}

/// A whole number: its sign, and limbs with the lowest first.
class WholeNumber {
 public:
  /// `value` in units of 2 to the `unit_exponent`, which must divide it.
  WholeNumber(double value, int unit_exponent) {
    const WholeParts parts = whole_parts(value);
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

  // Copies only what is set.
  WholeNumber(const WholeNumber& other) { *this = other; }
  WholeNumber& operator=(const WholeNumber& other) {
    std::copy_n(other.limbs_.begin(), other.size_, limbs_.begin());
    size_ = other.size_;
    is_negative_ = other.is_negative_;
    return *this;
  }

  int sign() const { return size_ == 0 ? 0 : is_negative_ ? -1 : 1; }

  friend WholeNumber operator+(const WholeNumber& a, const WholeNumber& b) {
    return sum(a, b, b.is_negative_);
  }
  friend WholeNumber operator-(const WholeNumber& a, const WholeNumber& b) {
    return sum(a, b, !b.is_negative_);
  }
  friend WholeNumber operator*(const WholeNumber& a, const WholeNumber& b) {
    WholeNumber product;
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
  /// Doubles span 2098 bits or 33 limbs; six factors and sums of billions of such products take six times
  /// that and two more.
  static constexpr std::size_t k_most_limbs = 200;

  WholeNumber() = default;

  Limb& limb(int i) { return limbs_[static_cast<std::size_t>(i)]; }
  const Limb& limb(int i) const { return limbs_[static_cast<std::size_t>(i)]; }
  void drop_zeros() {
    while (size_ > 0 && limb(size_ - 1) == 0) --size_;
  }

  static bool is_smaller_in_size(const WholeNumber& a, const WholeNumber& b) {
    if (a.size_ != b.size_) return a.size_ < b.size_;
    int i = a.size_ - 1;
    while (i >= 0 && a.limb(i) == b.limb(i)) --i;
    return i >= 0 && a.limb(i) < b.limb(i);
  }

  /// a plus the size of b with the given sign.
  static WholeNumber sum(const WholeNumber& a, const WholeNumber& b, bool b_is_negative) {
    const bool swap = is_smaller_in_size(a, b);
    const WholeNumber& large = swap ? b : a;
    const WholeNumber& small = swap ? a : b;
    WholeNumber result;
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

/// A difference of two points, in whole numbers.
struct WholeVector {
  WholeNumber x, y, z;
  WholeVector(const Vec3& to, const Vec3& from, int unit_exponent)
      : x(WholeNumber(to.x(), unit_exponent) - WholeNumber(from.x(), unit_exponent)),
        y(WholeNumber(to.y(), unit_exponent) - WholeNumber(from.y(), unit_exponent)),
        z(WholeNumber(to.z(), unit_exponent) - WholeNumber(from.z(), unit_exponent)) {}
};

inline WholeNumber determinant(const WholeVector& u, const WholeVector& v, const WholeVector& w) {
  return u.x * (v.y * w.z - v.z * w.y) + u.y * (v.z * w.x - v.x * w.z) + u.z * (v.x * w.y - v.y * w.x);
}

/// The largest power of two, as its exponent, that divides all coordinates.
inline int common_exponent(std::initializer_list<const Vec3*> points) {
  int least = 1024;
  for (const Vec3* p : points) least = std::min(least, common_exponent({p->x(), p->y(), p->z()}));
  return least;
}

}  // namespace recede::detail
