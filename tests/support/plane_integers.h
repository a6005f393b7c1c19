// Signs of points with whole coordinates below 2^26, computed without any rounding.
#pragma once

#include <recede/geometry/vec.h>

#include <cstdint>

namespace recede::test {

__extension__ using Wide = __int128;

struct WholePoint {
  std::int64_t x = 0, y = 0;
  explicit WholePoint(const Vec2& p)
      : x(static_cast<std::int64_t>(p.x())), y(static_cast<std::int64_t>(p.y())) {}
};

inline int sign_of(Wide value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

/// Twice the area of a triangle, above 0 when it turns to the left.
inline std::int64_t twice_area(const Vec2& a, const Vec2& b, const Vec2& c) {
  const WholePoint p(a), q(b), r(c);
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

inline int whole_orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  return sign_of(twice_area(a, b, c));
}

inline int whole_side_of_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const WholePoint s(d);
  Wide sum = 0;
  const Vec2* corners[] = {&a, &b, &c};
  for (int k = 0; k < 3; ++k) {
    const WholePoint p(*corners[k]);
    const std::int64_t x = p.x - s.x, y = p.y - s.y;
    sum += Wide{x * x + y * y} * twice_area(d, *corners[(k + 1) % 3], *corners[(k + 2) % 3]);
  }
  return sign_of(sum);
}

/// Whether segments cross between their ends.
inline bool cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  return whole_orientation(a, b, c) * whole_orientation(a, b, d) < 0 &&
         whole_orientation(c, d, a) * whole_orientation(c, d, b) < 0;
}

/// Whether a point lies on a segment, its ends included.
inline bool is_on_segment(const Vec2& a, const Vec2& b, const Vec2& p) {
  return whole_orientation(a, b, p) == 0 && (p - a).dot(p - b) <= 0;
}

}  // namespace recede::test
