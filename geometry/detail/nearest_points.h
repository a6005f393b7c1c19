// The points of a cloud that are nearest to a place.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <memory>
#include <span>
#include <vector>

namespace recede::detail {

class NearestPoints {
 public:
  /// At least one. Keeps a copy.
  explicit NearestPoints(std::vector<Vec3> points);
  ~NearestPoints();
  NearestPoints(const NearestPoints&) = delete;
  NearestPoints& operator=(const NearestPoints&) = delete;

  /// From the nearest one.
  double distance(const Vec3& place) const;
  /// The numbers of the nearest ones, nearest first; `found` has at most as many entries as there are points.
  void find(const Vec3& place, std::span<Index> found) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace recede::detail
