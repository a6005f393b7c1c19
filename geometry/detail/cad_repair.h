// Faces mended by OpenCASCADE.
#pragma once

#include <TopTools_IndexedDataMapOfShapeShape.hxx>
#include <TopoDS_Face.hxx>

#include <vector>

namespace recede::detail {

struct MendedFace {
  std::vector<TopoDS_Face> faces;                 ///< one, or more where loops had to be told apart
  TopTools_IndexedDataMapOfShapeShape originals;  ///< from new edges and corners to those of the file
};

/// Closes loops, adds seams and natural bounds, turns loops around, and cuts those that cross.
MendedFace mend_face(const TopoDS_Face& face);

}  // namespace recede::detail
