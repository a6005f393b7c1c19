// The Seam Graph: trimming loops of all patches of a CAD model as poly-lines over shared points, so that no
// crack can open between patches however they are triangulated.
//
// M. Guthe, J. Meseth, R. Klein: Fast and Memory Efficient View-Dependent Trimmed NURBS Rendering. Pacific
// Graphics 2002. J. Meseth: Towards Predictive Rendering in Virtual Reality. Dissertation, Bonn 2008,
// chapter 6.
#pragma once

#include <recede/geometry/patch_surface.h>
#include <recede/geometry/progress.h>

#include <span>
#include <string>
#include <vector>

namespace recede {

/// A place of a trimming loop: where it is on its own patch, and the point in space that it shares with
/// others.
struct SeamSlot {
  Vec2 uv = Vec2::Zero();  ///< stays as it is on every level
  Index vertex = 0;
};

/// A trimming loop at some level of detail.
struct SeamLoop {
  std::vector<SeamSlot> slots;
  std::vector<float>
      widths;  ///< from each slot to the next: how far trimming curve and chord are apart at most
};

/// A place where patches should meet and don't.
struct SeamGap {
  Index patch = 0;  ///< where the point is
  Index other = 0;  ///< the patch that it is nearest to
  Vec3 point = Vec3::Zero();
  double distance = 0;  ///< the largest along this seam
};

/// What set-up found.
struct SeamReport {
  std::size_t edges_of_file = 0;      ///< seams whose patches the file knew
  std::size_t edges_by_position = 0;  ///< seams that were found where trimming curves meet in space
  std::size_t free_edges = 0;         ///< pieces of loops that no other patch is at
  std::size_t crowded_edges = 0;      ///< seams of three patches or more
  double largest_move = 0;            ///< of a point of a patch by sewing
  std::vector<SeamGap> gaps;          ///< what was too far apart to be sewn
};

struct SeamGraph {
  std::vector<Vec3> positions;  ///< of the sewing points
  std::vector<SeamSlot> slots;  ///< loop by loop, in the loop's order
  std::vector<float>
      widths;  ///< by slot: how far trimming curve and chord up to the next slot are apart in space, at most
  std::vector<Index> loop_offsets{0};  ///< loop l has slots [offsets[l], offsets[l + 1])
  std::vector<Index> patch_loops{0};   ///< patch p has loops [patch_loops[p], patch_loops[p + 1])
  double tolerance = 0;                ///< of triangles, for which it is fine enough
  SeamReport report;

  std::size_t n_patches() const { return patch_loops.size() - 1; }
  std::size_t n_loops() const { return loop_offsets.size() - 1; }
  std::span<const SeamSlot> loop(std::size_t loop) const {
    return {slots.data() + loop_offsets[loop], loop_offsets[loop + 1] - loop_offsets[loop]};
  }
  /// By loop.
  std::vector<Index> patches_of_loops() const;
  /// All of a patch, as fine as they are.
  std::vector<SeamLoop> loops_of(std::size_t patch) const;
};

struct SeamGraphOptions {
  /// The least that triangles of patches will be asked for, in units of the model: poly-lines are as near to
  /// trimming curves as that takes. 0: 1e-4 of the diagonal of the model's box.
  double tolerance = 0;
  /// The widest gap that is sewn up, in units of the model. 0: half of the tolerance.
  double gap = 0;
  /// Takes from the file which patches share an edge, where it says so.
  bool use_connectivity = true;
};

/// Approximates all trimming curves by poly-lines, makes those of neighbours agree point by point, and
/// replaces points that belong together by their mean. `surfaces` are those of the patches.
SeamGraph build_seam_graph(std::span<const TrimmedPatch> patches, std::span<const PatchSurface> surfaces,
                           const SeamGraphOptions& options = {}, Progress* progress = nullptr);

}  // namespace recede
