#include <recede/shells/detail/lp_tree.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

namespace recede::detail {
namespace {

using Mat3 = Eigen::Matrix3d;

/// A part of the surface.
struct Part {
  double mass = 0;
  Vec3 centroid = Vec3::Zero();
  Mat3 second = Mat3::Zero();  ///< integral of (y - centroid) (y - centroid)^T
  Box3 box;
};

Part part_of(const LpElement& element) {
  Part part;
  part.mass = element.mass;
  part.centroid = element.centroid();
  for (const Vec3& corner : element.corners) {
    const Vec3 r = corner - part.centroid;
    part.second += element.mass / 12 * r * r.transpose();
    part.box.extend(corner);
  }
  return part;
}

Part joined(std::span<const Part> parts) {
  Part whole;
  for (const Part& part : parts) {
    whole.mass += part.mass;
    whole.centroid += part.mass * part.centroid;
    whole.box.extend(part.box);
  }
  whole.centroid /= whole.mass;
  for (const Part& part : parts) {
    const Vec3 r = part.centroid - whole.centroid;
    whole.second += part.second + part.mass * r * r.transpose();
  }
  return whole;
}

/// The least distance from which on the bound of the terms left out is at most `error` times a part's
/// integral. The n-th term of |c + v - x|^-p in v is at most binomial(n + p - 1, n) |v|^n / D^(n + p), that
/// of Gegenbauer's polynomials, so that the remainder is at most the term of order n with D - radius for D.
/// And the integral is at least mass (D^2 + second / mass)^(-p / 2), as z^(-p / 2) is convex and D^2 + second
/// / mass is the mean of the squared distances: better than by the farthest point.
double reach_for(double error, double p, int order, double mass, double radius, double second,
                 double remainder) {
  if (!(remainder > 0)) return 0;
  double factor = 1;
  for (int k = 0; k < order; ++k) factor *= (p + k) / (k + 1);
  const double spread = second / mass / (radius * radius), rest = remainder / mass / std::pow(radius, order);
  // In radii; the bound's share falls with the distance.
  const auto is_far = [&](double distance) {
    const double bound = std::log(factor * rest) - (p + order) * std::log(distance - 1);
    return bound <= std::log(error) - 0.5 * p * std::log(distance * distance + spread);
  };
  double near = 1, far = 2;
  while (!is_far(far)) {
    near = far;
    far *= 2;
  }
  constexpr int k_halvings = 30;
  for (int k = 0; k < k_halvings; ++k) {
    const double middle = 0.5 * (near + far);
    (is_far(middle) ? far : near) = middle;
  }
  return far * radius;
}

class Builder {
 public:
  Builder(LpTree& tree, std::vector<LpElement> elements, const LpTreeOptions& options)
      : tree_(tree), elements_(std::move(elements)), options_(options), order_(elements_.size()) {
    std::iota(order_.begin(), order_.end(), Index{0});
    centroids_.reserve(elements_.size());
    for (const LpElement& element : elements_) centroids_.push_back(element.centroid());
    // A bound of what was left out is told relative to what was computed, so a bit less is allowed.
    if (options_.error > 0) options_.error /= 1 + 2 * options_.error;
  }

  Part build(std::size_t first, std::size_t last) {
    const auto index = tree_.nodes.size();
    tree_.nodes.push_back(empty_node());
    tree_.extents.emplace_back();
    std::array<std::size_t, k_lp_lanes + 1> bounds{};
    const std::size_t n = split_in_four(first, last, bounds);
    std::array<Part, k_lp_lanes> parts;
    for (std::size_t lane = 0; lane < n; ++lane) {
      const std::size_t from = bounds[lane], to = bounds[lane + 1];
      if (to - from <= k_lp_lanes) {
        tree_.nodes[index].child[lane] = k_lp_leaf_bit | static_cast<Index>(tree_.blocks.size());
        parts[lane] = add_leaf(from, to);
      } else {
        tree_.nodes[index].child[lane] = static_cast<Index>(tree_.nodes.size());
        parts[lane] = build(from, to);
      }
      describe(index, lane, parts[lane], from, to);
    }
    return joined(std::span(parts).first(n));
  }

 private:
  static LpNode empty_node() {
    // Nothing, and so far away that no query is there, where 0 times infinity would be something; near enough
    // for distances of four children to be multiplied.
    constexpr double k_nowhere = 1e60;
    LpNode node{};
    std::fill(std::begin(node.center[0]), std::end(node.center[0]), k_nowhere);
    std::fill(std::begin(node.squared_reach), std::end(node.squared_reach), -1.0);
    return node;
  }

  /// Halves at the median of the longest axis of the centroids, twice; all leaves but the last are full.
  std::size_t split_in_four(std::size_t first, std::size_t last,
                            std::array<std::size_t, k_lp_lanes + 1>& bounds) {
    const std::size_t middle = split(first, last);
    std::size_t n = 0;
    bounds[n++] = first;
    for (const std::size_t bound : {split(first, middle), middle, split(middle, last), last}) {
      if (bound > bounds[n - 1]) bounds[n++] = bound;
    }
    return n - 1;
  }

