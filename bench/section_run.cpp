#include "section_run.h"

#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

namespace recede::bench {

std::string section_tables(const BenchOptions& options, const std::string& title, const std::string& file,
                           const std::vector<NamedSection>& sections) {
  std::filesystem::create_directories(options.out);
  std::string markdown = "# " + title + '\n', lines;
  for (const NamedSection& section : sections) {
    if (!is_wanted(section.name, options.systems)) continue;
    const BenchSection found = section.measure(options);
    markdown += '\n' + found.markdown;
    for (nlohmann::json row : found.rows) {
      row["section"] = section.name;
      lines += row.dump() + '\n';
    }
    // After each, so that an interrupted run leaves something.
    write_file_atomically(options.out / (file + ".md"), markdown);
    write_file_atomically(options.out / (file + ".jsonl"), lines);
    fmt::print(stderr, "{} is done\n", section.name);
  }
  return markdown;
}

}  // namespace recede::bench
