// A face of a CAD file with its surface and its loops as B-splines.
#pragma once

#include <recede/geometry/detail/cad_loops.h>

#include <string>
#include <vector>

namespace recede::detail {

/// A curve of a loop in the NURBS parameters, in the loop's direction.
struct TrimmedUse {
  EdgeUse use;
  Handle(Geom2d_BSplineCurve) curve;
  bool meets_edge = true;  ///< stays at the edge's curve in space
};

using TrimmedLoop = std::vector<TrimmedUse>;

struct TrimmedFace {
  ConvertedSurface surface;
  std::vector<TrimmedLoop> loops;
  std::vector<std::string> left_out, repairs;  ///< in words that follow the face's name
};

/// Converts a face; its own orientation doesn't matter. `size` is that of the body. Ends of curves that
/// follow each other are the same point. Throws `CadProblem` when the face can't be used as it is.
TrimmedFace trim_face(const TopoDS_Face& face, double size, bool repair);

}  // namespace recede::detail
