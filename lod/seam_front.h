// A Seam Graph at any level of detail that its hierarchy allows, finer in some places than in others.
#pragma once

#include <recede/lod/seam_hierarchy.h>

#include <functional>
#include <memory>

namespace recede {

class SeamFront {
 public:
  /// Stands at the coarsest level. `graph` and `hierarchy` must live as long.
  SeamFront(const SeamGraph& graph, const SeamHierarchy& hierarchy);
  SeamFront(SeamFront&&) noexcept;
  SeamFront& operator=(SeamFront&&) noexcept;
  ~SeamFront();

  /// Refines and coarsens until no patch has seams of a larger error than it tolerates. Returns what that
  /// took.
  FrontMoves adapt(std::span<const double> tolerance_of_patch);
  FrontMoves adapt(double tolerance);

  /// Active loops of a patch; none: the patch has vanished. `surface` is its own.
  std::vector<SeamLoop> loops_of(std::size_t patch, const PatchSurface& surface) const;
  bool has_vanished(std::size_t patch) const;
  std::size_t n_patches_left() const;
  bool is_applied(std::size_t split) const;

  /// Patches whose loops or positions changed since the last call.
  std::vector<Index> take_changed();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace recede
