#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <array>
#include <cmath>

namespace recede {
namespace {

/// A surface as triangles, with its search tree.
struct Surface {
  explicit Surface(const PolygonSoup& soup)
      : positions(soup.positions), triangles(triangulate(soup)), tree(positions, triangles) {
    used.resize(positions.size(), false);
    for (const Index v : triangles) used[v] = true;
    areas.reserve(n_triangles());
    for (std::size_t t = 0; t < n_triangles(); ++t) {
      const Triangle corners = triangle(t);
      areas.push_back(0.5 * (corners.b - corners.a).cross(corners.c - corners.a).norm());
      area += areas.back();
    }
  }

  std::size_t n_triangles() const { return triangles.size() / 3; }
  Triangle triangle(std::size_t t) const {
    return {positions[triangles[3 * t]], positions[triangles[3 * t + 1]], positions[triangles[3 * t + 2]]};
  }

  const std::vector<Vec3>& positions;
  std::vector<Index> triangles;
  ClosestPointTree tree;
  std::vector<double> areas;
  std::vector<bool> used;
  double area = 0;
};

/// `count` points spread evenly by area: point i stands at share (i + 1/2) / count of the running area, and
/// its place inside the triangle comes from Roberts' R2 sequence, so that points of one triangle fill it
/// evenly.
std::vector<Vec3> sample_points(const Surface& surface, std::size_t count) {
  constexpr double k_alpha1 = 0.7548776662466927, k_alpha2 = 0.5698402909980532;
  std::vector<Vec3> points;
  if (!(surface.area > 0)) return points;
  points.reserve(count);
  std::size_t t = 0;
  double before = 0;  // area of the triangles before t
  for (std::size_t i = 0; i < count; ++i) {
    const double at = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * surface.area;
    while (t + 1 < surface.n_triangles() && before + surface.areas[t] < at) before += surface.areas[t++];
    double u = std::fmod(0.5 + k_alpha1 * static_cast<double>(i), 1.0);
    double v = std::fmod(0.5 + k_alpha2 * static_cast<double>(i), 1.0);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    const Triangle corners = surface.triangle(t);
    points.push_back(corners.a + u * (corners.b - corners.a) + v * (corners.c - corners.a));
  }
  return points;
}

/// Squared distance of each point to the surface. Neighbouring points are asked in one block, so that the
/// answer to one is a good guess for the next.
std::vector<double> squared_distances(const std::vector<Vec3>& points, const ClosestPointTree& tree) {
  std::vector<double> result(points.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points.size(), 1024), [&](const auto& range) {
    Index hint = k_no_index;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const auto hit = tree.closest(points[i], hint);
      result[i] = hit.squared_distance;
      hint = hit.triangle;
    }
  });
  return result;
}

void keep_largest(const std::vector<Vec3>& points, const std::vector<double>& squared,
                  OneSidedDistance& side) {
  double largest = side.max * side.max;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (squared[i] <= largest) continue;
    largest = squared[i];
    side.max = std::sqrt(largest);
    side.at = points[i];
  }
}

OneSidedDistance sampled_distance(const Surface& from, const Surface& to, std::size_t samples,
                                  std::size_t& evaluated) {
  OneSidedDistance side;
  const std::vector<Vec3> points = sample_points(from, samples);
  const std::vector<double> squared = squared_distances(points, to.tree);
  double sum = 0, sum_of_squares = 0;
  for (const double value : squared) {
    sum += std::sqrt(value);
    sum_of_squares += value;
  }
  if (!points.empty()) {
    side.mean = sum / static_cast<double>(points.size());
    side.rms = std::sqrt(sum_of_squares / static_cast<double>(points.size()));
  }
  keep_largest(points, squared, side);
  std::vector<Vec3> vertices;
  for (std::size_t v = 0; v < from.positions.size(); ++v) {
    if (from.used[v]) vertices.push_back(from.positions[v]);
  }
  keep_largest(vertices, squared_distances(vertices, to.tree), side);
  evaluated += points.size() + vertices.size();
  return side;
}

