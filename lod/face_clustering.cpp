#include <recede/geometry/agglomerate.h>
#include <recede/geometry/detail/nearest_points.h>
#include <recede/lod/detail/face_clustering.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace recede::detail {

namespace {

// A box around points along given axes.
class Extents {
 public:
  explicit Extents(const Eigen::Matrix3d& axes) : to_axes_(axes.transpose()) {}

  void extend(const Vec3& point) { box_.extend(Vec3(to_axes_ * point)); }
  Vec3 axis(int number) const { return to_axes_.row(number).transpose(); }
  int narrowest() const {
    int axis = 0;
    box_.sizes().minCoeff(&axis);
    return axis;
  }
  double error(int axis) const { return box_.sizes()[axis] / 2; }
  double rectangle(int axis) const { return box_.sizes()[(axis + 1) % 3] * box_.sizes()[(axis + 2) % 3]; }

 private:
  Eigen::Matrix3d to_axes_;
  Box3 box_;
};

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

// Shares of a limit are kept free for rounding.
constexpr double k_rounding = 1e-12;
constexpr double k_infinity = std::numeric_limits<double>::infinity();

// The faces of a cluster and their points, one after the other in memory. A lone face needs none.
struct Members {
  std::vector<Index> faces, numbers;  // of points
  std::vector<Vec3> points;
  std::size_t n_points_once = 0;  // when repeated points went

  bool is_empty() const { return faces.empty(); }

  void add(Index face, const BillboardFaces& model) {
    faces.push_back(face);
    for (const Index corner : model.corners_of(face)) {
      numbers.push_back(corner);
      points.push_back(model.points[corner]);
    }
  }

  // Takes over those of another cluster. What has the most of them stays where it is.
  void take(Members& other, const BillboardFaces& model) {
    if (other.points.size() > points.size()) std::swap(*this, other);
    faces.insert(faces.end(), other.faces.begin(), other.faces.end());
    numbers.insert(numbers.end(), other.numbers.begin(), other.numbers.end());
    points.insert(points.end(), other.points.begin(), other.points.end());
    other = {};
    if (points.size() < 2 * n_points_once) return;
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    n_points_once = numbers.size();
    points.resize(n_points_once);
    for (std::size_t i = 0; i < n_points_once; ++i) points[i] = model.points[numbers[i]];
  }
};

// Faces near to each other get numbers near to each other: what is near is then near in memory too.
BillboardFaces in_order_of_space(const BillboardFaces& faces) {
  std::vector<std::pair<std::uint64_t, Index>> order;
  for (Index face = 0; face < faces.count(); ++face) {
    constexpr double k_cells = 1 << 16;  // along each axis, of a space from -1/2 to 1/2
    const Vec3 middle = faces.moments[face].first / faces.moments[face].area;
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cell =
          static_cast<std::uint64_t>(std::clamp((middle[axis] + 0.5) * k_cells, 0.0, k_cells - 1));
      for (int bit = 0; bit < 16; ++bit) code |= (cell >> bit & 1) << (3 * bit + axis);
    }
    order.emplace_back(code, face);
  }
  std::sort(order.begin(), order.end());
  BillboardFaces result;
  result.left_out = faces.left_out;
  result.center = faces.center;
  result.size = faces.size;
  std::vector<Index> places(faces.points.size(), k_no_index);
  for (const auto& [code, face] : order) {
    for (const Index corner : faces.corners_of(face)) {
      if (places[corner] == k_no_index) {
        places[corner] = static_cast<Index>(result.points.size());
        result.points.push_back(faces.points[corner]);
      }
      result.corners.push_back(places[corner]);
    }
    result.offsets.push_back(static_cast<Index>(result.corners.size()));
    result.numbers.push_back(faces.numbers[face]);
    result.normals.push_back(faces.normals[face]);
    result.moments.push_back(faces.moments[face]);
  }
  return result;
}

