// The faces of a model at the triangles that are left when it is simplified.
#pragma once

#include <recede/lod/detail/plane_cover.h>

namespace recede::detail {

/// What simplification to an error leaves of a model.
struct SimplifiedCover {
  std::vector<CoveringPlane> triangles;  ///< those that have faces
  std::vector<Index> left_over;          ///< faces, rising, that no triangle may take
};

/// For each of rising errors, in units of the model's size: triangles within the error of the model, proved,
/// and the faces of each, by their middles' distance from it. No point of a face is farther from the plane of
/// its triangle than the error, and normals deviate by no more than `options.largest_deviation`.
std::vector<SimplifiedCover> cover_by_simplification(const BillboardFaces& faces,
                                                     std::span<const double> errors,
                                                     const BillboardOptions& options,
                                                     Progress* progress = nullptr);

}  // namespace recede::detail
