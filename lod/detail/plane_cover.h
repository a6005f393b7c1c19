// Few planes that all faces of a model are near to.
#pragma once

#include <recede/lod/detail/billboard_faces.h>

namespace recede::detail {

/// Faces near to a plane with a normal.
struct CoveringPlane {
  Vec3 normal = Vec3::UnitZ();
  std::vector<Index> faces;  ///< rising; each face is at one plane
};

/// Planes such that each face is within `error` of its own, in units of the model's size; faces that are bent
/// by more have one each. Greedy: the plane that sees the largest area of what is left, out of some
/// directions and all offsets, improved from there (Decoret et al. 2003); then planes go whose faces others
/// can take. Throws `OptionError` for an error so small that offsets are too many.
std::vector<CoveringPlane> cover_by_planes(const BillboardFaces& faces, double error,
                                           Progress* progress = nullptr);

/// The faces of a plane, parted where gaps between them are wide and rectangles of parts are smaller.
std::vector<std::vector<Index>> regions_of(const BillboardFaces& faces, const CoveringPlane& plane);

}  // namespace recede::detail
