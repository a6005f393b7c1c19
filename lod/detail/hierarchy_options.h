#pragma once

#include <recede/lod/lod_hierarchy.h>

#include <array>

namespace recede::detail {

/// Of levels, where nothing is asked for.
inline constexpr std::array k_default_ratios{0.5, 0.25, 0.1, 0.03, 0.01};

/// Throws `OptionError` for options out of range.
void check(const HierarchyOptions& options);
void check(const ViewSettings& view);

}  // namespace recede::detail
