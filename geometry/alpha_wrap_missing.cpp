// What stands in for the wrap in a build without CGAL's GPL parts.
#include <recede/geometry/alpha_wrap.h>
#include <recede/geometry/error.h>

namespace recede {

bool can_alpha_wrap() { return false; }

PolygonSoup alpha_wrap(const PolygonSoup&, const AlphaWrapOptions&, Progress*) {
  throw OptionError("this build wraps nothing: it was made without CGAL's GPL parts (RECEDE_CGAL_GPL)");
}

}  // namespace recede
