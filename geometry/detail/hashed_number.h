// Numbers that look random and are the same everywhere: for lots that mustn't depend on the order of work.
#pragma once

#include <cstdint>

namespace recede::detail {

/// Uniform in [0, 1), another one for each `which` (the output function of SplitMix64: Steele, Lea, Flood
/// 2014).
inline double hashed_number(std::uint64_t key, std::uint64_t which) {
  std::uint64_t h = key + (which + 1) * 0x9e3779b97f4a7c15u;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  h ^= h >> 31;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

}  // namespace recede::detail
