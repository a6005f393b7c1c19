// Meshes baked in chunks beside the same levels baked in memory.
#pragma once

#include "section_run.h"

namespace recede::bench {

/// Every bake in a process of its own. Writes out-of-core.jsonl, an object for each level.
BenchSection measure_out_of_core(const BenchOptions& options);

}  // namespace recede::bench
