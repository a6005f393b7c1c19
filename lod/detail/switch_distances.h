// From where on levels serve.
#pragma once

#include <recede/lod/lod_hierarchy.h>

namespace recede::detail {

/// Sets the middle and the radius of the sphere from the points of level 0.
void set_bounding_sphere(LodHierarchy& hierarchy, const std::vector<Vec3>& points);

/// Sets distances and coverages of all levels from their bounds. Distances count from the nearest point of
/// the bounding sphere, where an error looks largest, and never fall from one level to the next.
void set_switch_distances(LodHierarchy& hierarchy);

}  // namespace recede::detail
