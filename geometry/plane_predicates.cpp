// The exact signs, by whole numbers.
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/whole_number.h>

namespace recede::detail {

int exact_orientation(const Vec2& a, const Vec2& b, const Vec2& c) {
  // Lines along an axis are common and simple.
  if ((a.x() == c.x() && b.x() == c.x()) || (a.y() == c.y() && b.y() == c.y())) return 0;
  const int unit = common_exponent({a.x(), a.y(), b.x(), b.y(), c.x(), c.y()});
  const WholeNumber cx(c.x(), unit), cy(c.y(), unit);
  const WholeNumber left = (WholeNumber(a.x(), unit) - cx) * (WholeNumber(b.y(), unit) - cy);
  const WholeNumber right = (WholeNumber(a.y(), unit) - cy) * (WholeNumber(b.x(), unit) - cx);
  return (left - right).sign();
}

int exact_side_of_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const int unit = common_exponent({a.x(), a.y(), b.x(), b.y(), c.x(), c.y(), d.x(), d.y()});
  const WholeNumber dx(d.x(), unit), dy(d.y(), unit);
  const WholeNumber ax = WholeNumber(a.x(), unit) - dx, ay = WholeNumber(a.y(), unit) - dy;
  const WholeNumber bx = WholeNumber(b.x(), unit) - dx, by = WholeNumber(b.y(), unit) - dy;
  const WholeNumber cx = WholeNumber(c.x(), unit) - dx, cy = WholeNumber(c.y(), unit) - dy;
  const WholeNumber from_a = (ax * ax + ay * ay) * (bx * cy - cx * by);
  const WholeNumber from_b = (bx * bx + by * by) * (cx * ay - ax * cy);
  const WholeNumber from_c = (cx * cx + cy * cy) * (ax * by - bx * ay);
  return (from_a + from_b + from_c).sign();
}

}  // namespace recede::detail
