#include "section_run.h"

#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

namespace recede::bench {

BenchSection run_sections(const BenchOptions& options, const std::string& title, const std::string& file,
                          const std::vector<NamedSection>& sections) {
  std::filesystem::create_directories(options.out);
  BenchSection all;
  std::string lines;
  for (const NamedSection& section : sections) {
    if (!is_wanted(section.name, options.systems)) continue;
    if (options.quick && !section.in_quick && options.systems.empty()) continue;
    const BenchSection found = section.measure(options);
    all.markdown += '\n' + found.markdown;
    all.curves.insert(all.curves.end(), found.curves.begin(), found.curves.end());
    for (nlohmann::json row : found.rows) {
      row["section"] = section.name;
      lines += row.dump() + '\n';
    }
    // After each, so that an interrupted run leaves something.
    write_file_atomically(options.out / (file + ".md"), "# " + title + '\n' + all.markdown);
    write_file_atomically(options.out / (file + ".jsonl"), lines);
    fmt::print(stderr, "{} is done\n", section.name);
  }
  return all;
}

}  // namespace recede::bench
