// Faces merged into clusters that a rectangle can stand for.
#pragma once

#include <recede/lod/detail/billboard_faces.h>

namespace recede::detail {

/// For each of rising errors, in units of the model: the pair of clusters next that wastes the least of its
/// rectangle, among those of the finest error that has any.
std::vector<std::vector<Billboard>> cluster_faces(const BillboardFaces& faces,
                                                  const BillboardOptions& options,
                                                  std::span<const double> errors,
                                                  Progress* progress = nullptr);

}  // namespace recede::detail
