// Levels of detail of CAD models measured: Recede's triangles beside those of OpenCASCADE's BRepMesh.
#pragma once

#include "section_run.h"

#include <string>

namespace recede::bench {

/// Measures the models that `options.models` finds; files are looked for in the folder `cad` beside the data.
/// Both sides get the same shapes, the same distances and all threads, and are judged by the same
/// samples of the file's surfaces. Writes cad.md and cad.json into `options.out` and gives the former; also
/// cad-recede.ply and cad-brep-mesh.ply, a model whose faces have two deflections.
BenchSection measure_cad(const BenchOptions& options);

/// What the Seam Graph saves from large to tiny, and what it costs: memory and time of many patches. Part of
/// the former, for models that find `scale`.
std::string cad_scale_tables(const BenchOptions& options);

/// Pictures instead: of three models from four distances, as one camera sees both but enlarged, BRepMesh's
/// triangles above Recede's (cad-distances-<model>.png), and plots of triangles against distance
/// (cad-distances.svg), in `options.out`. Gives the numbers of both, and writes them into cad-distances.md.
BenchSection draw_cad(const BenchOptions& options);

/// Those plots. Part of the former; gives their numbers.
std::string cad_distance_plots(const BenchOptions& options);

}  // namespace recede::bench
