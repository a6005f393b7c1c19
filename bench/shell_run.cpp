#include "shell_run.h"

#include "work_timer.h"

#include <fmt/format.h>

namespace recede::bench {

TimedShell build_timed(const PolygonSoup& surface, ShellSide side, double thickness) {
  ShellOptions options;
  options.thickness = thickness;
  options.side = side;
  const WorkTimer timer;
  TimedShell timed{build_shell(surface, options)};
  timed.seconds = timer.wall();
  return timed;
}

const ShellLayer& only_layer(const Shell& shell) {
  return shell.exterior ? *shell.exterior : shell.interior.value();
}

const char* name_of(ShellSide side) {
  return side == ShellSide::exterior ? "exterior" : side == ShellSide::interior ? "interior" : "envelope";
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

BenchSection measure_shells(const BenchOptions& options) {
  return run_sections(options, "Shells", "shells",
                      {{"field", measure_shell_field},
                       {"directors", measure_shell_directors, false},
                       {"experiments", measure_shell_experiments, false},
                       {"updates", measure_shell_updates, false},
                       {"torture", measure_shell_torture},
                       {"volumes", measure_shell_volumes, false},
                       {"models", measure_shell_models, false}});
}

}  // namespace recede::bench
