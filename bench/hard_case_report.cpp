#include "bench_report.h"
#include "hard_case_run.h"
#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

namespace recede::bench {
namespace {

std::string error_text(double error, double unit) {
  if (error < k_exact) return "0";
  return error < 1000 * unit ? fmt::format("{:.3g}", error / unit) : fmt::format("{:.0f}", error / unit);
}

std::string short_outcome(const HardCaseRow& row, const HardCaseResult& result) {
  const std::string first = row.remarks.empty() ? "" : row.remarks.front();
  if (!row.answered) return first.substr(0, first.find(':'));
  if (!row.measured) return first.empty() ? fmt::format("{} faces", row.faces) : first;
  std::string text = fmt::format("{} ; {}", error_text(row.max, 1e-3), error_text(row.rms, 1e-4));
  if (row.faces > result.target) text += fmt::format(" at {:.3g} %", percent(row.faces, result.faces));
  if (row.dropped_faces > 0) text += fmt::format(", {} dropped", row.dropped_faces);
  return text;
}

std::string header(const std::vector<std::string>& columns) {
  std::string rule = "|";
  for (std::size_t i = 0; i < columns.size(); ++i) rule += "---|";
  return fmt::format("| {} |\n{}\n", fmt::join(columns, " | "), rule);
}

std::string overview(const std::vector<HardCaseResult>& results) {
  std::vector<std::string> columns{"case", "faces"};
  for (const HardCaseRow& row : results.front().systems) columns.push_back(row.system);
  std::string text = "## Overview: maximum 1e-3 ; RMS 1e-4\n\n" + header(columns);
  for (const HardCaseResult& result : results) {
    text += fmt::format("| {} | {} |", result.name, result.faces);
    for (const HardCaseRow& row : result.systems) text += fmt::format(" {} |", short_outcome(row, result));
    text += '\n';
  }
  return text + '\n';
}

std::string details(const HardCaseResult& result) {
  std::string text = fmt::format("### {}\n\n{}, {} triangles to {}\n\n", result.name, result.description,
                                 result.faces, result.target);
  text += header({"system", "faces", "maximum 1e-3", "RMS 1e-4", "new borders ; non-manifold edges",
                  "seconds", "what it said, what is odd"});
  for (const HardCaseRow& row : result.systems) {
    text += fmt::format("| {} |", row.system);
    text += row.answered ? fmt::format(" {} |", row.faces) : " |";
    text += row.measured
                ? fmt::format(" {} | {} | {} ; {} |", error_text(row.max, 1e-3), error_text(row.rms, 1e-4),
                              row.new_defects.border_edges, row.new_defects.non_manifold_edges)
                : " | | |";
    text += row.answered ? fmt::format(" {:.2g} |", row.seconds) : " |";
    text += fmt::format(" {} |\n", fmt::join(row.remarks, "; "));
  }
  return text + '\n';
}

std::string operations(const std::vector<HardCaseResult>& results) {
  std::vector<std::string> columns{"case"};
  for (const OperationRow& row : results.front().operations) columns.push_back(row.operation);
  std::string text = "## Our operations\n\n" + header(columns);
  for (const HardCaseResult& result : results) {
    text += fmt::format("| {} |", result.name);
    for (const OperationRow& row : result.operations) text += fmt::format(" {} |", row.outcome);
    text += '\n';
  }
  return text + '\n';
}

std::string csv(const std::vector<HardCaseResult>& results) {
  std::string text =
      "case,system,input_faces,target,answered,faces,seconds,dropped_faces,max_share_of_diagonal,"
      "rms_share_of_diagonal,reported_error_share_of_diagonal,new_border_edges,new_non_manifold_edges,"
      "new_degenerate_faces,remarks\n";
  for (const HardCaseResult& result : results) {
    for (const HardCaseRow& row : result.systems) {
      text += fmt::format("{},{},{},{},{},", quoted(result.name), quoted(row.system), result.faces,
                          result.target, row.answered);
      text += row.answered ? fmt::format("{},{:.6g},{},", row.faces, row.seconds, row.dropped_faces) : ",,,";
      text += row.measured ? fmt::format("{:.6g},{:.6g},{:.6g},{},{},{},", row.max, row.rms, row.reported,
                                         row.new_defects.border_edges, row.new_defects.non_manifold_edges,
                                         row.new_defects.degenerate_faces)
                           : ",,,,,,";
      text += quoted(fmt::format("{}", fmt::join(row.remarks, "; "))) + '\n';
    }
  }
  return text;
}

}  // namespace

BenchSection measure_hard_cases(const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  const std::vector<HardCaseResult> results = run_hard_cases(options);
  BenchSection section;
  if (!results.empty()) section.markdown = overview(results) + operations(results) + "## Each case\n\n";
  for (const HardCaseResult& result : results) section.markdown += details(result);
  write_file_atomically(options.out / "hard-cases.md", section.markdown);
  write_file_atomically(options.out / "hard-cases.csv", csv(results));
  return section;
}

}  // namespace recede::bench
