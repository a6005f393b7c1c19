// What the two ways of choosing collapses have in common: limits, counts, and committing a collapse.
#pragma once

#include <recede/lod/detail/collapse_log.h>
#include <recede/lod/detail/collapse_rules.h>
#include <recede/lod/detail/corner_table.h>
#include <recede/lod/simplify.h>

#include <memory>

namespace recede::detail {

/// A target in absolute numbers and table units.
struct Limits {
  std::size_t faces = 0, vertices = 0;  ///< 0: none
  double error = 0;                     ///< table units; infinity: none
};

/// Counts since the start of the run.
struct RunCounts {
  std::size_t collapses = 0, interior_collapses = 0, removed_faces = 0, lost_sides = 0, passes = 0;
  std::size_t joined = 0, dropped_parts = 0, dropped_faces = 0;
  double error = 0;  ///< table units
  double cost = 0;   ///< of all collapses by an order of costs; `volume`: table units^6
  RefusedCollapses refused;
  CollapseLog log;  ///< empty unless the table is logged
  void add(const CollapseEffect& effect);
  void add(const RunCounts& other);
};

/// A table under simplification. A strategy derives from it and chooses the collapses.
class Simplifier {
 public:
  Simplifier(CornerTable table, const SimplifyOptions& options, double least_normal_cosine)
      : table_(std::move(table)), options_(options), rules_(table_, least_normal_cosine) {}
  virtual ~Simplifier() = default;
  Simplifier(const Simplifier&) = delete;
  Simplifier& operator=(const Simplifier&) = delete;

  /// Collapses edges until a limit is reached or nothing is left to do.
  StopReason run(const Limits& limits, Progress* progress);

  const CornerTable& table() const { return table_; }
  const RunCounts& counts() const { return counts_; }

  /// Where the simplification stands, to come back to.
  struct State {
    CornerTable table;
    RunCounts counts;
  };
  State state() const { return {table_, counts_}; }
  void restore(const State& state) {
    table_ = state.table;
    counts_ = state.counts;
  }

  /// Keeps the edges around these places, object units, from being collapsed.
  void hold(const std::vector<Vec3>& places);
  void release() { table_.held.clear(); }

 protected:
  /// One pass or sweep under `limits`. Returns how many collapses it made.
  virtual std::size_t pass(const Limits& limits, Progress* progress) = 0;

  bool reached(const Limits& limits) const {
    return (limits.faces > 0 && table_.n_alive_faces <= limits.faces) ||
           (limits.vertices > 0 && table_.n_alive_points <= limits.vertices);
  }
  /// Drops parts whose own error is at most `most_error`, table units, until a limit is reached.
  bool drop(double most_error, const Limits& limits);
  /// Share of the way from `start_faces_` to the limit, for progress.
  double fraction_done(const Limits& limits) const;
  /// Adds to the counts of the run and keeps those of the table.
  void count(const RunCounts& counts);

  CornerTable table_;
  SimplifyOptions options_;
  CollapseRules rules_;
  RunCounts counts_;
  std::size_t start_faces_ = 0, start_points_ = 0;
};

/// Throws `OptionError` for options out of range.
void check(const SimplifyOptions& options);
void check(const SimplifyTarget& target);
/// Targets in table units; `diagonal`, too, is in those.
Limits to_limits(const SimplifyTarget& target, std::size_t input_faces, double diagonal, double scale);
double diagonal_of(const CornerTable& table);
/// Counts and estimates of a run, without errors and seconds.
void fill_report(const Simplifier& simplifier, SimplifyReport& report);

/// The strategy for `options.cost`, with joins where they are wanted.
std::unique_ptr<Simplifier> make_simplifier(CornerTable table, const SimplifyOptions& options);
/// For `volume` and `texture_deviation`.
std::unique_ptr<Simplifier> make_volume_simplifier(CornerTable table, const SimplifyOptions& options);
std::unique_ptr<Simplifier> make_normal_deviation_simplifier(CornerTable table,
                                                             const SimplifyOptions& options);

}  // namespace recede::detail
