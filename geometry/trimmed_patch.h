// A patch of a CAD model: a NURBS surface, of which loops of curves say what part is there.
#pragma once

#include <recede/geometry/nurbs.h>
#include <recede/geometry/polygon_soup.h>

#include <array>
#include <string>
#include <vector>

namespace recede {

/// A piece of a trimming loop, in the parameters of the surface. It runs through its whole domain.
struct TrimmingCurve {
  NurbsCurve2 curve;
  /// The edge of the model that it lies on, as the file knows it; k_no_index: it doesn't say, or the curve is
  /// a side of the surface that is one point. Curves of an edge meet in space: a share x of the domain of
  /// one is where the share x of another is, or 1 - x where one of them `runs_against` the edge.
  Index edge = k_no_index;
  bool runs_against = false;
  /// The corners of the model between which it runs, in its own direction, as the file knows them.
  std::array<Index, 2> corners{k_no_index, k_no_index};
};

/// A closed loop: each curve ends where the next one begins, and the last where the first begins.
struct TrimmingLoop {
  std::vector<TrimmingCurve> curves;
};

/// Inside is to the left of the loops, seen in the plane of the parameters with u to the right and v up: an
/// outer loop runs counter-clockwise, those of holes clockwise.
struct TrimmedPatch {
  NurbsSurface surface;
  std::vector<TrimmingLoop> loops;
  bool is_reversed = false;  ///< the front is where du x dv points away from
  std::string name;          ///< what the file calls it, or its number there
  Index material = k_no_index;
};

}  // namespace recede
