// The numbers that a pixel's samples draw: a pure function of pixel, sample and dimension, so that neither
// threads nor the order of work change a picture.
//
// Points of Sobol's first two dimensions, shuffled and scrambled for each pair of dimensions by Owen's method
// with hashes (Burley 2020, "Practical Hash-based Owen Scrambling"): the first 2^k samples of a pixel fill
// every pair of dimensions evenly, for every k.
#pragma once

#include <recede/geometry/vec.h>

#include <cstdint>

namespace recede::detail {

/// A hash of 32 bits in which each bit of the input flips half of the bits.
constexpr std::uint32_t hash_bits(std::uint32_t x) {
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
  x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
  x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
  x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
  x = (x & 0x00ff00ffu) << 8 | (x >> 8 & 0x00ff00ffu);
  return x << 16 | x >> 16;
}

/// A permutation in which each bit depends on lower bits and the seed only (Laine and Karras 2011): Owen's
/// scrambling of a fraction whose bits are reversed.
constexpr std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return x;
}

/// The digits, lowest first, that Sobol's second dimension has for a point's number: its generating matrix is
/// Pascal's triangle modulo 2, the fifth power (by Kronecker) of a matrix of two rows, so five steps do.
constexpr std::uint32_t second_sobol_digits(std::uint32_t index) {
  index ^= index >> 1 & 0x55555555u;
  index ^= index >> 2 & 0x33333333u;
  index ^= index >> 4 & 0x0f0f0f0fu;
  index ^= index >> 8 & 0x00ff00ffu;
  return index ^ (index >> 16);
}

/// The numbers of one sample of one pixel, in the order in which they are asked for.
class SampleStream {
 public:
  SampleStream() = default;
  SampleStream(int x, int y, std::uint32_t sample)
      : seed_(hash_bits(static_cast<std::uint32_t>(x) + hash_bits(static_cast<std::uint32_t>(y) + 1))),
        sample_(reverse_bits(sample)) {}

  /// In [0, 1) x [0, 1).
  Vec2 next_pair() {
    const std::uint32_t seed = hash_bits(seed_ + k_step * ++pairs_);
    const std::uint32_t index = reverse_bits(scramble_reversed(sample_, seed));
    return {fraction(scramble_reversed(index, hash_bits(seed ^ k_first))),
            fraction(scramble_reversed(second_sobol_digits(index), hash_bits(seed ^ k_second)))};
  }

 private:
  static constexpr std::uint32_t k_step = 0x9e3779b9u, k_first = 0x1u, k_second = 0x2u;

  static double fraction(std::uint32_t reversed) { return reverse_bits(reversed) * 0x1p-32; }

  std::uint32_t seed_ = 0, sample_ = 0;
  std::uint32_t pairs_ = 0;
};

}  // namespace recede::detail
