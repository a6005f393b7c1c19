// Diced views measured: speed, and triangles against uniform dicing of the same error in the picture.
#pragma once

#include "bench_run.h"

#include <string>

namespace recede::bench {

/// Markdown tables of the triangle models that `options.models` finds, with maps of 1024 texels on 2 % of
/// their faces. Times are processor seconds of one thread.
std::string dicing_tables(const BenchOptions& options);

}  // namespace recede::bench
