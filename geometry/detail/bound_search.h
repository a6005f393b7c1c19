// The certified interval of the one-sided maximum distance between two surfaces.
#pragma once

#include <recede/geometry/closest_point.h>

#include <optional>

namespace recede::detail {

/// A surface as triangles over the vertices that they use, with its search tree.
struct Surface {
  explicit Surface(PolygonSoup soup);

  std::size_t n_triangles() const { return triangles.size() / 3; }
  Triangle triangle(std::size_t t) const {
    return {positions[triangles[3 * t]], positions[triangles[3 * t + 1]], positions[triangles[3 * t + 2]]};
  }

  std::vector<Vec3> positions;
  std::vector<Index> triangles;  ///< three positions each
  ClosestPointTree tree;
  std::vector<double> areas;
  double area = 0;
  /// Triangles that are no mere segment or point, when others are: what lies beside a segment is near none.
  std::vector<Index> solid;
  std::optional<ClosestPointTree> solid_tree;
};

struct Interval {
  double lower = 0, upper = 0;
  Vec3 at = Vec3::Zero();  ///< where the upper end comes from
};

/// How narrow the interval has to be.
struct BoundGoal {
  double lower = 0;      ///< a distance known to occur
  double tolerance = 0;  ///< upper - lower <= tolerance * upper is enough
  double floor = 0;      ///< and so is an upper end of this
};

/// For each triangle of `from` an interval that holds the largest distance from a point of it to the surface
/// `to`; the lower ends are at least the goal's. `nearest` names for each position of `from` a triangle of
/// `to` near it. The same for any number of threads.
std::vector<Interval> certified_intervals(const Surface& from, const Surface& to,
                                          const std::vector<Index>& nearest, const BoundGoal& goal);

}  // namespace recede::detail
