#pragma once

#include <recede/lod/lod_hierarchy.h>

namespace recede::detail {

/// Throws `OptionError` for options out of range.
void check(const HierarchyOptions& options);

}  // namespace recede::detail
