#include "cad_bake.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>

#include <chrono>
#include <numbers>

namespace recede::cli {
namespace {

struct SeamsOptions {
  CommonOptions common;
  std::string input, output;
  SeamGraphOptions seams;
  double error = 0, relative_error = 3e-4;
  double shown_error = 0;
  CLI::Option* absolute = nullptr;
};

struct PartSeams {
  const CadPart* part;
  SeamModel model;
  CadSeamReport report;
};

// Bytes of graph and hierarchy for each sewing point.
double bytes_per_point(const SeamModel& model) {
  const SeamGraph& graph = model.graph;
  const SeamHierarchy& levels = model.hierarchy;
  const std::size_t bytes = graph.positions.size() * sizeof(Vec3) + graph.slots.size() * sizeof(SeamSlot) +
                            (graph.loop_offsets.size() + graph.patch_loops.size()) * sizeof(Index) +
                            levels.vanished.size() * sizeof(VanishedAtSplit) +
                            levels.n_splits() * (sizeof(VertexPair) + sizeof(float) + sizeof(Index)) +
                            levels.changes.size() * sizeof(SlotChange);
  return graph.positions.empty() ? 0
                                 : static_cast<double>(bytes) / static_cast<double>(graph.positions.size());
}

// Lines of an OBJ file for the loops that are left at an error, one group for each patch.
std::string lines_of(const PartSeams& seams, double error, std::size_t& first) {
  SeamFront front(seams.model.graph, seams.model.hierarchy);
  front.adapt(error);
  std::string text = fmt::format("o {}\n", seams.part->name);
  for (const Vec3& point : seams.model.graph.positions)
    text += fmt::format("v {} {} {}\n", point.x(), point.y(), point.z());
  for (std::size_t patch = 0; patch < seams.model.graph.n_patches(); ++patch) {
    const std::vector<SeamLoop> loops = front.loops_of(patch, seams.model.surfaces[patch]);
    if (!loops.empty()) text += fmt::format("g {}\n", seams.model.names[patch]);
    for (const SeamLoop& loop : loops) {
      text += "l";
      for (const SeamSlot& slot : loop) text += fmt::format(" {}", first + slot.vertex);
      text += fmt::format(" {}\n", first + loop.front().vertex);
    }
  }
  first += seams.model.graph.positions.size();
  return text;
}

Json levels_to_json(const SeamModel& model, double diagonal) {
  Json levels = Json::array();
  SeamFront front(model.graph, model.hierarchy);
  for (const double share : {0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4}) {
    front.adapt(share * diagonal);
    std::size_t points = 0, splits = 0;
    for (std::size_t split = 0; split < model.hierarchy.n_splits(); ++split)
      if (front.is_applied(split)) ++splits;
    points = model.graph.positions.size() - model.hierarchy.n_splits() + splits;
    levels.push_back(
        {{"relative_error", share}, {"patches", front.n_patches_left()}, {"sewing_points", points}});
  }
  return levels;
}

void print_text(const PartSeams& seams, double diagonal) {
  const SeamReport& report = seams.report.seams;
  fmt::print("part         {}\n", seams.part->name);
  fmt::print("patches      {} ({} turned to agree with their neighbours)\n", seams.report.patches,
             seams.report.turned);
  fmt::print("points       {} ({:.0f} bytes each)\n", seams.report.sewing_points,
             bytes_per_point(seams.model));
  fmt::print("seams        {} of the file, {} found by position; {} of three patches or more\n",
             report.edges_of_file, report.edges_by_position, report.crowded_edges);
  fmt::print("free edges   {}\n", report.free_edges);
  fmt::print("moved        {} at most\n", length_text(report.largest_move, diagonal));
  for (const SeamGap& gap : report.gaps) {
    fmt::print("gap          {:.3g} between faces {} and {} at {:.6g} {:.6g} {:.6g}\n", gap.distance,
               seams.model.names[gap.patch], seams.model.names[gap.other], gap.point.x(), gap.point.y(),
               gap.point.z());
  }
  fmt::print("error (%)    patches   points\n");
  for (const Json& level : levels_to_json(seams.model, diagonal)) {
    fmt::print("{:9.3g} {:10} {:8}\n", 100 * level["relative_error"].get<double>(),
               level["patches"].get<std::size_t>(), level["sewing_points"].get<std::size_t>());
  }
}

void run(SeamsOptions options) {
  const auto start = std::chrono::steady_clock::now();
  if (!options.output.empty()) check_output_file(options.output, {".obj"});
  TerminalProgress progress(options.common.quiet);
  const CadModel model = read_cad(options.input, {}, &progress);
  const double diagonal = cad_diagonal(model);
  const double error = options.absolute->count() > 0 ? options.error : options.relative_error * diagonal;
  if (!(error > 0)) throw OptionError("the error of seams is above 0");
  options.seams.tolerance = error;
  std::vector<PartSeams> parts;
  for (const CadPart& part : model.parts) {
    SeamModel made = build_seam_model(part, {options.seams, {}}, &progress);
    CadSeamReport report{part.name, made.graph.report, part.patches.size(), made.graph.positions.size(),
                         made.turned};
    parts.push_back({&part, std::move(made), std::move(report)});
  }
  if (!options.output.empty()) {
    std::string text;
    std::size_t first = 1;
    for (const PartSeams& part : parts) text += lines_of(part, options.shown_error, first);
    write_file_atomically(options.output, text);
  }
  progress.clear();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  print_cad_remarks(model, options.common);
  if (!options.common.json) {
    for (const PartSeams& part : parts) print_text(part, diagonal);
    fmt::print("seconds      {:.3g}\n", seconds);
    return;
  }
  Json list = Json::array();
  for (const PartSeams& part : parts) {
    Json json = seams_to_json(part.report, part.model.names);
    json["bytes_per_point"] = bytes_per_point(part.model);
    json["refused"] = part.model.hierarchy.refused;
    json["levels"] = levels_to_json(part.model, diagonal);
    list.push_back(std::move(json));
  }
  print_json({{"command", "seams"},
              {"input", options.input},
              {"diagonal", diagonal},
              {"error", error},
              {"output", options.output.empty() ? Json(nullptr) : Json(options.output)},
              {"parts", list},
              {"left_out", left_out_to_json(model)},
              {"seconds", seconds},
              {"repairs", model.repairs}});
}

}  // namespace

void add_seams_command(CLI::App& app) {
  const auto options = std::make_shared<SeamsOptions>();
  CLI::App* command = app.add_subcommand(
      "seams",
      "Shows where patches of a CAD model meet, what is open, and how many are left at which error.");
  command->footer("Example:\n  recede seams part.step -o seams.obj --shown-error 0.5");
  command->add_option("input", options->input, "CAD file (.step .stp .iges .igs .brep .brp)")->required();
  command->add_option("-o,--output", options->output, "writes the loops as lines of an .obj file");
  const auto group = "Seams";
  options->absolute =
      command->add_option("--error", options->error, "of the finest level, millimetres")->group(group);
  command
      ->add_option("--relative-error", options->relative_error,
                   "the same as a share of the diagonal (0.0003)")
      ->group(group)
      ->excludes(options->absolute);
  command
      ->add_option("--shown-error", options->shown_error,
                   "of the level that is written, millimetres (0: the finest)")
      ->check(not_negative())
      ->group(group);
  add_seam_options(*command, options->seams, group);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
