#include <recede/lod/detail/linked_level.h>

namespace recede::detail {

LinkedLevel::LinkedLevel(const ProgressiveMesh& mesh, LevelState state)
    : mesh_(&mesh),
      state_(std::move(state)),
      next_(mesh.corner_vertices.size(), k_no_index),
      previous_(next_.size(), k_no_index),
      first_(mesh.positions.size(), k_no_index) {
  corner_face_.reserve(next_.size());
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    corner_face_.insert(corner_face_.end(), mesh.face_offsets[f + 1] - mesh.face_offsets[f], f);
    if (!state_.is_face_alive(f)) continue;
    each_corner_of(f, [&](Index c) { link(c, state_.corner_vertices()[c]); });
  }
}

void LinkedLevel::move_given(std::size_t split, Index from, Index to) {
  for (const Index c : mesh_->items_of(split).first(mesh_->splits[split].n_corners)) {
    if (!state_.is_face_alive(corner_face_[c]) || !state_.is_corner_alive(c)) continue;
    unlink(c, from);
    link(c, to);
  }
}

/// The corners of faces that come back or go, and single ones of larger faces.
template <bool come>
void LinkedLevel::link_new(std::size_t split) {
  const auto change = [&](Index corner) {
    const Index vertex = state_.corner_vertices()[corner];
    if constexpr (come)
      link(corner, vertex);
    else
      unlink(corner, vertex);
  };
  const auto faces = faces_of(split);
  for (const Index face : faces) each_corner_of(face, change);
  for (const Index corner : mesh_->items_of(split).subspan(mesh_->splits[split].n_corners + faces.size())) {
    change(corner);
  }
}

template <bool refines>
void LinkedLevel::apply(std::size_t split) {
  const auto [removed, kept] = std::pair(mesh_->splits[split].removed, mesh_->splits[split].kept);
  if constexpr (refines) {
    state_.apply<true>(split);
    link_new<true>(split);
    move_given(split, kept, removed);
  } else {
    move_given(split, removed, kept);
    link_new<false>(split);
    state_.apply<false>(split);
  }
}

template void LinkedLevel::apply<true>(std::size_t);
template void LinkedLevel::apply<false>(std::size_t);

}  // namespace recede::detail
