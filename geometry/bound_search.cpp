#include <recede/geometry/detail/bound_search.h>
#include <recede/geometry/detail/cut_triangle.h>
#include <recede/geometry/detail/edge_table.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::detail {
namespace {

double longest_side(const Triangle& t) {
  return std::sqrt(
      std::max({(t.a - t.b).squaredNorm(), (t.b - t.c).squaredNorm(), (t.c - t.a).squaredNorm()}));
}

/// Drops positions that no triangle uses.
std::vector<Vec3> keep_used(std::vector<Vec3> positions, std::vector<Index>& triangles) {
  std::vector<Index> number(positions.size(), k_no_index);
  for (const Index v : triangles) number[v] = 0;
  Index n = 0;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] == k_no_index) continue;
    number[v] = n;
    positions[n++] = positions[v];
  }
  positions.resize(n);
  for (Index& v : triangles) v = number[v];
  return positions;
}

}  // namespace

Surface::Surface(PolygonSoup soup)
    : triangles(triangulate(soup)),
      tree((positions = keep_used(std::move(soup.positions), triangles)), triangles) {
  areas.reserve(n_triangles());
  std::vector<Index> corners;  // of the solid ones
  for (std::size_t t = 0; t < n_triangles(); ++t) {
    const Triangle here = triangle(t);
    areas.push_back(0.5 * (here.b - here.a).cross(here.c - here.a).norm());
    area += areas.back();
    constexpr double k_no_area = 1e-15;  // of the square over the longest side
    const double longest = longest_side(here);
    if (areas.back() > k_no_area * longest * longest) solid.push_back(static_cast<Index>(t));
  }
  if (solid.empty() || solid.size() == n_triangles()) return;
  for (const Index t : solid) {
    corners.insert(corners.end(), triangles.begin() + 3 * t, triangles.begin() + 3 * t + 3);
  }
  solid_tree.emplace(positions, corners);
}

namespace {

/// For each side of each triangle (from corner s to the next) the triangle across it; k_no_index at borders
/// and where more than two meet.
std::vector<Index> triangles_across(const Surface& surface) {
  std::vector<Index> offsets(surface.n_triangles() + 1);
  for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = static_cast<Index>(3 * t);
  const EdgeTable edges = build_edge_table(surface.positions.size(), surface.triangles, offsets);
  std::vector<Index> across(surface.triangles.size(), k_no_index);
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const auto sides = edges.sides(e);
    if (sides.size() != 2) continue;
    across[sides[0]] = edges.corner_faces[sides[1]];
    across[sides[1]] = edges.corner_faces[sides[0]];
  }
  return across;
}

/// Distances of a piece's corners to a triangle: over the piece, `largest` isn't exceeded.
struct CornerDistances {
  double least, largest;
};

CornerDistances corner_distances(const Triangle& t, const Triangle& target) {
  const auto [least, largest] = std::minmax({(closest_point_on_triangle(t.a, target) - t.a).squaredNorm(),
                                             (closest_point_on_triangle(t.b, target) - t.b).squaredNorm(),
                                             (closest_point_on_triangle(t.c, target) - t.c).squaredNorm()});
  return {std::sqrt(least), std::sqrt(largest)};
}

/// Branch and bound over the pieces of one triangle.
///
/// The distance to one triangle is convex, so over a piece of the source surface it is largest at the piece's
/// corners; the distance to the surface is at most that for any triangle of it. It is also at most the
/// distance of the centroid plus the piece's radius. A piece whose smallest such bound doesn't meet the goal
/// is cut: along the prism over a triangle near it when it sticks out of that (beyond the cut the triangle
/// across the side is nearer, so flat regions are done after one piece for each pair of overlapping
/// triangles, walking from neighbour to neighbour), else into four.
class BoundSearch {
 public:
  BoundSearch(const Surface& to, const std::vector<Index>& across, const BoundGoal& goal)
      : to_(to), across_(across), goal_(goal) {}

