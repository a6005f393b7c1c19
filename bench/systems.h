// What is compared: a simplifier, as a name and a function on polygons.
#pragma once

#include "work_timer.h"
#include <recede/geometry/polygon_soup.h>
#include <recede/lod/simplify.h>

#include <functional>
#include <string>
#include <vector>

namespace recede::bench {

/// What one run gave. Converting to and from the system's own mesh isn't in `seconds`, only its simplify call
/// is.
struct Outcome {
  PolygonSoup result;
  double setup_seconds = 0;         ///< from the soup to the system's mesh
  double seconds = 0;               ///< wall clock of the call
  double cpu_seconds = 0;           ///< of the call, all threads together
  double proof_seconds = 0;         ///< wall clock of proving the error; 0: the system proves nothing
  double reported_error = 0;        ///< what the system says it did, object units; 0: it says nothing
  std::size_t peak_bytes = 0;       ///< resident memory at its highest, conversion and call
  std::size_t call_peak_bytes = 0;  ///< the same of the call alone, above what was resident before it
  std::size_t refused_faces = 0;    ///< of the input, that its mesh can't hold; it went on without them
  std::string remark;               ///< why it stopped before its target, when it says so
};

/// `run` throws `Error` when it can't take the mesh.
struct System {
  std::string name;
  std::string label{};           ///< short, for the legends of the plots
  bool all_threads = false;      ///< otherwise it runs in one
  bool takes_triangles = true;   ///< is measured on the triangle models
  bool takes_polygons = false;   ///< is measured on the polygon models
  bool runs_to_its_end = false;  ///< knows when to stop without a target
  bool in_growth = false;        ///< is measured over growing sizes
  std::function<Outcome(const PolygonSoup&, const SimplifyTarget&)> run;
};

/// All systems of this build, in the order of the tables.
std::vector<System> all_systems();

/// Our words for a target that wasn't reached, with what collapses were refused for most; else empty.
std::string why_it_stopped_early(const SimplifyReport& report);

void add_our_systems(std::vector<System>& systems);
void add_meshoptimizer(std::vector<System>& systems);
void add_openmesh(std::vector<System>& systems);
/// Only in builds with CGAL's GPL packages.
void add_cgal(std::vector<System>& systems);
/// Only where VTK is installed.
void add_vtk(std::vector<System>& systems);

/// Measures wall clock, processor time and memory from its construction to `stop`.
class CallMeter {
 public:
  CallMeter();
  void stop(Outcome& outcome) const;

 private:
  std::size_t setup_peak_, resident_before_;
  WorkTimer timer_;
};

}  // namespace recede::bench
