// Points inserted one by one, and what is inside loops. The triangles that a new point sees and whose circles
// hold it make room for triangles at the point (A. Bowyer, D. F. Watson, both in The Computer Journal 24,
// 1981). They are found from neighbour to neighbour and not across edges, by the tests that flips of sides
// would make (C. L. Lawson 1977), so that the room is star-shaped as it is with flips.
#include <recede/geometry/constrained_delaunay.h>
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/triangle_walk.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

#include <cstdlib>

namespace recede {
namespace {

using On = TriangleLocation::On;

// Twice as many triangles, numbered with their sides, are numbers of 32 bits and less than k_no_index.
constexpr std::size_t k_most_points = std::size_t{1} << 28;

void check_count(std::size_t n_points) {
  if (n_points > k_most_points) throw InputError("there are more than 2^28 points to triangulate");
}

}  // namespace

void ConstrainedDelaunay::check(std::span<const std::array<Index, 2>> edges) const {
  check_count(points_.size());
  for (std::size_t v = 0; v < points_.size(); ++v) {
    if (!points_[v].allFinite()) throw InputError(fmt::format("point {} isn't finite", v));
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto [a, b] = edges[e];
    const std::size_t n = points_.size();
    if (a >= n || b >= n) {
      throw InputError(fmt::format("edge {} has point {} of {}", e, std::max(a, b), n));
    }
    if (points_[a] == points_[b]) {
      throw InputError(fmt::format("edge {} has equal ends, points {} and {}", e, a, b));
    }
  }
}

TriangleLocation ConstrainedDelaunay::find(const Vec2& point, Index start) const {
  // Circles of a walk are rare and small; a walk across everything is about as long as a row of triangles.
  const std::size_t most_steps = triangles_.size() + 100;
  const auto place = detail::walk_to(point, start, most_steps, points_, triangles_);
  return place ? *place : detail::look_everywhere(point, points_, triangles_);
}

TriangleLocation ConstrainedDelaunay::locate(const Vec2& point, Index near) const {
  if (triangles_.empty() || !point.allFinite()) return {};
  const TriangleLocation place = find(point, near < triangles_.size() ? near : last_);
  return place.on == On::outside ? TriangleLocation{} : place;
}

Insertion ConstrainedDelaunay::insert(const Vec2& point, Index near) {
  changed_.clear();
  const TriangleLocation place = locate(point, near);
  if (place.on == On::outside) return {};
  const DelaunayTriangle& triangle = triangles_[place.triangle];
  if (place.on == On::vertex) return {triangle.vertex(place.corner), InsertionStatus::on_vertex};
  if (place.on == On::side && triangle.is_constrained(place.corner)) {
    return {k_no_index, InsertionStatus::on_constrained_edge};
  }
  if (!triangle.is_inside) return {};
  check_count(points_.size() + 1);
  const Index vertex = static_cast<Index>(points_.size());
  points_.push_back(point);
  first_equal_.push_back(vertex);
  make_star(vertex, place);
  return {vertex, InsertionStatus::inserted};
}

bool ConstrainedDelaunay::must_go(Index number, const Vec2& point) const {
  const DelaunayTriangle& triangle = triangles_[number];
  const int far = detail::far_corner(triangle);
  if (far >= 0) {  // its circle is the half plane beyond its side
    return detail::orientation(points_[triangle.from(far)], points_[triangle.to(far)], point) > 0;
  }
  return detail::side_of_circle(points_[triangle.vertex(0)], points_[triangle.vertex(1)],
                                points_[triangle.vertex(2)], point) > 0;
}

/// The one or two triangles at the place go; their other sides are open, the last one first in turn.
void ConstrainedDelaunay::open_sides_at(const TriangleLocation& place) {
  changed_.assign(1, place.triangle);
  open_sides_.clear();
  const auto open = [&](Index triangle, int side) {
    open_sides_.push_back(4 * triangle + static_cast<Index>(side));
  };
  if (place.on == On::face) {
    for (const int side : {2, 1, 0}) open(place.triangle, side);
    return;
  }
  const Index across = triangles_[place.triangle].side_across(place.corner);
  if (across != k_no_index) {
    const int entered = static_cast<int>(across % 4);
    changed_.push_back(across / 4);
    open(across / 4, DelaunayTriangle::previous(entered));
    open(across / 4, DelaunayTriangle::next(entered));
  }
  open(place.triangle, DelaunayTriangle::previous(place.corner));
  open(place.triangle, DelaunayTriangle::next(place.corner));
}

/// Finds the triangles that go, in `changed_`, and the sides around them counter-clockwise, in `star_`.
void ConstrainedDelaunay::carve(const Vec2& point, const TriangleLocation& place) {
  open_sides_at(place);
  star_.clear();
  while (!open_sides_.empty()) {
    const Index side = open_sides_.back();
    open_sides_.pop_back();
    const DelaunayTriangle& triangle = triangles_[side / 4];
    const int k = static_cast<int>(side % 4);
    const Index across = triangle.side_across(k);
    const bool is_constrained = triangle.is_constrained(k);
    if (is_constrained || across == k_no_index || !must_go(across / 4, point)) {
      star_.push_back(
          {triangle.from(k), across, triangle.turns[static_cast<std::size_t>(k)], is_constrained});
      continue;
    }
    const int entered = static_cast<int>(across % 4);
    const Index first = across - across % 4;
    changed_.push_back(across / 4);
    open_sides_.push_back(first + static_cast<Index>(DelaunayTriangle::previous(entered)));
    open_sides_.push_back(first + static_cast<Index>(DelaunayTriangle::next(entered)));
  }
}

/// Makes triangles between a point and the sides around those that go for it. They are inside as those were:
/// nothing is inserted elsewhere.
void ConstrainedDelaunay::make_star(Index vertex, const TriangleLocation& place) {
  const DelaunayTriangle& there = triangles_[place.triangle];
  // On the border of the convex hull the star is open.
  const bool is_open = place.on == On::side && there.side_across(place.corner) == k_no_index;
  const Index last_vertex = is_open ? there.from(place.corner) : k_no_index;
  const Vec2 point = points_[vertex];
  carve(point, place);
  const std::size_t n = star_.size();
  while (changed_.size() < n) {
    changed_.push_back(static_cast<Index>(triangles_.size()));
    triangles_.emplace_back();
  }
  for (std::size_t i = 0; i < n; ++i) {
    const bool is_first = i == 0, is_last = i + 1 == n;
    const StarSide& side = star_[i];
    const Index to = !is_last ? star_[i + 1].from : is_open ? last_vertex : star_[0].from;
    const Index before = !is_first ? changed_[i - 1] : changed_[n - 1];
    const Index after = !is_last ? changed_[i + 1] : changed_[0];
    DelaunayTriangle& triangle = triangles_[changed_[i]];
    triangle.vertices = {vertex, side.from, to};
    triangle.across = {side.across, is_last && is_open ? k_no_index : 4 * after + 2,
                       is_first && is_open ? k_no_index : 4 * before + 1};
    triangle.turns = {side.turns, 0, 0};
    triangle.constrained = side.is_constrained ? 1 : 0;
    if (side.across != k_no_index) triangles_[side.across / 4].across[side.across % 4] = 4 * changed_[i];
    if (side.from != detail::k_far && to != detail::k_far) last_ = changed_[i];
  }
}

/// Throws where edges don't close loops.
void ConstrainedDelaunay::check_loops(InsideRule rule) const {
  std::vector<int> ends(points_.size(), 0);
  for (Index t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const DelaunayTriangle& triangle = triangles_[t];
      const int turns = triangle.turns[static_cast<std::size_t>(k)];
      const Index side = 4 * t + static_cast<Index>(k);
      if (turns == 0 || side > triangle.side_across(k)) continue;  // each pair of sides once
      ends[triangle.from(k)] += turns;
      ends[triangle.to(k)] -= turns;
    }
  }
  for (std::size_t v = 0; v < ends.size(); ++v) {
    if (rule == InsideRule::even_odd ? ends[v] % 2 != 0 : ends[v] != 0) {
      throw InputError(fmt::format("the edges at point {} don't close a loop", v));
    }
  }
}

