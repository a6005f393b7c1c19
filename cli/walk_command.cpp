#include "cad_bake.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/lod/seam_viewer.h>

#include <algorithm>
#include <numbers>

namespace recede::cli {
namespace {

struct WalkOptions {
  CommonOptions common;
  std::string input, output;
  SeamGraphOptions seams;
  double relative_error = 3e-4;
  std::optional<std::array<double, 3>> from, to, look_at;
  std::string up;
  double field_of_view = 45;
  int frames = 100, width = 1920, height = 1080;
  double pixel_error = ViewSettings{}.pixel_error;
  std::optional<std::size_t> most_new_triangles;
};

// What all instances together took in a frame.
struct WalkFrame {
  double tolerance = std::numeric_limits<double>::infinity();
  double pixel_error = 0, milliseconds = 0;
  std::size_t triangles = 0, patches = 0, tessellated = 0, culled = 0, postponed = 0;
};

struct Walker {
  Eigen::Affine3d to_part;  // from the model's coordinates
  SeamViewer viewer;
};

SeamView view_of(const WalkOptions& options, const Vec3& eye, const Vec3& target, const Walker& walker) {
  SeamView view;
  view.position = walker.to_part * eye;
  view.target = walker.to_part * target;
  view.up = walker.to_part.linear() * up_direction(options.up, options.input);
  view.view = {static_cast<double>(options.height), options.field_of_view * std::numbers::pi / 180,
               options.pixel_error};
  view.aspect_ratio = static_cast<double>(options.width) / options.height;
  view.most_new_triangles = options.most_new_triangles;
  return view;
}

WalkFrame walk_frame(const WalkOptions& options, const Vec3& eye, const Vec3& target,
                     std::vector<Walker>& walkers) {
  WalkFrame frame;
  for (Walker& walker : walkers) {
    const SeamFrame part = walker.viewer.update(view_of(options, eye, target, walker));
    if (part.drawn_patches > 0) frame.tolerance = std::min(frame.tolerance, part.finest_tolerance);
    frame.pixel_error = std::max(frame.pixel_error, part.pixel_error);
    frame.milliseconds += 1000 * part.seconds;
    frame.triangles += part.drawn_triangles;
    frame.patches += part.drawn_patches;
    frame.tessellated += part.update.tessellated;
    frame.culled += part.culled_patches;
    frame.postponed += part.postponed;
  }
  if (frame.patches == 0) frame.tolerance = 0;
  return frame;
}

std::string as_csv(const std::vector<WalkFrame>& frames) {
  std::string text =
      "frame,tolerance,triangles,patches,tessellated,culled,postponed,pixel_error,milliseconds\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const WalkFrame& f = frames[i];
    text += fmt::format("{},{:.6g},{},{},{},{},{},{:.4g},{:.4g}\n", i, f.tolerance, f.triangles, f.patches,
                        f.tessellated, f.culled, f.postponed, f.pixel_error, f.milliseconds);
  }
  return text;
}

Json to_json(const WalkFrame& f, std::size_t i) {
  return {{"frame", i},
          {"tolerance", f.tolerance},
          {"triangles", f.triangles},
          {"patches", f.patches},
          {"tessellated", f.tessellated},
          {"culled", f.culled},
          {"postponed", f.postponed},
          {"pixel_error", f.pixel_error},
          {"milliseconds", f.milliseconds}};
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void run(const WalkOptions& options) {
  if (!options.output.empty()) check_output_file(options.output, {".csv"});
  TerminalProgress progress(options.common.quiet);
  const CadModel model = read_cad(options.input, {}, &progress);
  const double diagonal = cad_diagonal(model);
  SeamGraphOptions seams = options.seams;
  seams.tolerance = options.relative_error * diagonal;
  std::vector<SeamModel> parts;
  parts.reserve(model.parts.size());
  for (const CadPart& part : model.parts) parts.push_back(build_seam_model(part, {seams, {}}, &progress));
  std::vector<Walker> walkers;
  Box3 box;
  for (const CadInstance& instance : model.instances) {
    for (const Vec3& point : parts[instance.part].graph.positions) box.extend(instance.placement * point);
    walkers.push_back({instance.placement.inverse(), SeamViewer(parts[instance.part])});
  }
  const Vec3 target = options.look_at ? to_vector(*options.look_at) : Vec3(box.center());
  const Vec3 slanted = Vec3(1, 0.7, 1.3).normalized();
  const Vec3 from = options.from ? to_vector(*options.from) : Vec3(target + 8 * diagonal * slanted);
  const Vec3 to = options.to ? to_vector(*options.to) : Vec3(target + diagonal * slanted);
  std::vector<WalkFrame> frames;
  for (int i = 0; i < options.frames; ++i) {
    report_progress(&progress, "walk", static_cast<double>(i) / options.frames);
    const double share = options.frames > 1 ? static_cast<double>(i) / (options.frames - 1) : 0.0;
    frames.push_back(walk_frame(options, from + share * (to - from), target, walkers));
  }
  if (!options.output.empty()) write_file_atomically(options.output, as_csv(frames));
  progress.clear();
  print_cad_remarks(model, options.common);
  std::vector<double> times;
  double worst = 0;
  for (const WalkFrame& frame : frames) {
    times.push_back(frame.milliseconds);
    worst = std::max(worst, frame.pixel_error);
  }
  if (!options.common.json) {
    fmt::print("frame   tolerance  triangles  patches  anew  culled  pixel error        ms\n");
    const std::size_t step = std::max<std::size_t>(1, frames.size() / 10);
    for (std::size_t i = 0; i < frames.size(); i += step) {
      const WalkFrame& f = frames[i];
      fmt::print("{:5} {:11.4g} {:10} {:8} {:5} {:7} {:12.3g} {:9.3g}\n", i, f.tolerance, f.triangles,
                 f.patches, f.tessellated, f.culled, f.pixel_error, f.milliseconds);
    }
    fmt::print("median {:.3g} ms, largest pixel error {:.3g}\n", median(times), worst);
    return;
  }
  Json list = Json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) list.push_back(to_json(frames[i], i));
  print_json({{"command", "walk"},
              {"input", options.input},
              {"output", options.output.empty() ? Json(nullptr) : Json(options.output)},
              {"diagonal", diagonal},
              {"frames", list},
              {"median_milliseconds", median(times)},
              {"largest_pixel_error", worst}});
}

}  // namespace

