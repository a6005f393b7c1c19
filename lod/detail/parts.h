// Parts of a surface that no face connects: joining near ones, and dropping those that lie close to the rest.
#pragma once

#include <recede/lod/detail/corner_table.h>

#include <functional>

namespace recede::detail {

/// Pairs of points of different parts, each with the nearest point of another part when that is no farther
/// than `distance` (table units); lower point first, sorted.
std::vector<PointPair> find_joins(const CornerTable& table, double distance);

/// What was dropped.
struct DroppedParts {
  std::size_t parts = 0, faces = 0, points = 0;
  double error = 0;  ///< the largest own error of a dropped part, table units
};

/// Takes parts out of the table. A part's own error is how far its points are from the nearest other part, on
/// top of their deviation. Parts go in the order of their own errors, up to `most_error` (table units), until
/// `enough` says so (asked before each one with what was dropped so far). A part that another one relied on
/// stays, so the errors hold with all that go together; held parts stay, too. What relied on them takes over
/// their deviation.
DroppedParts drop_parts(CornerTable& table, double most_error,
                        const std::function<bool(const DroppedParts&)>& enough);

}  // namespace recede::detail
