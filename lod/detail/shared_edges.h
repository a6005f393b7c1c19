// Which pieces of trimming curves run along the same edge.
#pragma once

#include <recede/lod/seam_graph.h>

#include <array>

namespace recede::detail {

/// A piece of a trimming curve. Pieces of a curve follow one another.
struct CurvePiece {
  Index patch = 0, loop = 0, curve = 0;
  ParameterRange range;
  Index edge = k_no_index;
  bool is_point = false;                                 ///< in space
  bool runs_against = false;                             ///< the edge
  std::array<Index, 2> corners{k_no_index, k_no_index};  ///< where it starts and ends, in its own direction
};

struct SharedEdges {
  std::vector<CurvePiece> pieces;  ///< patch by patch, loop by loop, in order
  std::vector<bool> is_parallel;   ///< by edge: its pieces meet at equal shares of their ranges
  Index n_corners = 0;
};

/// Takes edges from the file where it knows them and finds the others in space. Gaps and numbers of edges go
/// to `report`.
SharedEdges find_shared_edges(std::span<const TrimmedPatch> patches, std::span<const PatchSurface> surfaces,
                              const SeamGraphOptions& options, SeamReport& report);

}  // namespace recede::detail
