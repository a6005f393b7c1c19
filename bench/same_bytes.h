// Fingerprints of results for one and for two threads.
#pragma once

#include "section_run.h"

namespace recede::bench {

/// A Markdown table of ten models, simplified to 10 % of their faces: 64-bit FNV-1a hashes of all bytes of
/// the result, and where two threads give another. `options.models` chooses.
BenchSection compare_threads(const BenchOptions& options);

}  // namespace recede::bench
