// Floats of 16 bits, as files have them.
#pragma once

#include <Eigen/Core>

#include <cstdint>

namespace recede::detail {

/// The bits of the half nearest to a number, of two the even one; infinite beyond 65 504.
inline std::uint16_t to_half(float number) {
  return Eigen::numext::bit_cast<std::uint16_t>(Eigen::half(number));
}

inline float from_half(std::uint16_t bits) {
  return static_cast<float>(Eigen::numext::bit_cast<Eigen::half>(bits));
}

}  // namespace recede::detail