/// The certified interval of the one-sided maximum, by branch and bound.
///
/// The distance to one triangle is convex, so over a piece of the source surface it is largest at the piece's
/// corners; the distance to the surface is at most that for any triangle of it. It is also at most the
/// distance of the centroid plus the piece's radius. A piece whose smallest such bound doesn't meet the goal
/// is cut: along the prism over the triangle nearest to its centroid when it sticks out of that (beyond the
/// cut another triangle is nearer, so flat regions are done after one piece for each pair of overlapping
/// triangles), else into four.
class BoundSearch {
 public:
  struct Interval {
    double lower = 0, upper = 0;
  };

  /// `floor`: bounds below it need no further work. `lower`: a distance known to occur.
  /// `n_triangles`: how many share the work.
  BoundSearch(const ClosestPointTree& to, double lower, double tolerance, double floor,
              std::size_t n_triangles)
      : to_(to),
        lower_(lower),
        tolerance_(tolerance),
        floor_(floor),
        most_pieces_(std::max(k_most_pieces / n_triangles, k_least_share)) {}

  /// Interval over one triangle, [lower, upper]; `lower` is at least the one known before.
  Interval run(const Triangle& triangle) {
    Interval result{lower_, 0};
    pieces_.clear();
    pieces_.push_back({triangle, k_no_index});
    for (std::size_t visited = 0; !pieces_.empty(); ++visited) {
      const Piece piece = pieces_.back();
      pieces_.pop_back();
      visit(piece, result, visited > most_pieces_);
    }
    return result;
  }

 private:
  // Past its share of these, a triangle's pieces keep the bound that they have: the interval stays true, only
  // wider than asked. Surfaces made of slivers would otherwise be cut for hours.
  static constexpr std::size_t k_most_pieces = 20'000'000;
  static constexpr std::size_t k_least_share = 1000;

  struct Piece {
    Triangle corners;
    Index hint;
  };

  void visit(const Piece& piece, Interval& result, bool give_up) {
    const Triangle& t = piece.corners;
    const Vec3 centroid = (t.a + t.b + t.c) / 3;
    const auto nearest = to_.closest(centroid, piece.hint);
    const double at_centroid = std::sqrt(nearest.squared_distance);
    result.lower = std::max(result.lower, at_centroid);
    const Triangle target = to_.triangle(nearest.triangle);
    const double radius = std::sqrt(std::max(
        {(t.a - centroid).squaredNorm(), (t.b - centroid).squaredNorm(), (t.c - centroid).squaredNorm()}));
    const double bound = std::min(at_centroid + radius, largest_distance(t, target));
    if (bound <= std::max(result.lower / (1 - tolerance_), floor_) || give_up) {
      result.upper = std::max(result.upper, bound);
      return;
    }
    if (!cut_along_prism(piece, target, nearest.triangle)) cut_in_four(piece, nearest.triangle);
  }

  static double largest_distance(const Triangle& t, const Triangle& target) {
    double largest = 0;
    for (const Vec3& p : {t.a, t.b, t.c}) {
      largest = std::max(largest, (closest_point_on_triangle(p, target) - p).squaredNorm());
    }
    return std::sqrt(largest);
  }

  /// Cuts by the plane through a side of `target`, upright on it, beyond which a corner of the piece lies
  /// farthest. False when no side cuts the piece, or when the piece is so much larger than `target` that
  /// halving its sides is better.
  bool cut_along_prism(const Piece& piece, const Triangle& target, Index hint) {
    const std::array<Vec3, 3> ends{target.a, target.b, target.c};
    const Vec3 normal = (target.b - target.a).cross(target.c - target.a);
    const std::array<Vec3, 3> corners{piece.corners.a, piece.corners.b, piece.corners.c};
    constexpr double k_much_larger = 4;
    if (longest_side(piece.corners) > k_much_larger * longest_side(target)) return false;
    double farthest = 0;
    std::array<double, 3> heights{};
    for (std::size_t s = 0; s < 3; ++s) {
      const Vec3 outward = (ends[(s + 1) % 3] - ends[s]).cross(normal);
      const double length = outward.norm();
      if (!(length > 0)) return false;
      std::array<double, 3> h{};
      for (std::size_t i = 0; i < 3; ++i) h[i] = (corners[i] - ends[s]).dot(outward) / length;
      const auto [least, most] = std::minmax({h[0], h[1], h[2]});
      // A part thinner than the floor changes no bound that matters.
      const double thin = 0.1 * floor_;
      if (least >= -thin || most <= thin || most <= farthest) continue;
      farthest = most;
      heights = h;
    }
    if (!(farthest > 0)) return false;
    push_halves(corners, heights, hint);
    return true;
  }

