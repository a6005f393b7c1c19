// recede_bench: everything measured, ours beside the peers, on the same inputs in one run.
#include "appearance_run.h"
#include "bench_command.h"
#include "bench_report.h"
#include "billboard_run.h"
#ifdef RECEDE_BENCH_CAD
#include "cad_run.h"
#endif
#include "dicing_run.h"
#include "displaced_run.h"
#include "hard_case_run.h"
#include "out_of_core_run.h"
#include "progressive_run.h"
#include "round_trips.h"
#include "same_bytes.h"
#include "shell_run.h"
#include "stability_run.h"

namespace {

using recede::bench::ReportSection;

/// In the order of the report; those after `shells` only when they are named.
std::vector<ReportSection> all_sections() {
  using namespace recede::bench;
  return {
      {"simplification", "Simplification",
       "Recede beside meshoptimizer, CGAL, OpenMesh and, where it is installed, VTK.",
       measure_simplification},
      {"growth", "Growth", "Recede and meshoptimizer over spheres of growing size.", measure_growth},
      {"out-of-core", "Meshes larger than memory",
       "Hierarchies baked in chunks beside those baked in memory.", measure_out_of_core},
      {"progressive", "Progressive meshes",
       "Recede's progressive meshes beside OpenMesh's; also textures, charts and maps.", measure_progressive},
      {"dicing", "Diced views", "Surfaces diced for a view beside uniform dicing.", measure_dicing},
      {"displaced", "Displaced surfaces",
       "Rays against displaced surfaces, beside Embree's triangles, grids and subdivision surfaces.",
       measure_displaced},
      {"appearance", "Appearances",
       "Reliefs from afar beside rays that meet them, and beside other filters of slopes.",
       measure_appearance},
#ifdef RECEDE_BENCH_CAD
      {"cad", "CAD models", "Triangles of CAD models beside those of OpenCASCADE's BRepMesh.", measure_cad},
#endif
      {"billboards", "Billboard clouds",
       "Billboard clouds beside those of a Hough transform, octahedral impostors and triangles.",
       measure_billboards},
      {"shells", "Shells",
       "Layers of space over real and spoilt models, the field that they grow along, and volume textures "
       "beside slices.",
       measure_shells},
      {"hard-cases", "Hard cases", "What every system gives on meshes that break simplifiers.",
       measure_hard_cases, true},
      {"stability", "Stability",
       "Every operation over all hard cases and models, and over changed shapes, with a check.",
       measure_stability, true},
      {"same-bytes", "Same bytes", "Fingerprints of results for one and for two threads.", compare_threads,
       true},
      {"round-trips", "Round trips", "Progressive meshes of every model in the folder, into files and back.",
       run_round_trips, true},
#ifdef RECEDE_BENCH_CAD
      {"cad-pictures", "Pictures of CAD models", "Recede's triangles and BRepMesh's from four distances.",
       draw_cad, true},
#endif
      {"billboard-pictures", "Pictures of billboard clouds",
       "Models and their billboards, near by and from afar.", draw_billboards, true},
  };
}

}  // namespace

int main(int argc, char** argv) { return recede::bench::run_bench_command(all_sections(), argc, argv); }
