#include "common.h"
#include "drawn_levels.h"
#include "shell_texture.h"
#include <recede/geometry/alpha_wrap.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/render/shell_level.h>
#include <recede/shells/subdivided_shell.h>
#include <recede/shells/textured_shell_io.h>

#include <fmt/format.h>

#include <chrono>
#include <numbers>

namespace recede::cli {
namespace {

struct ShellCommandOptions {
  CommonOptions common;
  std::string input, output, folder;
  ShellOptions shell;
  ShellTextureOptions texture;
  ShellLevelOptions levels;
  std::optional<double> relative_thickness, relative_alpha;
  std::optional<int> level;
  std::optional<double> crease_angle;  // degrees
  SubdivisionScheme scheme = SubdivisionScheme::catmull_clark;
  int interpolated_levels = 0;
  bool no_repair = false, keep_invalid = false;
};

struct Built {
  RepairReport repairs;
  double diagonal = 0, seconds = 0;
  std::shared_ptr<const Shell> shell;
  std::size_t traced = 0;  // directors of a layer
};

std::size_t n_contacts(const ShellValidity& validity) {
  return validity.top_contacts.size() + validity.layer_contacts.size() + validity.wall_contacts.size() +
         validity.nested_pieces.size();
}

Json layer_to_json(const Shell& shell, const std::optional<ShellLayer>& layer) {
  if (!layer) return nullptr;
  const ShellThickness reached = reached_thickness(shell, *layer);
  return {{"is_valid", layer->validity.is_valid()},
          {"is_valid_elsewhere", layer->is_valid_elsewhere},
          {"excused", layer->excused.size()},
          {"given_up", layer->given_up.size()},
          {"inverted", layer->validity.inverted.size()},
          {"contacts", n_contacts(layer->validity)},
          {"inverted_before", layer->inverted_before},
          {"contacts_before", layer->contacts_before},
          {"shortened", layer->shortened},
          {"is_of_normals", layer->is_of_normals},
          {"hexahedra", layer->hexahedra.size()},
          {"repair_rounds", layer->repair_rounds},
          {"evaluations", layer->evaluations},
          {"thickness", {{"min", reached.least}, {"mean", reached.mean}, {"max", reached.most}}}};
}

const ShellLayer& any_layer(const Shell& shell) { return shell.exterior ? *shell.exterior : *shell.interior; }

std::string validity_text(const ShellLayer& layer) {
  if (layer.validity.is_valid()) return "valid";
  const std::string faults = fmt::format("{} prisms inverted, {} contacts", layer.validity.inverted.size(),
                                         n_contacts(layer.validity));
  return layer.is_valid_elsewhere ? fmt::format(
                                        "not valid over {} triangles ({}), "
                                        "valid elsewhere; --wrap puts a closed surface around the model",
                                        layer.excused.size() + layer.given_up.size(), faults)
                                  : "not valid: " + faults;
}

void print_layer(const char* name, const Shell& shell, const std::optional<ShellLayer>& layer) {
  if (!layer) return;
  const ShellThickness reached = reached_thickness(shell, *layer);
  fmt::print("{:<12} {}; {:.3g} % of the thickness, {:.3g} % at least\n", name, validity_text(*layer),
             100 * reached.mean, 100 * reached.least);
  fmt::print("  before     {} prisms inverted, {} contacts; {} directors shortened in {} rounds\n",
             layer->inverted_before, layer->contacts_before, layer->shortened, layer->repair_rounds);
  if (layer->is_of_normals) fmt::print("  plain normals, which are longer on average and valid\n");
}

SubdividedShellOptions over_control_mesh(const ShellCommandOptions& options) {
  SubdividedShellOptions result;
  result.subdivision.level = *options.level;
  result.subdivision.scheme = options.scheme;
  if (options.crease_angle) result.subdivision.crease_angle = *options.crease_angle * std::numbers::pi / 180;
  result.interpolated_levels = options.interpolated_levels;
  result.shell = options.shell;
  return result;
}

Built build(ShellCommandOptions& options, Progress* progress) {
  Built built;
  Model model = read_model(options.input, progress);
  require_faces(model, options.input);
  PolygonSoup surface = to_soup(model.read.mesh);
  built.repairs = std::move(model.read.report);
  built.diagonal = bounding_box(surface).diagonal().norm();
  if (options.relative_alpha) {
    surface = alpha_wrap(surface, {.alpha = *options.relative_alpha * built.diagonal}, progress);
    built.diagonal = bounding_box(surface).diagonal().norm();
  }
  if (options.relative_thickness) options.shell.thickness = *options.relative_thickness * built.diagonal;
  options.shell.repair = !options.no_repair;
  if (!options.texture.name.empty()) surface = with_coordinates(std::move(surface), progress);
  const auto start = std::chrono::steady_clock::now();
  if (options.level) {
    SubdividedShell over = build_subdivided_shell(surface, over_control_mesh(options), progress);
    built.traced = over.traced;
    built.shell = std::make_shared<const Shell>(std::move(over.shell));
  } else {
    built.shell = std::make_shared<const Shell>(build_shell(surface, options.shell, progress));
    built.traced = built.shell->base.positions.size();
  }
  built.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return built;
}

void print_document(const ShellCommandOptions& options, const Built& built, bool is_written) {
  const auto written = [&](const std::string& path) {
    return is_written && !path.empty() ? Json(path) : Json(nullptr);
  };
  const ShellValidity& of_base = any_layer(*built.shell).validity;
  print_json({{"command", "shell"},
              {"input", options.input},
              {"output", written(options.output)},
              {"folder", written(options.folder)},
              {"thickness", options.shell.thickness},
              {"diagonal", built.diagonal},
              {"subdivision_level", options.level ? Json(*options.level) : Json(nullptr)},
              {"triangles", built.shell->base.n_faces()},
              {"texture", options.texture.name.empty() ? Json(nullptr) : Json(options.texture.name)},
              {"traced", built.traced},
              {"is_valid", built.shell->is_valid()},
              {"base_contacts", of_base.bottom_contacts.size() + of_base.overlapping_neighbours.size()},
              {"layers_meet", built.shell->layers_meet.size()},
              {"exterior", layer_to_json(*built.shell, built.shell->exterior)},
              {"interior", layer_to_json(*built.shell, built.shell->interior)},
              {"seconds", built.seconds},
              {"repairs", repairs_to_json(built.repairs)}});
}

void check_output(const ShellCommandOptions& options) {
  const bool is_textured = !options.texture.name.empty();
  if (is_textured && options.output.empty() && options.folder.empty())
    throw OptionError("--texture needs an output: -o FILE.shell or --folder");
  if (!is_textured && !options.folder.empty()) throw OptionError("--folder needs --texture");
  if (!options.output.empty() && is_textured != is_textured_shell(options.output)) {
    throw OptionError(is_textured ? "with --texture the output (-o) ends in .shell"
                                  : "a .shell file holds a shell with a --texture");
  }
  if (is_textured && options.shell.side == ShellSide::envelope)
    throw OptionError("--texture fills one layer: --side exterior or interior");
  if (!options.output.empty() && !is_textured) check_mesh_path(options.output);
  if (!options.folder.empty()) check_output_folder(options.folder);
}

/// Level 0 of the hierarchy in a folder is the shell.
void write_levels(const ShellCommandOptions& options, const TexturedShell& textured, Progress* progress) {
  const std::string name = std::filesystem::path(options.input).stem().string();
  const HierarchyFiles files =
      write_hierarchy(options.folder, shell_hierarchy(textured, name, options.levels, progress));
  write_textured_shell(shell_file(files.folder, 0), textured);
}

void write(const ShellCommandOptions& options, const Built& built, Progress* progress) {
  if (options.texture.name.empty()) {
    write_soup(options.output, shell_boundary(*built.shell));
    return;
  }
  const TexturedShell textured = textured_shell(built.shell, options.shell.side, options.texture, progress);
  if (!options.folder.empty()) write_levels(options, textured, progress);
  if (!options.output.empty()) write_textured_shell(options.output, textured);
}

void print_text(const ShellCommandOptions& options, const Built& built, bool is_written) {
  fmt::print("thickness    {}\n", length_text(options.shell.thickness, built.diagonal));
  if (options.level)
    fmt::print("directors    {} traced of {} a layer, level {}\n", built.traced,
               built.shell->base.positions.size(), *options.level);
  print_layer("exterior", *built.shell, built.shell->exterior);
  print_layer("interior", *built.shell, built.shell->interior);
  if (!built.shell->layers_meet.empty())
    fmt::print("the layers meet in {} pairs of triangles\n", built.shell->layers_meet.size());
  fmt::print("seconds      {:.3g}\n", built.seconds);
  for (const std::string& written : {options.output, options.folder})
    if (is_written && !written.empty()) fmt::print("written      {}\n", written);
}

void run(ShellCommandOptions options) {
  check_output(options);
  if (options.shell.thickness == 0 && !options.relative_thickness)
    throw OptionError("a shell needs --thickness or --relative-thickness");
  TerminalProgress progress(options.common.quiet);
  const Built built = build(options, &progress);
  const bool has_output = !options.output.empty() || !options.folder.empty();
  const bool is_written = has_output && (built.shell->is_valid() || options.keep_invalid);
  if (is_written) write(options, built, &progress);
  progress.clear();
  print_repairs(built.repairs, options.common);
  if (!any_layer(*built.shell).validity.has_valid_base())
    print_remark(options.input + ": the surface meets itself, so that no shell is valid there",
                 options.common);
  if (is_written && !built.shell->is_valid())
    print_remark(options.input + ": what was written isn't valid", options.common);
  if (options.common.json) {
    print_document(options, built, is_written);
  } else {
    print_text(options, built, is_written);
  }
  if (has_output && !is_written)
    throw Error(options.input + ": the shell isn't valid, so it wasn't written; --keep-invalid writes it");
}

CLI::Option* add_wrap_option(CLI::App& command, ShellCommandOptions& options) {
  return command
      .add_option(
          "--wrap", options.relative_alpha,
          "first puts a closed surface around the model, which may be anything; goes into holes wider "
          "than this share of the diagonal (0.02); give the model first or write --wrap=0.02")
      ->expected(0, 1)
      ->default_str("0.02")
      ->check(between(1e-4, 1.0));
}

void add_control_mesh_options(CLI::App& command, ShellCommandOptions& options, CLI::Option* wrap) {
  const auto group = "Control meshes";
  CLI::Option* level = command.add_option(
      "--subdivision-level", options.level,
      "the input is a control mesh: builds the shell of its limit surface, refined so many times, 0 to 10");
  level->check(between(0, SubdivisionOptions::k_largest_level))->excludes(wrap)->group(group);
  command
      .add_option(
          "--interpolate-directors", options.interpolated_levels,
          "traces directors at the points of so many levels below only (0); others stand between them")
      ->check(between(0, SubdivisionOptions::k_largest_level))
      ->needs(level)
      ->group(group);
  command.add_option("--scheme", options.scheme, "catmull-clark (default) or loop, for triangles")
      ->transform(one_of<SubdivisionScheme>(
          {{"catmull-clark", SubdivisionScheme::catmull_clark}, {"loop", SubdivisionScheme::loop}}))
      ->needs(level)
      ->group(group);
  command
      .add_option("--crease-angle", options.crease_angle,
                  "edges are creases whose faces meet at more, degrees")
      ->check(between(0.0, 180.0))
      ->needs(level)
      ->group(group);
}

}  // namespace

void add_shell_command(CLI::App& app) {
  const auto options = std::make_shared<ShellCommandOptions>();
  CLI::App* command = app.add_subcommand(
      "shell", "Builds a layer of space over a surface, proves that it is valid, and says how thick it got.");
  command->footer(
      "Example:\n  recede shell bunny.ply -o shell.ply --relative-thickness 0.05 --side envelope");
  command->add_option("input", options->input, k_input_help)->required();
  command->add_option("-o,--output", options->output,
                      "writes all sides of the layer as one closed mesh; or with --texture a .shell file, to "
                      "draw and to carve");
  ShellOptions& shell = options->shell;
  CLI::Option* thickness =
      command->add_option("--thickness", shell.thickness, "how thick it is to be, object units");
  thickness->check(above_zero());
  command
      ->add_option("--relative-thickness", options->relative_thickness,
                   "the same as a share of the diagonal of the surface's box")
      ->check(above_zero())
      ->excludes(thickness);
  command->add_option("--side", shell.side, "exterior (default), interior or envelope, which is both")
      ->transform(one_of<ShellSide>({{"exterior", ShellSide::exterior},
                                     {"interior", ShellSide::interior},
                                     {"envelope", ShellSide::envelope}}));
  command
      ->add_option("--directors", shell.method,
                   "where they lead: averaged (default), along the gradient of an averaged distance; exact, "
                   "along that of the distance; normals")
      ->transform(one_of<DirectorMethod>({{"averaged", DirectorMethod::averaged_distance},
                                          {"exact", DirectorMethod::exact_distance},
                                          {"normals", DirectorMethod::normals}}));
  command->add_option("--power", shell.field.p,
                      "of the averaged distance, above 2 (3), averaged above 1; others take much longer");
  command
      ->add_option(
          "--form", shell.field.form,
          "of the averaged distance: calibrated (default), over a plane the distance; averaged, a mean "
          "of distances, along which directors get longer than asked for on flat parts")
      ->transform(one_of<LpForm>({{"calibrated", LpForm::calibrated}, {"averaged", LpForm::averaged}}));
  command
      ->add_option(
          "--step", shell.step,
          "the longest step of directors, as a share of the thickness, turning by at most 0.8 times as many "
          "radians (0.25; 0.125 is precise)")
      ->check(between(1e-3, 1.0));
  command
      ->add_option("--border-extension", shell.border_extension,
                   "how far the field sees the surface go on at open borders, in thicknesses (2.5)")
      ->check(not_negative());
  add_control_mesh_options(*command, *options, add_wrap_option(*command, *options));
  command->add_flag("!--keep-directors", shell.at_least_normals,
                    "keeps directors that got shorter than plain normals could be all over the surface");
  command->add_flag("--no-repair", options->no_repair, "leaves directors as long as they got, valid or not");
  command->add_flag("--keep-invalid", options->keep_invalid,
                    "writes the shell even where it isn't valid, instead of failing");
  add_shell_texture_options(*command, options->texture);
  CLI::Option* folder = command->add_option(
      "--folder", options->folder,
      "writes a hierarchy for recede render: the textured shell, and from afar the surface alone");
  folder->option_text("FOLDER")->group("Texture");
  command
      ->add_option("--ratios", options->levels.ratios, "shares of its faces on further levels (0.25 0.0625)")
      ->needs(folder)
      ->group("Texture");
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
