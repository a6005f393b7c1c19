// One report of many sections.
#pragma once

#include "section_run.h"

#include <functional>
#include <string>
#include <vector>

namespace recede::bench {

struct ReportSection {
  std::string name;      ///< one word
  std::string title;     ///< its heading
  std::string compares;  ///< a sentence: what is beside what
  std::function<BenchSection(const BenchOptions&)> measure;
  bool when_named = false;  ///< not part of a report of all
};

/// Those named, in the order of `all`; without names, all but those `when_named`. Throws `OptionError` for a
/// name that none has.
std::vector<ReportSection> choose_sections(const std::vector<ReportSection>& all,
                                           const std::vector<std::string>& names);

/// Measures the sections one after the other, each in a process of its own, and writes report.md into
/// `options.out` after each, with its curves in report-<name>.svg. Where a section fails, its reason stands
/// in its place, on stderr too. Returns how many failed.
std::size_t write_bench_report(const std::vector<ReportSection>& sections, const BenchOptions& options);

}  // namespace recede::bench
