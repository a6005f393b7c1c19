#include <recede/lod/detail/active_loops.h>

namespace recede::detail {

ActiveLoops::ActiveLoops(const SeamGraph& graph)
    : next_(graph.slots.size()),
      previous_(graph.slots.size()),
      loop_of_(graph.slots.size()),
      next_of_vertex_(graph.slots.size(), k_no_index),
      is_active_(graph.slots.size(), 1),
      first_of_vertex_(graph.positions.size(), k_no_index) {
  for (const SeamSlot& slot : graph.slots) vertices_.push_back(slot.vertex);
  for (std::size_t loop = 0; loop < graph.n_loops(); ++loop) {
    const Index first = graph.loop_offsets[loop], end = graph.loop_offsets[loop + 1];
    sizes_.push_back(end - first);
    first_of_loop_.push_back(first);
    for (Index slot = first; slot < end; ++slot) {
      next_[slot] = slot + 1 < end ? slot + 1 : first;
      previous_[slot] = slot > first ? slot - 1 : end - 1;
      loop_of_[slot] = static_cast<Index>(loop);
    }
  }
  // Backwards, so that the lists are in order.
  for (std::size_t slot = graph.slots.size(); slot-- > 0;) link(static_cast<Index>(slot), vertices_[slot]);
}

void ActiveLoops::link(Index slot, Index vertex) {
  next_of_vertex_[slot] = first_of_vertex_[vertex];
  first_of_vertex_[vertex] = slot;
}

void ActiveLoops::unlink(Index slot) {
  Index* at = &first_of_vertex_[vertices_[slot]];
  while (*at != slot) at = &next_of_vertex_[*at];
  *at = next_of_vertex_[slot];
}

void ActiveLoops::drop(Index slot) {
  unlink(slot);
  is_active_[slot] = 0;
  next_[previous_[slot]] = next_[slot];
  previous_[next_[slot]] = previous_[slot];
  const Index loop = loop_of_[slot];
  --sizes_[loop];
  first_of_loop_[loop] = sizes_[loop] > 0 ? next_[slot] : k_no_index;
}

void ActiveLoops::restore(Index slot) {
  link(slot, vertices_[slot]);
  is_active_[slot] = 1;
  next_[previous_[slot]] = slot;
  previous_[next_[slot]] = slot;
  const Index loop = loop_of_[slot];
  ++sizes_[loop];
  first_of_loop_[loop] = slot;
}

void ActiveLoops::give(Index slot, Index vertex) {
  unlink(slot);
  vertices_[slot] = vertex;
  link(slot, vertex);
}

}  // namespace recede::detail
