// Coarser and coarser Seam Graphs: half-edge collapses shorten trimming loops and let patches vanish, each
// with a bound of what it costs the surface.
//
// J. Meseth: Towards Predictive Rendering in Virtual Reality. Dissertation, Bonn 2008, section 6.4. Errors
// here are of the surface, not of seams alone: the source bounds distances of seams by the triangle
// inequality, and leaves the inside of patches out.
#pragma once

#include <recede/lod/seam_graph.h>
#include <recede/lod/vertex_hierarchy.h>

#include <limits>
#include <span>
#include <vector>

namespace recede {

/// What a collapse does to a slot: takes it out of its loop, or gives it the vertex that is kept.
class SlotChange {
 public:
  static SlotChange dropped(Index slot) { return SlotChange(2 * slot + 1); }
  static SlotChange given(Index slot) { return SlotChange(2 * slot); }
  Index slot() const { return packed_ / 2; }
  bool is_dropped() const { return packed_ % 2 != 0; }

 private:
  explicit SlotChange(Index packed) : packed_(packed) {}
  Index packed_;
};

/// A patch that had vanished when a collapse took the side away that stood for it, though none of its slots.
struct VanishedAtSplit {
  Index split = 0, patch = 0;
};

struct SeamHierarchy {
  /// Split s takes the collapse back that was made as number n_splits - 1 - s.
  std::vector<VertexPair> splits;
  /// By split: with this tolerance and larger ones a model may do without it. Not rising.
  std::vector<float> errors;
  std::vector<Index> change_offsets{0};  ///< split s has changes [offsets[s], offsets[s + 1])
  std::vector<SlotChange> changes;       ///< in the order of the collapse
  std::vector<VanishedAtSplit> vanished;
  /// Why seams of the coarsest graph are still there: collapses that were forbidden when they were last
  /// tried, by a loop in the way, a hole, a patch that touches itself, or because nothing would have been
  /// left to be near to.
  std::size_t refused = 0;

  std::size_t n_splits() const { return splits.size(); }
  std::span<const SlotChange> changes_of(std::size_t split) const {
    return {changes.data() + change_offsets[split], change_offsets[split + 1] - change_offsets[split]};
  }
};

struct SeamHierarchyOptions {
  /// Collapses that only coarser levels than these need aren't made.
  double largest_error = std::numeric_limits<double>::infinity();
};

/// Collapses the graph as far as it goes, the cheapest first. The error of a collapse bounds, for all patches
/// around it, the strip between trimming curve and chord, the distance of the surface along the chord from
/// it, and how far the chord's ends are from the patch, together; for a patch that vanishes, its distance
/// from the seam between the slots of it that are left, then and whenever these move. What is left of it is
/// at sides of patches that are left, or within a flat one where a hole closed: two patches at least are left
/// of what hangs together as a closed surface, one of a sheet. Loops stay simple in parameters for any choice
/// of splits that `VertexFront` can reach, but for a patch of which a neighbour opens a closed hole again
/// while its outline stays as coarse as it was without: `triangulate_patch` refuses it then, and
/// `SeamTessellation` makes its seams finer.
SeamHierarchy build_seam_hierarchy(const SeamGraph& graph, std::span<const PatchSurface> surfaces,
                                   const SeamHierarchyOptions& options = {}, Progress* progress = nullptr);

}  // namespace recede
