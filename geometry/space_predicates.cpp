#include <recede/geometry/detail/space_predicates.h>
#include <recede/geometry/detail/whole_number.h>

namespace recede::detail {

int exact_side_of_plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Planes across an axis are common and simple.
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (a[k] == b[k] && a[k] == c[k] && a[k] == d[k]) return 0;
  }
  const int unit = common_exponent({&a, &b, &c, &d});
  return determinant(WholeVector(b, a, unit), WholeVector(c, a, unit), WholeVector(d, a, unit)).sign();
}

}  // namespace recede::detail
