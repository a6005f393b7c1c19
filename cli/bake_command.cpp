#include "cad_bake.h"
#include "drawn_levels.h"
#include "level_info.h"
#include "size_option.h"
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>
#include <recede/lod/out_of_core.h>
#include <recede/render/far_level.h>
#include <recede/render/report.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <numbers>

namespace recede::cli {
namespace {

struct BakeOptions {
  CommonOptions common;
  std::string input, output;
  HierarchyOptions hierarchy;
  double field_of_view = 45;  // degrees
  double feature_angle = 0;
  std::string up;
  bool no_report = false, appearance = false, no_billboards = false;
  HierarchyWriteOptions write;
  std::vector<std::string> maps;  // names
  std::string map_format = "png";
  std::optional<double> map_seam_weight;
  SeamGraphOptions seams;          // of CAD files
  std::vector<std::string> given;  // options by name, without those that choose levels
  std::size_t viewer_triangles = ReportOptions{}.viewer_triangles;
  std::optional<std::size_t> memory;  // bytes
  int map_size = MapOptions{}.size, map_normal_bits = MapOptions{}.normal_bits;
};

Json maps_to_json(const LodLevel& level, const MapFiles& files) {
  if (!level.maps) return nullptr;
  const auto path = [](const std::filesystem::path& file) {
    return file.empty() ? Json(nullptr) : Json(file.string());
  };
  const MapReport& report = level.maps->report;
  const auto& accuracy = level.map_accuracy;
  return {{"displacement", path(files.displacement)},
          {"normal", path(files.normal)},
          {"color", path(files.color)},
          {"displacement_exr", path(files.displacement_exr)},
          {"normal_exr", path(files.normal_exr)},
          {"size", level.maps->size},
          {"atlas_reason", report.atlas_reason},
          {"search_distance", report.search_distance},
          {"texels", report.texels},
          {"missed", report.missed},
          {"seam_difference", report.seam_difference},
          {"displaced", accuracy ? Json{{"max", accuracy->max}, {"rms", accuracy->rms}} : Json(nullptr)},
          {"seconds", report.seconds}};
}

Json billboards_to_json(const LodLevel& level, const MapFiles& files) {
  if (!level.billboards) return nullptr;
  const BillboardTextures& textures = *level.billboards;
  return {{"color", files.color.string()},   {"normal", files.normal.string()},
          {"height", files.height.string()}, {"size", {textures.color.width, textures.color.height}},
          {"texels", textures.n_texels()},   {"bytes", billboard_bytes(textures)}};
}

Json trial_to_json(const FarLevelTrial& trial) {
  return {{"error", trial.error},
          {"distance", trial.distance},
          {"method", trial.method == BillboardMethod::plane_cover ? "planes" : "clusters"},
          {"billboards", trial.billboards},
          {"texels", trial.texels},
          {"billboard_bytes", trial.billboard_bytes},
          {"triangles", trial.triangles},
          {"triangle_bytes", trial.triangle_bytes},
          {"billboard_difference", trial.billboard_difference},
          {"triangle_difference", trial.triangle_difference},
          {"takes_billboards", trial.takes_billboards},
          {"reason", trial.reason}};
}

Json level_to_json(const LodHierarchy& hierarchy, const HierarchyFiles& files, std::size_t i,
                   double diagonal) {
  const LodLevel& level = hierarchy.levels[i];
  return {{"level", i},
          {"file", files.level_files[i].string()},
          {"bytes", files.level_bytes[i]},
          {"glb", files.level_glbs.empty() ? Json(nullptr) : Json(files.level_glbs[i].string())},
          {"faces", level.mesh.n_faces()},
          {"vertices", level.mesh.n_vertices()},
          {"error", error_to_json(level.error.max, level.error.rms, level.error.bound, diagonal)},
          {"switch_distance", level.switch_distance},
          {"screen_coverage", level.screen_coverage},
          {"seconds", {{"simplify", level.simplify_seconds}, {"measure", level.measure_seconds}}},
          {"stop_reason", level.stop_reason},
          {"maps", maps_to_json(level, files.map_files[i])},
          {"billboards", billboards_to_json(level, files.map_files[i])}};
}

/// What levels with heights have beside their maps.
using Appearances = std::vector<std::shared_ptr<const Appearance>>;

Appearances write_appearances(const LodHierarchy& hierarchy, const std::filesystem::path& folder,
                              Progress* progress) {
  Appearances appearances(hierarchy.levels.size());
  for (std::size_t i = 0; i < appearances.size(); ++i) {
    const auto& maps = hierarchy.levels[i].maps;
    if (!maps) continue;
    appearances[i] = make_appearance(*maps, {}, progress);
    write_appearance(appearance_file(folder, i), *appearances[i]);
  }
  return appearances;
}

Json appearance_to_json(const Appearance* appearance, const std::filesystem::path& file) {
  if (appearance == nullptr) return nullptr;
  const MapStretch& stretch = appearance->stretch();
  return {{"file", file.string()},
          {"sides", {stretch.sides.x(), stretch.sides.y()}},
          {"stretch_spread", {stretch.spread.x(), stretch.spread.y()}},
          {"wavelength", appearance->wavelength()}};
}

void print_maps(const LodHierarchy& hierarchy) {
  if (std::none_of(hierarchy.levels.begin(), hierarchy.levels.end(), [](const auto& l) { return !!l.maps; }))
    return;
  fmt::print("level   rms with maps    max with maps   seam difference   missed texels  atlas\n");
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const LodLevel& level = hierarchy.levels[i];
    if (!level.maps) continue;
    const MapReport& report = level.maps->report;
    const auto& accuracy = level.map_accuracy;
    fmt::print("{:5} {:>15} {:>16} {:>17} {:15}  {}\n", i,
               accuracy ? fmt::format("{:.3g}", accuracy->rms) : "-",
               accuracy ? fmt::format("{:.3g}", accuracy->max) : "-",
               accuracy ? fmt::format("{:.3g}", report.seam_difference) : "-", report.missed,
               report.atlas_reason.empty() ? "the input's" : "new: " + report.atlas_reason);
  }
}

void print_text(const LodHierarchy& hierarchy, const std::vector<FarLevelTrial>& trials,
                const HierarchyFiles& files, const std::optional<ReportFiles>& report, double diagonal,
                double seconds) {
  fmt::print(
      "level      faces        max error      rms error              bound   from distance  why it "
      "stopped\n");
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const LodLevel& level = hierarchy.levels[i];
    fmt::print("{:5} {:10} {:9.3g} ({:.2g} %) {:12.3g} {:12.3g} ({:.2g} %) {:12.4g}    {}\n", i,
               level.mesh.n_faces(), level.error.max, 100 * level.error.max / diagonal, level.error.rms,
               level.error.bound, 100 * level.error.bound / diagonal, level.switch_distance,
               level.stop_reason);
  }
  if (hierarchy.levels.back().billboards)
    fmt::print(
        "Bounds are certified, but not those of billboards: the larger of the greatest distance found "
        "and the cloud's error.\n");
  print_lengths(hierarchy.view, "object units");
  print_maps(hierarchy);
  if (!trials.empty()) fmt::print("triangles or billboards\nfrom distance   which are better there\n");
  for (const FarLevelTrial& trial : trials) fmt::print("{:13.4g}   {}\n", trial.distance, trial.reason);
  fmt::print("hierarchy  {}\nlevels     {}\n", files.glb.string(), files.folder.string());
  if (!files.level_glbs.empty())
    fmt::print("one each   {} to {}\n", files.level_glbs.front().string(), files.level_glbs.back().string());
  if (report) fmt::print("report     {}\n", report->html.string());
  fmt::print("seconds    {:.3g}\n", seconds);
}

