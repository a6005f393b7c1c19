#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/geometry/sheared_line.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recede {
namespace {

constexpr std::size_t k_leaf_size = 4;
constexpr Index k_leaf_bit = 0x80000000u;
constexpr Index k_leaf_count_shift = 28;  // three bits of count, 2^28 triangles
constexpr Index k_leaf_first_mask = (Index{1} << k_leaf_count_shift) - 1;

double squared_distance_to_box(const Vec3& p, const Vec3& lower, const Vec3& upper) {
  return (lower - p).cwiseMax(p - upper).cwiseMax(0.0).squaredNorm();
}

Vec3 closest_point_on_sides(const Vec3& p, const Triangle& t) {
  const Vec3 candidates[3] = {closest_point_on_segment(p, t.a, t.b), closest_point_on_segment(p, t.b, t.c),
                              closest_point_on_segment(p, t.c, t.a)};
  return *std::min_element(std::begin(candidates), std::end(candidates), [&](const Vec3& x, const Vec3& y) {
    return (x - p).squaredNorm() < (y - p).squaredNorm();
  });
}

}  // namespace

Vec3 closest_point_on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length = d.squaredNorm();
  if (!(length > 0)) return a;
  return a + std::clamp((p - a).dot(d) / length, 0.0, 1.0) * d;
}

Vec3 closest_point_on_triangle(const Vec3& p, const Triangle& t) {
  const Vec3 ab = t.b - t.a, ac = t.c - t.a, ap = p - t.a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t.a;
  const Vec3 bp = p - t.b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t.b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return d1 - d3 > 0 ? Vec3(t.a + d1 / (d1 - d3) * ab) : t.a;
  const Vec3 cp = p - t.c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t.c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return d2 - d6 > 0 ? Vec3(t.a + d2 / (d2 - d6) * ac) : t.a;
  const double va = d3 * d6 - d5 * d4;
  const double sum = (d4 - d3) + (d5 - d6);
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return sum > 0 ? Vec3(t.b + (d4 - d3) / sum * (t.c - t.b)) : t.b;
  // Slivers: the three areas are noise of the same size as their sum, so the sides decide.
  const double area = va + vb + vc;
  const double scale = ab.squaredNorm() * ac.squaredNorm();
  constexpr double k_sliver = 1e-24;  // of (twice the area)^2 against the product of squared sides
  if (!(area > k_sliver * scale)) return closest_point_on_sides(p, t);
  return t.a + ab * (vb / area) + ac * (vc / area);
}

ClosestPointTree::ClosestPointTree(const std::vector<Vec3>& positions, const std::vector<Index>& triangles) {
  const std::size_t n = triangles.size() / 3;
  if (n > k_leaf_first_mask) throw InputError(fmt::format("{} triangles are more than 2^28", n));
  std::vector<Vec3> centers(n);
  triangles_.resize(n);
  for (std::size_t t = 0; t < n; ++t) {
    triangles_[t] = {positions[triangles[3 * t]], positions[triangles[3 * t + 1]],
                     positions[triangles[3 * t + 2]]};
    centers[t] = (triangles_[t].a + triangles_[t].b + triangles_[t].c) / 3;
  }
  number_.resize(n);
  std::iota(number_.begin(), number_.end(), Index{0});
  nodes_.reserve(n / 2 + 1);
  Box3 box;
  if (n <= k_leaf_size) {
    // The root is a node like any other: its second child is an empty leaf that no point is near to.
    const double far = std::numeric_limits<double>::infinity();
    nodes_.push_back({{Vec3::Constant(-far), Vec3::Constant(far)},
                      {Vec3::Constant(far), Vec3::Constant(far)},
                      {k_leaf_bit | static_cast<Index>(n) << k_leaf_count_shift, k_leaf_bit}});
  } else {
    build(number_, centers, 0, n, box);
  }
  std::vector<Triangle> ordered(n);
  place_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    ordered[i] = triangles_[number_[i]];
    place_[number_[i]] = static_cast<Index>(i);
  }
  triangles_ = std::move(ordered);
}

