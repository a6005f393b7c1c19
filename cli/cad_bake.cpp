#include "cad_bake.h"

#include "level_info.h"
#include <recede/render/report.h>

#include <chrono>

namespace recede::cli {
namespace {

Json level_to_json(const CadHierarchy& cad, const HierarchyFiles& files, std::size_t i) {
  const LodLevel& level = cad.hierarchy.levels[i];
  return {{"level", i},
          {"file", files.level_files[i].string()},
          {"bytes", files.level_bytes[i]},
          {"glb", files.level_glbs.empty() ? Json(nullptr) : Json(files.level_glbs[i].string())},
          {"faces", level.mesh.n_faces()},
          {"vertices", level.mesh.n_vertices()},
          {"patches", cad.levels[i].patches},
          {"tightened", cad.levels[i].tightened},
          {"missed", cad.levels[i].missed},
          {"error", error_to_json(level.error.max, level.error.rms, level.error.bound, cad.diagonal)},
          {"switch_distance", level.switch_distance},
          {"screen_coverage", level.screen_coverage},
          {"seconds", {{"tessellate", cad.levels[i].seconds}, {"measure", level.measure_seconds}}}};
}

void print_text(const CadHierarchy& cad, const HierarchyFiles& files,
                const std::optional<ReportFiles>& report, double seconds) {
  fmt::print(
      "level      faces   patches        max error      rms error    certified bound   from distance\n");
  for (std::size_t i = 0; i < cad.hierarchy.levels.size(); ++i) {
    const LodLevel& level = cad.hierarchy.levels[i];
    fmt::print("{:5} {:10} {:9} {:9.3g} ({:.2g} %) {:12.3g} {:12.3g} ({:.2g} %) {:12.4g}\n", i,
               level.mesh.n_faces(), cad.levels[i].patches, level.error.max,
               100 * level.error.max / cad.diagonal, level.error.rms, level.error.bound,
               100 * level.error.bound / cad.diagonal, level.switch_distance);
  }
  print_lengths(cad.hierarchy.view, "millimetres");
  std::size_t of_file = 0, by_position = 0, free = 0, gaps = 0;
  for (const CadSeamReport& part : cad.parts) {
    of_file += part.seams.edges_of_file;
    by_position += part.seams.edges_by_position;
    free += part.seams.free_edges;
    gaps += part.seams.gaps.size();
  }
  fmt::print("seams      {} of the file, {} found by position, {} free edges, {} gaps\n", of_file,
             by_position, free, gaps);
  fmt::print("hierarchy  {}\nlevels     {}\n", files.glb.string(), files.folder.string());
  if (report) fmt::print("report     {}\n", report->html.string());
  fmt::print("seconds    {:.3g}\n", seconds);
}

void print_missed(const CadHierarchy& cad, const CommonOptions& options) {
  for (std::size_t i = 0; i < cad.levels.size(); ++i) {
    for (const std::string& line : cad.levels[i].missed)
      print_remark(fmt::format("level {}: {}", i, line), options);
  }
}

}  // namespace

void add_seam_options(CLI::App& command, SeamGraphOptions& options, const std::string& group) {
  command
      .add_option("--gap", options.gap,
                  "widest gap between patches that is sewn up, millimetres (half of the finest error)")
      ->check(not_negative())
      ->group(group);
  command
      .add_flag("!--no-connectivity", options.use_connectivity,
                "finds by position which patches meet, even where the file knows it")
      ->group(group);
}

Json seams_to_json(const CadSeamReport& report, const std::vector<std::string>& names) {
  Json gaps = Json::array();
  for (const SeamGap& gap : report.seams.gaps) {
    gaps.push_back({{"patch", names[gap.patch]},
                    {"other", names[gap.other]},
                    {"point", {gap.point.x(), gap.point.y(), gap.point.z()}},
                    {"distance", gap.distance}});
  }
  return {{"part", report.part},
          {"patches", report.patches},
          {"sewing_points", report.sewing_points},
          {"edges_of_file", report.seams.edges_of_file},
          {"edges_by_position", report.seams.edges_by_position},
          {"free_edges", report.seams.free_edges},
          {"crowded_edges", report.seams.crowded_edges},
          {"turned", report.turned},
          {"largest_move", report.seams.largest_move},
          {"gaps", gaps}};
}

void bake_cad(const CadBakeOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  TerminalProgress progress(options.common.quiet);
  const CadModel model = read_cad(options.input, {}, &progress);
  const std::string name = std::filesystem::path(options.input).stem().string();
  const CadHierarchy cad = build_cad_hierarchy(model, name, options.hierarchy, &progress);
  const HierarchyFiles files = write_hierarchy(options.output, cad.hierarchy, options.write);
  std::optional<ReportFiles> report;
  if (!options.no_report) {
    ReportOptions report_options{.up = up_direction(options.up, options.input),
                                 .viewer_triangles = options.viewer_triangles};
    for (const CadLevelReport& level : cad.levels) report_options.patches.push_back(level.patches);
    report = write_report(options.output, cad.hierarchy, files, report_options, &progress);
  }
  progress.clear();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  print_cad_remarks(model, options.common);
  print_missed(cad, options.common);
  if (!options.common.json) return print_text(cad, files, report, seconds);
  Json levels = Json::array(), parts = Json::array();
  for (std::size_t i = 0; i < cad.levels.size(); ++i) levels.push_back(level_to_json(cad, files, i));
  for (std::size_t i = 0; i < cad.parts.size(); ++i) {
    std::vector<std::string> names;
    for (const TrimmedPatch& patch : model.parts[i].patches) names.push_back(patch.name);
    parts.push_back(seams_to_json(cad.parts[i], names));
  }
  print_json({{"command", "bake"},
              {"input", options.input},
              {"hierarchy", files.glb.string()},
              {"folder", files.folder.string()},
              {"report", report ? Json(report->html.string()) : Json(nullptr)},
              {"diagonal", cad.diagonal},
              {"metres_per_unit", model.metres_per_unit},
              {"patches", cad.patches},
              {"instances", model.instances.size()},
              {"levels", levels},
              {"parts", parts},
              {"left_out", left_out_to_json(model)},
              {"seconds", seconds},
              {"repairs", model.repairs}});
}

}  // namespace recede::cli
