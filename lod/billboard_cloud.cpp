#include <recede/geometry/agglomerate.h>
#include <recede/geometry/error.h>
#include <recede/lod/billboard_cloud.h>
#include <recede/lod/detail/surface_moments.h>

#include <nanoflann.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace recede {

namespace {

using detail::SurfaceMoments;

// Faces with an area, as they are clustered: around the middle of the model, in units of its size.
struct Faces {
  std::vector<Vec3> points;
  std::vector<Index> numbers;     // in the model
  std::vector<Index> offsets{0};  // face i has corners [offsets[i], offsets[i + 1])
  std::vector<Index> corners;
  std::vector<Vec3> normals;
  std::vector<SurfaceMoments> moments;
  std::size_t left_out = 0;

  std::size_t size() const { return numbers.size(); }
  std::span<const Index> corners_of(Index face) const {
    return {corners.data() + offsets[face], offsets[face + 1] - offsets[face]};
  }
};

Faces faces_of(const PolygonSoup& model, const Vec3& center, double size) {
  Faces faces;
  for (const Vec3& point : model.positions) faces.points.push_back((point - center) / size);
  std::vector<Index> of_triangles;
  const std::vector<Index> triangles = triangulate(model, &of_triangles);
  std::vector<SurfaceMoments> moments(model.n_faces());
  for (std::size_t t = 0; t < of_triangles.size(); ++t) {
    moments[of_triangles[t]].add(faces.points[triangles[3 * t]], faces.points[triangles[3 * t + 1]],
                                 faces.points[triangles[3 * t + 2]]);
  }
  for (std::size_t face = 0; face < model.n_faces(); ++face) {
    const SurfaceMoments& here = moments[face];
    if (!(here.area > 0)) {
      ++faces.left_out;
      continue;
    }
    faces.numbers.push_back(static_cast<Index>(face));
    for (const Index corner : model.face(face)) faces.corners.push_back(corner);
    faces.offsets.push_back(static_cast<Index>(faces.corners.size()));
    faces.normals.push_back(here.normal.normalized());
    faces.moments.push_back(here);
  }
  return faces;
}

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
  FaceMerger(const Faces& faces, const BillboardOptions& options, const std::vector<double>& errors)
      : faces_(faces), options_(options), errors_(errors), clusters_(faces.size()), next_(faces.size()) {
    for (Index face = 0; face < faces.size(); ++face) {
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

  const Faces& faces_;
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
std::vector<std::pair<Index, Index>> neighbours_of(const Faces& faces, std::size_t n) {
  Middles middles;
  for (const SurfaceMoments& moments : faces.moments) middles.points.push_back(moments.first / moments.area);
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Middles>, Middles, 3, Index>;
  const Tree tree(3, middles, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  const std::size_t n_found = std::min(n + 1, faces.size());
  std::vector<Index> found(faces.size() * n_found);
  tbb::parallel_for(std::size_t{0}, faces.size(), [&](std::size_t i) {
    std::vector<double> squares(n_found);
    tree.knnSearch(middles.points[i].data(), n_found, found.data() + i * n_found, squares.data());
  });
  std::vector<std::pair<Index, Index>> pairs;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t k = 0; k < n_found; ++k) {
      const Index other = found[i * n_found + k];
      if (other != i) pairs.emplace_back(std::minmax(static_cast<Index>(i), other));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

Billboard billboard_of(const Faces& faces, const std::vector<Index>& members, const BillboardOptions& options,
                       const Vec3& center, double size) {
  SurfaceMoments moments;
  for (const Index face : members) moments += faces.moments[face];
  const Eigen::Matrix3d axes = moments.axes();
  Extents extents(axes);
  for (const Index face : members) {
    for (const Index corner : faces.corners_of(face)) extents.extend(faces.points[corner]);
  }
  const int narrow = extents.narrowest();
  const Vec3 normal = turned(axes.col(narrow), moments);
  const int wide = extents.box().sizes()[(narrow + 1) % 3] >= extents.box().sizes()[(narrow + 2) % 3]
                       ? (narrow + 1) % 3
                       : (narrow + 2) % 3;
  const int other = 3 - narrow - wide;
  Billboard result;
  result.axis_u = axes.col(wide);
  result.axis_v = normal.cross(result.axis_u);
  result.half_sizes = size / 2 * Vec2(extents.box().sizes()[wide], extents.box().sizes()[other]);
  result.center = center + size * (axes * extents.box().center());
  result.error = size * extents.error();
  result.face_area = size * size * moments.area;
  double least = 1;
  for (const Index face : members) {
    const double cosine = faces.normals[face].dot(normal);
    least = std::min(least, options.is_two_sided ? std::abs(cosine) : cosine);
    result.faces.push_back(faces.numbers[face]);
  }
  result.normal_deviation = std::acos(std::clamp(least, -1.0, 1.0));
  return result;
}

void check(const BillboardOptions& options) {
  double last = 0;
  for (const double error : options.errors) {
    if (!(error > last && std::isfinite(error)))
      throw OptionError("errors of billboard clouds are above 0 and increase");
    last = error;
  }
  if (!(options.largest_deviation >= 0 && options.largest_deviation <= std::numbers::pi))
    throw OptionError("the largest deviation of normals is between 0 and 180 degrees");
  if (!(options.largest_waste >= 1)) throw OptionError("the largest waste of billboards is at least 1");
  if (options.n_neighbours < 1) throw OptionError("faces need a neighbour at least");
}

}  // namespace

std::vector<BillboardCloud> build_billboard_clouds(const PolygonSoup& model, const BillboardOptions& options,
                                                   Progress* progress) {
  check(options);
  validate(model, "billboard cloud");
  Box3 box;
  for (const Index corner : model.corner_vertices) box.extend(model.positions[corner]);
  const double size = box.isEmpty() ? 0 : box.sizes().maxCoeff();
  if (!(size > 0)) throw InputError("a billboard cloud needs faces with an area");
  std::vector<double> errors = options.errors;
  if (errors.empty()) errors = {0.005 * size, 0.01 * size, 0.02 * size, 0.04 * size};
  const Faces faces = faces_of(model, box.center(), size);
  if (faces.size() == 0) throw InputError("a billboard cloud needs faces with an area");
  std::vector<double> scaled;
  for (const double error : errors) scaled.push_back(error / size);
  FaceMerger merger(faces, options, scaled);
  const Agglomeration tree =
      agglomerate(faces.size(), neighbours_of(faces, options.n_neighbours), merger, {}, progress);
  std::vector<BillboardCloud> clouds;
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
    BillboardCloud& cloud = clouds.emplace_back();
    cloud.error = errors[level];
    cloud.left_out = faces.left_out;
    cloud.billboards.resize(members.size());
    tbb::parallel_for(std::size_t{0}, members.size(), [&](std::size_t i) {
      cloud.billboards[i] = billboard_of(faces, members[i], options, box.center(), size);
    });
  }
  return clouds;
}

}  // namespace recede
