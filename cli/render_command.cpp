#include "common.h"
#include "lighting_options.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/lod/lod_selection.h>
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>
#include <recede/render/progressive_render.h>

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

namespace recede::cli {
namespace {

namespace fs = std::filesystem;

enum class FalseColor { none, level, error, samples };
enum class ChooseBy { error, distance };

struct RenderCommandOptions {
  CommonOptions common;
  std::string input, output;
  ViewOptions view;
  int width = 800, height = 600;
  std::optional<std::size_t> level;
  ChooseBy level_rule = ChooseBy::error;
  double pixel_error = 1;
  std::optional<double> distance_unit;
  double near_limit = 0;
  int samples = 16;
  bool wireframe = false, flat = false, no_maps = false, ground = false;
  LightingOptions lighting;
  FalseColor false_color = FalseColor::none;
  // Of a turntable.
  int frames = 36;
  double turn = 360;  // degrees
  std::optional<double> until_distance;
};

/// Levels that can be drawn: those of a hierarchy, or a mesh alone.
class Drawn {
 public:
  Drawn(const RenderCommandOptions& options, Progress* progress) : options_(options) {
    if (fs::is_directory(options.input)) {
      hierarchy_ = read_hierarchy(options.input);
    } else {
      Model model = read_model(options.input, progress);
      require_faces(model, options.input);
      hierarchy_.levels.emplace_back().mesh = std::move(model.read.mesh);
    }
    scenes_.resize(hierarchy_.levels.size());
    if (options.level && *options.level >= scenes_.size()) {
      throw OptionError(fmt::format("there is no level {}, only {}", *options.level, scenes_.size()));
    }
    if (scenes_.size() == 1 &&
        (options.false_color == FalseColor::level || options.false_color == FalseColor::error)) {
      throw OptionError(options.input + " has one level, and nothing to show by false colours");
    }
    if (options.false_color == FalseColor::samples && options.lighting.noise == 0)
      throw OptionError("without --noise all pixels have the same number of samples");
    rendering_.samples_per_pixel = options.samples;
    if (options.wireframe) rendering_.wireframe = Wireframe{};
    set_lighting(options.lighting, up_direction(options.view.up, options.input), rendering_);
    finest_ = to_soup(hierarchy_.levels[0].mesh);
    if (scenes_.size() > 1) surface_.emplace(finest_.positions, triangulate(finest_));
  }

  const PolygonSoup& finest() const { return finest_; }
  const LodHierarchy& hierarchy() const { return hierarchy_; }

  /// The level for a camera, from the one that was shown before.
  std::size_t choose(const Camera& camera, std::optional<std::size_t> before) const {
    if (options_.level) return *options_.level;
    if (!surface_) return 0;
    const double distance = std::sqrt(surface_->closest(camera.position).squared_distance);
    if (options_.level_rule == ChooseBy::distance) {
      const double to_sphere = (camera.position - hierarchy_.center).norm() - hierarchy_.radius;
      return level_by_distance(
          hierarchy_, to_sphere, distance,
          {.unit = options_.distance_unit.value_or(hierarchy_.radius), .near_limit = options_.near_limit});
    }
    const ViewSettings view{static_cast<double>(camera.height), camera.field_of_view, options_.pixel_error};
    return level_by_error(hierarchy_, distance, {.view = view, .current = before});
  }

  Image draw(const Camera& camera, std::size_t level, Progress* progress) {
    if (options_.false_color != FalseColor::samples)
      return render(scene_of(level), camera, rendering_, progress);
    ProgressiveRender picture(scene_of(level), camera, rendering_);
    picture.add_samples(options_.samples, progress);
    return heat_map(picture.sample_counts(), options_.samples);
  }

 private:
  const Scene& scene_of(std::size_t level) {
    std::optional<Scene>& scene = scenes_[level];
    if (scene) return *scene;
    SceneOptions shading;
    if (options_.flat) shading.crease_angle = 0;
    if (options_.ground) shading.ground = Ground{.up = up_direction(options_.view.up, options_.input)};
    const LodLevel& drawn = hierarchy_.levels[level];
    PolygonSoup soup = drawn.maps && !options_.no_maps ? dice_surface(*drawn.maps) : to_soup(drawn.mesh);
    if (options_.false_color == FalseColor::level)
      paint(soup, [&](const Vec3&) { return level_share(level); });
    if (options_.false_color == FalseColor::error) paint(soup, [&](const Vec3& p) { return error_share(p); });
    return scene.emplace(soup, shading);
  }

  template <typename Share>
  static void paint(PolygonSoup& soup, Share&& share_at) {
    soup.materials.clear();
    soup.face_materials.clear();
    soup.vertex_colors.clear();
    for (const Vec3& position : soup.positions) {
      const Rgb color = heat_map_color(share_at(position));
      soup.vertex_colors.emplace_back(color.x(), color.y(), color.z(), 1);
    }
  }
  double level_share(std::size_t level) const {
    return static_cast<double>(level) / static_cast<double>(std::max<std::size_t>(scenes_.size() - 1, 1));
  }
  /// Distance from the input over the coarsest level's bound.
  double error_share(const Vec3& position) const {
    const double most = hierarchy_.levels.back().error.bound;
    return surface_ && most > 0 ? std::sqrt(surface_->closest(position).squared_distance) / most : 0;
  }

