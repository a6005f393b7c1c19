// Displaced surfaces drawn by what each ray needs, measured: speed, brightness and noise against displacement
// everywhere.
#pragma once

#include "bench_run.h"

#include <string>

namespace recede::bench {

/// Markdown tables for a torus over which a map of waves repeats. Times are those of whole pictures, with all
/// threads; medians over `options.repeats`.
std::string transition_tables(const BenchOptions& options);

}  // namespace recede::bench
