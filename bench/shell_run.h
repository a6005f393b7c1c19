// Shells measured: the field that they grow along, their directors, and layers of real and of bad models.
#pragma once

#include "section_run.h"
#include <recede/shells/shell.h>

#include <string>
#include <vector>

namespace recede::bench {

/// Errors of the field and its speed by opening, and how the time of an evaluation grows with triangles.
BenchSection measure_shell_field(const BenchOptions& options);

/// Inverted prisms before any repair along normals, the gradient of the exact distance and that of the
/// averaged one: shapes of the specification's table 2.9.
BenchSection measure_shell_directors(const BenchOptions& options);

/// The source's figures, on shapes that are made by formulas: the field by its power, and layers in narrow
/// places by what directors follow.
BenchSection measure_shell_experiments(const BenchOptions& options);

/// How long edits and frames of animations take, beside building everything anew.
BenchSection measure_shell_updates(const BenchOptions& options);

/// Layers over all closed models in the folder that have at most 100 000 triangles, beside the thickness up
/// to which plain displacement along normals is valid.
BenchSection measure_shell_models(const BenchOptions& options);

/// Layers over sixteen spoilt variants of one mesh.
BenchSection measure_shell_torture(const BenchOptions& options);

/// Volume textures: pictures by rays beside those by slices (`draw_slices`), and what levels keep of opacity
/// and brightness.
BenchSection measure_shell_volumes(const BenchOptions& options);

/// A layer on one side, and how long it took.
struct TimedShell {
  Shell shell;
  double seconds = 0;
};
TimedShell build_timed(const PolygonSoup& surface, ShellSide side, double thickness);

/// The layer of a shell that has one.
const ShellLayer& only_layer(const Shell& shell);

/// As rows and tables call it.
const char* name_of(ShellSide side);

/// Valid, valid but over some triangles, or what is wrong.
std::string verdict_of(const ShellLayer& layer);

/// Runs all sections and writes shells.md and shells.jsonl, an object a line, into `options.out`.
/// `options.systems` chooses sections, `options.models` models. Returns all together.
BenchSection measure_shells(const BenchOptions& options);

}  // namespace recede::bench