/// Splits at the median of the longest axis of the centres: depth stays logarithmic whatever the input.
Index ClosestPointTree::build(std::vector<Index>& order, const std::vector<Vec3>& centers, std::size_t first,
                              std::size_t last, Box3& box) {
  if (last - first <= k_leaf_size) {
    for (std::size_t i = first; i < last; ++i) {
      const Triangle& t = triangles_[order[i]];
      box.extend(t.a).extend(t.b).extend(t.c);
    }
    return k_leaf_bit | static_cast<Index>(last - first) << k_leaf_count_shift | static_cast<Index>(first);
  }
  Box3 center_box;
  for (std::size_t i = first; i < last; ++i) center_box.extend(centers[order[i]]);
  Eigen::Index axis = 0;
  center_box.sizes().maxCoeff(&axis);
  const std::size_t middle = first + (last - first) / 2;
  const auto begin = order.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(last), [&](Index x, Index y) {
                     return centers[x][axis] != centers[y][axis] ? centers[x][axis] < centers[y][axis]
                                                                 : x < y;
                   });
  const auto index = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  Box3 boxes[2];
  const Index left = build(order, centers, first, middle, boxes[0]);
  const Index right = build(order, centers, middle, last, boxes[1]);
  Node& node = nodes_[index];
  for (int side = 0; side < 2; ++side) {
    node.lower[side] = boxes[side].min();
    node.upper[side] = boxes[side].max();
    box.extend(boxes[side]);
  }
  node.child[0] = left;
  node.child[1] = right;
  return index;
}

/// Visits subtrees nearest first and keeps the best hit. `may_enter(node)` and `may_test(place of a
/// triangle)` leave parts of the tree out.
template <typename MayEnter, typename MayTest>
void ClosestPointTree::descend(const Vec3& p, Hit& best, MayEnter&& may_enter, MayTest&& may_test) const {
  struct Pending {
    Index node;
    double distance;
  };
  Pending stack[64];  // median splits: the depth is at most log2 of the number of triangles
  int top = 0;
  stack[top++] = {0, 0};
  while (top > 0) {
    const Pending pending = stack[--top];
    if (pending.distance >= best.squared_distance) continue;
    if ((pending.node & k_leaf_bit) != 0) {
      const Index first = pending.node & k_leaf_first_mask;
      const Index count = (pending.node & ~k_leaf_bit) >> k_leaf_count_shift;
      for (Index i = first; i < first + count; ++i) {
        if (!may_test(i)) continue;
        const Vec3 point = closest_point_on_triangle(p, triangles_[i]);
        const double distance = (point - p).squaredNorm();
        if (distance < best.squared_distance) best = {distance, number_[i], point};
      }
      continue;
    }
    if (!may_enter(pending.node)) continue;
    const Node& node = nodes_[pending.node];
    const double left = squared_distance_to_box(p, node.lower[0], node.upper[0]);
    const double right = squared_distance_to_box(p, node.lower[1], node.upper[1]);
    const int near = right < left ? 1 : 0;
    const double far_distance = near == 1 ? left : right;
    if (far_distance < best.squared_distance) stack[top++] = {node.child[1 - near], far_distance};
    stack[top++] = {node.child[near], near == 1 ? right : left};
  }
}

ClosestPointTree::Hit ClosestPointTree::closest(const Vec3& p, Index hint) const {
  Hit best;
  if (hint != k_no_index) {
    const Vec3 point = closest_point_on_triangle(p, triangle(hint));
    best = {(point - p).squaredNorm(), hint, point};
  }
  const auto always = [](Index) { return true; };
  descend(p, best, always, always);
  return best;
}

std::vector<ClosestPointTree::Hit> ClosestPointTree::closest_within(const Vec3& p, double distance) const {
  const double limit = distance * distance;
  std::vector<Hit> hits;
  // The search leaves out what isn't nearer than this, and never finds anything better.
  Hit nothing;
  nothing.squared_distance = std::nextafter(limit, std::numeric_limits<double>::infinity());
  descend(
      p, nothing, [](Index) { return true; },
      [&](Index place) {
        const Vec3 point = closest_point_on_triangle(p, triangles_[place]);
        const double squared = (point - p).squaredNorm();
        if (squared <= limit) hits.push_back({squared, number_[place], point});
        return false;
      });
  return hits;
}

