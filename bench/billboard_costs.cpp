// What clouds cost: seconds and memory of growing models, and pictures for as many bytes.
#include "billboard_models.h"
#include "billboard_run.h"
#include "child_process.h"
#include "measurement.h"
#include "plot_sheet.h"
#include "work_timer.h"
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/octahedral_impostor.h>
#include <recede/render/far_level.h>
#include <recede/render/renderer.h>
#include <recede/render/sphere_directions.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::bench {
namespace {

constexpr unsigned k_seconds_allowed = 900;

struct CostFigures {
  std::size_t faces = 0, billboards = 0, peak_bytes = 0;
  double clustering = 0, texturing = 0, clustering_processor = 0;  // seconds
};

// Four clouds from one run, and textures of the one at 1 %.
CostFigures measure_cost(const PolygonSoup& model, bool is_two_sided, std::size_t repeats) {
  CostFigures figures{.faces = model.n_faces()};
  const std::size_t before = resident_bytes();
  forget_peak();
  BillboardOptions options;
  options.is_two_sided = is_two_sided;
  std::vector<double> clustering, texturing, processor;
  for (std::size_t i = 0; i < repeats; ++i) {
    const WorkTimer timer;
    const std::vector<BillboardCloud> clouds = build_billboard_clouds(model, options);
    clustering.push_back(timer.wall());
    processor.push_back(timer.cpu());
    const WorkTimer of_textures;
    texture_billboards(model, clouds[1]);
    texturing.push_back(of_textures.wall());
    figures.billboards = clouds[1].billboards.size();
    if (i == 0) figures.peak_bytes = peak_above(before);
  }
  figures.clustering = median(clustering);
  figures.clustering_processor = median(processor);
  figures.texturing = median(texturing);
  return figures;
}

// Root mean square of sRGB differences over the model's pixels, as `compare_far_levels` has it, so that
// impostors stand beside its figures.
class FarViews {
 public:
  FarViews(const LodHierarchy& hierarchy, double distance, int n_views) {
    const Scene model(hierarchy.levels[0]);
    for (const Vec3& direction : spread_directions(n_views).directions) {
      const Camera whole =
          look_at(hierarchy.center, direction, distance + hierarchy.radius, Vec3::UnitY(), hierarchy.view);
      int side = std::min(whole.height, static_cast<int>(projected_diameter(whole, hierarchy.radius)) + 4);
      side += (whole.height - side) % 2;
      cameras_.push_back(crop_to_middle(whole, side, side));
      pictures_.push_back(render(model, cameras_.back(), options_));
    }
  }

  double difference(const Scene& scene) const {
    double squares = 0, n = 0;
    for (std::size_t view = 0; view < cameras_.size(); ++view) {
      const Image picture = render(scene, cameras_[view], options_);
      for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        n += pictures_[view].pixels[i] != options_.background ? 3 : 0;
        for (int k = 0; k < 3; ++k)
          squares += std::pow(static_cast<double>(encode_srgb(picture.pixels[i][k]) -
                                                  encode_srgb(pictures_[view].pixels[i][k])),
                              2);
      }
    }
    return std::sqrt(squares / std::max(1.0, n));
  }

 private:
  RenderOptions options_{.samples_per_pixel = 16};
  std::vector<Camera> cameras_;
  std::vector<Image> pictures_;
};

}  // namespace

