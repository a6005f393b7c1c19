// A closed surface around anything: holes, overlaps, loose triangles, surfaces that meet themselves.
//
// Portaneri, Rouxel-Labbe, Hemmer, Cohen-Steiner, Alliez 2022, "Alpha Wrapping with an Offset", as the
// library CGAL has it. That part of CGAL is under the GPL, so it is built in only when RECEDE_CGAL_GPL says
// so.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

namespace recede {

struct AlphaWrapOptions {
  /// Object units, above 0: into holes and gaps narrower than about this the wrap doesn't go, and its
  /// triangles are about as large. The tenth part takes about a hundred times as long.
  double alpha = 0;
  double offset = 0;  ///< object units: the wrap is about this far outside; 0: a thirtieth of alpha
};

/// Whether this build has it.
bool can_alpha_wrap();

/// Triangles of a closed surface that doesn't meet itself and has all of the soup strictly inside. The soup
/// may be anything that `validate` takes; attributes are lost.
///
/// Progress is reported before and after, and it can't be cancelled meanwhile. One thread, so the same result
/// for any number of them. Throws `InputError` for a soup that `validate` refuses or without area, and
/// `OptionError` for options out of range, also for an alpha below a ten-thousandth of the diagonal of the
/// soup's box, and where `can_alpha_wrap` is false.
PolygonSoup alpha_wrap(const PolygonSoup& soup, const AlphaWrapOptions& options,
                       Progress* progress = nullptr);

}  // namespace recede
