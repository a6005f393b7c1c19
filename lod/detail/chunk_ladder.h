// A chunk of a surface in ever fewer faces, as costs tell how many it needs beside others.
#pragma once

#include <recede/lod/detail/chunk_files.h>
#include <recede/lod/simplify.h>

namespace recede::detail {

/// A rung: the chunk with so many faces.
struct Rung {
  PolygonSoup soup;
  double cost = 0;  ///< of a face that goes on the way here from the rung before, side^6
};

/// The chunk simplified by `CostPolicy::volume` down to `least_share` of its faces, by `step` of them each
/// time, both in (0, 1). Shared vertices stay, and so do edges between two of them: chunks still meet there.
/// Costs never fall from one rung to the next. The first rung is the chunk without faces that occur twice or
/// visit a vertex twice. Parts are neither joined nor dropped. `side`: the longest of the whole surface's
/// box, which weights of attributes are shares of.
std::vector<Rung> make_ladder(Chunk chunk, double step, double least_share, double side,
                              const SimplifyOptions& options);

}  // namespace recede::detail