BenchSection measure_billboard_growth(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Seconds and memory\n\nElapsed, all threads; clusters at four errors, textures of the cloud at 1 % "
      "of "
      "the longest side; memory above the model's\n\n| model | billboards at 1 % | clusters, s | of "
      "processors | "
      "textures, s | MB at most |\n|---|---|---|---|---|---|\n";
  Plot time = log_plot("Four clouds and the textures of one", "faces", "seconds"),
       memory = log_plot("Memory above the model", "faces", "bytes per face");
  for (const bool are_leaves : {false, true}) {
    for (const std::size_t faces : {10'000u, 30'000u, 100'000u, 300'000u, 1'000'000u}) {
      if (options.quick && faces > 100'000) continue;
      const std::string name = fmt::format("{}, {} faces", are_leaves ? "loose leaves" : "sphere", faces);
      if (!is_wanted(name, options.models)) continue;
      const std::size_t repeats = faces > 100'000 ? 1 : options.repeats;
      const ChildAnswer answer = run_in_child(
          [&] {
            return as_bytes(measure_cost(
                are_leaves ? loose_leaves(faces) : make_displaced_sphere(faces, true), are_leaves, repeats));
          },
          k_seconds_allowed);
      if (!answer.succeeded) {
        section.markdown += fmt::format("| {} | {} |\n", name, answer.failure);
        section.rows.push_back({{"model", name}, {"failure", answer.failure}});
        continue;
      }
      const auto f = ByteReader(answer.bytes).take<CostFigures>();
      section.markdown +=
          fmt::format("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.0f} |\n", name, f.billboards, f.clustering,
                      f.clustering_processor, f.texturing, 1e-6 * static_cast<double>(f.peak_bytes));
      section.rows.push_back({{"model", name},
                              {"faces", f.faces},
                              {"billboards", f.billboards},
                              {"seconds", f.clustering},
                              {"processor_seconds", f.clustering_processor},
                              {"texture_seconds", f.texturing},
                              {"peak_bytes", f.peak_bytes}});
      const auto n_faces = static_cast<double>(f.faces);
      const char* series = are_leaves ? "loose leaves" : "ball with ridges";
      add_point(time, series, n_faces, f.clustering + f.texturing);
      add_point(memory, series, n_faces, static_cast<double>(f.peak_bytes) / n_faces);
      fmt::print(stderr, "{}: {:.2f} s\n", name, f.clustering + f.texturing);
    }
  }
  section.curves = {time, memory};
  return section;
}

BenchSection measure_far_levels(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Far levels\n\nThe tree where a pixel is the error, 12 views: root mean square of sRGB differences "
      "over its pixels\n\n| error | billboards | texels | bytes | off by | octahedral impostor of as many "
      "bytes "
      "| triangles of as many bytes | off by |\n|---|---|---|---|---|---|---|---|\n";
  const BillboardModel tree = billboard_model(options, "tree");
  HierarchyOptions levels;
  levels.ratios = {0.5, 0.25, 0.1, 0.03};
  const LodHierarchy hierarchy = build_hierarchy(repair_to_polygon_mesh(tree.soup).mesh, tree.name, levels);
  FarLevelOptions far;
  far.relative_errors = {0.005, 0.01, 0.02, 0.04, 0.08};
  Plot plot = log_plot("The tree where a pixel is the error", "bytes", "RMS of sRGB differences");
  for (const FarLevelTrial& trial : compare_far_levels(hierarchy, far)) {
    const double share = trial.error / tree.size();
    if (!trial.cloud) {
      section.markdown += fmt::format("| {:g} % | {} |\n", 100 * share, trial.reason);
      section.rows.push_back({{"error_share", share}, {"reason", trial.reason}});
      continue;
    }
    const FarViews views(hierarchy, trial.distance, far.views);
    const BillboardTextures impostor = octahedral_impostor_within(tree.soup, trial.billboard_bytes);
    const double of_impostor = views.difference(scene_of(impostor)),
                 again = views.difference(scene_of(*trial.cloud));
    constexpr double k_rounding = 1e-6;  // of floats
    if (!(std::abs(again - trial.billboard_difference) <= k_rounding))
      throw Error(fmt::format("a cloud is {:.6f} off here, and {:.6f} as a far level", again,
                              trial.billboard_difference));
    section.markdown +=
        fmt::format("| {:g} % | {} | {} | {} | {:.3f} | {:.3f} | {} | {:.3f} |\n", 100 * share,
                    trial.billboards, trial.texels, trial.billboard_bytes, trial.billboard_difference,
                    of_impostor, trial.triangles, trial.triangle_difference);
    section.rows.push_back({{"error_share", share},
                            {"billboards", trial.billboards},
                            {"texels", trial.texels},
                            {"bytes", trial.billboard_bytes},
                            {"billboard_difference", trial.billboard_difference},
                            {"impostor_difference", of_impostor},
                            {"impostor_bytes", billboard_bytes(impostor)},
                            {"triangles", trial.triangles},
                            {"triangle_bytes", trial.triangle_bytes},
                            {"triangle_difference", trial.triangle_difference}});
    add_point(plot, "billboards", static_cast<double>(trial.billboard_bytes), trial.billboard_difference);
    add_point(plot, "octahedral impostor", static_cast<double>(billboard_bytes(impostor)), of_impostor);
    add_point(plot, "triangles", static_cast<double>(trial.triangle_bytes), trial.triangle_difference);
  }
  section.curves.push_back(plot);
  return section;
}

}  // namespace recede::bench
