// Meshes that break simplifiers: what every system gives on each, and what our operations do.
#pragma once

#include "section_run.h"

#include <optional>

namespace recede::test {
struct HardCase;
}

namespace recede::bench {

/// What a system gave. Errors are shares of the input's diagonal.
struct HardCaseRow {
  std::string system;
  bool answered = false;          ///< otherwise it refused, crashed or took too long
  std::size_t faces = 0;          ///< of the result
  double seconds = 0;             ///< wall clock of the simplify call
  bool measured = false;          ///< otherwise input or result has no surface to measure, and all below is 0
  double max = 0, rms = 0;        ///< sampled, two-sided
  double reported = 0;            ///< by the system itself; 0: nothing
  SurfaceDefects new_defects{};   ///< those that the input didn't have
  std::size_t dropped_faces = 0;  ///< of the input, that the system's mesh can't hold
  std::vector<std::string> remarks{};  ///< what it said, and what is odd about the result
};

/// What one of our operations did, in words.
struct OperationRow {
  std::string operation, outcome;
};

struct HardCaseResult {
  std::string name, description;
  std::size_t faces = 0, target = 0;  ///< triangles of the input, and how many are to stay
  std::vector<HardCaseRow> systems{};
  std::vector<OperationRow> operations{};
};

/// All cases whose name `options.models` finds, each to 10 % of its triangles by every system that
/// `options.systems` finds, in one thread. Every run has a process of its own, which ends after
/// `k_hard_case_seconds`.
std::vector<HardCaseResult> run_hard_cases(const BenchOptions& options);
inline constexpr unsigned k_hard_case_seconds = 60;
/// Errors below this share of the diagonal are rounding.
inline constexpr double k_exact = 1e-9;

/// Each of our operations on the polygons of a case, in processes of their own.
std::vector<OperationRow> run_operations(const test::HardCase& hard_case);

/// All of them as tables. Writes hard-cases.md and hard-cases.csv into `options.out`.
BenchSection measure_hard_cases(const BenchOptions& options);

}  // namespace recede::bench
