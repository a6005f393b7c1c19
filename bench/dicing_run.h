// Diced views measured: speed, and triangles against uniform dicing of the same error in the picture.
#pragma once

#include "section_run.h"

namespace recede::bench {

/// Markdown tables of the triangle models that `options.models` finds, with maps of 1024 texels on 2 % of
/// their faces. Times of the first table are processor seconds of one thread. Curves are those of the
/// bunny, which is the only model of a quick run.
BenchSection measure_dicing(const BenchOptions& options);

}  // namespace recede::bench
