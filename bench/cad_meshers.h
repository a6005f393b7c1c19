// Triangles of CAD models by Recede and by OpenCASCADE's BRepMesh, each run in a process of its own.
#pragma once

#include "cad_judge.h"

#include <optional>
#include <span>
#include <string>

namespace recede::bench {

/// BRepMesh's angular limit with which the deflection alone counts, radians.
inline constexpr double k_wide_angle = 3;
/// Deflection, over the diagonal, for which Seam Graphs of all levels are set up: that of the dissertation's
/// cars, 0.2 mm.
inline constexpr double k_setup_share = 5e-5;

struct CadRunOptions {
  double deflection = 0;    ///< largest distance asked for, in units of the model
  double angle = 0.5;       ///< BRepMesh's angular limit, radians
  std::size_t repeats = 3;  ///< whose medians count
  bool equal = false;       ///< also looks for the setting whose measured deviation is the deflection
  unsigned seconds_allowed = 600;
};

/// Seconds of a processor, all threads together, and by the wall clock; medians.
struct CadSeconds {
  double cpu = 0, wall = 0;
};

/// How many triangles are needed for a measured deviation that is at most the one asked for.
struct CadEqual {
  double setting = 0;  ///< over the deflection
  double deviation = 0;
  std::size_t triangles = 0;
};

/// Numbers only.
struct CadFigures {
  CadSeconds total;
  CadSeconds surfaces, seams, collapses, triangulation;  ///< of Recede, together the total
  std::size_t peak_bytes = 0;  ///< resident memory of the first run above what was there
  double bound = 0;            ///< proved by Recede
  std::size_t refused = 0;     ///< patches that Recede says aren't within the deflection
  std::size_t vanished = 0;    ///< patches that Recede left out, within the deflection
  std::size_t status = 0;      ///< flags of BRepMesh
  CadJudgement judgement;
  CadEqual equal;  ///< no triangles: not looked for, or everything is flat
};

struct CadAnswer {
  std::optional<CadFigures> figures;
  std::string failure;
};

CadAnswer run_recede(const CadSubject& subject, const CadRunOptions& options);
CadAnswer run_brep_mesh(const CadSubject& subject, const CadRunOptions& options);

/// Sides of one triangle alone when all faces have the deflection, and when every second one has a twentieth.
struct CadLevels {
  std::size_t even = 0, odd_finer = 0;
  std::size_t triangles = 0;  ///< of the second
};
struct CadLevelsAnswer {
  std::optional<CadLevels> levels;
  std::string failure;
};
/// With a `mesh`, writes the triangles of the latter there.
CadLevelsAnswer run_recede_levels(const CadSubject& subject, double deflection,
                                  const std::filesystem::path& mesh = {});
CadLevelsAnswer run_brep_mesh_levels(const CadSubject& subject, double deflection,
                                     const std::filesystem::path& mesh = {});

/// Triangles of the bodies at each of the deflections, made in this process: it can't fork any more then.
/// Recede's are of one Seam Graph, set up for `k_setup_share`; with `all_seams` none of it is collapsed.
std::vector<std::vector<CadBodyMesh>> recede_meshes(const CadSubject& subject,
                                                    std::span<const double> deflections,
                                                    bool all_seams = false);
std::vector<std::vector<CadBodyMesh>> brep_meshes(const CadSubject& subject,
                                                  std::span<const double> deflections,
                                                  double angle = k_wide_angle);

}  // namespace recede::bench
