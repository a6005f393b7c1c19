// The triangulation of all points. They come in rounds of eight times as many each, drawn at random, so that
// no arrangement of points costs more than about n log n steps (N. Amenta, S. Choi and G. Rote: Incremental
// Constructions con BRIO, 2003), and in each round along Hilbert's curve, so that the next point and its
// triangles are near.
#include <recede/geometry/detail/delaunay_build.h>
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/triangle_walk.h>

#include <algorithm>
#include <bit>
#include <utility>

namespace recede {
namespace {

constexpr std::size_t k_smallest_round = 512;
constexpr int k_bits_a_round = 3;

/// Place along Hilbert's curve through a square of 2^16 by 2^16 cells.
std::uint32_t hilbert_key(std::uint32_t x, std::uint32_t y) {
  // The curve runs through the quarters of a square in one of four ways; a quarter's way is one of them
  // again.
  struct Quarter {
    std::uint8_t rank, way;
  };
  static constexpr Quarter k_quarters[4][4] = {// by way and by 2 x + y
                                               {{0, 1}, {1, 0}, {3, 3}, {2, 0}},
                                               {{0, 0}, {3, 2}, {1, 1}, {2, 1}},
                                               {{2, 2}, {3, 1}, {1, 2}, {0, 3}},
                                               {{2, 3}, {1, 3}, {3, 0}, {0, 2}}};
  std::uint32_t key = 0;
  unsigned way = 0;
  for (int bit = 15; bit >= 0; --bit) {
    const Quarter quarter = k_quarters[way][2 * (x >> bit & 1) + (y >> bit & 1)];
    key = 4 * key + quarter.rank;
    way = quarter.way;
  }
  return key;
}

/// Rounds before the last one that a point is drawn for.
int rounds_before_last(std::size_t point, int most) {
  std::uint64_t hash = (point + 1) * 0x9e3779b97f4a7c15u;
  hash ^= hash >> 32;
  hash *= 0xff51afd7ed558ccdu;
  hash ^= hash >> 32;
  return std::min(std::countr_zero(hash) / k_bits_a_round, most);
}

struct PlaceOnCurve {
  std::uint32_t key;
  Index point;
  bool operator<(const PlaceOnCurve& other) const {
    return key != other.key ? key < other.key : point < other.point;
  }
};

/// Sorts points along the curve through the square around them.
void sort_along_curve(std::span<PlaceOnCurve> places, const std::vector<Vec2>& points) {
  Eigen::AlignedBox2d box;
  for (const PlaceOnCurve& place : places) box.extend(points[place.point]);
  // Halves of the largest doubles don't overflow in a difference; for the smallest it doesn't matter.
  const Vec2 corner = 0.5 * box.min();
  const double side = (0.5 * box.max() - corner).maxCoeff();
  if (!(side > 0)) return;
  constexpr double k_last_cell = 65535;
  const auto cell = [&](double x) {
    return static_cast<std::uint32_t>(std::min(x / side * k_last_cell, k_last_cell));
  };
  for (PlaceOnCurve& place : places) {
    const Vec2 in_box = 0.5 * points[place.point] - corner;
    place.key = hilbert_key(cell(in_box.x()), cell(in_box.y()));
  }
  std::sort(places.begin(), places.end());
}

/// The points' numbers along the curve, and along one of its own through each cell with many points.
std::vector<Index> order_along_curve(const std::vector<Vec2>& points) {
  constexpr std::size_t k_many = 16;
  std::vector<PlaceOnCurve> places(points.size());
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = {0, static_cast<Index>(i)};
  std::vector<std::span<PlaceOnCurve>> crowded(1, places);
  while (!crowded.empty()) {
    const std::span<PlaceOnCurve> all = crowded.back();
    crowded.pop_back();
    sort_along_curve(all, points);
    for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
      while (end < all.size() && all[end].key == all[begin].key) ++end;
      // Those that fill what was sorted are all equal.
      if (end - begin > k_many && end - begin < all.size())
        crowded.push_back(all.subspan(begin, end - begin));
    }
  }
  std::vector<Index> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = places[i].point;
  return order;
}

std::vector<Index> insertion_order(const std::vector<Vec2>& points) {
  std::vector<Index> order = order_along_curve(points);
  int most_rounds = 0;
  while (points.size() >> (k_bits_a_round * most_rounds) > k_smallest_round) ++most_rounds;
  if (most_rounds == 0) return order;
  std::vector<Index> begins(static_cast<std::size_t>(most_rounds) + 2, 0);
  const auto round_of = [&](Index point) {
    return static_cast<std::size_t>(most_rounds - rounds_before_last(point, most_rounds));
  };
  for (const Index point : order) ++begins[round_of(point) + 1];
  for (std::size_t r = 1; r < begins.size(); ++r) begins[r] += begins[r - 1];
  std::vector<Index> in_rounds(order.size());
  for (const Index point : order) in_rounds[begins[round_of(point)]++] = point;
  return in_rounds;
}

}  // namespace

