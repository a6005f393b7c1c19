// One mesh spoilt in fifteen ways, each of which some meshes from elsewhere show.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <iosfwd>
#include <string>
#include <vector>

namespace recede::test {

struct TortureVariant {
  std::string name, description;
  PolygonSoup soup;
};
/// For the names of tests.
void PrintTo(const TortureVariant& variant, std::ostream* out);

/// The base and fifteen variants. The base is a closed ball with ridges, of at least `faces` triangles. The
/// same bytes on every call.
std::vector<TortureVariant> torture_set(std::size_t faces);

}  // namespace recede::test
