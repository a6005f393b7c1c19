// One cell of the tables: a system, a model, a goal, and everything that was seen.
#pragma once

#include "surface_defects.h"
#include "systems.h"

#include <optional>

namespace recede::bench {

/// How far to simplify. None of the shares: until the system stops by itself.
struct Goal {
  std::string name;
  std::optional<double> face_share{}, vertex_share{};  ///< of the input's, 0 to 1
};

struct Model {
  std::string name;
  bool polygons = false;
  PolygonSoup soup;
  SurfaceDefects defects;
};

/// What crosses from the measuring process: plain numbers. Errors are shares of the input's diagonal.
struct Figures {
  std::size_t faces = 0, vertices = 0;
  std::size_t runs = 0;
  double setup_seconds = 0, seconds = 0, cpu_seconds = 0, proof_seconds = 0;  ///< medians over the runs
  /// Highest resident memory of the first run: conversion and call above the input's arrays, and the call
  /// alone above what was resident when it began.
  std::size_t peak_bytes = 0, call_peak_bytes = 0;
  bool with_errors = false;    ///< otherwise it was only timed, and all below but the quads is 0
  double max = 0, rms = 0;     ///< sampled, two-sided
  double bound = 0;            ///< certified by the bench: the two-sided maximum is no larger
  double reported = 0;         ///< by the system itself; 0: nothing
  SurfaceDefects new_defects;  ///< those that the input didn't have
  double quad_share = 0;
};

struct Row {
  std::string model, goal, system, label;
  bool all_threads = false, polygons = false;
  std::size_t input_faces = 0, input_vertices = 0;
  std::size_t target = 0;            ///< faces, or vertices where the goal says so; 0: none
  std::optional<Figures> figures{};  ///< absent: refused, crashed or out of time
  std::string remark{};              ///< why there are no figures, or why it stopped early
  double million_faces_per_second() const;
  /// It has no more than 1 % above what was asked, so that its error can be compared.
  bool reached_target() const;
};

struct MeasureOptions {
  std::size_t repeats = 3;
  bool with_errors = true;
};

/// Runs the system in a process of its own: first for time and memory, then how far the result is from the
/// input.
Row measure(const System& system, const Model& model, const Goal& goal, const MeasureOptions& options);

double median(std::vector<double> values);

/// Median over the runs of the processor time that `work` takes, all threads together. `before_each` isn't
/// timed.
double median_seconds(std::size_t runs, const std::function<void()>& work,
                      const std::function<void()>& before_each = {});

/// The same of the wall clock, for work that someone waits for.
double median_wall_seconds(std::size_t runs, const std::function<void()>& work);

}  // namespace recede::bench
