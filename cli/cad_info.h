// What `recede info` says of CAD files.
#pragma once

#include "common.h"

namespace recede::cli {

/// Reads a STEP, IGES or BREP file and prints what it holds, what was left out and what was mended.
void print_cad_info(const std::string& input, const CommonOptions& common);

}  // namespace recede::cli
