// Two numbers at a time, in a register that every 64-bit processor has.
#pragma once

#include <cmath>
#include <cstring>

namespace recede::detail {

using DoublePair = double __attribute__((vector_size(16)));
using PairMask = long long __attribute__((vector_size(16)));

inline DoublePair both(double value) { return DoublePair{value, value}; }

inline DoublePair pair_at(const double* first) {
  DoublePair pair;
  std::memcpy(&pair, first, sizeof pair);
  return pair;
}

inline DoublePair select(PairMask mask, DoublePair yes, DoublePair no) { return mask ? yes : no; }

/// The value, or zero whatever the value is, infinite ones too.
inline DoublePair where(PairMask mask, DoublePair value) {
  return reinterpret_cast<DoublePair>(mask & reinterpret_cast<PairMask>(value));
}

inline DoublePair root(DoublePair x) { return DoublePair{std::sqrt(x[0]), std::sqrt(x[1])}; }

inline DoublePair magnitude(DoublePair x) { return x < both(0) ? -x : x; }

inline double sum(DoublePair x) { return x[0] + x[1]; }

/// Three coordinates of two vectors.
struct Vec3Pair {
  DoublePair x, y, z;
};

inline Vec3Pair operator-(const Vec3Pair& a, const Vec3Pair& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline DoublePair dot(const Vec3Pair& a, const Vec3Pair& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3Pair cross(const Vec3Pair& a, const Vec3Pair& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace recede::detail