std::optional<MapOptions> map_options(const BakeOptions& options) {
  if (options.maps.empty()) return {};
  const auto wanted = [&](const char* map) {
    return std::find(options.maps.begin(), options.maps.end(), map) != options.maps.end();
  };
  return MapOptions{.displacement = wanted("displacement"),
                    .normal = wanted("normal"),
                    .color = wanted("color"),
                    .size = options.map_size,
                    .seam_weight = options.map_seam_weight,
                    .format = options.map_format == "exr" ? MapFormat::exr : MapFormat::png,
                    .normal_bits = options.map_normal_bits};
}

// What has a meaning for CAD files; the last two for nothing else.
constexpr std::array<std::string_view, 14> k_options_of_cad{"input",
                                                            "--output",
                                                            "--image-height",
                                                            "--field-of-view",
                                                            "--pixel-error",
                                                            "--up",
                                                            "--json",
                                                            "--quiet",
                                                            "--threads",
                                                            "--no-report",
                                                            "--viewer-triangles",
                                                            "--glb-per-level",
                                                            "--gap",
                                                            "--no-connectivity"};

void run_for_cad(const BakeOptions& options) {
  if (!options.hierarchy.ratios.empty() || !options.hierarchy.faces.empty())
    throw OptionError(
        "--faces and --ratios are of meshes; levels of CAD files have --errors or --relative-errors");
  for (const std::string& name : options.given) {
    if (std::find(k_options_of_cad.begin(), k_options_of_cad.end(), name) == k_options_of_cad.end())
      throw OptionError(name + " is for meshes, not for CAD files");
  }
  CadBakeOptions cad{
      options.common,           options.input, options.output, options.up, {}, options.no_report,
      options.viewer_triangles, options.write};
  cad.hierarchy.errors = options.hierarchy.errors;
  cad.hierarchy.view = options.hierarchy.view;
  cad.hierarchy.view.field_of_view = options.field_of_view * std::numbers::pi / 180;
  cad.hierarchy.gap = options.seams.gap;
  cad.hierarchy.use_connectivity = options.seams.use_connectivity;
  cad.hierarchy.relative_errors = options.hierarchy.relative_errors;
  cad.hierarchy.distances = options.hierarchy.distances;
  bake_cad(cad);
}

