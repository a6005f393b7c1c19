// `recede info` for what holds levels or layers instead of a mesh: hierarchies, progressive meshes and
// textured shells.
#pragma once

#include "common.h"
#include <recede/lod/lod_hierarchy.h>

#include <filesystem>

namespace recede::cli {

/// `folder` is the hierarchy's own, in `input`.
void print_hierarchy_info(const std::string& input, const std::filesystem::path& folder,
                          const CommonOptions& common);
/// Units of the lengths in a table of levels, and the view that its distances are for.
void print_lengths(const ViewSettings& view, const char* unit);

void print_progressive_info(const std::string& input, const CommonOptions& common);
void print_shell_info(const std::string& input, const CommonOptions& common);

}  // namespace recede::cli
