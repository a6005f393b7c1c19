#include "appearance_run.h"

#include <recede/geometry/atomic_file.h>

namespace recede::bench {

BenchSection measure_appearance(const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  constexpr AppearanceSection (*k_sections[])(const BenchOptions&) = {measure_agreement, measure_transitions,
                                                                      measure_filtered_reflectance};
  BenchSection all;
  std::string csv = "section,surface,method,figure,value\n";
  for (const auto& measure : k_sections) {
    const AppearanceSection section = measure(options);
    all.markdown += '\n' + section.markdown;
    all.curves.insert(all.curves.end(), section.curves.begin(), section.curves.end());
    csv += section.csv;
    // After each, so that an interrupted run leaves something.
    write_file_atomically(options.out / "appearance.md", "# Appearances\n" + all.markdown);
    write_file_atomically(options.out / "appearance.csv", csv);
  }
  return all;
}

}  // namespace recede::bench
