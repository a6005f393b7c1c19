// Levels of detail of a CAD model: triangles of its patches at chosen errors, without a gap between patches.
#pragma once

#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/seam_model.h>

#include <string>
#include <vector>

namespace recede {

struct CadHierarchyOptions {
  /// Largest distances between surface and triangles, increasing, units of the model; the first is level 0.
  /// At most one of the three; without one, relative errors 3e-4, 1e-3, 3e-3, 0.01 and 0.03.
  std::vector<double> errors;
  std::vector<double> relative_errors{};  ///< the same as shares of `cad_diagonal`
  std::vector<double> distances{};        ///< of cameras, increasing: error = what `view` permits there
  ViewSettings view;
  double gap = 0;  ///< the widest that is sewn up, units of the model; 0: half of the first error
  bool use_connectivity = true;  ///< what the file knows of shared edges
};

/// How a level of the model came about, all instances of parts together.
struct CadLevelReport {
  std::size_t patches = 0;  ///< that are left
  std::size_t triangles = 0;
  std::size_t tightened = 0;  ///< patches with finer seams than their error asks for
  /// Patches that aren't within the level's error, by name and with theirs. The level's bound is that of all.
  std::vector<std::string> missed;
  double seconds = 0;  ///< to triangulate it
};

/// What was found where parts were sewn, all parts together.
struct CadSeamReport {
  std::string part;
  SeamReport seams;
  std::size_t patches = 0, sewing_points = 0;
  std::size_t turned = 0;  ///< patches whose front was turned to agree with their neighbours'
};

struct CadHierarchy {
  /// Its errors are against the surfaces of the file: `bound` is proved; `max` and `rms` are those of
  /// samples, of triangles from the surface at their parameters and of points of level 0 from the triangles,
  /// the larger of both.
  LodHierarchy hierarchy;
  std::vector<CadLevelReport> levels;
  std::vector<CadSeamReport> parts;
  std::size_t patches = 0;  ///< of the whole model, instances counted each
  double diagonal = 0;      ///< of the box of all trimming loops
};

/// Triangulates each part once for each level and puts it where its instances are. Throws `OptionError` for
/// errors that don't increase, or are given in several ways, and for numbers of the view out of range.
CadHierarchy build_cad_hierarchy(const CadModel& model, const std::string& name,
                                 const CadHierarchyOptions& options = {}, Progress* progress = nullptr);

/// The box of points of all trimming curves, where instances are. Surfaces may bulge out of it.
Box3 cad_trimming_box(const CadModel& model);

/// The diagonal of that box: the size to which shares of errors refer. 0 without curves.
double cad_diagonal(const CadModel& model);

}  // namespace recede