  /// Interval over one triangle; `lower` is at least that of the goal. `near` are triangles of the other
  /// surface. After `most_work` (in steps to a neighbour) the pieces keep the bound that they have: the
  /// interval stays true, only wider than asked, and `gave_up` says so.
  Interval run(const Triangle& triangle, const std::array<Index, 3>& near, std::size_t most_work,
               bool& gave_up) {
    gave_up = false;
    Interval result{goal_.lower, 0, triangle.a};
    for (const Index hint : near) {
      if (settle(corner_distances(triangle, to_.triangle(hint)).largest, triangle.a, result)) return result;
    }
    pieces_.clear();
    pieces_.push_back({triangle, near[0], 0});
    // First come, first served: if the work runs out, what is left is small.
    std::size_t work = 0;
    for (std::size_t next = 0; next < pieces_.size(); ++next) {
      const Piece piece = pieces_[next];
      const bool give_up = work > most_work;
      gave_up = gave_up || give_up;
      if (give_up || !walk(piece, result)) {
        look_up(piece, result, give_up);
        work += k_look_up_work;
      } else {
        ++work;
      }
    }
    return result;
  }

 private:
  /// A look-up takes as long as some ten steps.
  static constexpr std::size_t k_look_up_work = 10;
  /// Steps from neighbour to neighbour, after which the nearest triangle is looked up, and after which a
  /// piece is cut in four: on folded surfaces prisms may cut for ever.
  static constexpr int k_most_walk = 12, k_most_steps = 16;

  struct Piece {
    Triangle corners;
    Index near;  ///< a triangle of the other surface
    int steps;   ///< to it since the last cut in four
  };
  /// How a piece lies to the prism over a triangle.
  struct Overhang {
    int side = -1;                    ///< beyond which a corner lies farthest; -1: none
    bool cuts = false;                ///< part of the piece lies on the inner side
    std::array<double, 3> heights{};  ///< of the piece's corners beyond the side
  };

  double enough(const Interval& result) const {
    return std::max(result.lower / (1 - goal_.tolerance), goal_.floor);
  }

  /// True when this bound is good enough.
  bool settle(double bound, const Vec3& at, Interval& result) const {
    if (bound > enough(result)) return false;
    accept(bound, at, result);
    return true;
  }

  static void accept(double bound, const Vec3& at, Interval& result) {
    if (bound <= result.upper) return;
    result.upper = bound;
    result.at = at;
  }

  /// Settles the piece by the triangle that it names, or hands it on, cut or whole, to a neighbour. False
  /// when it takes a look-up.
  bool walk(const Piece& piece, Interval& result) {
    const Triangle target = to_.triangle(piece.near);
    const CornerDistances distances = corner_distances(piece.corners, target);
    if (settle(distances.largest, piece.corners.a, result)) return true;
    if (piece.steps >= k_most_walk) return false;
    const Overhang overhang = find_overhang(piece.corners, target);
    if (overhang.side < 0) return false;
    const Index neighbour = across_[3 * piece.near + static_cast<Index>(overhang.side)];
    if (neighbour == k_no_index) return false;
    // A part that isn't near enough either needn't be cut off.
    if (overhang.cuts && distances.least <= enough(result)) {
      push_halves(piece, overhang.heights, piece.near, neighbour);
    } else {
      pieces_.push_back({piece.corners, neighbour, piece.steps + 1});
    }
    return true;
  }

  /// Finds the triangle nearest to the middle, and cuts the piece when that isn't near enough.
  void look_up(const Piece& piece, Interval& result, bool give_up) {
    const Triangle& t = piece.corners;
    const Vec3 centroid = (t.a + t.b + t.c) / 3;
    const auto nearest = to_.tree.closest(centroid, piece.near);
    const double at_centroid = std::sqrt(nearest.squared_distance);
    result.lower = std::max(result.lower, at_centroid);
    const Index near = solid_near(centroid, nearest.triangle);
    const Triangle target = to_.triangle(near);
    const double radius = std::sqrt(std::max(
        {(t.a - centroid).squaredNorm(), (t.b - centroid).squaredNorm(), (t.c - centroid).squaredNorm()}));
    const double bound = std::min(at_centroid + radius, corner_distances(t, target).largest);
    if (settle(bound, centroid, result)) return;
    if (give_up) return accept(bound, centroid, result);
    const Overhang overhang = find_overhang(t, target);
    if (!overhang.cuts || piece.steps >= k_most_steps) return push_quarters(piece, near);
    const Index neighbour = across_[3 * near + static_cast<Index>(overhang.side)];
    push_halves(piece, overhang.heights, near, neighbour == k_no_index ? near : neighbour);
  }