OutOfCoreHierarchy build_in_core(const BakeOptions& options, Progress* progress) {
  Model model = read_model(options.input, progress);
  require_faces(model, options.input);
  mark_features(model.read.mesh, options.feature_angle);
  OutOfCoreHierarchy built;
  built.hierarchy = build_hierarchy(model.read.mesh, model.name, options.hierarchy, progress);
  built.repairs = std::move(model.read.report);
  return built;
}

OutOfCoreHierarchy build_out_of_core(const BakeOptions& options, Progress* progress) {
  if (options.feature_angle > 0) throw OptionError("--feature-angle is for meshes that fit in --memory");
  return build_hierarchy_out_of_core(options.input, std::filesystem::path(options.input).stem().string(),
                                     options.hierarchy,
                                     {.memory = *options.memory, .scratch = options.output}, progress);
}

void print_out_of_core(const OutOfCoreHierarchy& built, const BakeOptions& options) {
  if (built.hierarchy.source_faces > 0) {
    print_remark(
        fmt::format("{} has {} faces, more than --memory allows; level 0 has {}, and all errors are those "
                    "to the file",
                    options.input, built.hierarchy.source_faces,
                    built.hierarchy.levels.front().mesh.n_faces()),
        options.common);
  }
  if (!built.left_out.empty()) {
    print_remark(
        fmt::format("left out, as they would be finer than level 0: {}", fmt::join(built.left_out, ", ")),
        options.common);
  }
}

/// A new atlas has no place for the textures of the input, unless their colours are baked.
void print_lost_textures(const LodHierarchy& hierarchy, const CommonOptions& options) {
  if (!has_textures(hierarchy.levels.front().mesh.materials)) return;
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const auto& maps = hierarchy.levels[i].maps;
    if (!maps || maps->report.atlas_reason.empty() || !maps->color.samples.empty()) continue;
    print_remark(fmt::format("level {} has a new atlas ({}) and no texture; --maps color bakes one", i,
                             maps->report.atlas_reason),
                 options);
  }
}

