// Progressive meshes of all models, into files and back.
#pragma once

#include "section_run.h"

namespace recede::bench {

/// A Markdown table of every mesh in the folder of models and every hard case: bits per vertex of its
/// `.pmesh` files, and whether the full level read back is the input bit for bit. Files are read as they are,
/// without repair, and kept numbering is part of the comparison. `options.models` chooses.
BenchSection run_round_trips(const BenchOptions& options);

}  // namespace recede::bench
