// The results as tables and plots.
#pragma once

#include "bench_run.h"

namespace recede::bench {

/// Time and error, in Markdown.
std::string summary_tables(const BenchResults& results);

/// A field of a CSV line.
std::string quoted(std::string text);

/// Writes results.csv, results.md (these and tables of bounds, memory and defects) and the plots into the
/// folder, which is made when missing.
void write_report(const BenchResults& results, const std::filesystem::path& folder);

}  // namespace recede::bench