// Beside the waste, the source's cost, angles count too: by waste alone, patches become as round as they can,
// at any place of a bend, and then no two of them may merge.
constexpr double k_most_tilt = 8;
// Where a rectangle costs no more, another one isn't tried.
constexpr double k_good_enough = 3;

class FaceMerger {
 public:
  static constexpr bool k_costs_are_of_pairs_alone = true;

  FaceMerger(const BillboardFaces& faces, const BillboardOptions& options)
      : faces_(faces),
        options_(options),
        least_cosine_(std::cos(options.largest_deviation)),
        clusters_(faces_.count()) {
    for (Index face = 0; face < faces_.count(); ++face) {
      clusters_[face].moments = faces_.moments[face];
      clusters_[face].measure();
    }
  }

  /// In units of the model's size; it may grow from run to run.
  void allow(double error) { error_ = error; }

  const Vec3& middle(Index cluster) const { return clusters_[cluster].middle; }

  // From the farthest points and the most tilted normals of some directions: at most the cost.
  double cost(Index a, Index b) const { return fit(a, b, false).cost; }

  void costs(std::span<const std::pair<Index, Index>> pairs, std::span<double> costs) const {
    const auto compute = [&](std::size_t i) { costs[i] = cost(pairs[i].first, pairs[i].second); };
    // Below it threads cost more than they bring.
    constexpr std::size_t k_many = 1000;
    if (pairs.size() < k_many) {
      for (std::size_t i = 0; i < pairs.size(); ++i) compute(i);
    } else {
      tbb::parallel_for(std::size_t{0}, pairs.size(), compute);
    }
  }

  // From all of them.
  double final_cost(Index a, Index b) const { return fit(a, b, true).cost; }

  // Between the middle of one and the other, taken as a ball.
  double distance(Index cluster, Index other) const {
    const Cluster& far = clusters_[other];
    return (clusters_[cluster].middle - far.middle).norm() - far.radius;
  }

  /// Those of the clusters that merges made, in their order. Of long thin ones, two axes are as narrow, and
  /// other sums of the same faces would turn them.
  const std::vector<Vec3>& normals_of_merges() const { return normals_of_merges_; }

  void merge(Index kept, Index absorbed) {
    normals_of_merges_.push_back(fit(kept, absorbed, true).normal);
    Cluster &to = clusters_[kept], &from = clusters_[absorbed];
    std::vector<Vec3> points, normals;
    for (const Index cluster : {kept, absorbed}) {
      each_point(cluster, [&](const Vec3& point) { points.push_back(point); });
      each_normal(cluster, [&](const Vec3& normal) { normals.push_back(normal); });
    }
    thin(points);
    thin(normals);
    to.points = std::move(points);
    to.normals = std::move(normals);
    if (to.members.is_empty()) to.members.add(kept, faces_);
    if (from.members.is_empty()) from.members.add(absorbed, faces_);
    to.members.take(from.members, faces_);
    to.moments += from.moments;
    to.measure();
    from = {};
  }

 private:
  struct Cluster {
    SurfaceMoments moments;
    Vec3 middle = Vec3::Zero();
    double radius = 0;
    std::vector<Vec3> points, normals;  // those that are farthest along some directions; none: a face's
    Members members;

    void measure() {
      middle = moments.first / moments.area;
      radius = std::sqrt(std::max(0.0, moments.second.trace() / moments.area - middle.squaredNorm()));
    }
  };

  template <typename Visit>
  void each_point(Index cluster, Visit&& visit) const {
    for (const Vec3& point : clusters_[cluster].points) visit(point);
    if (!clusters_[cluster].points.empty()) return;
    for (const Index corner : faces_.corners_of(cluster)) visit(faces_.points[corner]);
  }
  template <typename Visit>
  void each_normal(Index cluster, Visit&& visit) const {
    for (const Vec3& normal : clusters_[cluster].normals) visit(normal);
    if (clusters_[cluster].normals.empty()) visit(faces_.normals[cluster]);
  }

