// Points without a pattern that fill a square or a cube evenly, however many of them are taken.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/render/detail/sample_stream.h>

#include <cstddef>
#include <cstdint>

namespace recede::detail {

/// Points that fill the unit square or cube evenly: multiples of numbers that are far from all fractions, the
/// inverse powers of the roots of x^3 = x + 1 and of x^4 = x + 1 (Roberts 2018, "The unreasonable
/// effectiveness of quasirandom sequences"). Products of whole numbers, so that nothing is rounded.
class EvenPoints {
 public:
  EvenPoints(std::uint32_t seed, bool in_cube) : steps_(in_cube ? k_cube : k_square) {
    for (std::size_t k = 0; k < 3; ++k)
      shift_[k] = std::uint64_t{hash_bits(3 * seed + static_cast<std::uint32_t>(k) + 1)} << 32;
  }
  /// In [0, 1) each.
  Vec3 point(std::uint64_t number) const {
    const auto fraction = [&](std::size_t k) {
      return static_cast<double>((shift_[k] + number * steps_[k]) >> 11) * 0x1p-53;
    };
    return {fraction(0), fraction(1), fraction(2)};
  }

 private:
  // Times 2^64.
  static constexpr std::uint64_t k_cube[3] = {0xd1b54a32d192ed03u, 0xabc98388fb8fac02u, 0x8cb92ba72f3d8dd7u};
  static constexpr std::uint64_t k_square[3] = {0xc13fa9a902a6328fu, 0x91e10da5c79e7b1cu, 0};
  const std::uint64_t* steps_;
  std::uint64_t shift_[3];
};

}  // namespace recede::detail
