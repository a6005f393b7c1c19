#include "shell_run.h"

#include <recede/geometry/atomic_file.h>

#include <fmt/format.h>

namespace recede::bench {

const ShellLayer& only_layer(const Shell& shell) {
  return shell.exterior ? *shell.exterior : shell.interior.value();
}

std::string verdict_of(const ShellLayer& layer) {
  if (layer.validity.is_valid()) return "yes";
  if (layer.is_valid_elsewhere) {
    return layer.given_up.empty()
               ? fmt::format("but over {}", layer.excused.size())
               : fmt::format("but over {}, {} given up", layer.excused.size(), layer.given_up.size());
  }
  return fmt::format("no: {} inverted, {} contacts, {} nested; {} excused", layer.validity.inverted.size(),
                     layer.validity.top_contacts.size() + layer.validity.layer_contacts.size() +
                         layer.validity.wall_contacts.size(),
                     layer.validity.nested_pieces.size(), layer.excused.size());
}

std::string shell_tables(const BenchOptions& options) {
  struct Section {
    const char* name;
    ShellSection (*measure)(const BenchOptions&);
  };
  constexpr Section k_sections[] = {{"field", measure_shell_field},
                                    {"directors", measure_shell_directors},
                                    {"torture", measure_shell_torture},
                                    {"models", measure_shell_models}};
  std::filesystem::create_directories(options.out);
  std::string markdown = "# Shells\n", lines;
  for (const Section& section : k_sections) {
    if (!is_wanted(section.name, options.systems)) continue;
    const ShellSection found = section.measure(options);
    markdown += '\n' + found.markdown;
    for (nlohmann::json row : found.rows) {
      row["section"] = section.name;
      lines += row.dump() + '\n';
    }
    // After each, so that an interrupted run leaves something.
    write_file_atomically(options.out / "shells.md", markdown);
    write_file_atomically(options.out / "shells.jsonl", lines);
    fmt::print(stderr, "{} is done\n", section.name);
  }
  return markdown;
}

}  // namespace recede::bench
