// Every operation over every shape that there is, and the same shapes a little changed.
#pragma once

#include "section_run.h"

namespace recede::bench {

/// Each operation on each hard case and each model of the data packages, in processes of their own, with a
/// check of what it promises.
BenchSection measure_operations(const BenchOptions& options);

/// Some shapes with moved vertices, in another order, turned, and larger or smaller: what becomes of the
/// results.
BenchSection measure_perturbations(const BenchOptions& options);

/// Runs both sections and writes stability.md and stability.jsonl, an object a line, into `options.out`.
/// `options.systems` chooses sections, `options.models` shapes. Returns all together.
BenchSection measure_stability(const BenchOptions& options);

}  // namespace recede::bench