void add_walk_command(CLI::App& app) {
  const auto options = std::make_shared<WalkOptions>();
  CLI::App* command = app.add_subcommand("walk",
                                         "Walks towards a CAD model and tells for every frame what it needs: "
                                         "tolerance, triangles, patches, time.");
  command->footer("Example:\n  recede walk part.step --frames 200 -o walk.csv");
  command->add_option("input", options->input, "CAD file (.step .stp .iges .igs .brep .brp)")->required();
  command->add_option("-o,--output", options->output, "writes a line for each frame as .csv");
  const auto group = "Walk";
  command->add_option("--from", options->from, "where it starts, millimetres (8 diagonals away)")
      ->option_text("X Y Z")
      ->group(group);
  command->add_option("--to", options->to, "where it ends (a diagonal away)")
      ->option_text("X Y Z")
      ->group(group);
  command
      ->add_option("--look-at", options->look_at,
                   "what is in the middle of the image (the middle of the model)")
      ->option_text("X Y Z")
      ->group(group);
  command->add_option("--frames", options->frames, "steps (100)")->check(between(1, 1'000'000))->group(group);
  add_up_option(*command, options->up, group);
  command->add_option("--image-width", options->width, "pixels (1920)")
      ->check(between(1, 100'000))
      ->group(group);
  command->add_option("--image-height", options->height, "pixels (1080)")
      ->check(between(1, 100'000))
      ->group(group);
  command->add_option("--field-of-view", options->field_of_view, "vertical, degrees (45)")->group(group);
  command->add_option("--pixel-error", options->pixel_error, "error that may be seen, pixels (1)")
      ->group(group);
  command
      ->add_option("--most-new-triangles", options->most_new_triangles,
                   "triangles that a frame may make anew for each part, about (all)")
      ->group(group);
  command
      ->add_option("--relative-error", options->relative_error,
                   "of the finest seams, as a share of the diagonal (0.0003)")
      ->check(above_zero())
      ->group(group);
  add_seam_options(*command, options->seams, group);
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