  // What a rectangle for two clusters costs.
  struct Fit {
    Vec3 normal = Vec3::Zero();
    double cost = k_infinity;
  };

  // The cheaper one of two: across the narrowest axis of all faces, and as they face.
  Fit fit(Index a, Index b, bool is_final) const {
    SurfaceMoments moments = clusters_[a].moments;
    moments += clusters_[b].moments;
    Eigen::Matrix3d axes = moments.axes();
    const Extents narrow = extents(a, b, axes, is_final);
    const int axis = narrow.narrowest();
    const Fit across = rated(a, b, narrow, axis, moments, is_final);
    if (across.cost < k_good_enough) return across;
    const Vec3 facing = facing_of(a, b, across.normal);
    const Vec3 wide = axes.col(2);
    Vec3 u = wide - wide.dot(facing) * facing;
    if (!(u.norm() > 0.1)) u = facing.unitOrthogonal();
    u.normalize();
    axes << facing, u, facing.cross(u);
    const Fit toward = rated(a, b, extents(a, b, axes, is_final), 0, moments, is_final);
    return toward.cost < across.cost ? toward : across;
  }

  Extents extents(Index a, Index b, const Eigen::Matrix3d& axes, bool is_final) const {
    Extents extents(axes);
    for (const Index cluster : {a, b}) {
      each_point(cluster, [&](const Vec3& point) { extents.extend(point); });
      if (!is_final) continue;
      for (const Vec3& point : clusters_[cluster].members.points) extents.extend(point);
    }
    return extents;
  }

  Fit rated(Index a, Index b, const Extents& extents, int axis, const SurfaceMoments& moments,
            bool is_final) const {
    Fit fit{extents.axis(axis)};
    if (moments.normal.dot(fit.normal) < 0) fit.normal = -fit.normal;
    const double waste = extents.rectangle(axis) / moments.area;
    if (extents.error(axis) > error_ || waste > options_.largest_waste) return fit;
    double least = 1;
    for (const Index cluster : {a, b}) {
      if (is_final) {
        least = std::min(least, least_cosine_of(cluster, fit.normal));
      } else {
        each_normal(cluster,
                    [&](const Vec3& normal) { least = std::min(least, cosine(normal, fit.normal)); });
      }
    }
    if (least >= least_cosine_) fit.cost = waste + tilt(least);
    return fit;
  }

  // About the axis of the narrowest cone around their normals.
  Vec3 facing_of(Index a, Index b, const Vec3& start) const {
    constexpr int k_steps = 8;
    Vec3 axis = start;
    for (int step = 0; step < k_steps; ++step) {
      Vec3 farthest = axis;
      double least = 2;
      for (const Index cluster : {a, b}) {
        each_normal(cluster, [&](const Vec3& normal) {
          const double at = normal.dot(axis);
          const bool is_turned = options_.is_two_sided && at < 0;
          if ((is_turned ? -at : at) >= least) return;
          least = is_turned ? -at : at;
          farthest = is_turned ? Vec3(-normal) : normal;
        });
      }
      const Vec3 next = axis + (farthest - axis) / (step + 2);
      if (!(next.norm() > 0)) break;  // they face apart
      axis = next.normalized();
    }
    return axis;
  }

  double cosine(const Vec3& of_face, const Vec3& normal) const {
    const double cosine = of_face.dot(normal);
    return options_.is_two_sided ? std::abs(cosine) : cosine;
  }

  // Of the angles between a normal and those of the faces.
  double least_cosine_of(Index cluster, const Vec3& normal) const {
    const Members& members = clusters_[cluster].members;
    if (members.is_empty()) return cosine(faces_.normals[cluster], normal);
    double least = 1;
    for (const Index face : members.faces) least = std::min(least, cosine(faces_.normals[face], normal));
    return least;
  }

  // What the largest angle adds to a cost: flat parts grow along themselves first, and around bends last.
  double tilt(double least_cosine) const {
    return least_cosine_ < 1 ? k_most_tilt * (1 - least_cosine) / (1 - least_cosine_) : 0;
  }

