// The slots of a Seam Graph that are there at present, as loops, and whose vertex each of them has.
#pragma once

#include <recede/lod/seam_graph.h>

#include <vector>

namespace recede::detail {

class ActiveLoops {
 public:
  /// With all slots.
  explicit ActiveLoops(const SeamGraph& graph);

  bool is_active(Index slot) const { return is_active_[slot] != 0; }
  Index vertex(Index slot) const { return vertices_[slot]; }
  Index next(Index slot) const { return next_[slot]; }
  Index previous(Index slot) const { return previous_[slot]; }
  Index loop_of(Index slot) const { return loop_of_[slot]; }
  /// Active slots of a loop, and one of them, or k_no_index.
  Index size_of(Index loop) const { return sizes_[loop]; }
  Index first_of(Index loop) const { return first_of_loop_[loop]; }
  /// With fewer slots there is nothing inside.
  static constexpr Index k_least_slots = 3;
  bool encloses(Index loop) const { return sizes_[loop] >= k_least_slots; }

  /// Visits the active slots of a vertex.
  template <typename Visit>
  void each_slot(Index vertex, Visit&& visit) const {
    for (Index slot = first_of_vertex_[vertex]; slot != k_no_index;) {
      const Index after = next_of_vertex_[slot];
      visit(slot);
      slot = after;
    }
  }
  /// Visits the active slots of a loop in its order.
  template <typename Visit>
  void each_slot_of_loop(Index loop, Visit&& visit) const {
    Index slot = first_of_loop_[loop];
    for (Index k = 0; k < sizes_[loop]; ++k, slot = next_[slot]) visit(slot);
  }
  /// Visits the vertices before and after each slot of a vertex, some more than once, and itself where a
  /// loop has it twice in a row.
  template <typename Visit>
  void each_neighbour(Index vertex, Visit&& visit) const {
    each_slot(vertex, [&](Index slot) {
      visit(vertices_[previous_[slot]]);
      visit(vertices_[next_[slot]]);
    });
  }

  /// Takes a slot out of its loop; it remembers where it was.
  void drop(Index slot);
  /// Puts a slot back between those between which it was: the last dropped of neighbours first.
  void restore(Index slot);
  /// Gives a slot another vertex.
  void give(Index slot, Index vertex);

 private:
  void link(Index slot, Index vertex);
  void unlink(Index slot);

  std::vector<Index> vertices_, next_, previous_, loop_of_, next_of_vertex_;
  std::vector<unsigned char> is_active_;
  std::vector<Index> first_of_vertex_, sizes_, first_of_loop_;
};

}  // namespace recede::detail