void ClosestPointTree::set_labels(const std::vector<Index>& labels) {
  labels_.resize(triangles_.size());
  for (std::size_t i = 0; i < labels_.size(); ++i) labels_[i] = labels[number_[i]];
  node_labels_.resize(nodes_.size());
  // Children stand behind their parents.
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Index common = k_no_index;
    bool several = false;
    const auto add = [&](Index label) {
      several = several || label == k_no_index || (common != k_no_index && common != label);
      common = label;
    };
    for (const Index child : nodes_[n].child) {
      if ((child & k_leaf_bit) == 0) {
        add(node_labels_[child]);
        continue;
      }
      const Index first = child & k_leaf_first_mask, count = (child & ~k_leaf_bit) >> k_leaf_count_shift;
      for (Index i = first; i < first + count; ++i) add(labels_[i]);
    }
    node_labels_[n] = several ? k_no_index : common;
  }
}

ClosestPointTree::Hit ClosestPointTree::closest_of_others(const Vec3& p, Index label,
                                                          double squared_limit) const {
  Hit best;
  best.squared_distance = squared_limit;
  descend(
      p, best, [&](Index node) { return node_labels_[node] != label; },
      [&](Index i) { return labels_[i] != label; });
  return best;
}

namespace {

/// The least distance from the origin, either way, at which the line is in the box; infinity when it isn't
/// within `limit`.
double distance_to_box(const ShearedLine& line, const Vec3& lower, const Vec3& upper, double limit) {
  const ShearedLine::Range inside = line.clip_to_box(lower, upper, {-limit, limit});
  if (inside.empty()) return std::numeric_limits<double>::infinity();
  return std::max({0.0, inside.enter, -inside.leave});
}

/// Crosses the triangle from behind, nearer than `best`; then `best` becomes that crossing but for its
/// triangle's number.
bool cross(const ShearedLine& line, const Triangle& triangle, ClosestPointTree::Crossing& best) {
  const Vec3 a = line.sheared(triangle.a), b = line.sheared(triangle.b), c = line.sheared(triangle.c);
  const double u = c.x() * b.y() - c.y() * b.x(), v = a.x() * c.y() - a.y() * c.x(),
               w = b.x() * a.y() - b.y() * a.x();
  // Against the sense of the source, whose front sides face the origin of the ray.
  if (u > 0 || v > 0 || w > 0) return false;
  const double sum = u + v + w;
  if (!(sum < 0)) return false;
  const Vec3 weights = Vec3(u, v, w) / sum;
  const double distance = weights.dot(Vec3(a.z(), b.z(), c.z()));
  if (!(std::abs(distance) < std::abs(best.distance))) return false;
  best.distance = distance;
  best.weights = weights;
  return true;
}

}  // namespace

ClosestPointTree::Crossing ClosestPointTree::nearest_crossing(const Vec3& origin, const Vec3& direction,
                                                              double limit) const {
  Crossing best;
  if (!(direction.squaredNorm() > 0)) return best;
  best.distance = std::nextafter(limit, std::numeric_limits<double>::infinity());
  const ShearedLine line(origin, direction);
  struct Pending {
    Index node;
    double distance;
  };
  Pending stack[64];
  int top = 0;
  stack[top++] = {0, 0};
  while (top > 0) {
    const Pending pending = stack[--top];
    const double reach = std::abs(best.distance);
    if (pending.distance > reach) continue;
    if ((pending.node & k_leaf_bit) != 0) {
      const Index first = pending.node & k_leaf_first_mask;
      const Index count = (pending.node & ~k_leaf_bit) >> k_leaf_count_shift;
      for (Index i = first; i < first + count; ++i) {
        if (cross(line, triangles_[i], best)) best.triangle = number_[i];
      }
      continue;
    }
    const Node& node = nodes_[pending.node];
    const double left = distance_to_box(line, node.lower[0], node.upper[0], reach);
    const double right = distance_to_box(line, node.lower[1], node.upper[1], reach);
    const int near = right < left ? 1 : 0;
    const double near_distance = std::min(left, right), far_distance = std::max(left, right);
    if (far_distance <= reach) stack[top++] = {node.child[1 - near], far_distance};
    if (near_distance <= reach) stack[top++] = {node.child[near], near_distance};
  }
  if (best.triangle == k_no_index) return {};
  return best;
}

}  // namespace recede