  // Keeps what is farthest along directions, where there are more.
  static void thin(std::vector<Vec3>& items) {
    const auto less = [](const Vec3& a, const Vec3& b) {
      return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
    };
    std::sort(items.begin(), items.end(), less);
    items.erase(std::unique(items.begin(), items.end()), items.end());
    if (items.size() <= 2 * directions().size()) return;
    std::vector<unsigned char> is_kept(items.size(), 0);
    for (const Vec3& direction : directions()) {
      std::size_t least = 0, most = 0;
      double low = std::numeric_limits<double>::infinity(), high = -low;
      for (std::size_t i = 0; i < items.size(); ++i) {
        const double at = items[i].dot(direction);
        if (at < low) low = at, least = i;
        if (at > high) high = at, most = i;
      }
      is_kept[least] = is_kept[most] = 1;
    }
    std::size_t n = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (is_kept[i]) items[n++] = items[i];
    }
    items.resize(n);
  }

  const BillboardFaces& faces_;
  const BillboardOptions& options_;
  double least_cosine_;
  double error_ = 0;
  std::vector<Cluster> clusters_;
  std::vector<Vec3> normals_of_merges_;
};

// The nearest others of each cluster, by their middles.
std::vector<std::pair<Index, Index>> neighbours_of(const FaceMerger& merger,
                                                   const std::vector<Index>& clusters, std::size_t n) {
  std::vector<Vec3> middles;
  for (const Index cluster : clusters) middles.push_back(merger.middle(cluster));
  const NearestPoints nearest(middles);
  const std::size_t n_found = std::min(n + 1, clusters.size());
  std::vector<Index> found(clusters.size() * n_found);
  tbb::parallel_for(std::size_t{0}, clusters.size(), [&](std::size_t i) {
    Index* const row = found.data() + i * n_found;
    nearest.find(middles[i], {row, n_found});
    std::sort(row, row + n_found);
  });
  const auto finds = [&](Index place, Index other) {
    const Index* const row = found.data() + place * n_found;
    return std::binary_search(row, row + n_found, other);
  };
  // A pair is the lower one's, or the other's where only that finds it.
  const auto each_pair_of = [&](Index place, auto&& visit) {
    for (std::size_t k = 0; k < n_found; ++k) {
      const Index other = found[place * n_found + k];
      if (other > place || (other < place && !finds(other, place))) visit(other);
    }
  };
  std::vector<std::size_t> starts(clusters.size() + 1, 0);
  tbb::parallel_for(std::size_t{0}, clusters.size(), [&](std::size_t i) {
    each_pair_of(static_cast<Index>(i), [&](Index) { ++starts[i + 1]; });
  });
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  std::vector<std::pair<Index, Index>> pairs(starts.back());
  tbb::parallel_for(std::size_t{0}, clusters.size(), [&](std::size_t i) {
    std::size_t next = starts[i];
    each_pair_of(static_cast<Index>(i), [&](Index other) { pairs[next++] = {clusters[i], clusters[other]}; });
  });
  return pairs;
}

// Of one face, that faces as it does, unless its corners are too far from a plane; then along its narrowest
// axis.
Billboard billboard_of_one(const BillboardFaces& faces, Index face, bool is_two_sided, double error) {
  const std::array<Index, 1> members{face};
  Billboard billboard = billboard_facing(faces, members, faces.normals[face], is_two_sided);
  if (billboard.error <= error) return billboard;
  Extents extents(faces.moments[face].axes());
  for (const Index corner : faces.corners_of(face)) extents.extend(faces.points[corner]);
  return billboard_facing(faces, members, extents.axis(extents.narrowest()), is_two_sided);
}

// One bar for the merging of all errors.
class RoundProgress final : public Progress {
 public:
  RoundProgress(Progress* all, std::size_t n_faces) : all_(all), n_faces_(n_faces) {}

