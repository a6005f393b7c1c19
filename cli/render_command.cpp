#include "common.h"
#include "drawn_levels.h"
#include "lighting_options.h"
#include <recede/geometry/error.h>
#include <recede/render/image_io.h>

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

namespace recede::cli {
namespace {

namespace fs = std::filesystem;

struct RenderCommandOptions : DrawnOptions {
  std::string output;
  std::string mask;  // of one picture

  // Of a turntable.
  int frames = 36;
  double turn = 360;  // degrees
  std::optional<double> until_distance;
};

/// From near to far, with the names of the options.
constexpr std::pair<RenderingMethod, const char*> k_methods[] = {
    {RenderingMethod::displacement, "displacement"},
    {RenderingMethod::bump_to_displacement, "bump_to_displacement"},
    {RenderingMethod::bump, "bump"},
    {RenderingMethod::brdf_to_bump, "brdf_to_bump"},
    {RenderingMethod::brdf, "brdf"}};

Json methods_to_json(const std::optional<PictureShares>& shares) {
  if (!shares) return nullptr;
  Json methods;
  for (const auto& [method, name] : k_methods) methods[name] = shares->of(method);
  return methods;
}

void print_methods(const std::optional<PictureShares>& shares) {
  if (!shares) return;
  std::string text;
  for (const auto& [method, name] : k_methods) {
    if (shares->of(method) > 0)
      text += fmt::format("{}{} {:.3g} %", text.empty() ? "" : ", ", name, 100 * shares->of(method));
  }
  fmt::print("methods      {}\n", text.empty() ? "none" : text);
}

Json frame_to_json(const Drawn& drawn, const fs::path& file, const Camera& camera, std::size_t level) {
  const auto point = [](const Vec3& p) { return Json{p.x(), p.y(), p.z()}; };
  return {{"file", file.string()},
          {"level", level},
          {"faces", drawn.n_faces(level)},
          {"displacement", std::string(name_of(drawn.method_of(level)))},
          {"methods", methods_to_json(drawn.methods_of(camera, level))},
          {"error_bound", drawn.hierarchy().levels[level].error.bound},
          {"eye", point(camera.position)},
          {"look_at", point(camera.target)}};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void run_render(const RenderCommandOptions& options) {
  check_image_path(options.output);
  if (!options.mask.empty()) check_image_path(options.mask);
  const auto start = std::chrono::steady_clock::now();
  TerminalProgress progress(options.common.quiet);
  remark_hidden_model(options.input, options.common);
  Drawn drawn(options, &progress);
  const Camera camera =
      camera_of(options.view, options.input, drawn.finest().positions, options.width, options.height);
  const std::size_t level = drawn.choose(camera, std::nullopt);
  write_image(options.output, drawn.draw(camera, level, &progress));
  if (!options.mask.empty()) write_image(options.mask, drawn.draw_mask(camera, level, &progress));
  progress.clear();
  if (options.common.json) {
    Json document{{"command", "render"}, {"input", options.input}};
    document.update(frame_to_json(drawn, options.output, camera, level));
    document["mask"] = options.mask.empty() ? Json(nullptr) : Json(options.mask);
    document["seconds"] = seconds_since(start);
    return print_json(document);
  }
  fmt::print("level        {}, {} faces\n", level, drawn.n_faces(level));
  print_methods(drawn.methods_of(camera, level));
  fmt::print("written      {}\n", options.output);
  if (!options.mask.empty()) fmt::print("mask         {}\n", options.mask);
}

/// Turns around the target, and goes away evenly in proportion when there is a last distance.
Camera camera_of_frame(const RenderCommandOptions& options, const Camera& first, int frame) {
  const double share = static_cast<double>(frame) / options.frames;
  Camera camera = orbit(first, share * options.turn * std::numbers::pi / 180);
  if (!options.until_distance || options.frames == 1) return camera;
  const double from = (first.position - first.target).norm();
  const double way = static_cast<double>(frame) / (options.frames - 1);
  const double distance = from * std::pow(*options.until_distance / from, way);
  camera.position = camera.target + (camera.position - camera.target) * (distance / from);
  return camera;
}

void run_turntable(const RenderCommandOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  check_output_folder(options.output);
  TerminalProgress progress(options.common.quiet);
  remark_hidden_model(options.input, options.common);
  Drawn drawn(options, &progress);
  const Camera first =
      camera_of(options.view, options.input, drawn.finest().positions, options.width, options.height);
  fs::create_directories(options.output);
  Json frames = Json::array();
  std::optional<std::size_t> level;
  for (int frame = 0; frame < options.frames; ++frame) {
    const Camera camera = camera_of_frame(options, first, frame);
    level = drawn.choose(camera, level);
    const fs::path file = fs::path(options.output) / fmt::format("frame_{:04}.png", frame);
    write_png(file, drawn.draw(camera, *level, &progress));
    frames.push_back(frame_to_json(drawn, file, camera, *level));
  }
  progress.clear();
  if (options.common.json) {
    return print_json({{"command", "turntable"},
                       {"input", options.input},
                       {"frames", frames},
                       {"seconds", seconds_since(start)}});
  }
  fmt::print("frames       {} in {}\n", options.frames, options.output);
  for (int i = 0; i < options.frames; ++i) {
    const Json& frame = frames[static_cast<std::size_t>(i)];
    const bool changed = i == 0 || frame["level"] != frames[static_cast<std::size_t>(i - 1)]["level"];
    if (changed) {
      fmt::print("from {:4}    level {}, {} faces\n", i, frame["level"].get<std::size_t>(),
                 frame["faces"].get<std::size_t>());
    }
  }
}

void add_picture_options(CLI::App& command, RenderCommandOptions& options) {
  command
      .add_option("input", options.input,
                  "mesh file, built-in model (teapot, sphere, tree), .shell file, or a hierarchy: its folder "
                  "NAME.recede, or the one that recede bake wrote")
      ->required();
  const auto view = "View (default: the whole model from in front)";
  add_view_options(command, options.view, view);
  command.add_option("--image-width", options.width, "pixels (800)")->check(between(1, 32768))->group(view);
  command.add_option("--image-height", options.height, "pixels (600)")->check(between(1, 32768))->group(view);
  const auto level = "Level of a hierarchy";
  CLI::Option* fixed =
      command.add_option("--level", options.level, "this one; 0 is the finest")->group(level);
  command
      .add_option("--pixel-error", options.pixel_error, "the coarsest whose error covers at most this (1)")
      ->check(above_zero())
      ->excludes(fixed)
      ->group(level);
  command
      .add_option(
          "--level-rule", options.level_rule,
          "error: by the certified error in pixels (default); distance: by the share of the faces alone")
      ->transform(one_of<ChooseBy>({{"error", ChooseBy::error}, {"distance", ChooseBy::distance}}))
      ->option_text("error|distance")
      ->excludes(fixed)
      ->group(level);
  command
      .add_option("--distance-unit", options.distance_unit,
                  "of the rule by distance, object units (the radius of the bounding sphere)")
      ->check(above_zero())
      ->group(level);
  command
      .add_option(
          "--near-limit", options.near_limit,
          "the rule by distance takes the coarsest level nearer than this to the surface, in its unit (0)")
      ->check(not_negative())
      ->group(level);
  const auto drawing = "Drawing";
  command.add_option("--samples", options.samples, "rays from the camera for each pixel (16)")
      ->check(between(1, 65536))
      ->group(drawing);
  command.add_flag("--wireframe", options.wireframe, "lines along the sides of polygons")->group(drawing);
  CLI::Option* no_maps = command.add_flag("--no-maps", options.no_maps,
                                          "bare levels, without their displacement and normal maps");
  no_maps->group(drawing);
  command
      .add_option(
          "--displacement", options.displacement,
          "how heights are drawn: traced (default) without tessellation; diced, as triangles made for the "
          "view; tessellated, as small triangles of equal parts; none")
      ->transform(one_of<Displacement>({{"traced", Displacement::traced},
                                        {"diced", Displacement::diced},
                                        {"tessellated", Displacement::tessellated},
                                        {"none", Displacement::none}}))
      ->option_text("traced|diced|tessellated|none")
      ->group(drawing);
  command
      .add_option("--subdivision-level", options.subdivision_level,
                  "of traced heights: every triangle of the base becomes 4^N (about two to a texel)")
      ->check(between(0, 14))
      ->option_text("N")
      ->group(drawing);
  add_height_map_options(command, options.heights, drawing);
  command
      .add_option(
          "--appearance", options.appearance,
          "draws heights by what a view needs: auto chooses for each ray among displacement, a bump map "
          "and a table (brdf) that agree with each other; or one of these for all")
      ->transform(one_of<Representation>({{"auto", Representation::automatic},
                                          {"brdf", Representation::brdf},
                                          {"bump", Representation::bump},
                                          {"displacement", Representation::displacement}}))
      ->option_text("auto|brdf|bump|displacement")
      ->group(drawing);
  command
      .add_flag("--reflectance", options.reflectance,
                "draws billboards by what recede billboards --reflectance wrote for them")
      ->excludes(no_maps)
      ->group(drawing);
  command
      .add_option("--transition-distance", options.transition_distance,
                  "from the camera, around which auto changes methods, object units (where a wave of heights "
                  "covers two pixels)")
      ->check(not_negative())
      ->group(drawing);
  command
      .add_option(
          "--false-color", options.false_color,
          "level: dark is the finest; error: distances of vertices from the input, dark is none, light "
          "the coarsest level's bound; method: green is traced, yellow diced, blue tessellated, grey without "
          "heights, and with --appearance green displacement, blue the bump map, red the table; samples: how "
          "many each pixel got of --samples")
      ->transform(one_of<FalseColor>({{"level", FalseColor::level},
                                      {"error", FalseColor::error},
                                      {"method", FalseColor::method},
                                      {"samples", FalseColor::samples}}))
      ->option_text("level|error|method|samples")
      ->group(drawing);
  command
      .add_option("--matter-color", options.matter_color,
                  "of a textured shell without colours of its own, linear light (0.7 0.7 0.7)")
      ->option_text("R G B")
      ->check(between(0.0, 1.0))
      ->group(drawing);
  command.add_flag("--flat", options.flat, "facets instead of smooth shading")->group(drawing);
  command.add_flag("--ground", options.ground, "a wide floor under the model")->group(drawing);
  add_lighting_options(command, options.lighting);
}

}  // namespace

void add_render_command(CLI::App& app) {
  const auto options = std::make_shared<RenderCommandOptions>();
  CLI::App* command =
      app.add_subcommand("render", "Draws a model, or the level of a hierarchy that a view needs.");
  command->footer("Example:\n  recede render out/dragon.recede -o dragon.png --eye 0 1 3");
  add_picture_options(*command, *options);
  command->add_option("-o,--output", options->output, "picture to write, .png or .exr")->required();
  command->add_option("--mask", options->mask,
                      "also writes a picture that is white where the model is seen, for recede diff --mask");
  add_common_options(*command, options->common);
  command->callback([options] { run_render(*options); });
}

void add_turntable_command(CLI::App& app) {
  const auto options = std::make_shared<RenderCommandOptions>();
  CLI::App* command =
      app.add_subcommand("turntable", "Draws a model from all sides, and its levels as it goes away.");
  command->footer("Example:\n  recede turntable out/dragon.recede -o frames/ --until-distance 100");
  add_picture_options(*command, *options);
  command->add_option("-o,--output", options->output, "folder for frame_0000.png and so on")
      ->option_text("FOLDER")
      ->required();
  const auto motion = "Motion";
  command->add_option("--frames", options->frames, "number of pictures (36)")
      ->check(between(1, 9999))
      ->group(motion);
  command->add_option("--turn", options->turn, "angle in all, degrees (360)")->group(motion);
  command
      ->add_option("--until-distance", options->until_distance,
                   "distance from what is looked at in the last picture, object units")
      ->check(above_zero())
      ->group(motion);
  add_common_options(*command, options->common);
  command->callback([options] { run_turntable(*options); });
}

}  // namespace recede::cli
