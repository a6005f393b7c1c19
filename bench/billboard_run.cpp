#include "billboard_run.h"

#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

namespace recede::bench {

std::string billboard_tables(const BenchOptions& options) {
  struct Section {
    const char* name;
    BillboardSection (*measure)(const BenchOptions&);
  };
  constexpr Section k_sections[] = {{"growth", measure_billboard_growth},
                                    {"counts", measure_billboard_counts},
                                    {"planes", measure_plane_counts},
                                    {"outlines", measure_outlines},
                                    {"relit", measure_relit},
                                    {"atlases", measure_atlases},
                                    {"far levels", measure_far_levels}};
  std::filesystem::create_directories(options.out);
  std::string markdown = "# Billboard clouds\n", lines;
  for (const Section& section : k_sections) {
    if (!is_wanted(section.name, options.systems)) continue;
    const BillboardSection found = section.measure(options);
    markdown += '\n' + found.markdown;
    for (nlohmann::json row : found.rows) {
      row["section"] = section.name;
      lines += row.dump() + '\n';
    }
    // After each, so that an interrupted run leaves something.
    write_file_atomically(options.out / "billboards.md", markdown);
    write_file_atomically(options.out / "billboards.jsonl", lines);
    fmt::print(stderr, "{} is done\n", section.name);
  }
  return markdown;
}

}  // namespace recede::bench