/// How often edges run round each triangle. Where they close loops by one rule only, the numbers are those of
/// some path from outside, and right by that rule.
std::vector<int> ConstrainedDelaunay::winding_numbers() const {
  std::vector<int> numbers(triangles_.size(), 0);
  std::vector<bool> known(triangles_.size(), false);
  std::vector<Index> open;
  const auto enter = [&](Index t, int number) {
    if (known[t]) return;
    known[t] = true;
    numbers[t] = number;
    open.push_back(t);
  };
  for (Index border = 0; border < triangles_.size(); ++border) {
    for (int k = 0; k < 3; ++k) {
      const DelaunayTriangle& triangle = triangles_[border];
      if (triangle.neighbour(k) == k_no_index) enter(border, triangle.turns[static_cast<std::size_t>(k)]);
    }
    while (!open.empty()) {
      const Index t = open.back();
      open.pop_back();
      for (int k = 0; k < 3; ++k) {
        const Index other = triangles_[t].neighbour(k);
        if (other != k_no_index) enter(other, numbers[t] - triangles_[t].turns[static_cast<std::size_t>(k)]);
      }
    }
  }
  return numbers;
}

void ConstrainedDelaunay::keep_inside(InsideRule rule) {
  check_loops(rule);
  const std::vector<int> numbers = winding_numbers();
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    triangles_[t].is_inside = rule == InsideRule::even_odd ? numbers[t] % 2 != 0 : numbers[t] != 0;
  }
}

}  // namespace recede
