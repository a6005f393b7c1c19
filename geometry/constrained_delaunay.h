// Triangles between points of the plane, as round as given edges allow, that take further points one by one.
//
// L. P. Chew: Constrained Delaunay Triangulations. Algorithmica 4, 1989.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/vec.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace recede {

/// A triangle and what lies at its sides. Side k lies opposite to vertex k: it runs from vertex k + 1 to
/// vertex k + 2, modulo 3. Half a cache line, so that one visit reads one place in memory.
struct alignas(32) DelaunayTriangle {
  std::array<Index, 3> vertices{};  ///< counter-clockwise
  /// The same sides in the triangles across: 4 times the number of the triangle, plus that of the side there.
  /// k_no_index: the border of the convex hull.
  std::array<Index, 3> across{k_no_index, k_no_index, k_no_index};
  /// How many of the edges on a side run as the side does, less those that run against it.
  std::array<std::int16_t, 3> turns{};
  std::uint8_t constrained = 0;  ///< bit k: side k lies on an edge
  bool is_inside = true;         ///< see `keep_inside`

  static constexpr int next(int k) { return k == 2 ? 0 : k + 1; }
  static constexpr int previous(int k) { return k == 0 ? 2 : k - 1; }
  Index vertex(int k) const { return vertices[static_cast<std::size_t>(k)]; }
  /// The vertices between which a side runs.
  Index from(int side) const { return vertex(next(side)); }
  Index to(int side) const { return vertex(previous(side)); }
  /// The side as the triangle across knows it.
  Index side_across(int side) const { return across[static_cast<std::size_t>(side)]; }
  /// The triangle across a side; k_no_index at the border of the convex hull.
  Index neighbour(int side) const {
    return side_across(side) == k_no_index ? k_no_index : side_across(side) / 4;
  }
  bool is_constrained(int side) const { return (constrained >> side & 1) != 0; }
};

/// Where a point lies.
struct TriangleLocation {
  enum class On { outside, face, side, vertex };
  On on = On::outside;          ///< `outside`: of the convex hull
  Index triangle = k_no_index;  ///< one that holds the point
  int corner = 0;               ///< number there of the side or vertex on which the point lies, 0 to 2
};

/// What is inside loops of edges.
enum class InsideRule {
  even_odd,  ///< what an odd number of edges separates from the outside, however they run
  winding,   ///< what loops run round more often one way than the other
};

enum class InsertionStatus {
  inserted,
  on_vertex,            ///< equal to a vertex
  on_constrained_edge,  ///< the edge may not be split
  outside,              ///< of the convex hull, or of what `keep_inside` kept, or not finite
};

struct Insertion {
  Index vertex = k_no_index;  ///< the new one; for `on_vertex` the one that is there; else k_no_index
  InsertionStatus status = InsertionStatus::outside;
};

/// A constrained Delaunay triangulation of the convex hull of some points: each given edge is made of sides
/// of triangles, and the circle round a triangle has no vertex inside that can be seen from within the
/// triangle past the edges. Where more than three vertices lie on one circle, the order of insertion decides,
/// always in the same way. Signs of exact numbers decide everything, for all finite coordinates.
class ConstrainedDelaunay {
 public:
  /// Vertex i is point i. Points of equal position are one vertex, that of the first of them; the others are
  /// in no triangle, see `first_equal`. Points that all lie on one line make no triangle.
  ///
  /// Edges are pairs of points. One that passes through further points is made of the pieces between them;
  /// a piece may lie on several edges. About n log n steps for n points, whatever their order, and for each
  /// edge as many as it crosses triangles, at worst their square.
  ///
  /// Throws `InputError` for a point that isn't finite, an edge whose ends are equal or aren't there, two
  /// edges that cross where there is no point, more than 32 767 edges that run the same way on one piece, and
  /// more than 2^28 points.
  explicit ConstrainedDelaunay(std::span<const Vec2> points,
                               std::span<const std::array<Index, 2>> edges = {});

  /// Marks the triangles inside the loops of edges: `is_inside` is false for the others, where no point can
  /// be inserted from then on. The numbers of triangles stay. An edge that is there once in each direction
  /// bounds nothing, yet is kept. Without edges nothing is inside.
  ///
  /// Throws `InputError` where edges don't close loops: where their number at a point is odd, or by `winding`
  /// where not as many arrive as leave.
  void keep_inside(InsideRule rule = InsideRule::even_odd);

  /// Makes a point a vertex, unless the status says why it can't be one; nothing changes then. Triangles that
  /// aren't at the new vertex keep their vertices and numbers, and none goes. `near`, a triangle thought to
  /// be near, saves time; without one the search begins where the last point went. Spans got before are no
  /// longer good. Throws `InputError` past 2^28 points.
  Insertion insert(const Vec2& point, Index near = k_no_index);

  /// The triangles that the last insertion made or altered: those at its vertex, which is the first of each.
  /// Empty when it was refused.
  std::span<const Index> changed() const { return changed_; }

  /// Where a point lies, inside or outside of loops. `near` as for `insert`; it never changes the result
  /// but for which of the triangles at a common side or vertex is named.
  TriangleLocation locate(const Vec2& point, Index near = k_no_index) const;

  std::size_t n_vertices() const { return points_.size(); }
  const Vec2& point(Index vertex) const { return points_[vertex]; }
  std::span<const Vec2> points() const { return points_; }
  /// The first point of equal position.
  Index first_equal(Index vertex) const { return first_equal_[vertex]; }

  std::span<const DelaunayTriangle> triangles() const { return triangles_; }
  bool is_inside(Index triangle) const { return triangles_[triangle].is_inside; }

 private:
  class Builder;
  class EdgeInserter;

  /// A side of the star-shaped polygon that becomes the new triangles, and what lies across.
  struct StarSide {
    Index from, across;
    std::int16_t turns;
    bool is_constrained;
  };

  void check(std::span<const std::array<Index, 2>> edges) const;
  TriangleLocation find(const Vec2& point, Index start) const;
  void make_star(Index vertex, const TriangleLocation& place);
  void carve(const Vec2& point, const TriangleLocation& place);
  void open_sides_at(const TriangleLocation& place);
  bool must_go(Index triangle, const Vec2& point) const;
  void check_loops(InsideRule rule) const;
  std::vector<int> winding_numbers() const;

  std::vector<Vec2> points_;
  std::vector<Index> first_equal_;
  std::vector<DelaunayTriangle> triangles_;
  std::vector<Index> changed_;
  Index last_ = 0;  // a triangle of the last star
  // Kept for their memory between insertions.
  std::vector<StarSide> star_;
  std::vector<Index> open_sides_;
};

}  // namespace recede
