#include "common.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/geomorph.h>
#include <recede/lod/pmesh.h>
#include <recede/lod/selective_mesh.h>

#include <fmt/format.h>

#include <numbers>

namespace recede::cli {
namespace {

/// One level, named by one of these; none: `otherwise`.
struct LevelChoice {
  std::optional<std::size_t> faces;
  std::optional<double> ratio, error;

  bool is_given() const { return faces || ratio || error; }
  std::size_t of(const ProgressiveMesh& mesh, std::size_t otherwise) const {
    if (faces) return mesh.level_for_faces(*faces);
    if (ratio) {
      return mesh.level_for_faces(
          static_cast<std::size_t>(*ratio * static_cast<double>(mesh.level_faces.back())));
    }
    return error ? mesh.level_for_error(*error) : otherwise;
  }
};

struct ExtractOptions {
  CommonOptions common;
  std::string input, output;
  LevelChoice level, morph;
  ViewOptions camera;
  RefinementView view;
  std::optional<double> image_width;
  bool no_cull = false;
};

Json common_json(const ExtractOptions& options, const ProgressiveMesh& mesh, const PolygonSoup& soup,
                 const WriteResult& written) {
  return {{"command", "extract"},
          {"input", options.input},
          {"output", options.output},
          {"faces", soup.n_faces()},
          {"vertices", soup.positions.size()},
          {"errors_are_proved", mesh.errors_are_proved},
          {"bytes", written.bytes},
          {"written_without", written.written_without}};
}

const char* kind_of_error(const ProgressiveMesh& mesh) {
  return mesh.errors_are_proved ? "certified" : "estimated";
}

/// Writes the mesh by `write` and prints what it is: as text by `text`, or with `fields` beside the common
/// ones.
template <typename Write, typename Text>
void finish(const ExtractOptions& options, const ProgressiveMesh& mesh, const PolygonSoup& soup,
            Write&& write, const Json& fields, Text&& text) {
  const WriteResult written = write();
  for (const std::string& missing : written.written_without) {
    print_remark(fmt::format("{}: written without {}", options.output, missing), options.common);
  }
  if (options.common.json) {
    Json document = common_json(options, mesh, soup, written);
    document.update(fields);
    return print_json(document);
  }
  fmt::print("faces        {} of {}\n", soup.n_faces(), mesh.level_faces.back());
  text();
  fmt::print("written      {}\n", options.output);
}

void extract_level(const ExtractOptions& options, const ProgressiveMesh& mesh) {
  ProgressiveCursor cursor(mesh);
  cursor.move_to(options.level.of(mesh, mesh.n_splits()));
  const PolygonSoup soup = cursor.soup();
  finish(
      options, mesh, soup, [&] { return write_soup(options.output, soup); },
      {{"splits", cursor.level()}, {"level_error", cursor.error()}},
      [&] { fmt::print("error        {:.4g}, {}\n", cursor.error(), kind_of_error(mesh)); });
}

void extract_morph(const ExtractOptions& options, const ProgressiveMesh& mesh) {
  const std::size_t fine = options.level.of(mesh, mesh.n_splits()), coarse = options.morph.of(mesh, 0);
  const Geomorph morph = make_geomorph(mesh, coarse, fine);
  finish(
      options, mesh, morph.fine, [&] { return write_geomorph(options.output, morph); },
      {{"splits", fine},
       {"level_error", mesh.level_errors[fine]},
       {"coarse_faces", mesh.level_faces[coarse]},
       {"coarse_splits", coarse},
       {"coarse_error", mesh.level_errors[coarse]}},
      [&] {
        fmt::print("coarse       {} faces\n", mesh.level_faces[coarse]);
        fmt::print("errors       {:.4g} and {:.4g}, {}\n", mesh.level_errors[fine], mesh.level_errors[coarse],
                   kind_of_error(mesh));
      });
}

Vec3 middle_of(const ProgressiveMesh& mesh) {
  Box3 box;
  for (const Vec3& position : mesh.positions) box.extend(position);
  return box.isEmpty() ? Vec3(Vec3::Zero()) : Vec3(box.center());
}

void extract_view(const ExtractOptions& options, const ProgressiveMesh& mesh) {
  RefinementView view = options.view;
  view.position = to_vector(*options.camera.eye);
  view.target = options.camera.look_at ? to_vector(*options.camera.look_at) : middle_of(mesh);
  view.up = up_direction(options.camera.up, options.input);
  view.view.field_of_view = options.camera.field_of_view * std::numbers::pi / 180;
  if (options.image_width) view.aspect_ratio = *options.image_width / view.view.image_height;
  view.faces = options.level.faces;
  view.cull = !options.no_cull;
  SelectiveMesh selective(mesh);
  const RefinementReport report = selective.update(view);
  const PolygonSoup soup = selective.soup();
  finish(
      options, mesh, soup, [&] { return write_soup(options.output, soup); },
      {{"splits", report.splits},
       {"forced_splits", report.forced},
       {"pixel_error", report.pixel_error},
       {"seconds", report.seconds}},
      [&] {
        fmt::print("pixel error  {:.4g} at most, from what is drawn to the input, {}\n", report.pixel_error,
                   kind_of_error(mesh));
      });
}

void run(const ExtractOptions& options) {
  if (options.morph.is_given())
    check_output_file(options.output, {".glb", ".gltf", ".ply"});
  else
    check_mesh_path(options.output);
  const ProgressiveMesh mesh = read_pmesh(options.input);
  print_missing_pictures(mesh.materials, options.common);
  if (options.camera.eye) return extract_view(options, mesh);
  if (options.morph.is_given()) return extract_morph(options, mesh);
  extract_level(options, mesh);
}

CLI::Option_group* add_level(CLI::App& command, const std::string& group, const std::string& prefix,
                             LevelChoice& choice) {
  CLI::Option_group* level = command.add_option_group(group);
  level->add_option("--" + prefix + "faces", choice.faces,
                    prefix.empty() ? "the finest with at most this many faces; with --eye what is seen best"
                                   : "the finest with at most this many faces");
  level->add_option("--" + prefix + "ratio", choice.ratio, "the same as a share of all faces, 0 to 1")
      ->check(between(0.0, 1.0));
  level
      ->add_option("--" + prefix + "error", choice.error,
                   "the coarsest with at most this error, object units")
      ->check(not_negative());
  level->require_option(0, 1);
  return level;
}

void add_view(CLI::App& command, ExtractOptions& options, CLI::Option_group* level,
              CLI::Option_group* morph) {
  const auto group = "View (instead of a level: fine where it is seen)";
  RefinementView& view = options.view;
  CLI::Option* eye = add_view_options(command, options.camera, group);
  for (CLI::Option* other : command.get_options([&](CLI::Option* o) { return o->get_group() == group; })) {
    if (other != eye) other->needs(eye);
  }
  for (CLI::Option_group* others : {level, morph}) {
    for (CLI::Option* other :
         others->get_options([&](CLI::Option* o) { return o != others->get_help_ptr(); }))
      if (other->get_name() != "--faces") eye->excludes(other);
  }
  const auto add = [&](const char* name, auto& value, const char* help) {
    command.add_option(name, value, help)->needs(eye)->group(group);
  };
  add("--image-width", options.image_width, "pixels (as many as the height)");
  add("--image-height", view.view.image_height, "pixels (1080)");
  add("--pixel-error", view.view.pixel_error, "error that may be seen, pixels (1)");
  add("--back-pixel-error", view.back_pixel_error, "the same for what faces away");
  add("--silhouette-pixel-error", view.silhouette_pixel_error, "the same on silhouettes");
  command.add_flag("--no-cull", options.no_cull, "detail outside the image too")->needs(eye)->group(group);
}

}  // namespace

void add_extract_command(CLI::App& app) {
  const auto options = std::make_shared<ExtractOptions>();
  CLI::App* command =
      app.add_subcommand("extract", "Writes one level of a progressive mesh, or what a view needs of it.");
  command->footer(
      "Examples:\n  recede extract dragon.pmesh -o small.ply --ratio 0.1\n"
      "  recede extract dragon.pmesh -o morph.glb --faces 10000 --morph-faces 2000\n"
      "  recede extract dragon.pmesh -o seen.ply --eye 0 1 3 --pixel-error 0.5");
  command->add_option("input", options->input, "a .pmesh file")->required();
  command->add_option("-o,--output", options->output, "file to write; the extension chooses the format")
      ->required();
  CLI::Option_group* level = add_level(*command, "Level (default: the finest)", "", options->level);
  CLI::Option_group* morph = add_level(
      *command, "Geomorph: the coarse level that it turns into (.glb .gltf .ply)", "morph-", options->morph);
  add_view(*command, *options, level, morph);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
