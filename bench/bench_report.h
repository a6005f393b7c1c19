// Simplification as tables and plots.
#pragma once

#include "section_run.h"

namespace recede::bench {

/// All systems on all models, and one model to many sizes. Writes simplification.csv into `options.out`.
BenchSection measure_simplification(const BenchOptions& options);

/// Time and memory over growing inputs. Writes growth.csv.
BenchSection measure_growth(const BenchOptions& options);

double percent(std::size_t part, std::size_t whole);

/// A field of a CSV line.
std::string quoted(std::string text);

}  // namespace recede::bench
