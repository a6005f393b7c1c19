#include "common.h"
#include <recede/geometry/mesh_io.h>

#include <fmt/format.h>

namespace recede::cli {
namespace {

struct SimplifyCommandOptions {
  CommonOptions common;
  std::string input, output;
  SimplifyOptions simplify;
  double feature_angle = 0;
  bool no_measure = false;
};

Json to_json(const SimplifyCommandOptions& options, const SimplifyResult& result,
             const std::optional<MeshDistance>& d, double diagonal, const WriteResult& written,
             const RepairReport& repairs) {
  Json document = {{"command", "simplify"},
                   {"input", options.input},
                   {"output", options.output},
                   {"faces_before", result.faces_before},
                   {"faces", result.faces_after},
                   {"vertices_before", result.vertices_before},
                   {"vertices", result.vertices_after},
                   {"collapses", result.collapses},
                   {"joined", result.joined},
                   {"dropped_parts", result.dropped_parts},
                   {"dropped_faces", result.dropped_faces},
                   {"passes", result.passes},
                   {"stop_reason", to_string(result.stop_reason)},
                   {"refused", refused_to_json(result.refused)},
                   {"error_estimate", result.error_estimate}};
  document["error"] = d ? error_to_json(d->max, d->rms, result.error_bound, diagonal) : Json(nullptr);
  document["diagonal"] = diagonal;
  document["bytes"] = written.bytes;
  document["written_without"] = written.written_without;
  document["seconds"] = result.seconds;
  document["proof_seconds"] = result.proof_seconds;
  document["repairs"] = repairs_to_json(repairs);
  return document;
}

bool target_missed(const SimplifyCommandOptions& options, const SimplifyResult& result) {
  const SimplifyTarget& t = options.simplify.target;
  return result.stop_reason == StopReason::no_collapse_left && (t.faces || t.vertices || t.ratio);
}

std::string refusal_text(const RefusedCollapses& refused) {
  std::string text;
  for (std::size_t i = 0; i < refused.counts.size(); ++i) {
    if (refused.counts[i] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", to_string(static_cast<Refusal>(i)),
                        refused.counts[i]);
  }
  return text.empty() ? "none" : text;
}

void print_text(const SimplifyCommandOptions& options, const SimplifyResult& result,
                const std::optional<MeshDistance>& d, double diagonal) {
  fmt::print("faces        {} -> {}\n", result.faces_before, result.faces_after);
  fmt::print("vertices     {} -> {}\n", result.vertices_before, result.vertices_after);
  if (result.joined > 0) fmt::print("joined       {} pairs of points of different parts\n", result.joined);
  if (result.dropped_parts > 0) {
    fmt::print("dropped      {} parts of {} faces\n", result.dropped_parts, result.dropped_faces);
  }
  if (d) {
    fmt::print("error max    {}, sampled\n", length_text(d->max, diagonal));
    fmt::print("error bound  {}, certified\n", length_text(result.error_bound.value_or(d->max), diagonal));
    fmt::print("error rms    {}\n", length_text(d->rms, diagonal));
  } else {
    fmt::print("error        {}, estimated while simplifying\n",
               length_text(result.error_estimate, diagonal));
  }
  fmt::print("stopped      {}\n", to_string(result.stop_reason));
  fmt::print("refused      {}\n", refusal_text(result.refused));
  fmt::print("seconds      {:.3g}", result.seconds);
  if (result.proof_seconds > 0) fmt::print(", and {:.3g} for the proof", result.proof_seconds);
  fmt::print("\n");
  fmt::print("written      {}\n", options.output);
}

void run(const SimplifyCommandOptions& options) {
  check_mesh_path(options.output);
  TerminalProgress progress(options.common.quiet);
  Model model = read_model(options.input, &progress);
  require_faces(model, options.input);
  mark_features(model.read.mesh, options.feature_angle);
  SimplifyOptions simplify_options = options.simplify;
  simplify_options.prove_error = !options.no_measure;
  const SimplifyResult result = simplify(model.read.mesh, simplify_options, &progress);
  std::optional<MeshDistance> distance;
  if (!options.no_measure) distance = measure_distance(model.read.mesh, result.mesh, {}, &progress);
  const double diagonal = summarize(model.read.mesh).box.diagonal().norm();
  const WriteResult written = write_mesh(options.output, result.mesh);
  progress.clear();
  print_repairs(model.read.report, options.common);
  for (const std::string& missing : written.written_without) {
    print_remark(fmt::format("{}: written without {}", options.output, missing), options.common);
  }
  if (target_missed(options, result)) {
    print_remark(fmt::format("the target was not reached: {}; refused: {}", to_string(result.stop_reason),
                             refusal_text(result.refused)),
                 options.common);
  }
  if (options.common.json) {
    print_json(to_json(options, result, distance, diagonal, written, model.read.report));
  } else {
    print_text(options, result, distance, diagonal);
  }
}

template <typename Value>
void add_target(CLI::App& command, const std::string& name, std::optional<Value>& target,
                const std::string& help) {
  command.add_option(name, target, help)->group("Target (the first that is reached stops)");
}

}  // namespace

void add_simplify_command(CLI::App& app) {
  const auto options = std::make_shared<SimplifyCommandOptions>();
  CLI::App* command =
      app.add_subcommand("simplify", "Makes one coarser mesh and measures how far it is from the input.");
  command->footer("Example:\n  recede simplify dragon.ply -o small.ply --ratio 0.1");
  command->add_option("input", options->input, k_input_help)->required();
  command->add_option("-o,--output", options->output, "file to write; the extension chooses the format")
      ->required();
  SimplifyTarget& target = options->simplify.target;
  add_target(*command, "--faces", target.faces, "at most this many faces");
  add_target(*command, "--vertices", target.vertices, "at most this many vertices");
  add_target(*command, "--ratio", target.ratio, "at most this share of the faces, 0 to 1");
  add_target(*command, "--error", target.error,
             "two-sided distance to the input that is kept, proved, object units");
  add_target(*command, "--relative-error", target.relative_error,
             "the same as a share of the diagonal (0.01 = 1 %)");
  add_simplify_options(*command, options->simplify, options->feature_angle);
  command->add_flag("--no-measure", options->no_measure,
                    "neither measure nor prove the error; error targets then stop at an estimate");
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
