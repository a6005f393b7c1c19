#include <recede/geometry/agglomerate.h>
#include <recede/lod/detail/face_clustering.h>

#include <nanoflann.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::detail {

namespace {

// A box around points along given axes.
class Extents {
 public:
  explicit Extents(const Eigen::Matrix3d& axes) : to_axes_(axes.transpose()) {}

  void extend(const Vec3& point) { box_.extend(Vec3(to_axes_ * point)); }
  const Box3& box() const { return box_; }
  // The axis along which it is narrowest.
  int narrowest() const {
    int axis = 0;
    box_.sizes().minCoeff(&axis);
    return axis;
  }
  double error() const { return box_.sizes().minCoeff() / 2; }
  double rectangle() const {
    const int axis = narrowest();
    return box_.sizes()[(axis + 1) % 3] * box_.sizes()[(axis + 2) % 3];
  }

 private:
  Eigen::Matrix3d to_axes_;
  Box3 box_;
};

// Turned to the front of most faces.
Vec3 turned(const Vec3& normal, const SurfaceMoments& moments) {
  return moments.normal.dot(normal) < 0 ? Vec3(-normal) : normal;
}

// 13 directions, to faces, edges and corners of a cube: what is farthest along each of them, both ways.
const std::array<Vec3, 13>& directions() {
  static const std::array<Vec3, 13> k_directions = [] {
    std::array<Vec3, 13> result;
    std::size_t n = 0;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (9 * x + 3 * y + z > 0) result[n++] = Vec3(x, y, z).normalized();
        }
      }
    }
    return result;
  }();
  return k_directions;
}

class FaceMerger {
 public:
  FaceMerger(const BillboardFaces& faces, const BillboardOptions& options, const std::vector<double>& errors)
      : faces_(faces), options_(options), errors_(errors), clusters_(faces.count()), next_(faces.count()) {
    for (Index face = 0; face < faces.count(); ++face) {
      Cluster& cluster = clusters_[face];
      cluster.moments = faces.moments[face];
      cluster.last = face;
      next_[face] = k_no_index;
      const std::span<const Index> corners = faces.corners_of(face);
      cluster.points.assign(corners.begin(), corners.end());
      cluster.normals.assign(1, face);
      thin(cluster.points, faces_.points);
    }
  }

  // From the farthest points and the most tilted normals of some directions: at most the cost.
  double cost(Index a, Index b) const {
    const Cluster &first = clusters_[a], &second = clusters_[b];
    SurfaceMoments moments = first.moments;
    moments += second.moments;
    const Eigen::Matrix3d axes = moments.axes();
    Extents extents(axes);
    for (const Cluster* cluster : {&first, &second}) {
      for (const Index point : cluster->points) extents.extend(faces_.points[point]);
    }
    const Vec3 normal = turned(axes.col(extents.narrowest()), moments);
    double least = 1;
    for (const Cluster* cluster : {&first, &second}) {
      for (const Index face : cluster->normals) least = std::min(least, cosine(face, normal));
    }
    return cost_of(extents, least, moments.area);
  }

  // From all of them.
  double final_cost(Index a, Index b) const {
    SurfaceMoments moments = clusters_[a].moments;
    moments += clusters_[b].moments;
    const Eigen::Matrix3d axes = moments.axes();
    Extents extents(axes);
    for (const Index cluster : {a, b}) {
      each_face(cluster, [&](Index face) {
        for (const Index corner : faces_.corners_of(face)) extents.extend(faces_.points[corner]);
      });
    }
    const Vec3 normal = turned(axes.col(extents.narrowest()), moments);
    double least = 1;
    for (const Index cluster : {a, b})
      each_face(cluster, [&](Index face) { least = std::min(least, cosine(face, normal)); });
    return cost_of(extents, least, moments.area);
  }

  void merge(Index kept, Index absorbed) {
    Cluster &to = clusters_[kept], &from = clusters_[absorbed];
    to.moments += from.moments;
    next_[to.last] = absorbed;
    to.last = from.last;
    to.points.insert(to.points.end(), from.points.begin(), from.points.end());
    to.normals.insert(to.normals.end(), from.normals.begin(), from.normals.end());
    thin(to.points, faces_.points);
    thin(to.normals, faces_.normals);
    from = {};
  }

 private:
  struct Cluster {
    SurfaceMoments moments;
    std::vector<Index> points, normals;  // all, or those that are farthest along some directions
    Index last = k_no_index;             // of its faces, which are a list from its own number on
  };

  double cosine(Index face, const Vec3& normal) const {
    const double cosine = faces_.normals[face].dot(normal);
    return options_.is_two_sided ? std::abs(cosine) : cosine;
  }

