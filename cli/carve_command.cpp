#include "common.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/shells/shell_edit.h>
#include <recede/shells/textured_shell_io.h>

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <numbers>

namespace recede::cli {
namespace {

enum class Edit { carve, unite, intersect, cut };

struct CarveCommandOptions {
  CommonOptions common;
  std::string input, output, tool;
  Edit edit = Edit::carve;
  std::optional<std::array<double, 4>> ball;
  std::optional<std::array<double, 3>> color, from, to;
  std::optional<std::array<int, 3>> size;
  double ramp = 2, radius = 0, turn = 0;
  bool is_copy = false;
};

/// What is carved out, or put in.
struct Tool {
  InsideDistance inside;
  double volume = 0;  ///< object units to the third
};

struct Edited {
  EditReport report{};
  std::optional<double> tool_volume{};
  std::optional<MoveReport> move{};
};

Tool read_tool(const CarveCommandOptions& options, Progress* progress) {
  if (options.ball) {
    const auto& [x, y, z, radius] = *options.ball;
    return {ball_body({x, y, z}, radius), 4.0 / 3 * std::numbers::pi * radius * radius * radius};
  }
  const auto mesh = std::make_shared<const SignedDistance>(
      read_unrepaired(options.tool, options.common, progress), options.tool);
  return {mesh_body(mesh), mesh->volume()};
}

void check(const CarveCommandOptions& options) {
  check_output_file(options.output, {".shell"});
  const int n_tools = (options.tool.empty() ? 0 : 1) + (options.ball ? 1 : 0) + (options.from ? 1 : 0);
  if (n_tools != 1) throw OptionError("one of a TOOL, --ball and --move says what to do");
  if (options.from.has_value() != options.to.has_value() || (options.from && options.radius == 0))
    throw OptionError("--move needs --to and --radius");
  if (options.ramp != CarveCommandOptions{}.ramp && options.edit == Edit::cut)
    throw OptionError("what is cut has sharp ends, and no --ramp");
  if (options.color && options.edit != Edit::unite)
    throw OptionError("--color is of what --operation unite adds");
}

Edited edit(VolumeTexture& texture, const LayerGrid& grid, const CarveCommandOptions& options,
            Progress* progress) {
  if (options.from) {
    MoveOptions move{.from = nearest_place(grid.shell(), to_vector(*options.from)),
                     .to = nearest_place(grid.shell(), to_vector(*options.to))};
    move.radius = options.radius;
    move.turn = options.turn * std::numbers::pi / 180;
    move.is_copy = options.is_copy;
    const MoveReport report = move_matter(texture, grid, move);
    return {.report = report.edit, .move = report};
  }
  const Tool tool = read_tool(options, progress);
  Edited edited{.tool_volume = tool.volume};
  if (options.edit == Edit::cut) {
    edited.report =
        cut(texture, grid, [&](const Vec3&, const Vec3& point) { return tool.inside(point) > 0; });
    return edited;
  }
  CombineOptions combining{.ramp_texels = options.ramp};
  combining.operation = options.edit == Edit::carve   ? VolumeOperation::carve
                        : options.edit == Edit::unite ? VolumeOperation::unite
                                                      : VolumeOperation::intersect;
  if (options.color) combining.color = to_vector(*options.color);
  edited.report = combine(texture, grid, tool.inside, combining, progress);
  return edited;
}

Json to_json(const CarveCommandOptions& options, const LayerGrid& grid, const Edited& edited,
             double seconds) {
  Json move = nullptr;
  if (edited.move)
    move = {{"stretch", edited.move->stretch}, {"without_source", edited.move->without_source}};
  return {{"command", "carve"},
          {"input", options.input},
          {"output", options.output},
          {"size", grid.size()},
          {"changed", edited.report.changed},
          {"volume", edited.report.volume},
          {"tool_volume", edited.tool_volume ? Json(*edited.tool_volume) : Json(nullptr)},
          {"missed_triangles", grid.missed()},
          {"move", move},
          {"seconds", seconds}};
}

void print_text(const CarveCommandOptions& options, const LayerGrid& grid, const Edited& edited,
                double seconds) {
  fmt::print("texture      {} x {} x {} texels\n", grid.size()[0], grid.size()[1], grid.size()[2]);
  fmt::print("changed      {} texels\n", edited.report.changed);
  if (edited.tool_volume) {
    fmt::print("tool         {:.3g} units^3, {:.3g} of {}\n", *edited.tool_volume, edited.report.volume,
               options.edit == Edit::cut ? "matter in it" : "them in the layer");
  }
  if (edited.move)
    fmt::print("move         stretch {:.4g}; {} texels without a source\n", edited.move->stretch,
               edited.move->without_source);
  fmt::print("seconds      {:.3g}\n", seconds);
  fmt::print("written      {}\n", options.output);
}

void run(const CarveCommandOptions& options) {
  check(options);
  TerminalProgress progress(options.common.quiet);
  const TexturedShell textured = read_textured_shell(options.input, {.make_mipmap = false}, &progress);
  const auto start = std::chrono::steady_clock::now();
  FilledLayer filled = fill_once(textured, options.size);
  const LayerGrid& grid = filled.grid;
  const Edited edited = edit(filled.texture, grid, options, &progress);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  write_textured_shell(options.output, with_texture(textured, std::move(filled.texture)));
  progress.clear();
  if (grid.missed() > 0)
    print_remark(fmt::format("{}: {} triangles are smaller than texels; a larger --size fills them",
                             options.input, grid.missed()),
                 options.common);
  if (edited.report.changed == 0) print_remark(options.input + ": nothing changed", options.common);
  if (options.common.json) return print_json(to_json(options, grid, edited, seconds));
  print_text(options, grid, edited, seconds);
}

void add_body_options(CLI::App& command, CarveCommandOptions& options) {
  CLI::Option* operation = command.add_option(
      "--operation", options.edit,
      "carve (default) takes the tool away, unite adds it, intersect leaves what is in it, cut "
      "empties texels in it, with sharp ends");
  operation->transform(one_of<Edit>(
      {{"carve", Edit::carve}, {"unite", Edit::unite}, {"intersect", Edit::intersect}, {"cut", Edit::cut}}));
  command.add_option("--ball", options.ball, "a ball instead of a mesh: middle and radius, object units")
      ->option_text("X Y Z R");
  command.add_option("--color", options.color, "of what unite adds, sRGB, 0 to 1 each")
      ->option_text("R G B")
      ->needs(operation);
  CLI::Option* ramp = command.add_option(
      "--ramp", options.ramp,
      "half of the width over which opacity goes from 0 to 1, in longest sides of texels (2)");
  ramp->check(above_zero());

  const auto moving = "Moving";
  CLI::Option* move =
      command.add_option("--move", options.from, "moves what is around this point of the surface");
  move->option_text("X Y Z")->group(moving)->excludes(operation)->excludes(ramp);
  command.add_option("--to", options.to, "around that one")->option_text("X Y Z")->group(moving)->needs(move);
  command.add_option("--radius", options.radius, "of the discs, along the surface, object units")
      ->check(above_zero())
      ->group(moving)
      ->needs(move);
  command.add_option("--turn", options.turn, "counter-clockwise, seen from outside, degrees (0)")
      ->group(moving)
      ->needs(move);
  command.add_flag("--copy", options.is_copy, "leaves it where it was, too")->group(moving)->needs(move);
}

}  // namespace

void add_carve_command(CLI::App& app) {
  const auto options = std::make_shared<CarveCommandOptions>();
  CLI::App* command = app.add_subcommand(
      "carve",
      "Carves matter of a textured shell, unites it with bodies, cuts it, or moves it over the surface.");
  command->footer("Example:\n  recede carve bunny.shell hole.ply -o carved.shell --operation carve");
  command->add_option("input", options->input, "textured shell (.shell)")->required();
  command->add_option("tool", options->tool,
                      "closed mesh to carve with, where it is: a file or a built-in model");
  command->add_option("-o,--output", options->output, ".shell file to write")->required();
  add_body_options(*command, *options);
  command
      ->add_option(
          "--size", options->size,
          "texels of the whole layer; else as it has, or where its texture repeats as fine as that, up to "
          "2048 x 2048")
      ->option_text("S T R");
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
