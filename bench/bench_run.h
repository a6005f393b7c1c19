// Simplification compared: every system on every model for every goal that fits both.
#pragma once

#include "measurement.h"

#include <filesystem>
#include <functional>

namespace recede::bench {

struct BenchOptions {
  std::filesystem::path data = "build/data/meshes", out = "out/bench";
  bool quick = false;           ///< without the largest models
  std::size_t repeats = 3;      ///< runs whose median counts; fewer for long ones
  std::string systems, models;  ///< regular expressions; empty: all
};

bool is_wanted(const std::string& name, const std::string& expression);
/// Those that `options.systems` finds.
std::vector<System> wanted_systems(const BenchOptions& options);

/// Gets all rows so far whenever a model is done, so that an interrupted run leaves something.
using AfterModel = std::function<void(const std::vector<Row>&)>;

/// All systems on all models. Throws `InputError` when a model can't be had.
std::vector<Row> run_simplification(const BenchOptions& options, const AfterModel& after_model);

/// One model to many sizes, by the systems that the plots show.
std::vector<Row> run_sizes(const BenchOptions& options, const AfterModel& after_model);

/// To a tenth of the faces, by those that are measured over growing sizes.
std::vector<Row> run_growth(const BenchOptions& options, const AfterModel& after_model);

}  // namespace recede::bench