  const RenderCommandOptions& options_;
  LodHierarchy hierarchy_;
  PolygonSoup finest_;
  std::optional<ClosestPointTree> surface_;
  std::vector<std::optional<Scene>> scenes_;
  RenderOptions rendering_;
};

/// Where it was asked to stand, or where the whole model is seen from in front.
Camera camera_of(const RenderCommandOptions& options, const PolygonSoup& model) {
  const ViewOptions& view = options.view;
  Camera camera = camera_in_front(model.positions, up_direction(view.up, options.input),
                                  view.field_of_view * std::numbers::pi / 180, options.width, options.height);
  if (view.eye) {
    camera.position = to_vector(*view.eye);
    camera.target = bounding_box(model).center();
  }
  if (view.look_at) camera.target = to_vector(*view.look_at);
  return camera;
}

Json frame_to_json(const Drawn& drawn, const fs::path& file, const Camera& camera, std::size_t level) {
  const auto point = [](const Vec3& p) { return Json{p.x(), p.y(), p.z()}; };
  return {{"file", file.string()},
          {"level", level},
          {"faces", drawn.hierarchy().levels[level].mesh.n_faces()},
          {"error_bound", drawn.hierarchy().levels[level].error.bound},
          {"eye", point(camera.position)},
          {"look_at", point(camera.target)}};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void run_render(const RenderCommandOptions& options) {
  check_image_path(options.output);
  const auto start = std::chrono::steady_clock::now();
  TerminalProgress progress(options.common.quiet);
  Drawn drawn(options, &progress);
  const Camera camera = camera_of(options, drawn.finest());
  const std::size_t level = drawn.choose(camera, std::nullopt);
  write_image(options.output, drawn.draw(camera, level, &progress));
  progress.clear();
  if (options.common.json) {
    Json document{{"command", "render"}, {"input", options.input}};
    document.update(frame_to_json(drawn, options.output, camera, level));
    document["seconds"] = seconds_since(start);
    return print_json(document);
  }
  fmt::print("level        {}, {} faces\nwritten      {}\n", level,
             drawn.hierarchy().levels[level].mesh.n_faces(), options.output);
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
  if (fs::exists(options.output) && !fs::is_directory(options.output)) {
    throw InputError::in_file(options.output, "isn't a folder");
  }
  TerminalProgress progress(options.common.quiet);
  Drawn drawn(options, &progress);
  const Camera first = camera_of(options, drawn.finest());
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
                  "mesh file, built-in model (teapot, sphere), or a hierarchy's folder NAME.recede")
      ->required();
  const auto view = "View (default: the whole model from in front)";
  add_view_options(command, options.view, view);
  command.add_option("--image-width", options.width, "pixels (800)")
      ->check(CLI::Range(1, 32768))
      ->group(view);
  command.add_option("--image-height", options.height, "pixels (600)")
      ->check(CLI::Range(1, 32768))
      ->group(view);
  const auto level = "Level of a hierarchy";
  CLI::Option* fixed =
      command.add_option("--level", options.level, "this one; 0 is the finest")->group(level);
  command
      .add_option("--pixel-error", options.pixel_error, "the coarsest whose error covers at most this (1)")
      ->check(CLI::PositiveNumber)
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
      ->check(CLI::PositiveNumber)
      ->group(level);
  command
      .add_option(
          "--near-limit", options.near_limit,
          "the rule by distance takes the coarsest level nearer than this to the surface, in its unit (0)")
      ->check(CLI::NonNegativeNumber)
      ->group(level);
  const auto drawing = "Drawing";
  command.add_option("--samples", options.samples, "rays from the camera for each pixel (16)")
      ->check(CLI::Range(1, 65536))
      ->group(drawing);
  command.add_flag("--wireframe", options.wireframe, "lines along the sides of polygons")->group(drawing);
  command.add_flag("--no-maps", options.no_maps, "bare levels, without their displacement and normal maps")
      ->group(drawing);
  command
      .add_option(
          "--false-color", options.false_color,
          "level: dark is the finest; error: distances of vertices from the input, dark is none, light "
          "the coarsest level's bound; samples: how many each pixel got of --samples")
      ->transform(one_of<FalseColor>(
          {{"level", FalseColor::level}, {"error", FalseColor::error}, {"samples", FalseColor::samples}}))
      ->option_text("level|error|samples")
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
  add_common_options(*command, options->common);
  command->callback([options] { run_render(*options); });
}

void add_turntable_command(CLI::App& app) {
  const auto options = std::make_shared<RenderCommandOptions>();
  CLI::App* command =
      app.add_subcommand("turntable", "Draws a model from all sides, and its levels as it goes away.");
  command->footer("Example:\n  recede turntable out/dragon.recede -o frames/ --until-distance 100");
  add_picture_options(*command, *options);
  command->add_option("-o,--output", options->output, "folder for frame_0000.png and so on")->required();
  const auto motion = "Motion";
  command->add_option("--frames", options->frames, "number of pictures (36)")
      ->check(CLI::Range(1, 9999))
      ->group(motion);
  command->add_option("--turn", options->turn, "angle in all, degrees (360)")->group(motion);
  command
      ->add_option("--until-distance", options->until_distance,
                   "distance from what is looked at in the last picture, object units")
      ->check(CLI::PositiveNumber)
      ->group(motion);
  add_common_options(*command, options->common);
  command->callback([options] { run_turntable(*options); });
}

}  // namespace recede::cli
