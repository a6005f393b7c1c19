// The polygons of a level while a file is written or read: loops of corners, and the corners at each vertex.
// Writer and reader carry out the same steps, so numbers and orders are the same for both.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <vector>

namespace recede::detail {

/// The corners at a vertex, in the order in which they lie around it.
struct VertexRing {
  std::vector<Index> corners;
  bool is_fan = false;     ///< one fan of faces, each sharing an edge with the next
  bool is_closed = false;  ///< the last shares one with the first
};

class PmeshTable {
 public:
  std::size_t n_vertices() const { return first_.size(); }
  std::size_t n_corners() const { return vertex_.size(); }
  std::size_t n_faces() const { return face_corner_.size(); }

  Index add_vertex();
  /// Corners are numbered on from `n_corners()`.
  Index add_face(std::span<const Index> vertices);
  /// A further corner of the face of `corner`, before or after it.
  Index add_corner(Index corner, bool before, Index vertex);
  void give(Index corner, Index vertex);

  Index vertex(Index corner) const { return vertex_[corner]; }
  Index next(Index corner) const { return next_[corner]; }
  Index previous(Index corner) const { return previous_[corner]; }
  Index face_corner(Index face) const { return face_corner_[face]; }

  template <typename Visit>
  void each_corner(Index of_vertex, Visit&& visit) const {
    const Index first = first_[of_vertex];
    if (first == k_no_index) return;
    Index corner = first;
    do {
      visit(corner);
      corner = ring_next_[corner];
    } while (corner != first);
  }
  void read_ring(Index of_vertex, VertexRing& ring) const;

 private:
  Index new_corner(Index vertex, Index face);
  void link(Index corner, Index vertex);
  void unlink(Index corner);

  std::vector<Index> vertex_, next_, previous_, face_, ring_next_, ring_previous_;  // by corner
  std::vector<Index> first_;                                                        // by vertex: a corner
  std::vector<Index> face_corner_;  // by face: its first corner
};

}  // namespace recede::detail
