// The nearest point of a triangle surface, and where a line crosses it, by a bounding volume hierarchy in
// double precision.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <limits>

namespace recede {

/// A triangle by its corners.
struct Triangle {
  Vec3 a, b, c;
};

/// The point between `a` and `b` nearest to `p`. They may be one point.
Vec3 closest_point_on_segment(const Vec3& p, const Vec3& a, const Vec3& b);

/// The point of a triangle nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5). Triangles of zero
/// area are segments or points.
Vec3 closest_point_on_triangle(const Vec3& p, const Triangle& triangle);

/// Answers nearest-point queries on a fixed set of triangles. Queries may run in parallel.
class ClosestPointTree {
 public:
  struct Hit {
    double squared_distance = std::numeric_limits<double>::infinity();
    Index triangle = k_no_index;  ///< its number in the list that the tree was built from
    Vec3 point = Vec3::Zero();
  };

  /// `triangles` holds three vertex indices each; there must be at least one triangle. Throws `InputError`
  /// for 2^28 of them or more.
  ClosestPointTree(const std::vector<Vec3>& positions, const std::vector<Index>& triangles);

  /// The nearest point. `hint`, a triangle thought to be near, makes a run of neighbouring queries faster;
  /// among equally near triangles the result may depend on it, the distance never does.
  Hit closest(const Vec3& p, Index hint = k_no_index) const;

  /// The nearest point of every triangle that is at most `distance` away, in the same order on every call.
  std::vector<Hit> closest_within(const Vec3& p, double distance) const;

  /// Gives every triangle a label, in the order of the list given to the constructor.
  void set_labels(const std::vector<Index>& labels);
  /// The nearest point of a triangle with another label, nearer than the square root of `squared_limit`; a
  /// hit without a triangle when there is none.
  Hit closest_of_others(const Vec3& p, Index label, double squared_limit) const;

  /// Where a line crosses a triangle.
  struct Crossing {
    double distance = std::numeric_limits<double>::infinity();  ///< signed, in lengths of the direction
    Index triangle = k_no_index;
    Vec3 weights = Vec3::Zero();  ///< of the triangle's corners; their sum is 1
  };
  /// The crossing nearest to `origin`, ahead or behind, at most `limit` lengths of `direction` away, with a
  /// triangle whose normal points along `direction` rather than against it; without a triangle when there is
  /// none. Lines don't slip through between triangles with a common edge: both see the same signs there
  /// (Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection", in double precision).
  Crossing nearest_crossing(const Vec3& origin, const Vec3& direction, double limit) const;

  Triangle triangle(Index number) const { return triangles_[place_[number]]; }
  std::size_t size() const { return triangles_.size(); }

 private:
  struct Node {
    // Boxes of both children side by side: one visit reads one place in memory.
    Vec3 lower[2], upper[2];
    // Inner child: its node. Leaf: first triangle | count << 28 | leaf bit.
    Index child[2];
  };
  struct Range;

  Index build(std::vector<Index>& order, const std::vector<Vec3>& centers, std::size_t first,
              std::size_t last, Box3& box);
  template <typename MayEnter, typename MayTest>
  void descend(const Vec3& p, Hit& best, MayEnter&& may_enter, MayTest&& may_test) const;

  std::vector<Triangle> triangles_;  // in the order of the leaves
  std::vector<Index> number_;        // of each in the list given
  std::vector<Index> place_;         // inverse of number_
  std::vector<Node> nodes_;
  std::vector<Index> labels_;       // in the order of the leaves; empty: none
  std::vector<Index> node_labels_;  // that of all triangles below a node, k_no_index: several
};

}  // namespace recede
