#include "appearance_run.h"

#include <recede/geometry/atomic_file.h>

namespace recede::bench {

std::string appearance_tables(const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  constexpr AppearanceSection (*k_sections[])(const BenchOptions&) = {measure_agreement, measure_transitions,
                                                                      measure_filtered_reflectance};
  AppearanceSection all{.markdown = "# Appearances\n", .csv = "section,surface,method,figure,value\n"};
  for (const auto& measure : k_sections) {
    const AppearanceSection section = measure(options);
    all.markdown += '\n' + section.markdown;
    all.csv += section.csv;
    // After each, so that an interrupted run leaves something.
    write_file_atomically(options.out / "appearance.md", all.markdown);
    write_file_atomically(options.out / "appearance.csv", all.csv);
  }
  return all.markdown;
}

}  // namespace recede::bench
