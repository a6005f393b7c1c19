#include <recede/geometry/closest_point.h>
#include <recede/geometry/disjoint_sets.h>
#include <recede/lod/detail/parts.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace recede::detail {
namespace {

/// The part of each point, k_no_index for dead ones, and the points of each part.
struct Parts {
  std::vector<Index> of_point;
  std::vector<Index> start, points;  ///< part i has points[start[i], start[i + 1])

  std::size_t size() const { return start.size() - 1; }
  std::span<const Index> operator[](std::size_t part) const {
    return {points.data() + start[part], start[part + 1] - start[part]};
  }
};

Parts find_parts(const CornerTable& table) {
  DisjointSets sets(table.n_points());
  std::vector<bool> is_alive(table.n_points(), false);
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (!table.is_face_alive(f)) continue;
    table.each_corner_of_face(f, [&](Index c) {
      is_alive[table.point[c]] = true;
      sets.unite(table.point[c], table.point_after(c));
    });
  }
  // Parts are numbered by their lowest points.
  Parts parts;
  parts.of_point.assign(table.n_points(), k_no_index);
  parts.start.push_back(0);
  for (Index p = 0; p < table.n_points(); ++p) {
    if (!is_alive[p]) continue;
    const Index root = sets.find(p);
    if (root == p) {
      parts.of_point[p] = static_cast<Index>(parts.size());
      parts.start.push_back(0);
    }
    parts.of_point[p] = parts.of_point[root];
    ++parts.start[parts.of_point[p] + 1];
  }
  std::partial_sum(parts.start.begin(), parts.start.end(), parts.start.begin());
  parts.points.resize(parts.start.back());
  std::vector<Index> end(parts.start.begin(), parts.start.end() - 1);
  for (Index p = 0; p < table.n_points(); ++p) {
    if (parts.of_point[p] != k_no_index) parts.points[end[parts.of_point[p]]++] = p;
  }
  return parts;
}

std::vector<Vec3> positions_of(const CornerTable& table) {
  return {table.positions.begin(), table.positions.end()};
}

/// How far parts are from the others.
class PartErrors {
 public:
  PartErrors(const CornerTable& table, const Parts& parts)
      : table_(table),
        parts_(parts),
        triangles_(fan_triangles(table)),
        tree_(positions_of(table), triangles_),
        nearest_(table.n_points()) {
    std::vector<Index> labels(triangles_.size() / 3);
    for (std::size_t t = 0; t < labels.size(); ++t) labels[t] = parts.of_point[triangles_[3 * t]];
    tree_.set_labels(labels);
  }

  /// The own error of a part, or infinity when it is more than `most` or the part is held. Remembers what
  /// each point is nearest to.
  double measure(std::size_t part, double most) {
    double error = 0;
    for (const Index p : parts_[part]) {
      const auto deviation = static_cast<double>(table_.deviation[p]);
      const double left = most - deviation;
      if (table_.is_held(p, p) || left < 0) return std::numeric_limits<double>::infinity();
      // What lies at the very limit counts as within.
      const double squared_limit =
          std::isfinite(left) ? std::nextafter(left * left, 2 * left * left + 1) : left;
      const auto hit = tree_.closest_of_others(table_.positions[p], static_cast<Index>(part), squared_limit);
      if (hit.triangle == k_no_index) return std::numeric_limits<double>::infinity();
      nearest_[p] = {hit.triangle, std::sqrt(hit.squared_distance) + deviation};
      error = std::max(error, nearest_[p].error);
    }
    return error;
  }

  /// Calls `visit(points of the nearest triangle, error)` for every point of a measured part.
  template <typename Visit>
  void each_support(std::size_t part, Visit&& visit) const {
    for (const Index p : parts_[part]) {
      const Index* const corners = triangles_.data() + 3 * std::size_t{nearest_[p].triangle};
      visit(std::span<const Index, 3>(corners, 3), nearest_[p].error);
    }
  }

 private:
  struct Nearest {
    Index triangle = k_no_index;
    double error = 0;
  };
  const CornerTable& table_;
  const Parts& parts_;
  std::vector<Index> triangles_;
  ClosestPointTree tree_;
  std::vector<Nearest> nearest_;  // by point
};

void kill_faces(CornerTable& table, const Parts& parts, const std::vector<bool>& goes) {
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (!table.is_face_alive(f) || !goes[parts.of_point[table.point[table.face_corner(f)]]]) continue;
    const Index first = table.face_corner(f);
    Index corner = first;
    do {
      const Index next = table.next(corner);
      table.point[corner] = k_no_index;
      corner = next;
    } while (corner != first);
    if (table.has_polygons) table.loop_size[f] = 0;
  }
}

}  // namespace

std::vector<PointPair> find_joins(const CornerTable& table, double distance) {
  const Parts parts = find_parts(table);
  std::vector<PointPair> joins;
  if (parts.size() < 2) return joins;
  // A point is a triangle without size.
  std::vector<Index> triangles, labels;
  for (const Index p : parts.points) {
    triangles.insert(triangles.end(), 3, p);
    labels.push_back(parts.of_point[p]);
  }
  ClosestPointTree tree(positions_of(table), triangles);
  tree.set_labels(labels);
  std::vector<Index> partner(parts.points.size(), k_no_index);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, partner.size(), 1024), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const Vec3& at = table.positions[parts.points[i]];
      const auto hit = tree.closest_of_others(at, labels[i], distance * distance);
      if (hit.triangle != k_no_index) partner[i] = parts.points[hit.triangle];
    }
  });
  for (std::size_t i = 0; i < partner.size(); ++i) {
    if (partner[i] == k_no_index) continue;
    const auto [low, high] = std::minmax(parts.points[i], partner[i]);
    joins.push_back({low, high});
  }
  std::sort(joins.begin(), joins.end());
  joins.erase(std::unique(joins.begin(), joins.end()), joins.end());
  return joins;
}

DroppedParts drop_parts(CornerTable& table, double most_error,
                        const std::function<bool(const DroppedParts&)>& enough) {
  DroppedParts dropped;
  const Parts parts = find_parts(table);
  if (parts.size() < 2) return dropped;
  PartErrors errors(table, parts);
  std::vector<std::pair<double, Index>> order(parts.size());
  tbb::parallel_for(std::size_t{0}, order.size(), [&](std::size_t part) {
    order[part] = {errors.measure(part, most_error), static_cast<Index>(part)};
  });
  std::sort(order.begin(), order.end());
  std::vector<std::size_t> n_faces(parts.size(), 0);
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (table.is_face_alive(f)) n_faces[parts.of_point[table.point[table.face_corner(f)]]] += table.sides(f);
  }
  std::vector<bool> goes(parts.size(), false), needed(parts.size(), false);
  for (const auto& [error, part] : order) {
    if (!std::isfinite(error) || enough(dropped)) break;
    if (needed[part]) continue;
    bool relies_on_gone = false;
    errors.each_support(part, [&](std::span<const Index, 3> points, double) {
      relies_on_gone = relies_on_gone || goes[parts.of_point[points[0]]];
    });
    if (relies_on_gone) continue;
    errors.each_support(part, [&](std::span<const Index, 3> points, double own) {
      needed[parts.of_point[points[0]]] = true;
      for (const Index q : points) table.deviation[q] = std::max(table.deviation[q], static_cast<float>(own));
    });
    goes[part] = true;
    ++dropped.parts;
    dropped.faces += n_faces[part];
    dropped.points += parts[part].size();
    dropped.error = std::max(dropped.error, error);
  }
  if (dropped.parts > 0) kill_faces(table, parts, goes);
  return dropped;
}

}  // namespace recede::detail