  /// The nearest triangle that has an area, where some have none.
  Index solid_near(const Vec3& place, Index nearest) const {
    if (!to_.solid_tree || std::binary_search(to_.solid.begin(), to_.solid.end(), nearest)) return nearest;
    return to_.solid[to_.solid_tree->closest(place).triangle];
  }

  /// Looks at the planes through the sides of `target`, upright on it. Nothing when the piece is so much
  /// larger than `target` that halving its sides is better.
  Overhang find_overhang(const Triangle& piece, const Triangle& target) const {
    constexpr double k_much_larger = 4;
    Overhang result;
    if (longest_side(piece) > k_much_larger * longest_side(target)) return result;
    const std::array<Vec3, 3> ends{target.a, target.b, target.c};
    const std::array<Vec3, 3> corners{piece.a, piece.b, piece.c};
    const Vec3 normal = (target.b - target.a).cross(target.c - target.a);
    // A part thinner than the floor changes no bound that matters.
    const double thin = 0.1 * goal_.floor;
    double farthest = thin;
    for (std::size_t s = 0; s < 3; ++s) {
      const Vec3 outward = (ends[(s + 1) % 3] - ends[s]).cross(normal);
      const double length = outward.norm();
      if (!(length > 0)) return {};
      std::array<double, 3> h{};
      for (std::size_t i = 0; i < 3; ++i) h[i] = (corners[i] - ends[s]).dot(outward) / length;
      const auto [least, most] = std::minmax({h[0], h[1], h[2]});
      const bool cuts = least < -thin;
      // Where some side cuts, the others can wait.
      if (most <= thin || (result.cuts && !cuts)) continue;
      if (most <= farthest && cuts == result.cuts) continue;
      farthest = most;
      result = {static_cast<int>(s), cuts, h};
    }
    return result;
  }

  /// The parts of a triangle below and above height 0, as triangles.
  void push_halves(const Piece& piece, const std::array<double, 3>& heights, Index near_below,
                   Index near_above) {
    cut_triangle(piece.corners, heights, [&](const Triangle& part, bool is_above) {
      pieces_.push_back({part, is_above ? near_above : near_below, piece.steps + (is_above ? 1 : 0)});
    });
  }

  void push_quarters(const Piece& piece, Index near) {
    for (const Triangle& part : cut_in_four(piece.corners)) pieces_.push_back({part, near, 0});
  }

  const Surface& to_;
  const std::vector<Index>& across_;
  BoundGoal goal_;
  std::vector<Piece> pieces_;
};

}  // namespace

/// Every triangle starts from the same lower bound and not from its neighbours' results: the intervals are
/// then the same for any number of threads.
std::vector<Interval> certified_intervals(const Surface& from, const Surface& to,
                                          const std::vector<Index>& nearest, const BoundGoal& goal) {
  // Nearly all triangles are done after a few steps. Surfaces made of slivers would be cut for hours; the few
  // hard triangles of other surfaces share what is left of the time.
  constexpr std::size_t k_first_work = 2000, k_least_work = 50'000'000, k_work_per_triangle = 200;
  const std::vector<Index> across = triangles_across(to);
  std::vector<Interval> intervals(from.n_triangles());
  std::vector<unsigned char> gave_up(from.n_triangles());
  const auto run = [&](std::size_t n, std::size_t work, auto&& triangle_at) {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, n, work > k_first_work ? 1 : 64), [&](const auto& range) {
          BoundSearch search(to, across, goal);
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            const std::size_t t = triangle_at(i);
            const Index* const corners = from.triangles.data() + 3 * t;
            bool wide = false;
            intervals[t] =
                search.run(from.triangle(t), {nearest[corners[0]], nearest[corners[1]], nearest[corners[2]]},
                           work, wide);
            gave_up[t] = wide ? 1 : 0;
          }
        });
  };
  run(from.n_triangles(), k_first_work, [](std::size_t i) { return i; });
  std::vector<std::size_t> hard;
  for (std::size_t t = 0; t < gave_up.size(); ++t) {
    if (gave_up[t] != 0) hard.push_back(t);
  }
  if (hard.empty()) return intervals;
  const std::size_t most_work =
      std::max(k_least_work, k_work_per_triangle * (from.n_triangles() + to.n_triangles()));
  const std::size_t share = most_work / hard.size();
  if (share > k_first_work) run(hard.size(), share, [&](std::size_t i) { return hard[i]; });
  return intervals;
}

}  // namespace recede::detail
