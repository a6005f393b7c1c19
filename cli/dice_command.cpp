#include "common.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/hierarchy_folder.h>
#include <recede/lod/lod_hierarchy.h>

#include <fmt/format.h>

#include <filesystem>

namespace recede::cli {
namespace {

namespace fs = std::filesystem;

struct DiceCommandOptions {
  CommonOptions common;
  std::string input, output;
  ViewOptions view;
  int width = 800, height = 600;
  std::optional<std::size_t> level;
  HeightMapOptions heights;
  bool no_cull = false;
  LevelOptions levels;
  RemeshOptions dicing;
};

/// A base, and the number of the hierarchy's level that it is.
struct Base {
  DisplacedBase surface;
  std::optional<std::size_t> level{};
};

bool has_heights(const LodLevel& level) { return level.maps && !level.maps->displacement.samples.empty(); }

void print_lost_colors(const PolygonSoup& surface, const DiceCommandOptions& options) {
  if (!surface.vertex_colors.empty())
    print_remark(options.input + ": the colours of its vertices are left out", options.common);
}

Base base_of_hierarchy(const DiceCommandOptions& options, const fs::path& folder, Progress* progress) {
  const LodHierarchy hierarchy = read_hierarchy(folder);
  const auto& levels = hierarchy.levels;
  const auto first = std::find_if(levels.begin(), levels.end(), has_heights);
  if (first == levels.end()) {
    throw InputError::in_file(
        options.input, "no level has a displacement map; `recede bake --maps displacement` makes them");
  }
  const std::size_t number = options.level.value_or(static_cast<std::size_t>(first - levels.begin()));
  if (number >= levels.size()) {
    throw OptionError(fmt::format("there is no level {}, only {}", number, levels.size()));
  }
  if (!has_heights(levels[number])) {
    throw InputError::in_file(options.input, fmt::format("level {} has no displacement map", number));
  }
  if (levels[number].maps->color.samples.empty()) print_lost_colors(levels[number].maps->surface, options);
  return {DisplacedBase(*levels[number].maps, options.levels, progress), number};
}

Base base_of_mesh(const DiceCommandOptions& options, Progress* progress) {
  if (options.heights.file.empty())
    throw OptionError("a mesh needs --displacement-map; a hierarchy has its own");
  if (options.level) throw OptionError("--level is for hierarchies");
  MeshWithHeights mesh = read_mesh_with_heights(options.input, options.heights, options.common, progress);
  print_lost_colors(mesh.base, options);
  return {DisplacedBase(mesh.base, std::move(mesh.map), options.levels, progress)};
}

Base read_base(const DiceCommandOptions& options, Progress* progress) {
  const fs::path folder = hierarchy_folder(options.input);
  if (folder.empty()) return base_of_mesh(options, progress);
  if (!options.heights.file.empty())
    throw OptionError("--displacement-map is for meshes; a hierarchy has its own");
  return base_of_hierarchy(options, folder, progress);
}

Json to_json(const DiceCommandOptions& options, const Base& base, const Camera& camera,
             const RemeshResult& diced, const WriteResult& written) {
  const RemeshReport& report = diced.report;
  const auto point = [](const Vec3& p) { return Json{p.x(), p.y(), p.z()}; };
  return {{"command", "dice"},
          {"input", options.input},
          {"output", options.output},
          {"level", base.level ? Json(*base.level) : Json(nullptr)},
          {"faces", diced.soup.n_faces()},
          {"vertices", diced.soup.positions.size()},
          {"base_triangles", report.base_triangles},
          {"patches", report.patches},
          {"culled", report.culled},
          {"flat", report.flat},
          {"swept_x", report.swept_x},
          {"swept_y", report.swept_y},
          {"swept_z", report.swept_z},
          {"corner_vertices", report.corner_vertices},
          {"edge_vertices", report.edge_vertices},
          {"inner_vertices", report.inner_vertices},
          {"largest_move", report.largest_move},
          {"eye", point(camera.position)},
          {"look_at", point(camera.target)},
          {"seconds", report.seconds},
          {"bytes", written.bytes},
          {"written_without", written.written_without}};
}

void print_text(const DiceCommandOptions& options, const Base& base, const RemeshResult& diced) {
  const RemeshReport& report = diced.report;
  if (base.level) fmt::print("level        {}\n", *base.level);
  fmt::print("base         {} triangles, {} patches, {} of them not in the picture\n", report.base_triangles,
             report.patches, report.culled);
  fmt::print("triangles    {}\n", diced.soup.n_faces());
  fmt::print("vertices     {}: {} at corners, {} on edges, {} inside\n", diced.soup.positions.size(),
             report.corner_vertices, report.edge_vertices, report.inner_vertices);
  fmt::print("moved        {:.4g} at most\n", report.largest_move);
  fmt::print("written      {}\n", options.output);
}

void run(const DiceCommandOptions& options) {
  check_mesh_path(options.output);
  TerminalProgress progress(options.common.quiet);
  const Base base = read_base(options, &progress);
  const Camera camera =
      camera_of(options.view, options.input, base.surface.positions(), options.width, options.height);
  RemeshOptions dicing = options.dicing;
  dicing.cull = !options.no_cull;
  const RemeshResult diced = remesh_for_view(base.surface, remesh_view_of(camera), dicing, &progress);
  if (diced.soup.n_faces() == 0) throw InputError("nothing of " + options.input + " is in the picture");
  const WriteResult written = write_soup(options.output, diced.soup);
  progress.clear();
  for (const std::string& missing : written.written_without) {
    print_remark(fmt::format("{}: written without {}", options.output, missing), options.common);
  }
  if (options.common.json) return print_json(to_json(options, base, camera, diced, written));
  print_text(options, base, diced);
}

void add_base(CLI::App& command, DiceCommandOptions& options) {
  const auto group = "Heights (a hierarchy has its own)";
  command
      .add_option("--level", options.level, "this level of a hierarchy (the finest with a displacement map)")
      ->group(group);
  add_height_map_options(command, options.heights, group);
  command
      .add_option("--map-levels", options.levels.rule,
                  "coarser levels of the map: mean (default), or least_volume, which takes seconds")
      ->transform(one_of<LevelRule>({{"mean", LevelRule::mean}, {"least_volume", LevelRule::least_volume}}))
      ->option_text("mean|least_volume")
      ->group(group);
}

void add_dicing(CLI::App& command, DiceCommandOptions& options) {
  const auto group = "Dicing";
  RemeshOptions& dicing = options.dicing;
  command
      .add_option("--triangle-pixels", dicing.triangle_pixels,
                  "length of a triangle's short sides, pixels (1)")
      ->group(group);
  command
      .add_option(
          "--footprint", dicing.footprint,
          "height of a vertex: by_side (default): highest around it, lowest on backs; mean; none: its own")
      ->transform(one_of<FootprintRule>({{"by_side", FootprintRule::by_side},
                                         {"mean", FootprintRule::mean},
                                         {"none", FootprintRule::none}}))
      ->option_text("by_side|mean|none")
      ->group(group);
  command
      .add_option("--depth-ratio", dicing.largest_depth_ratio,
                  "halve edges with a larger one of their ends (2)")
      ->group(group);
  command
      .add_option("--nearest", dicing.nearest,
                  "triangles nearer than this get no smaller, object units (1e-5 of the diagonal)")
      ->group(group);
  command.add_option("--most-triangles", dicing.most_triangles, "more are an error (50 million)")
      ->group(group);
  command
      .add_flag("--no-cull", options.no_cull, "what isn't in the picture too: closed surfaces stay closed")
      ->group(group);
}

}  // namespace

void add_dice_command(CLI::App& app) {
  const auto options = std::make_shared<DiceCommandOptions>();
  CLI::App* command = app.add_subcommand(
      "dice", "Makes a mesh of a displaced surface for one view, with triangles of about a pixel.");
  command->footer(
      "Examples:\n  recede dice out/dragon.recede -o seen.ply --eye 0 1 3\n"
      "  recede dice hill.obj -o seen.glb --displacement-map hill.png --displacement-scale 0.2");
  command
      ->add_option(
          "input", options->input,
          "hierarchy with displacement maps (NAME.recede, or the folder that recede bake wrote), or a "
          "mesh file")
      ->required();
  command->add_option("-o,--output", options->output, "mesh to write; the extension chooses the format")
      ->required();
  const auto view = "View (default: the whole model from in front)";
  add_view_options(*command, options->view, view);
  command->add_option("--image-width", options->width, "pixels (800)")->check(between(1, 32768))->group(view);
  command->add_option("--image-height", options->height, "pixels (600)")
      ->check(between(1, 32768))
      ->group(view);
  add_dicing(*command, *options);
  add_base(*command, *options);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
