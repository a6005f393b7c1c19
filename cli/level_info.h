// `recede info` for what holds levels or layers instead of a mesh: hierarchies, progressive meshes and
// textured shells.
#pragma once

#include "common.h"

#include <filesystem>

namespace recede::cli {

/// `folder` is the hierarchy's own, in `input`.
void print_hierarchy_info(const std::string& input, const std::filesystem::path& folder,
                          const CommonOptions& common);
void print_progressive_info(const std::string& input, const CommonOptions& common);
void print_shell_info(const std::string& input, const CommonOptions& common);

}  // namespace recede::cli
