// How `ConstrainedDelaunay` comes to be: all points, then the edges, then its numbers.
#pragma once

#include <recede/geometry/constrained_delaunay.h>

namespace recede {

/// Works on vertices in the order of their insertion, next to each other in memory, and with triangles
/// between the border of the convex hull and the far vertex.
class ConstrainedDelaunay::Builder {
 public:
  /// Takes over `triangulation.points_`.
  explicit Builder(ConstrainedDelaunay& triangulation);

  /// False when all points lie on one line, where there is nothing more to do.
  bool insert_points();
  /// Of each point given, the vertex in the order of insertion.
  std::vector<Index> vertex_numbers() const;
  /// Gives vertices the numbers of points again and takes the far vertex out.
  void finish();

 private:
  bool make_first_triangle();
  void find_equal_by_sorting();
  void bring_to(std::size_t place, std::size_t from);

  ConstrainedDelaunay& mesh_;
  std::vector<Vec2> given_;
  std::vector<Index> order_;  // number of the point inserted i-th
  std::vector<Index> equal_;  // the vertex at the place of the one inserted i-th
};

/// Makes edges sides of triangles, before `Builder::finish`.
class ConstrainedDelaunay::EdgeInserter {
 public:
  using Edges = std::span<const std::array<Index, 2>>;

  /// `vertices` are those of the points that edges name.
  EdgeInserter(ConstrainedDelaunay& triangulation, Edges edges, const std::vector<Index>& vertices);
  void insert_all();

 private:
  /// What lies to one side of an edge that crosses triangles: vertices from its begin to its end, and the
  /// sides between them as the crossed triangles knew them.
  struct Chain {
    struct Side {
      Index own, across;  // numbers of sides as in `DelaunayTriangle`
      std::int16_t turns;
      bool is_constrained;
      Index partner;  // the same side from its other side, when both are in the chain
      Index made;     // its number in the new triangles
    };
    std::vector<Index> vertices;
    std::vector<Side> sides;
    std::vector<Index> unpaired;

    void begin_at(Index vertex);
    void add(Index vertex, Index side, const std::vector<DelaunayTriangle>& triangles);
  };
  /// A part of a chain, between which and a side of a triangle there are triangles to make.
  struct Pocket {
    std::size_t begin, end;  // in the chain's vertices
    Index base;              // k_no_index: the first
  };

  bool has_fewer_triangles(Index a, Index b) const;
  Index insert_piece(Index from, Index to);
  int side_of_edge(Index from, Index to, Index vertex) const;
  bool is_ahead(Index from, Index to, Index vertex) const;
  Index cross(Index triangle, int corner, Index from, Index to);
  Index fill(Chain& chain, bool is_left);
  std::size_t best_apex(const Chain& chain, const Pocket& pocket, bool is_left) const;
  void close(Chain& chain, const Pocket& pocket);
  void link(Index side, Index other);
  void mark(Index side);
  [[noreturn]] void refuse_crossing(Index side) const;

  ConstrainedDelaunay& mesh_;
  std::vector<DelaunayTriangle>& triangles_;
  Edges edges_;
  const std::vector<Index>& vertices_;
  std::size_t edge_ = 0;            // the one that is being inserted
  int turn_ = 1;                    // -1: from its end
  std::vector<Index> triangle_at_;  // one of those at each vertex
  std::vector<Index> crossed_;      // triangles that the edge crosses; then free for new ones
  Chain left_, right_;
  std::vector<Pocket> pockets_;
};

}  // namespace recede
