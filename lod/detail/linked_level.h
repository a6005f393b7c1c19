// A level of a progressive mesh that knows the corners at each vertex.
#pragma once

#include <recede/lod/progressive_mesh.h>

namespace recede::detail {

class LinkedLevel {
 public:
  LinkedLevel(const ProgressiveMesh& mesh, LevelState state);

  const LevelState& state() const { return state_; }
  const Vec3& position(Index corner) const { return state_.positions()[state_.corner_vertices()[corner]]; }
  Index face(Index corner) const { return corner_face_[corner]; }

  /// Applies a split, or takes it back.
  template <bool refines>
  void apply(std::size_t split);

  bool has_faces(Index vertex) const { return first_[vertex] != k_no_index; }
  template <typename Visit>
  void each_corner_at(Index vertex, Visit&& visit) const {
    for (Index c = first_[vertex]; c != k_no_index; c = next_[c]) visit(c);
  }
  /// Also of a face that isn't there.
  template <typename Visit>
  void each_corner_of(Index face, Visit&& visit) const {
    for (Index c = mesh_->face_offsets[face]; c < mesh_->face_offsets[face + 1]; ++c) {
      if (state_.is_corner_alive(c)) visit(c);
    }
  }
  /// The faces that a split brings back.
  std::span<const Index> faces_of(std::size_t split) const {
    return mesh_->items_of(split).subspan(mesh_->splits[split].n_corners, mesh_->splits[split].n_faces);
  }

 private:
  void link(Index corner, Index vertex) {
    next_[corner] = first_[vertex];
    previous_[corner] = k_no_index;
    if (first_[vertex] != k_no_index) previous_[first_[vertex]] = corner;
    first_[vertex] = corner;
  }
  void unlink(Index corner, Index vertex) {
    if (previous_[corner] == k_no_index)
      first_[vertex] = next_[corner];
    else
      next_[previous_[corner]] = next_[corner];
    if (next_[corner] != k_no_index) previous_[next_[corner]] = previous_[corner];
  }
  void move_given(std::size_t split, Index from, Index to);
  template <bool come>
  void link_new(std::size_t split);

  const ProgressiveMesh* mesh_;
  LevelState state_;
  std::vector<Index> corner_face_;
  std::vector<Index> next_, previous_, first_;  // of the lists of corners
};

}  // namespace recede::detail