  /// Where the second half begins: at `last` when there is but one leaf.
  std::size_t split(std::size_t first, std::size_t last) {
    const std::size_t leaves = (last - first + k_lp_lanes - 1) / k_lp_lanes;
    if (leaves < 2) return last;
    const std::size_t middle = first + (leaves + 1) / 2 * k_lp_lanes;
    Box3 box;
    for (std::size_t i = first; i < last; ++i) box.extend(centroids_[order_[i]]);
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto at = [&](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(first), at(middle), at(last), [&](Index a, Index b) {
      const double x = centroids_[a][axis], y = centroids_[b][axis];
      return x != y ? x < y : a < b;
    });
    return middle;
  }

  Part add_leaf(std::size_t first, std::size_t last) {
    LpBlock block{};
    std::array<Part, k_lp_lanes> parts;
    for (std::size_t lane = 0; lane < k_lp_lanes; ++lane) {
      // Empty lanes are a triangle that is somewhere, and whose area of zero takes it out.
      const LpElement& element = elements_[order_[std::min(first + lane, last - 1)]];
      const bool is_empty = first + lane >= last;
      const Vec3 normal =
          (element.corners[1] - element.corners[0]).cross(element.corners[2] - element.corners[0]);
      const double twice_area = normal.norm();
      for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        for (std::size_t corner = 0; corner < 3; ++corner)
          block.corners[corner][k][lane] = element.corners[corner][axis];
        block.normal[k][lane] = twice_area > 0 ? normal[axis] / twice_area : 0;
      }
      block.twice_area[lane] = is_empty ? 0 : twice_area;
      block.mass[lane] = is_empty ? 0 : element.mass;
      if (!is_empty) parts[lane] = part_of(element);
    }
    tree_.blocks.push_back(block);
    return joined(std::span(parts).first(last - first));
  }

  void describe(std::size_t index, std::size_t lane, const Part& part, std::size_t first, std::size_t last) {
    // Around the balls of its elements, by whose nearest points supports ask.
    double radius = 0;
    for (std::size_t i = first; i < last; ++i) {
      const Vec3& centroid = centroids_[order_[i]];
      double reach = 0;
      for (const Vec3& corner : elements_[order_[i]].corners)
        reach = std::max(reach, (corner - centroid).squaredNorm());
      radius = std::max(radius, (centroid - part.centroid).norm() + std::sqrt(reach));
    }
    const double second = part.second.trace();
    LpNodeExtent& extent = tree_.extents[index];
    extent.radius[lane] = radius;
    extent.remainder[lane] = options_.quadrupole ? radius * second : second;
    LpNode& node = tree_.nodes[index];
    for (std::size_t k = 0; k < 3; ++k) node.center[k][lane] = part.centroid[static_cast<Eigen::Index>(k)];
    node.mass[lane] = part.mass;
    const double p = options_.p;
    const double reach = options_.error > 0 ? reach_for(options_.error, p, tree_.first_order_left_out(),
                                                        part.mass, radius, second, extent.remainder[lane])
                                            : options_.opening * part.box.diagonal().norm();
    // Infinity times nothing: a single point under an opening that sums nothing up.
    node.squared_reach[lane] = std::isnan(reach) ? std::numeric_limits<double>::infinity() : reach * reach;
    if (!options_.quadrupole) return;
    const Mat3 tensor = 0.5 * p * ((p + 2) * part.second - second * Mat3::Identity());
    const double entries[6] = {tensor(0, 0), tensor(1, 1), tensor(2, 2),
                               tensor(0, 1), tensor(0, 2), tensor(1, 2)};
    for (std::size_t k = 0; k < 6; ++k) node.tensor[k][lane] = entries[k];
  }

  LpTree& tree_;
  std::vector<LpElement> elements_;
  LpTreeOptions options_;
  std::vector<Index> order_;
  std::vector<Vec3> centroids_;
};

}  // namespace

LpTree::LpTree(std::vector<LpElement> elements, const LpTreeOptions& options)
    : quadrupole(options.quadrupole) {
  const std::size_t n = elements.size();
  blocks.reserve(n / k_lp_lanes + 1);
  nodes.reserve(n / (2 * k_lp_lanes) + 1);
  Builder(*this, std::move(elements), options).build(0, n);
}

std::vector<LpFade> fades_of(const LpTree& tree, double support) {
  std::vector<LpFade> fades(tree.nodes.size());
  for (std::size_t i = 0; i < fades.size(); ++i) {
    for (std::size_t lane = 0; lane < k_lp_lanes; ++lane) {
      const double radius = tree.extents[i].radius[lane];
      const double full = support - radius, end = k_lp_fade_end * support + radius;
      LpFade& fade = fades[i];
      fade.squared_full[lane] = full > 0 ? full * full : 0;
      // Of a lane without a child: nowhere.
      fade.squared_end[lane] = tree.nodes[i].mass[lane] > 0 ? end * end : -1;
      fade.squared_limit[lane] = radius < k_lp_fading_part * support ? std::numeric_limits<double>::infinity()
                                                                     : fade.squared_full[lane];
    }
  }
  return fades;
}

}  // namespace recede::detail
