#include "common.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/pmesh.h>

#include <fmt/format.h>

#include <algorithm>

namespace recede::cli {
namespace {

struct ProgressiveCommandOptions {
  CommonOptions common;
  std::string input, output;
  ProgressiveOptions progressive;
  PmeshOptions file;
  double feature_angle = 0;
  bool no_measure = false, keep_order = false;
};

/// What the file holds, with nothing repaired: this is what the full level gives back.
PolygonSoup read_input(const ProgressiveCommandOptions& options, Progress* progress) {
  if (options.feature_angle == 0) return read_unrepaired(options.input, options.common, progress);
  Model model = read_model(options.input, progress);
  print_repairs(model.read.report, options.common);
  mark_features(model.read.mesh, options.feature_angle);
  return to_soup(model.read.mesh);
}

Json to_json(const ProgressiveCommandOptions& options, const ProgressiveMesh& mesh, const PmeshReport& file,
             double diagonal) {
  return {{"command", "progressive"},
          {"input", options.input},
          {"output", options.output},
          {"faces", mesh.level_faces.back()},
          {"base_faces", mesh.level_faces.front()},
          {"splits", mesh.n_splits()},
          {"base_error", mesh.level_errors.front()},
          {"errors_are_proved", mesh.errors_are_proved},
          {"diagonal", diagonal},
          {"stop_reason", to_string(mesh.report.stop_reason)},
          {"refused", refused_to_json(mesh.report.refused)},
          {"bytes", file.bytes},
          {"base_bytes", file.base_bytes},
          {"connectivity_bytes", file.connectivity_bytes},
          {"position_bytes", file.position_bytes},
          {"attribute_bytes", file.attribute_bytes},
          {"error_bytes", file.error_bytes},
          {"numbering_bytes", file.numbering_bytes},
          {"batches", file.batches},
          {"positions", file.positions},
          {"largest_move", file.largest_move},
          {"seconds", mesh.report.seconds},
          {"proof_seconds", mesh.report.proof_seconds}};
}

void print_text(const ProgressiveCommandOptions& options, const ProgressiveMesh& mesh,
                const PmeshReport& file, double diagonal) {
  const double bits = 8.0 / static_cast<double>(std::max<std::size_t>(mesh.positions.size(), 1));
  fmt::print("faces        {} in the base, {} in all\n", mesh.level_faces.front(), mesh.level_faces.back());
  fmt::print("splits       {} in {} batches\n", mesh.n_splits(), file.batches);
  fmt::print("base error   {}, {}\n", length_text(mesh.level_errors.front(), diagonal),
             mesh.errors_are_proved ? "certified" : "estimated");
  fmt::print("positions    {}", file.positions);
  if (file.largest_move > 0) fmt::print(", moved by at most {}", length_text(file.largest_move, diagonal));
  fmt::print(
      "\nbits         {:.1f} per vertex: base {:.1f}, connectivity {:.1f}, positions {:.1f}, attributes "
      "{:.1f}, "
      "errors {:.1f}, numbering {:.1f}\n",
      static_cast<double>(file.bytes) * bits, static_cast<double>(file.base_bytes) * bits,
      static_cast<double>(file.connectivity_bytes) * bits, static_cast<double>(file.position_bytes) * bits,
      static_cast<double>(file.attribute_bytes) * bits, static_cast<double>(file.error_bytes) * bits,
      static_cast<double>(file.numbering_bytes) * bits);
  fmt::print("seconds      {:.3g}", mesh.report.seconds);
  if (mesh.report.proof_seconds > 0) fmt::print(", and {:.3g} for the proofs", mesh.report.proof_seconds);
  fmt::print("\nwritten      {}\n", options.output);
}

void run(const ProgressiveCommandOptions& options) {
  check_output_file(options.output, {".pmesh"});
  TerminalProgress progress(options.common.quiet);
  const PolygonSoup soup = read_input(options, &progress);
  ProgressiveOptions progressive = options.progressive;
  progressive.simplify.prove_error = !options.no_measure;
  const ProgressiveMesh mesh = build_progressive_mesh(soup, progressive, &progress);
  PmeshOptions file = options.file;
  if (options.keep_order) file.keep_order = true;
  const PmeshReport written = write_pmesh(options.output, mesh, file);
  progress.clear();
  const Box3 box = bounding_box(soup);
  const double diagonal = box.isEmpty() ? 0 : box.diagonal().norm();
  if (options.common.json)
    print_json(to_json(options, mesh, written, diagonal));
  else
    print_text(options, mesh, written, diagonal);
}

void add_bits(CLI::App& command, const std::string& name, std::optional<int>& bits, const std::string& help) {
  command.add_option(name, bits, help)
      ->check(between(1, 30))
      ->group("Quantisation (default: none, bit for bit)");
}

}  // namespace

void add_progressive_command(CLI::App& app) {
  const auto options = std::make_shared<ProgressiveCommandOptions>();
  CLI::App* command =
      app.add_subcommand("progressive", "Writes a base and the splits that refine it to the input.");
  command->footer("Example:\n  recede progressive dragon.ply -o dragon.pmesh --bits 14");
  command->add_option("input", options->input, k_input_help)->required();
  command->add_option("-o,--output", options->output, "file to write, .pmesh")->required();
  SimplifyTarget& target = options->progressive.simplify.target;
  const auto group = "Base (the first that is reached stops; default: as small as it gets)";
  command->add_option("--faces", target.faces, "at most this many faces")->group(group);
  command->add_option("--vertices", target.vertices, "at most this many vertices")->group(group);
  command->add_option("--ratio", target.ratio, "at most this share of the faces, 0 to 1")->group(group);
  add_bits(*command, "--bits", options->file.position_bits, "positions: bits along the longest side");
  add_bits(*command, "--uv-bits", options->file.uv_bits, "texture coordinates");
  add_bits(*command, "--normal-bits", options->file.normal_bits, "normals");
  add_bits(*command, "--color-bits", options->file.color_bits, "vertex colours");
  add_bits(*command, "--scalar-bits", options->file.scalar_bits, "scalars of the vertices");
  command->add_flag("--keep-numbering", options->file.keep_numbering,
                    "also write how the input numbers vertices and faces");
  command->add_flag("--keep-order", options->keep_order,
                    "keep the order of splits, and every level's error, with --bits as well");
  command->add_flag("--no-measure", options->no_measure, "prove no errors; levels carry estimates");
  add_simplify_options(*command, options->progressive.simplify, options->feature_angle);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
