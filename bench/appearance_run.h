// Appearances of reliefs measured against rays that meet the relief itself.
#pragma once

#include "section_run.h"

#include <string>

namespace recede::bench {

/// What a section of the run found: a text with tables, lines of section,surface,method,figure,value, and
/// plots.
struct AppearanceSection {
  std::string markdown{}, csv{};
  std::vector<Plot> curves{};
};

/// Mean reflectance by filters of the slopes, ours among them: errors, memory and time. Writes a picture,
/// appearance-lobes.png, into the folder of the results.
AppearanceSection measure_filtered_reflectance(const BenchOptions& options);

/// How far bump maps, redistributed and as they are, and tables are from what rays see of reliefs.
AppearanceSection measure_agreement(const BenchOptions& options);

/// A torus over which a map of waves repeats, drawn by what each ray needs: speed, brightness and noise
/// beside displacement everywhere. Times are those of whole pictures, with all threads.
AppearanceSection measure_transitions(const BenchOptions& options);

/// Runs all sections and writes appearance.md and appearance.csv. `options.models` chooses reliefs. Returns
/// text and plots of all.
BenchSection measure_appearance(const BenchOptions& options);

}  // namespace recede::bench