  static double longest_side(const Triangle& t) {
    return std::sqrt(
        std::max({(t.a - t.b).squaredNorm(), (t.b - t.c).squaredNorm(), (t.c - t.a).squaredNorm()}));
  }

  /// The parts of a triangle below and above height 0, as triangles.
  void push_halves(const std::array<Vec3, 3>& corners, const std::array<double, 3>& heights, Index hint) {
    for (const double sign : {1.0, -1.0}) {
      std::array<Vec3, 4> part;
      std::size_t n = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        const double hi = sign * heights[i], hj = sign * heights[j];
        if (hi >= 0) part[n++] = corners[i];
        // Always from the lower corner to the upper one, so that both parts get the same point.
        if ((hi < 0) != (hj < 0) && hi != 0 && hj != 0) {
          const auto [low, high] = heights[i] < heights[j] ? std::pair{i, j} : std::pair{j, i};
          const double share = heights[low] / (heights[low] - heights[high]);
          part[n++] = corners[low] + share * (corners[high] - corners[low]);
        }
      }
      if (n >= 3) pieces_.push_back({{part[0], part[1], part[2]}, hint});
      if (n == 4) pieces_.push_back({{part[0], part[2], part[3]}, hint});
    }
  }

  void cut_in_four(const Piece& piece, Index hint) {
    const Triangle& t = piece.corners;
    const Vec3 ab = 0.5 * (t.a + t.b), bc = 0.5 * (t.b + t.c), ca = 0.5 * (t.c + t.a);
    pieces_.push_back({{t.a, ab, ca}, hint});
    pieces_.push_back({{ab, t.b, bc}, hint});
    pieces_.push_back({{ca, bc, t.c}, hint});
    pieces_.push_back({{ab, bc, ca}, hint});
  }

  const ClosestPointTree& to_;
  double lower_, tolerance_, floor_;
  std::size_t most_pieces_;
  std::vector<Piece> pieces_;
};

/// Every triangle starts from the same lower bound and not from its neighbours' results: the interval is then
/// the same for any number of threads.
BoundSearch::Interval certified_interval(const Surface& from, const Surface& to, double lower,
                                         double tolerance, double floor) {
  std::vector<BoundSearch::Interval> intervals(from.n_triangles());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, from.n_triangles(), 64), [&](const auto& range) {
    BoundSearch search(to.tree, lower, tolerance, floor, from.n_triangles());
    for (std::size_t t = range.begin(); t < range.end(); ++t) intervals[t] = search.run(from.triangle(t));
  });
  BoundSearch::Interval result{lower, 0};
  for (const auto& interval : intervals) {
    result.lower = std::max(result.lower, interval.lower);
    result.upper = std::max(result.upper, interval.upper);
  }
  return result;
}

void check(const PolygonSoup& a, const PolygonSoup& b, const DistanceOptions& options) {
  if (a.n_faces() == 0 || b.n_faces() == 0) {
    throw InputError(std::string("the distance needs two surfaces, but the ") +
                     (a.n_faces() == 0 ? "first" : "second") + " one has no faces");
  }
  if (options.bound_tolerance && !(*options.bound_tolerance > 0 && *options.bound_tolerance < 1)) {
    throw OptionError("bound_tolerance must lie between 0 and 1");
  }
}