ConstrainedDelaunay::ConstrainedDelaunay(std::span<const Vec2> points,
                                         std::span<const std::array<Index, 2>> edges)
    : points_(points.begin(), points.end()) {
  check(edges);
  Builder builder(*this);
  if (builder.insert_points() && !edges.empty()) {
    const std::vector<Index> vertices = builder.vertex_numbers();
    EdgeInserter(*this, edges, vertices).insert_all();
  }
  builder.finish();
}

ConstrainedDelaunay::Builder::Builder(ConstrainedDelaunay& triangulation)
    : mesh_(triangulation), given_(std::move(triangulation.points_)), order_(insertion_order(given_)) {
  mesh_.points_.resize(given_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) mesh_.points_[i] = given_[order_[i]];
}

void ConstrainedDelaunay::Builder::bring_to(std::size_t place, std::size_t from) {
  std::swap(mesh_.points_[place], mesh_.points_[from]);
  std::swap(order_[place], order_[from]);
}

/// Of the first points that aren't on one line, with the far vertex beyond its sides.
bool ConstrainedDelaunay::Builder::make_first_triangle() {
  const std::vector<Vec2>& points = mesh_.points_;
  std::size_t second = 1, third = 2;
  while (second < points.size() && points[second] == points[0]) ++second;
  if (second >= points.size()) return false;
  bring_to(1, second);
  int sign = 0;
  for (; third < points.size(); ++third) {
    sign = detail::orientation(points[0], points[1], points[third]);
    if (sign != 0) break;
  }
  if (sign == 0) return false;
  bring_to(2, third);
  if (sign < 0) bring_to(1, 2);
  auto& triangles = mesh_.triangles_;
  triangles.reserve(2 * points.size());
  triangles.resize(4);
  triangles[0].vertices = {0, 1, 2};
  triangles[0].across = {4, 8, 12};
  for (const int k : {0, 1, 2}) {
    const auto beyond = [](int side) { return 4 * static_cast<Index>(side + 1); };
    DelaunayTriangle& triangle = triangles[static_cast<std::size_t>(k + 1)];
    triangle.vertices = {detail::k_far, triangles[0].to(k), triangles[0].from(k)};
    triangle.across = {static_cast<Index>(k), beyond(DelaunayTriangle::previous(k)) + 2,
                       beyond(DelaunayTriangle::next(k)) + 1};
  }
  return true;
}

bool ConstrainedDelaunay::Builder::insert_points() {
  if (!make_first_triangle()) {
    find_equal_by_sorting();
    return false;
  }
  const std::size_t n = order_.size();
  equal_.resize(n);
  for (Index v = 0; v < n; ++v) {
    equal_[v] = v;
    if (v < 3) continue;
    TriangleLocation place = mesh_.find(mesh_.points_[v], mesh_.last_);
    if (place.on == TriangleLocation::On::vertex) {
      equal_[v] = mesh_.triangles_[place.triangle].vertex(place.corner);
      continue;
    }
    if (place.on == TriangleLocation::On::outside) place.on = TriangleLocation::On::face;
    mesh_.make_star(v, place);
  }
  return true;
}

void ConstrainedDelaunay::Builder::find_equal_by_sorting() {
  const auto before = [&](Index a, Index b) {
    const Vec2 &p = mesh_.points_[a], &q = mesh_.points_[b];
    return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
  };
  std::vector<Index> sorted(order_.size());
  for (Index v = 0; v < sorted.size(); ++v) sorted[v] = v;
  std::sort(sorted.begin(), sorted.end(), before);
  equal_.resize(sorted.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const bool is_new = i == 0 || before(sorted[i - 1], sorted[i]);
    equal_[sorted[i]] = is_new ? sorted[i] : equal_[sorted[i - 1]];
  }
}

std::vector<Index> ConstrainedDelaunay::Builder::vertex_numbers() const {
  std::vector<Index> numbers(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) numbers[order_[i]] = equal_[i];
  return numbers;
}

void ConstrainedDelaunay::Builder::finish() {
  std::vector<Index> first(order_);
  for (std::size_t i = 0; i < order_.size(); ++i) first[equal_[i]] = std::min(first[equal_[i]], order_[i]);
  mesh_.first_equal_.resize(order_.size());
  for (std::size_t i = 0; i < order_.size(); ++i) mesh_.first_equal_[order_[i]] = first[equal_[i]];
  mesh_.points_ = std::move(given_);

  auto& triangles = mesh_.triangles_;
  std::vector<Index> numbers(triangles.size(), k_no_index);
  Index n = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (detail::far_corner(triangles[t]) < 0) numbers[t] = n++;
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (numbers[t] == k_no_index) continue;
    DelaunayTriangle triangle = triangles[t];
    for (Index& vertex : triangle.vertices) vertex = first[vertex];
    for (Index& across : triangle.across) {
      const Index other = numbers[across / 4];
      across = other == k_no_index ? k_no_index : 4 * other + across % 4;
    }
    triangles[numbers[t]] = triangle;
  }
  triangles.resize(n);
  mesh_.last_ = 0;
  mesh_.changed_.clear();
}

}  // namespace recede