  // Of an error's level, and within it the waste.
  double cost_of(const Extents& extents, double least_cosine, double area) const {
    constexpr double k_infinity = std::numeric_limits<double>::infinity();
    const double waste = extents.rectangle() / area;
    const auto level = std::lower_bound(errors_.begin(), errors_.end(), extents.error());
    if (level == errors_.end() || waste > options_.largest_waste ||
        least_cosine < std::cos(options_.largest_deviation))
      return k_infinity;
    return waste + static_cast<double>(level - errors_.begin()) * options_.largest_waste;
  }

  template <typename Visit>
  void each_face(Index cluster, Visit&& visit) const {
    for (Index face = cluster; face != k_no_index; face = next_[face]) visit(face);
  }

  // Keeps what is farthest along directions, where there are more.
  static void thin(std::vector<Index>& items, const std::vector<Vec3>& places) {
    std::sort(items.begin(), items.end());
    items.erase(std::unique(items.begin(), items.end()), items.end());
    if (items.size() <= 2 * directions().size()) return;
    std::vector<Index> kept;
    for (const Vec3& direction : directions()) {
      const auto along = [&](Index a, Index b) {
        return places[a].dot(direction) < places[b].dot(direction);
      };
      const auto [least, most] = std::minmax_element(items.begin(), items.end(), along);
      kept.push_back(*least);
      kept.push_back(*most);
    }
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    items = std::move(kept);
  }

  const BillboardFaces& faces_;
  const BillboardOptions& options_;
  const std::vector<double>& errors_;  // in units of the model's size
  std::vector<Cluster> clusters_;
  std::vector<Index> next_;  // face of the same cluster
};

// As the tree wants them.
struct Middles {
  std::vector<Vec3> points;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][static_cast<int>(axis)]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

// The nearest others of each face, by their middles.
std::vector<std::pair<Index, Index>> neighbours_of(const BillboardFaces& faces, std::size_t n) {
  Middles middles;
  for (const SurfaceMoments& moments : faces.moments) middles.points.push_back(moments.first / moments.area);
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Middles>, Middles, 3, Index>;
  const Tree tree(3, middles, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  const std::size_t n_found = std::min(n + 1, faces.count());
  std::vector<Index> found(faces.count() * n_found);
  tbb::parallel_for(std::size_t{0}, faces.count(), [&](std::size_t i) {
    std::vector<double> squares(n_found);
    tree.knnSearch(middles.points[i].data(), n_found, found.data() + i * n_found, squares.data());
  });
  std::vector<std::pair<Index, Index>> pairs;
  for (std::size_t i = 0; i < faces.count(); ++i) {
    for (std::size_t k = 0; k < n_found; ++k) {
      const Index other = found[i * n_found + k];
      if (other != i) pairs.emplace_back(std::minmax(static_cast<Index>(i), other));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

// Of a cluster, along the axis in which it is narrowest.
Billboard billboard_of(const BillboardFaces& faces, const std::vector<Index>& members, bool is_two_sided) {
  SurfaceMoments moments;
  for (const Index face : members) moments += faces.moments[face];
  const Eigen::Matrix3d axes = moments.axes();
  Extents extents(axes);
  for (const Index face : members) {
    for (const Index corner : faces.corners_of(face)) extents.extend(faces.points[corner]);
  }
  return billboard_facing(faces, members, axes.col(extents.narrowest()), is_two_sided);
}

Agglomeration merge_faces(const BillboardFaces& faces, const BillboardOptions& options,
                          std::vector<double> errors, Progress* progress) {
  for (double& error : errors) error /= faces.size;
  FaceMerger merger(faces, options, errors);
  const std::vector<std::pair<Index, Index>> neighbours = neighbours_of(faces, options.n_neighbours);
  return agglomerate(faces.count(), neighbours, merger, {}, progress);
}

}  // namespace

std::vector<std::vector<Billboard>> cluster_faces(const BillboardFaces& faces,
                                                  const BillboardOptions& options,
                                                  std::span<const double> errors, Progress* progress) {
  const Agglomeration tree = merge_faces(faces, options, {errors.begin(), errors.end()}, progress);
  std::vector<std::vector<Billboard>> result;
  for (std::size_t level = 0; level < errors.size(); ++level) {
    const double limit = static_cast<double>(level + 1) * options.largest_waste;
    const auto beyond = std::find_if(tree.merges.begin(), tree.merges.end(),
                                     [&](const ClusterMerge& merge) { return merge.cost > limit; });
    const std::vector<Index> cluster_of =
        clusters_after(tree, static_cast<std::size_t>(beyond - tree.merges.begin()));
    std::vector<std::vector<Index>> members;
    for (Index face = 0; face < cluster_of.size(); ++face) {
      if (cluster_of[face] >= members.size()) members.resize(cluster_of[face] + 1);
      members[cluster_of[face]].push_back(face);
    }
    std::vector<Billboard>& billboards = result.emplace_back(members.size());
    tbb::parallel_for(std::size_t{0}, members.size(), [&](std::size_t i) {
      billboards[i] = billboard_of(faces, members[i], options.is_two_sided);
    });
  }
  return result;
}

}  // namespace recede::detail
