// What `recede info` says of CAD files.
#pragma once

#include "common.h"
#include <recede/geometry/cad_import.h>

namespace recede::cli {

/// Reads a STEP, IGES or BREP file and prints what it holds, what was left out and what was mended.
void print_cad_info(const std::string& input, const CommonOptions& common);

/// What was left out of the model and what was mended to read it, a few lines of each on standard error.
void print_cad_remarks(const CadModel& model, const CommonOptions& options);
/// Objects with `entity` and `reason`.
Json left_out_to_json(const CadModel& model);

}  // namespace recede::cli