Json out_of_core_to_json(const OutOfCoreHierarchy& built) {
  if (built.hierarchy.source_faces == 0) return nullptr;
  return {{"faces", built.hierarchy.source_faces},
          {"chunks", built.chunks},
          {"passes", built.passes},
          {"left_out", built.left_out}};
}

void run(BakeOptions options) {
  const auto start = std::chrono::steady_clock::now();
  check_output_folder(options.output);
  if (is_cad_path(options.input)) return run_for_cad(options);
  for (const std::string& name : options.given) {
    if (name == "--gap" || name == "--no-connectivity") throw OptionError(name + " is for CAD files");
  }
  TerminalProgress progress(options.common.quiet);
  HierarchyOptions& hierarchy_options = options.hierarchy;
  hierarchy_options.view.field_of_view = options.field_of_view * std::numbers::pi / 180;
  hierarchy_options.maps = map_options(options);
  if (options.appearance && !(hierarchy_options.maps && hierarchy_options.maps->displacement))
    throw OptionError("--appearance is that of heights; it needs --maps displacement");
  const bool is_too_large = options.memory && std::filesystem::exists(options.input) &&
                            needs_more_than(*options.memory, options.input);
  OutOfCoreHierarchy built =
      is_too_large ? build_out_of_core(options, &progress) : build_in_core(options, &progress);
  LodHierarchy& hierarchy = built.hierarchy;
  const double diagonal = summarize(hierarchy.levels.front().mesh).box.diagonal().norm();
  std::vector<FarLevelTrial> trials;
  if (!options.no_billboards) {
    trials = compare_far_levels(hierarchy, {}, &progress);
    append_far_levels(hierarchy, trials, &progress);
  }
  const HierarchyFiles files = write_hierarchy(options.output, hierarchy, options.write);
  Appearances appearances(hierarchy.levels.size());
  if (options.appearance) appearances = write_appearances(hierarchy, files.folder, &progress);
  std::optional<ReportFiles> report;
  if (!options.no_report) {
    report = write_report(
        options.output, hierarchy, files,
        {.up = up_direction(options.up, options.input), .viewer_triangles = options.viewer_triangles},
        &progress);
  }
  progress.clear();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  print_repairs(built.repairs, options.common);
  print_out_of_core(built, options);
  if (hierarchy_options.maps && hierarchy_options.maps->color && hierarchy.levels.back().maps &&
      hierarchy.levels.back().maps->color.samples.empty()) {
    print_remark(options.input + " has no colours to bake", options.common);
  }
  print_lost_textures(hierarchy, options.common);
  if (!options.common.json) return print_text(hierarchy, trials, files, report, diagonal, seconds);
  Json levels = Json::array();
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    levels.push_back(level_to_json(hierarchy, files, i, diagonal));
    levels.back()["appearance"] = appearance_to_json(appearances[i].get(), appearance_file(files.folder, i));
  }
  Json far_levels = Json::array();
  for (const FarLevelTrial& trial : trials) far_levels.push_back(trial_to_json(trial));
  print_json({{"command", "bake"},
              {"input", options.input},
              {"hierarchy", files.glb.string()},
              {"folder", files.folder.string()},
              {"report", report ? Json(report->html.string()) : Json(nullptr)},
              {"diagonal", diagonal},
              {"levels", levels},
              {"far_levels", far_levels},
              {"seconds", seconds},
              {"repairs", repairs_to_json(built.repairs)},
              {"out_of_core", out_of_core_to_json(built)}});
}

}  // namespace

