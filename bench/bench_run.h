// The whole comparison: every system on every model for every goal that fits both.
#pragma once

#include "measurement.h"

#include <filesystem>
#include <functional>

namespace recede::bench {

struct BenchOptions {
  std::filesystem::path data = "build/data/meshes", out = "out/bench";
  bool quick = false;           ///< without the largest models
  bool growth = false;          ///< also time over growing sizes
  std::size_t repeats = 3;      ///< runs whose median counts; fewer for long ones
  std::string systems, models;  ///< regular expressions; empty: all
};

struct BenchResults {
  std::vector<Row> rows;
  std::vector<Row> growth;
  double load_at_start = 0, load_at_end = 0;  ///< processes that want to run, mean of one minute
};

bool is_wanted(const std::string& name, const std::string& expression);
/// Those that `options.systems` finds.
std::vector<System> wanted_systems(const BenchOptions& options);

/// `after_model` is called whenever a model is done, so that an interrupted run leaves something. Throws
/// `InputError` when a model can't be had.
BenchResults run_bench(const BenchOptions& options,
                       const std::function<void(const BenchResults&)>& after_model);

}  // namespace recede::bench
