#include "common.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/subdivision_surface.h>

#include <fmt/format.h>

#include <chrono>
#include <numbers>

namespace recede::cli {
namespace {

struct SubdivideCommandOptions {
  CommonOptions common;
  std::string input, output;
  SubdivisionOptions subdivision;
  std::optional<double> crease_angle;  // degrees
};

struct Subdivided {
  PolygonSoup control;
  RepairReport repairs;
  SubdivisionResult result;
  double seconds = 0;

  double diagonal() const { return bounding_box(result.soup).diagonal().norm(); }
};

Json to_json(const SubdivideCommandOptions& options, const Subdivided& done, const WriteResult& written) {
  const bool is_loop = options.subdivision.scheme == SubdivisionScheme::loop;
  return {{"command", "subdivide"},
          {"input", options.input},
          {"output", options.output},
          {"scheme", is_loop ? "loop" : "catmull-clark"},
          {"faces_before", done.control.n_faces()},
          {"faces", done.result.soup.n_faces()},
          {"vertices_before", done.control.positions.size()},
          {"vertices", done.result.soup.positions.size()},
          {"subdivision_level", done.result.level},
          {"error_estimate", done.result.error_estimate},
          {"diagonal", done.diagonal()},
          {"crease_edges", done.result.crease_edges},
          {"triangulated", done.result.triangulated},
          {"bytes", written.bytes},
          {"written_without", written.written_without},
          {"seconds", done.seconds},
          {"repairs", repairs_to_json(done.repairs)}};
}

void print_text(const SubdivideCommandOptions& options, const Subdivided& done) {
  fmt::print("faces        {} -> {}, level {}\n", done.control.n_faces(), done.result.soup.n_faces(),
             done.result.level);
  fmt::print("vertices     {} -> {}\n", done.control.positions.size(), done.result.soup.positions.size());
  fmt::print("creases      {} edges\n", done.result.crease_edges);
  fmt::print("off by       {} (estimate)\n", length_text(done.result.error_estimate, done.diagonal()));
  fmt::print("written      {}\n", options.output);
}

void run(SubdivideCommandOptions options) {
  check_mesh_path(options.output);
  if (options.crease_angle) options.subdivision.crease_angle = *options.crease_angle * std::numbers::pi / 180;
  TerminalProgress progress(options.common.quiet);
  Model model = read_model(options.input, &progress);
  require_faces(model, options.input);
  Subdivided done;
  done.control = to_soup(model.read.mesh);
  done.repairs = std::move(model.read.report);
  const auto start = std::chrono::steady_clock::now();
  done.result = subdivide(done.control, options.subdivision, &progress);
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const WriteResult written = write_soup(options.output, done.result.soup);
  progress.clear();
  print_repairs(done.repairs, options.common);
  for (const std::string& missing : written.written_without) {
    print_remark(fmt::format("{}: written without {}", options.output, missing), options.common);
  }
  if (done.result.triangulated > 0) {
    print_remark(
        fmt::format("{}: {} polygons were cut into triangles", options.input, done.result.triangulated),
        options.common);
  }
  if (options.common.json) return print_json(to_json(options, done, written));
  print_text(options, done);
}

void add_crease_options(CLI::App& command, SubdivideCommandOptions& options) {
  const auto group = "Creases and borders";
  SubdivisionOptions& subdivision = options.subdivision;
  CLI::Option* angle = command.add_option("--crease-angle", options.crease_angle,
                                          "edges are creases whose faces meet at more, degrees");
  angle->check(between(0.0, 180.0))->group(group);
  command
      .add_option("--crease-sharpness", subdivision.crease_sharpness,
                  "levels that they stay sharp; from 10 on (default) for ever")
      ->check(not_negative())
      ->needs(angle)
      ->group(group);
  command
      .add_option("--border", subdivision.boundary, "edge-only (rounds corners) or edge-and-corner (default)")
      ->transform(one_of<SubdivisionBoundary>({{"edge-only", SubdivisionBoundary::edge_only},
                                               {"edge-and-corner", SubdivisionBoundary::edge_and_corner}}))
      ->group(group);
  command
      .add_option("--uv-interpolation", subdivision.uv_interpolation,
                  "smooth, corners-only, corners-plus-1, corners-plus-2, boundaries (default) or linear")
      ->transform(one_of<UvInterpolation>({{"smooth", UvInterpolation::smooth},
                                           {"corners-only", UvInterpolation::corners_only},
                                           {"corners-plus-1", UvInterpolation::corners_plus_1},
                                           {"corners-plus-2", UvInterpolation::corners_plus_2},
                                           {"boundaries", UvInterpolation::boundaries},
                                           {"linear", UvInterpolation::linear}}))
      ->group(group);
}

}  // namespace

void add_subdivide_command(CLI::App& app) {
  const auto options = std::make_shared<SubdivideCommandOptions>();
  CLI::App* command = app.add_subcommand(
      "subdivide", "Refines a control mesh to polygons on its limit surface, with their normals.");
  command->footer("Example:\n  recede subdivide cage.obj -o smooth.glb --error 0.01");
  command->add_option("input", options->input, k_input_help)->required();
  command->add_option("-o,--output", options->output, "mesh to write; the extension chooses the format")
      ->required();
  SubdivisionOptions& subdivision = options->subdivision;
  command->add_option("--scheme", subdivision.scheme, "catmull-clark (default) or loop, for triangles")
      ->transform(one_of<SubdivisionScheme>(
          {{"catmull-clark", SubdivisionScheme::catmull_clark}, {"loop", SubdivisionScheme::loop}}));
  CLI::Option* level =
      command->add_option("--subdivision-level", subdivision.level, "refinements, 0 to 10 (2)");
  level->check(between(0, SubdivisionOptions::k_largest_level));
  command
      ->add_option("--error", subdivision.error,
                   "the least level whose error estimate is no larger, object units")
      ->excludes(level);
  add_crease_options(*command, *options);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
