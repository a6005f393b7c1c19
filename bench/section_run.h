// Runs that consist of sections, each with a table.
#pragma once

#include "bench_run.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace recede::bench {

/// What a section of a run found: a text with a table, and an object for each of its rows.
struct BenchSection {
  std::string markdown;
  std::vector<nlohmann::json> rows;
};

struct NamedSection {
  const char* name;
  BenchSection (*measure)(const BenchOptions&);
};

/// Runs the sections that `options.systems` chooses and writes `file`.md and `file`.jsonl, an object a line
/// with the section's name, into `options.out`. Returns the text.
std::string section_tables(const BenchOptions& options, const std::string& title, const std::string& file,
                           const std::vector<NamedSection>& sections);

}  // namespace recede::bench