void add_bake_command(CLI::App& app) {
  const auto options = std::make_shared<BakeOptions>();
  CLI::App* command = app.add_subcommand(
      "bake",
      "Makes a hierarchy of levels of detail, each with its measured error, and a report with pictures.");
  command->footer("Example:\n  recede bake dragon.ply -o out/ --ratios 0.5 0.1 0.02");
  command
      ->add_option("input", options->input,
                   "mesh or CAD file (.obj .ply .stl .off .gltf .glb .step .stp .iges .igs .brep .brp), or a "
                   "built-in model: teapot, sphere, tree")
      ->required();
  command->add_option("-o,--output", options->output, "folder to write to")
      ->option_text("FOLDER")
      ->required();
  HierarchyOptions& hierarchy = options->hierarchy;
  const auto levels =
      "Levels (one of; default: --ratios 0.5 0.25 0.1 0.03 0.01; of CAD files: --relative-errors 0.0003 "
      "0.001 0.003 "
      "0.01 0.03)";
  CLI::Option_group* choice = command->add_option_group(levels);
  choice->add_option("--faces", hierarchy.faces, "at most so many faces, decreasing");
  choice->add_option("--ratios", hierarchy.ratios, "the same as shares of the input's faces");
  choice->add_option("--errors", hierarchy.errors, "certified error bounds, increasing, object units");
  choice->add_option("--relative-errors", hierarchy.relative_errors,
                     "the same as shares of the diagonal (0.01 = 1 %)");
  choice->add_option("--distances", hierarchy.distances,
                     "camera distances, increasing; errors follow from the view");
  choice->require_option(0, 1);
  const auto view = "View (for switch distances)";
  command->add_option("--image-height", hierarchy.view.image_height, "pixels (1080)")->group(view);
  command->add_option("--field-of-view", options->field_of_view, "vertical, degrees (45)")->group(view);
  command->add_option("--pixel-error", hierarchy.view.pixel_error, "error that a level may show, pixels (1)")
      ->group(view);
  add_up_option(*command, options->up, view);
  const auto maps = "Maps (from level 0 onto every other level)";
  command->add_option("--maps", options->maps, "normal, displacement and color, those that are wanted")
      ->delimiter(',')
      ->transform(one_of_names({"normal", "displacement", "color"}))
      ->option_text("NAME ...")
      ->group(maps);
  command->add_option("--map-size", options->map_size, "texels along each side (1024)")
      ->check(between(4, 16384))
      ->group(maps);
  command
      ->add_option("--map-format", options->map_format,
                   "png (default), or exr: heights and normals also as floats, beside the PNG files")
      ->transform(one_of_names({"png", "exr"}))
      ->option_text("png|exr")
      ->group(maps);
  command
      ->add_option(
          "--map-seam-weight", options->map_seam_weight,
          "keeps more detail along seams and leaves them less closed, such as 1e4; 0: open (default: "
          "closed to a step of 16 bits)")
      ->check(not_negative())
      ->group(maps);
  command
      ->add_option("--map-normal-bits", options->map_normal_bits,
                   "bits of a sample of normal maps: 8 (default) or 16")
      ->check(CLI::IsMember({8, 16}))
      ->option_text("8|16")
      ->group(maps);
  command
      ->add_flag("--appearance", options->appearance,
                 "also writes how heights look from afar, for recede render --appearance")
      ->group(maps);
  add_simplify_options(*command, hierarchy.simplify, options->feature_angle);
  command
      ->add_option("--memory", options->memory,
                   "what the process may take, such as 8G, at least 256M; without a letter bytes. A larger "
                   "mesh (binary PLY or STL) is baked in chunks: "
                   "level 0 then has as many faces as fit")
      ->transform(size_in_bytes())
      ->option_text("SIZE");
  add_seam_options(*command, options->seams, "CAD files");
  command->add_flag("--no-billboards", options->no_billboards,
                    "no billboards as last levels, even where they look better than triangles");
  command->add_flag("--glb-per-level", options->write.glb_per_level,
                    "also one GLB file for each level, for engines that don't know MSFT_lod");
  command->add_flag("--no-report", options->no_report, "write the hierarchy only");
  command
      ->add_option("--viewer-triangles", options->viewer_triangles,
                   "levels of more triangles are left out of the report's viewer (200000); 0: no viewer")
      ->check(not_negative());
  add_common_options(*command, options->common);
  command->callback([options, command] {
    for (const CLI::Option* option : command->get_options()) {
      if (option->count() > 0) options->given.push_back(option->get_name());
    }
    run(*options);
  });
}

}  // namespace recede::cli
