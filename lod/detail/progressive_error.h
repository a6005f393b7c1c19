// Certified errors for all levels of a progressive mesh.
#pragma once

#include <recede/lod/progressive_mesh.h>

namespace recede::detail {

/// Sets `level_errors` to certified bounds of the two-sided distance between each level and the input.
///
/// From the level to the input: all faces that a split has on its coarse side are measured against the finest
/// level. A level consists of such faces and of faces of the finest level, so its largest is among those of
/// the splits that it lacks.
///
/// From the input to the level: each triangle of the finest level carries the faces of the present level that
/// its bound needs. When a split that is taken back touches one of them, the triangle gets a new bound from
/// the faces that came and from the others that it needed. So it is always near faces that are there.
///
/// The larger of both, as a running maximum toward the base, is the error; mending adds what it is off by.
/// `touched` names for each split the faces whose polygons it changes.
void prove_level_errors(ProgressiveMesh& mesh, const PolygonSoup& input, const SplitRows<Index>& touched,
                        Progress* progress);

}  // namespace recede::detail
