// Numbers as integers, so that differences between them can be coded without loss.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

namespace recede::detail {

/// How numbers of one kind become integers whose order is theirs.
struct NumberLattice {
  enum class Form : std::uint8_t { floats, doubles, decimals, quantised };
  Form form = Form::doubles;
  double origin = 0,
         step = 1;        ///< quantised: value = origin + step * integer. Decimals: value = integer / step
  std::int64_t most = 0;  ///< quantised: the largest integer

  /// The narrowest form that holds all the numbers bit for bit.
  static NumberLattice lossless(std::span<const std::span<const double>> lists);
  /// Integers of `bits` over `extent` from `lowest` on.
  static NumberLattice quantised(double lowest, double extent, int bits);

  std::int64_t to_integer(double value) const;
  double to_value(std::int64_t integer) const;
};

}  // namespace recede::detail
