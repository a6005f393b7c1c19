// Levels of hierarchies, without copies of them.
#pragma once

#include "calls.h"
#include <recede/lod/lod_hierarchy.h>

namespace recede::python {

/// References that keep `owner`, which holds the hierarchy, alive.
py::list levels_of(const LodHierarchy& hierarchy, const py::object& owner);

}  // namespace recede::python
