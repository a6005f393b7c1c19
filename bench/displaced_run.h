// Rays against displaced surfaces: ours beside Embree's triangles, grids and subdivision surfaces, and the
// recursion that tests all small triangles.
#pragma once

#include "section_run.h"

#include <string>

namespace recede::bench {

/// Measures everything. Each system runs in a process of its own; rates are of one thread.
BenchSection measure_displaced(const BenchOptions& options);

/// Rays that get out of closed surfaces, first hits that differ from brute force, and false shadows, counted.
std::string displaced_checks(const BenchOptions& options);

}  // namespace recede::bench
