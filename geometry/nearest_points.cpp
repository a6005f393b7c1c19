#include <recede/geometry/detail/nearest_points.h>

#include <nanoflann.hpp>

#include <cmath>

namespace recede::detail {

namespace {

// As the tree wants them.
struct Points {
  std::vector<Vec3> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<int>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Search =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3, Index>;

}  // namespace

struct NearestPoints::Tree {
  explicit Tree(std::vector<Vec3> all)
      : points{std::move(all)}, search(3, points, nanoflann::KDTreeSingleIndexAdaptorParams(10)) {}

  Points points;
  Search search;
};

NearestPoints::NearestPoints(std::vector<Vec3> points) : tree_(std::make_unique<Tree>(std::move(points))) {}
NearestPoints::~NearestPoints() = default;

double NearestPoints::distance(const Vec3& place) const {
  Index found = 0;
  double square = 0;
  tree_->search.knnSearch(place.data(), 1, &found, &square);
  return std::sqrt(square);
}

void NearestPoints::find(const Vec3& place, std::span<Index> found) const {
  std::vector<double> squares(found.size());
  tree_->search.knnSearch(place.data(), found.size(), found.data(), squares.data());
}

}  // namespace recede::detail
