// Height fields on which appearances are measured.
#pragma once

#include "bench_run.h"
#include <recede/geometry/displacement_map.h>

#include <string>
#include <vector>

namespace recede::bench {

struct Relief {
  std::string name;
  DisplacementMap map;  ///< 128 x 128, periodic, over a square with sides of 1
  bool held_out;        ///< nothing was chosen by its results
};

/// Gaussian bumps, V-grooves, bricks with bevels, half-spheres and scratches; and, held out, long ripples,
/// cobbles and ground that is rough in every fourth texel.
std::vector<Relief> make_reliefs();

/// Those that `options.models` finds; of the first two when `quick`.
std::vector<Relief> wanted_reliefs(const BenchOptions& options);

}  // namespace recede::bench
