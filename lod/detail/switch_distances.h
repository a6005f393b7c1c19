// From where on levels serve.
#pragma once

#include <recede/lod/lod_hierarchy.h>

namespace recede::detail {

/// Sets distances and coverages of all levels from their bounds. Distances count from the nearest point of
/// the bounding sphere, where an error looks largest, and never fall from one level to the next.
void set_switch_distances(LodHierarchy& hierarchy);

}  // namespace recede::detail
