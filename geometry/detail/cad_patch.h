// From OpenCASCADE's classes to plain patches.
#pragma once

#include <recede/geometry/detail/cad_face.h>
#include <recede/geometry/trimmed_patch.h>

#include <TopTools_IndexedDataMapOfShapeShape.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include <string>
#include <vector>

namespace recede::detail {

/// Numbers of a part's edges and corners in the order of their first use.
struct PartNumbers {
  TopTools_IndexedMapOfShape edges, corners;
  std::vector<double> edge_tolerances;
  /// Places of degenerate sides don't count: `edge` has a curve in space.
  Index edge(const TopoDS_Shape& shape, double tolerance);
  Index corner(const TopoDS_Shape& shape);
};

/// `originals` leads from edges and corners that were mended to those of the file, which have the numbers.
TrimmedPatch to_patch(const TrimmedFace& face, const TopTools_IndexedDataMapOfShapeShape& originals,
                      PartNumbers& numbers);

}  // namespace recede::detail
