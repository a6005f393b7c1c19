#include "report_run.h"

#include "child_process.h"
#include "plot_sheet.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace recede::bench {
namespace {

constexpr unsigned k_seconds_allowed = 12 * 3600;

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown processor";
}

std::string head(const BenchOptions& options) {
  return fmt::format(
      "# Benchmarks\n\n{} cores, {}.{} Where the load, the processes that wanted to run, is above the cores, "
      "wall clocks are too long.\n",
      std::thread::hardware_concurrency(), cpu_name(),
      options.quick ? " Small inputs, each measured once: for a quick look." : "");
}

/// Mean of a minute.
double load() {
  double value = 0;
  return ::getloadavg(&value, 1) == 1 ? value : -1;
}

/// Headings below that of the report's section.
std::string lowered(const std::string& markdown) {
  std::istringstream lines(markdown);
  std::string line, text;
  while (std::getline(lines, line)) text += (line.starts_with('#') ? "#" : "") + line + '\n';
  return text;
}

std::string section_text(const ReportSection& section, const BenchOptions& options) {
  const double load_before = load();
  const WorkTimer timer;
  const BenchSection found = section.measure(options);
  const double minutes = timer.wall() / 60;
  std::string text = lowered(found.markdown);
  if (const std::string curves = plot_sheet(found.curves); !curves.empty()) {
    const std::string file = fmt::format("report-{}.svg", section.name);
    write_file_atomically(options.out / file, curves);
    text += fmt::format("\n![{}: curves]({})\n", section.title, file);
  }
  return text +
         fmt::format("\n{:.1f} minutes; load {:.1f} before, {:.1f} after.\n", minutes, load_before, load());
}

}  // namespace

std::vector<ReportSection> choose_sections(const std::vector<ReportSection>& all,
                                           const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const ReportSection& section : all) known.push_back(section.name);
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw OptionError(fmt::format("no section `{}`; there are {}", name, fmt::join(known, ", ")));
  }
  std::vector<ReportSection> chosen;
  for (const ReportSection& section : all) {
    const bool is_named = std::find(names.begin(), names.end(), section.name) != names.end();
    if (is_named || (names.empty() && !section.when_named)) chosen.push_back(section);
  }
  return chosen;
}

std::size_t write_bench_report(const std::vector<ReportSection>& sections, const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  std::string text = head(options);
  std::size_t failures = 0;
  for (const ReportSection& section : sections) {
    fmt::print(stderr, "== {}\n", section.title);
    text += fmt::format("\n## {}\n\n{}\n\n", section.title, section.compares);
    // Sections start threads, and only a process without them may fork.
    const ChildAnswer answer =
        run_in_child([&] { return section_text(section, options); }, k_seconds_allowed);
    if (answer.succeeded) {
      text += answer.bytes;
    } else {
      ++failures;
      std::string reason = answer.failure;
      std::replace(reason.begin(), reason.end(), '\n', ' ');
      text += fmt::format("**Failed:** {}\n", reason);
      fmt::print(stderr, "recede_bench: {}: {}\n", section.name, reason);
    }
    write_file_atomically(options.out / "report.md", text);
  }
  return failures;
}

}  // namespace recede::bench
