// Loops of a face: its edges in order, each beginning where the one before ends, in the file's parameters.
#pragma once

#include <recede/geometry/detail/cad_trimming.h>

#include <TopoDS_Face.hxx>

#include <string>
#include <vector>

namespace recede::detail {

using EdgeLoop = std::vector<EdgeUse>;

struct FaceLoops {
  std::vector<EdgeLoop> loops;
  std::vector<std::string> left_out;  ///< edges that bound nothing, in words
  std::vector<std::string> repairs;
};

/// The loops of a face that is oriented forward, or of its surface's natural bounds when it has none. Curves
/// of periodic surfaces move by whole periods to meet; a missing side at a pole is added, and said in
/// `repairs` when `repair` allows it. Throws `CadProblem` when a loop doesn't close.
FaceLoops find_loops(const TopoDS_Face& face, bool repair);

}  // namespace recede::detail
