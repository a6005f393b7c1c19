// Edges in a triangulation of points. The triangles that an edge crosses go, and both sides of it are filled
// with triangles whose circles hold no other vertex there (M. V. Anglada: An Improved Incremental Algorithm
// for Constructing Restricted Delaunay Triangulations. Computers & Graphics 21, 1997).
#include <recede/geometry/detail/delaunay_build.h>
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/triangle_walk.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <utility>

namespace recede {
namespace {

int corner_of(const DelaunayTriangle& triangle, Index vertex) {
  return triangle.vertex(0) == vertex ? 0 : triangle.vertex(1) == vertex ? 1 : 2;
}

Index side_number(Index triangle, int side) { return 4 * triangle + static_cast<Index>(side); }

/// Whether p, on the line through a and b, lies between them or at one of them.
bool is_between(const Vec2& a, const Vec2& b, const Vec2& p) {
  return (p.array() >= a.array().min(b.array())).all() && (p.array() <= a.array().max(b.array())).all();
}

}  // namespace

void ConstrainedDelaunay::EdgeInserter::Chain::begin_at(Index vertex) {
  vertices.assign(1, vertex);
  sides.clear();
  unpaired.clear();
}

void ConstrainedDelaunay::EdgeInserter::Chain::add(Index vertex, Index side,
                                                   const std::vector<DelaunayTriangle>& triangles) {
  const DelaunayTriangle& triangle = triangles[side / 4];
  const Index number = static_cast<Index>(sides.size()), across = triangle.across[side % 4];
  Side added{
      side,       across,    triangle.turns[side % 4], triangle.is_constrained(static_cast<int>(side % 4)),
      k_no_index, k_no_index};
  // A side that hangs into the crossed triangles is met twice, like a pair of brackets.
  if (!unpaired.empty() && sides[unpaired.back()].own == across) {
    added.partner = unpaired.back();
    sides[added.partner].partner = number;
    unpaired.pop_back();
  } else {
    unpaired.push_back(number);
  }
  vertices.push_back(vertex);
  sides.push_back(added);
}

ConstrainedDelaunay::EdgeInserter::EdgeInserter(ConstrainedDelaunay& triangulation, Edges edges,
                                                const std::vector<Index>& vertices)
    : mesh_(triangulation), triangles_(triangulation.triangles_), edges_(edges), vertices_(vertices) {
  triangle_at_.resize(mesh_.points_.size(), k_no_index);
  for (Index t = 0; t < triangles_.size(); ++t) {
    if (detail::far_corner(triangles_[t]) >= 0) continue;
    for (const Index vertex : triangles_[t].vertices) triangle_at_[vertex] = t;
  }
}

void ConstrainedDelaunay::EdgeInserter::insert_all() {
  for (edge_ = 0; edge_ < edges_.size(); ++edge_) {
    Index at = vertices_[edges_[edge_][0]], end = vertices_[edges_[edge_][1]];
    turn_ = has_fewer_triangles(end, at) ? -1 : 1;
    if (turn_ < 0) std::swap(at, end);
    while (at != end) at = insert_piece(at, end);
  }
}

/// Whether fewer triangles meet at a than at b; counts no further than that takes.
bool ConstrainedDelaunay::EdgeInserter::has_fewer_triangles(Index a, Index b) const {
  const auto next_at = [&](Index vertex, Index triangle) {
    const DelaunayTriangle& here = triangles_[triangle];
    return here.neighbour(DelaunayTriangle::next(corner_of(here, vertex)));
  };
  Index at_a = triangle_at_[a], at_b = triangle_at_[b];
  do {
    at_a = next_at(a, at_a);
    at_b = next_at(b, at_b);
    if (at_b == triangle_at_[b]) return false;
  } while (at_a != triangle_at_[a]);
  return true;
}

/// 1: the vertex lies to the left, -1: to the right, 0: on the line through both.
int ConstrainedDelaunay::EdgeInserter::side_of_edge(Index from, Index to, Index vertex) const {
  if (vertex == to) return 0;
  return detail::orientation(mesh_.points_[from], mesh_.points_[to], mesh_.points_[vertex]);
}

/// Whether a vertex on the line through `from` and `to` lies on the same side of `from` as `to`.
bool ConstrainedDelaunay::EdgeInserter::is_ahead(Index from, Index to, Index vertex) const {
  const Vec2 &a = mesh_.points_[from], &b = mesh_.points_[to], &p = mesh_.points_[vertex];
  return a.x() != b.x() ? (a.x() < b.x()) == (a.x() < p.x()) : (a.y() < b.y()) == (a.y() < p.y());
}

/// Makes the way towards `to` up to the first vertex on it a side, and returns that vertex.
Index ConstrainedDelaunay::EdgeInserter::insert_piece(Index from, Index to) {
  // Counter-clockwise round `from`, until the edge runs along a side or into a triangle.
  Index here = triangle_at_[from];
  int sign = side_of_edge(from, to, triangles_[here].from(corner_of(triangles_[here], from)));
  for (std::size_t n = 0; n < triangles_.size(); ++n) {
    const DelaunayTriangle& triangle = triangles_[here];
    const int corner = corner_of(triangle, from);
    const Index first = triangle.from(corner), second = triangle.to(corner);
    if (first != detail::k_far && sign == 0 && is_ahead(from, to, first)) {
      mark(side_number(here, DelaunayTriangle::previous(corner)));
      return first;
    }
    const int next_sign = second == detail::k_far ? 0 : side_of_edge(from, to, second);
    const bool has_both = first != detail::k_far && second != detail::k_far;
    if (has_both && sign < 0 && next_sign > 0) return cross(here, corner, from, to);
    sign = next_sign;
    here = triangle.neighbour(DelaunayTriangle::next(corner));
  }
  throw std::logic_error("triangles round a vertex leave a gap");
}

/// Makes the piece from a corner of a triangle through the side opposite to it.
Index ConstrainedDelaunay::EdgeInserter::cross(Index triangle, int corner, Index from, Index to) {
  crossed_.assign(1, triangle);
  left_.begin_at(from);
  right_.begin_at(from);
  left_.add(triangles_[triangle].to(corner), side_number(triangle, DelaunayTriangle::next(corner)),
            triangles_);
  right_.add(triangles_[triangle].from(corner), side_number(triangle, DelaunayTriangle::previous(corner)),
             triangles_);
  Index side = side_number(triangle, corner), end = k_no_index;
  while (end == k_no_index) {
    if (triangles_[side / 4].is_constrained(static_cast<int>(side % 4))) refuse_crossing(side);
    const Index entered = triangles_[side / 4].across[side % 4], here = entered / 4;
    const int apex = static_cast<int>(entered % 4);
    const Index vertex = triangles_[here].vertex(apex);
    const Index left_side = side_number(here, DelaunayTriangle::previous(apex));
    const Index right_side = side_number(here, DelaunayTriangle::next(apex));
    crossed_.push_back(here);
    const int sign = side_of_edge(from, to, vertex);
    if (sign >= 0) left_.add(vertex, left_side, triangles_);
    if (sign <= 0) right_.add(vertex, right_side, triangles_);
    if (sign == 0) end = vertex;
    side = sign > 0 ? right_side : left_side;
  }
  const Index left_base = fill(left_, true), right_base = fill(right_, false);
  link(left_base, right_base);
  mark(left_base);
  return end;
}

/// Makes triangles between a chain and the edge; returns the side on the edge.
Index ConstrainedDelaunay::EdgeInserter::fill(Chain& chain, bool is_left) {
  Index edge_side = k_no_index;
  pockets_.assign(1, {0, chain.vertices.size() - 1, k_no_index});
  while (!pockets_.empty()) {
    const Pocket pocket = pockets_.back();
    pockets_.pop_back();
    if (pocket.end == pocket.begin + 1) {
      close(chain, pocket);
      continue;
    }
    const std::size_t apex = best_apex(chain, pocket, is_left);
    const Index number = crossed_.back(), base = side_number(number, 2);
    crossed_.pop_back();
    const Index begin = chain.vertices[pocket.begin], end = chain.vertices[pocket.end];
    DelaunayTriangle& triangle = triangles_[number];
    triangle = DelaunayTriangle{};
    triangle.vertices = {is_left ? begin : end, is_left ? end : begin, chain.vertices[apex]};
    for (const Index vertex : triangle.vertices) triangle_at_[vertex] = number;
    if (pocket.base == k_no_index) {
      edge_side = base;
    } else {
      link(base, pocket.base);
    }
    pockets_.push_back({pocket.begin, apex, side_number(number, is_left ? 1 : 0)});
    pockets_.push_back({apex, pocket.end, side_number(number, is_left ? 0 : 1)});
  }
  return edge_side;
}

/// The vertex between the ends of a pocket whose circle with them holds none of the others.
std::size_t ConstrainedDelaunay::EdgeInserter::best_apex(const Chain& chain, const Pocket& pocket,
                                                         bool is_left) const {
  const auto point = [&](std::size_t i) -> const Vec2& { return mesh_.points_[chain.vertices[i]]; };
  const Vec2& a = point(is_left ? pocket.begin : pocket.end);
  const Vec2& b = point(is_left ? pocket.end : pocket.begin);
  std::size_t best = pocket.begin + 1;
  for (std::size_t i = best + 1; i < pocket.end; ++i) {
    if (detail::side_of_circle(a, b, point(best), point(i)) > 0) best = i;
  }
  return best;
}

/// A pocket without vertices: its base is a side of the chain.
void ConstrainedDelaunay::EdgeInserter::close(Chain& chain, const Pocket& pocket) {
  Chain::Side& side = chain.sides[pocket.begin];
  side.made = pocket.base;
  DelaunayTriangle& triangle = triangles_[pocket.base / 4];
  triangle.turns[pocket.base % 4] = side.turns;
  if (side.is_constrained) triangle.constrained |= static_cast<std::uint8_t>(1u << (pocket.base % 4));
  if (side.partner == k_no_index) {
    link(pocket.base, side.across);
  } else if (chain.sides[side.partner].made != k_no_index) {
    link(pocket.base, chain.sides[side.partner].made);
  }
}

void ConstrainedDelaunay::EdgeInserter::link(Index side, Index other) {
  triangles_[side / 4].across[side % 4] = other;
  triangles_[other / 4].across[other % 4] = side;
}

/// Puts the edge on a side that runs as it is inserted, and on the side across.
void ConstrainedDelaunay::EdgeInserter::mark(Index side) {
  for (const Index s : {side, triangles_[side / 4].across[side % 4]}) {
    DelaunayTriangle& triangle = triangles_[s / 4];
    std::int16_t& turns = triangle.turns[s % 4];
    const int sum = turns + (s == side ? turn_ : -turn_);
    if (std::abs(sum) > std::numeric_limits<std::int16_t>::max()) {
      throw InputError(fmt::format("more than {} edges lie upon edge {}",
                                   std::numeric_limits<std::int16_t>::max(), edge_));
    }
    turns = static_cast<std::int16_t>(sum);
    triangle.constrained |= static_cast<std::uint8_t>(1u << (s % 4));
  }
}

/// Names the edge that crosses the one being inserted at a side.
void ConstrainedDelaunay::EdgeInserter::refuse_crossing(Index side) const {
  const DelaunayTriangle& triangle = triangles_[side / 4];
  const int k = static_cast<int>(side % 4);
  const Vec2 &p = mesh_.points_[triangle.from(k)], &q = mesh_.points_[triangle.to(k)];
  std::size_t other = 0;
  for (; other < edge_; ++other) {
    const Vec2& a = mesh_.points_[vertices_[edges_[other][0]]];
    const Vec2& b = mesh_.points_[vertices_[edges_[other][1]]];
    if (is_between(a, b, p) && is_between(a, b, q) && detail::orientation(a, b, p) == 0 &&
        detail::orientation(a, b, q) == 0) {
      break;
    }
  }
  throw InputError(fmt::format("edge {} from point {} to {} and edge {} from point {} to {} cross", other,
                               edges_[other][0], edges_[other][1], edge_, edges_[edge_][0],
                               edges_[edge_][1]));
}

}  // namespace recede
