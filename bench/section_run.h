// Runs that consist of sections, each with a table.
#pragma once

#include "bench_run.h"
#include <recede/render/svg_plot.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace recede::bench {

/// What a section of a run found: a text with tables, an object for each row, and plots.
struct BenchSection {
  std::string markdown{};
  std::vector<nlohmann::json> rows{};
  std::vector<Plot> curves{};
};

struct NamedSection {
  const char* name;
  BenchSection (*measure)(const BenchOptions&);
  bool in_quick = true;  ///< otherwise `BenchOptions::quick` leaves it out, unless `systems` names it
};

/// Runs the sections that `options.systems` chooses and writes `file`.md and `file`.jsonl, an object a line
/// with the section's name, into `options.out`. Returns texts and plots of all.
BenchSection run_sections(const BenchOptions& options, const std::string& title, const std::string& file,
                          const std::vector<NamedSection>& sections);

}  // namespace recede::bench
