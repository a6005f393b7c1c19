// `recede bake` for CAD files.
#pragma once

#include "cad_info.h"
#include <recede/lod/cad_hierarchy.h>

namespace recede::cli {

struct CadBakeOptions {
  CommonOptions common;
  std::string input, output, up;
  CadHierarchyOptions hierarchy;
  bool no_report = false;
  std::size_t viewer_triangles = 0;
  HierarchyWriteOptions write;
};

/// Adds `--gap` and `--no-connectivity`.
void add_seam_options(CLI::App& command, SeamGraphOptions& options, const std::string& group);

void bake_cad(const CadBakeOptions& options);

/// Fields `part`, `patches`, `sewing_points`, `edges_of_file`, `edges_by_position`, `free_edges`,
/// `crowded_edges`, `turned`, `largest_move` and `gaps`.
Json seams_to_json(const CadSeamReport& report, const std::vector<std::string>& names);

}  // namespace recede::cli