  void start_round(std::size_t n_merged) { before_ = n_merged; }
  void update(std::string_view stage, double fraction) override {
    const double merged = stage == k_merging_clusters ? fraction : 0;
    fraction_ = std::max(fraction_, merged + static_cast<double>(before_) / static_cast<double>(n_faces_));
    if (all_ != nullptr) all_->update("merging faces", std::min(1.0, fraction_));
  }
  bool cancel_requested() const override { return all_ != nullptr && all_->cancel_requested(); }

 private:
  Progress* all_;
  std::size_t n_faces_, before_ = 0;
  double fraction_ = 0;
};

struct FaceMerges {
  Agglomeration tree;
  std::vector<std::size_t> ends;  // how many merges there are up to each error
  std::vector<Vec3> normals;      // of the clusters that merges make
};

// Clusters that have grown have other neighbours than their faces had, so they are looked for again: at each
// error, and at the first one a second time.
FaceMerges merge_faces(const BillboardFaces& faces, const BillboardOptions& options,
                       std::span<const double> errors, Progress* progress) {
  FaceMerger merger(faces, options);
  std::vector<Index> clusters(faces.count());
  std::iota(clusters.begin(), clusters.end(), Index{0});
  std::vector<unsigned char> is_absorbed(faces.count(), 0);
  RoundProgress rounds(progress, faces.count());
  FaceMerges result;
  result.tree.n_items = faces.count();
  const auto merge_neighbours = [&] {
    rounds.start_round(result.tree.merges.size());
    const Agglomeration merges =
        agglomerate(faces.count(), neighbours_of(merger, clusters, options.n_neighbours), merger,
                    {.most_neighbours = options.n_neighbours}, &rounds);
    for (const ClusterMerge& merge : merges.merges) {
      result.tree.merges.push_back(merge);
      is_absorbed[merge.absorbed] = 1;
    }
    std::erase_if(clusters, [&](Index cluster) { return is_absorbed[cluster] != 0; });
  };
  for (const double error : errors) {
    merger.allow(error * (1 - k_rounding) / faces.size);
    merge_neighbours();
    if (result.ends.empty()) merge_neighbours();
    result.ends.push_back(result.tree.merges.size());
  }
  result.normals = merger.normals_of_merges();
  return result;
}

}  // namespace

std::vector<std::vector<Billboard>> cluster_faces(const BillboardFaces& model,
                                                  const BillboardOptions& options,
                                                  std::span<const double> errors, Progress* progress) {
  const BillboardFaces faces = in_order_of_space(model);
  const FaceMerges merged = merge_faces(faces, options, errors, progress);
  const Agglomeration& tree = merged.tree;
  std::vector<std::vector<Billboard>> result;
  for (std::size_t level = 0; level < errors.size(); ++level) {
    const std::size_t n_merges = merged.ends[level];
    const std::vector<Index> cluster_of = clusters_after(tree, n_merges);
    // A cluster is kept under the number of its first face.
    std::vector<std::size_t> last_merge(faces.count(), tree.merges.size());
    for (std::size_t m = 0; m < n_merges; ++m) last_merge[tree.merges[m].kept] = m;
    std::vector<std::vector<Index>> members;
    for (Index face = 0; face < cluster_of.size(); ++face) {
      if (cluster_of[face] >= members.size()) members.resize(cluster_of[face] + 1);
      members[cluster_of[face]].push_back(face);
    }
    std::vector<Billboard>& billboards = result.emplace_back(members.size());
    tbb::parallel_for(std::size_t{0}, members.size(), [&](std::size_t i) {
      const Index first = members[i].front();
      billboards[i] =
          members[i].size() == 1
              ? billboard_of_one(faces, first, options.is_two_sided, errors[level])
              : billboard_facing(faces, members[i], merged.normals[last_merge[first]], options.is_two_sided);
    });
  }
  return result;
}

}  // namespace recede::detail