MeshDistance measure_at_unit_size(const PolygonSoup& a, const PolygonSoup& b, const DistanceOptions& options,
                                  Progress* progress) {
  report_progress(progress, "measure", 0);
  const Surface first(a), second(b);
  MeshDistance distance;
  distance.diagonal = bounding_box(a).diagonal().norm();
  distance.forward = sampled_distance(first, second, options.samples, distance.samples);
  report_progress(progress, "measure", 0.3);
  distance.backward = sampled_distance(second, first, options.samples, distance.samples);
  distance.max = distance.max_lower = std::max(distance.forward.max, distance.backward.max);
  const double area = first.area + second.area;
  if (area > 0) {
    distance.rms = std::sqrt((first.area * distance.forward.rms * distance.forward.rms +
                              second.area * distance.backward.rms * distance.backward.rms) /
                             area);
    distance.samples_per_unit_area = 2 * static_cast<double>(options.samples) / area;
  }
  if (!options.bound_tolerance) return distance;
  report_progress(progress, "bound", 0);
  Box3 both = bounding_box(a);
  both.extend(bounding_box(b));
  const double floor = options.relative_floor * both.diagonal().norm();
  const double tolerance = *options.bound_tolerance;
  const auto forward = certified_interval(first, second, distance.max, tolerance, floor);
  report_progress(progress, "bound", 0.5);
  const auto backward = certified_interval(second, first, distance.max, tolerance, floor);
  distance.max_lower = std::max(forward.lower, backward.lower);
  distance.max_bound = std::max({forward.upper, backward.upper, distance.max_lower});
  report_progress(progress, "bound", 1);
  return distance;
}

/// Power of two that brings the larger extent of both surfaces to about 1. Squares of lengths then neither
/// overflow nor underflow, and scaling by it rounds nothing.
int unit_exponent(const PolygonSoup& a, const PolygonSoup& b) {
  Box3 box = bounding_box(a);
  box.extend(bounding_box(b));
  // Extents from 0, not from the box's lower corner: their difference could overflow.
  const double largest = std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  return largest > 0 ? -std::ilogb(largest) : 0;
}

Vec3 scaled(const Vec3& p, int exponent) {
  return {std::ldexp(p.x(), exponent), std::ldexp(p.y(), exponent), std::ldexp(p.z(), exponent)};
}

PolygonSoup scaled(const PolygonSoup& soup, int exponent) {
  PolygonSoup result;
  result.face_offsets = soup.face_offsets;
  result.corner_vertices = soup.corner_vertices;
  result.positions.reserve(soup.positions.size());
  for (const Vec3& p : soup.positions) result.positions.push_back(scaled(p, exponent));
  return result;
}

void scale(OneSidedDistance& side, int exponent) {
  side.max = std::ldexp(side.max, exponent);
  side.rms = std::ldexp(side.rms, exponent);
  side.mean = std::ldexp(side.mean, exponent);
  side.at = scaled(side.at, exponent);
}

}  // namespace

MeshDistance measure_distance(const PolygonSoup& a, const PolygonSoup& b, const DistanceOptions& options,
                              Progress* progress) {
  check(a, b, options);
  const int exponent = unit_exponent(a, b);
  MeshDistance distance = measure_at_unit_size(scaled(a, exponent), scaled(b, exponent), options, progress);
  scale(distance.forward, -exponent);
  scale(distance.backward, -exponent);
  distance.max = std::ldexp(distance.max, -exponent);
  distance.rms = std::ldexp(distance.rms, -exponent);
  if (distance.max_bound) distance.max_bound = std::ldexp(*distance.max_bound, -exponent);
  distance.max_lower = std::ldexp(distance.max_lower, -exponent);
  distance.diagonal = std::ldexp(distance.diagonal, -exponent);
  distance.samples_per_unit_area = std::ldexp(distance.samples_per_unit_area, 2 * exponent);
  return distance;
}

MeshDistance measure_distance(const PolygonMesh& a, const PolygonMesh& b, const DistanceOptions& options,
                              Progress* progress) {
  return measure_distance(to_soup(a), to_soup(b), options, progress);
}

}  // namespace recede
