#include "cad_meshers.h"
#include "cad_run.h"
#include "child_process.h"
#include "measurement.h"
#include "work_timer.h"
#include <recede/geometry/error.h>
#include <recede/lod/seam_viewer.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::bench {
namespace {

constexpr unsigned k_seconds_allowed = 900;
/// Pixels that the diagonal covers in the picture.
constexpr std::array<double, 4> k_sizes{1000, 300, 100, 30};
constexpr std::array<const char*, 4> k_size_names{"large", "medium", "small", "tiny"};

/// At one size. Triangles and patches of all instances.
struct SizeFigures {
  std::size_t triangles = 0, patches = 0, all_seams_triangles = 0, all_patches = 0;
  double update_seconds = 0;  ///< of a processor, from the size before
  double bound_pixels = 0;
};

std::size_t count_triangles(const SeamModel& model, double tolerance) {
  std::size_t n = 0;
  for (std::size_t patch = 0; patch < model.graph.n_patches(); ++patch) {
    try {
      n += triangulate_patch(model.graph.loops_of(patch), model.graph.positions, model.surfaces[patch],
                             {.tolerance = tolerance})
               .triangles.size();
    } catch (const InputError&) {
      continue;  // loops that cross, which the other column leaves out too
    }
  }
  return n;
}

std::vector<SizeFigures> measure_sizes(const CadSubject& subject) {
  std::vector<SeamModel> models;
  for (const CadPart& part : subject.model.parts)
    models.push_back(build_seam_model(part, {{.tolerance = k_setup_share * subject.diagonal}, {}}));
  std::vector<std::size_t> uses(models.size(), 0);
  for (const CadInstance& instance : subject.model.instances) ++uses[instance.part];
  std::vector<SeamTessellation> tessellations;
  for (const SeamModel& model : models) tessellations.emplace_back(model);
  std::vector<SizeFigures> figures;
  for (const double pixels : k_sizes) {
    const double pixel = subject.diagonal / pixels, tolerance = pixel / 2;
    SizeFigures& here = figures.emplace_back();
    for (std::size_t i = 0; i < models.size(); ++i) {
      const WorkTimer timer;
      const SeamUpdate update = tessellations[i].update(tolerance);
      here.update_seconds += timer.cpu();
      here.triangles += update.triangles * uses[i];
      here.patches += update.patches * uses[i];
      here.bound_pixels = std::max(here.bound_pixels, update.error_bound / pixel);
      here.all_patches += models[i].graph.n_patches() * uses[i];
      here.all_seams_triangles += count_triangles(models[i], tolerance) * uses[i];
    }
  }
  return figures;
}

std::string size_rows(const CadSubject& subject) {
  const ChildAnswer answer =
      run_in_child([&] { return as_bytes(measure_sizes(subject)); }, k_seconds_allowed);
  if (!answer.succeeded) return fmt::format("| {} | {} |\n", subject.name, answer.failure);
  std::vector<SizeFigures> figures;
  ByteReader(answer.bytes).take(figures);
  std::string text;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const SizeFigures& f = figures[i];
    const auto n = static_cast<double>(f.triangles), patches = static_cast<double>(f.patches);
    text += fmt::format(
        "| {}, {} ({:.0f} pixels) | {} | {} | {} | {:.1f} | {:.0f} | {:.1f} | {:.3f} | {:.2f} |\n",
        subject.name, k_size_names[i], k_sizes[i], f.triangles, f.patches, f.all_seams_triangles,
        static_cast<double>(f.all_seams_triangles) / n, 100 * patches / static_cast<double>(f.all_patches),
        n / patches, f.update_seconds, f.bound_pixels);
  }
  return text;
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

struct CostFigures {
  std::size_t patches = 0, points = 0, graph_bytes = 0, hierarchy_bytes = 0;
  double surfaces = 0, seams = 0, collapses = 0, wall = 0;
  std::size_t peak_bytes = 0;
};

CostFigures measure_cost(const std::vector<CadPart>& parts, double tolerance) {
  CostFigures figures;
  const std::size_t resident = resident_bytes();
  forget_peak();
  const WorkTimer all;
  for (const CadPart& part : parts) {
    const WorkTimer surfaces_timer;
    const std::vector<PatchSurface> surfaces = prepare_surfaces(part.patches, k_bounds_share * tolerance);
    figures.surfaces += surfaces_timer.cpu();
    const WorkTimer seams_timer;
    const SeamGraph graph = build_seam_graph(part.patches, surfaces, {.tolerance = tolerance});
    figures.seams += seams_timer.cpu();
    const WorkTimer collapses_timer;
    const SeamHierarchy hierarchy = build_seam_hierarchy(graph, surfaces);
    figures.collapses += collapses_timer.cpu();
    figures.patches += graph.n_patches();
    figures.points += graph.positions.size();
    figures.graph_bytes += bytes_of(graph.positions) + bytes_of(graph.slots) + bytes_of(graph.loop_offsets) +
                           bytes_of(graph.patch_loops);
    figures.hierarchy_bytes += bytes_of(hierarchy.splits) + bytes_of(hierarchy.errors) +
                               bytes_of(hierarchy.change_offsets) + bytes_of(hierarchy.changes) +
                               bytes_of(hierarchy.vanished);
  }
  figures.wall = all.wall();
  figures.peak_bytes = peak_above(resident);
  return figures;
}

/// Copies of a part in rows of four, as one part.
CadPart repeated(const CadPart& part, double step, std::size_t copies) {
  CadPart result{part.name, {}, 0, 0, part.is_closed};
  for (std::size_t copy = 0; copy < copies; ++copy) {
    const Vec3 move(step * static_cast<double>(copy % 4), step * static_cast<double>(copy / 4), 0);
    for (TrimmedPatch patch : part.patches) {
      for (Vec3& point : patch.surface.points) point += move;
      for (TrimmingLoop& loop : patch.loops) {
        for (TrimmingCurve& curve : loop.curves) {
          if (curve.edge != k_no_index) curve.edge += result.n_edges;
          for (Index& corner : curve.corners) {
            if (corner != k_no_index) corner += result.n_corners;
          }
        }
      }
      result.patches.push_back(std::move(patch));
    }
    result.n_edges += part.n_edges;
    result.n_corners += part.n_corners;
  }
  return result;
}

std::string cost_row(const std::string& name, const std::vector<CadPart>& parts, double tolerance) {
  const ChildAnswer answer =
      run_in_child([&] { return as_bytes(measure_cost(parts, tolerance)); }, k_seconds_allowed);
  if (!answer.succeeded) return fmt::format("| {} | {} |\n", name, answer.failure);
  const auto f = ByteReader(answer.bytes).take<CostFigures>();
  const auto points = static_cast<double>(f.points);
  return fmt::format(
      "| {} | {} | {} | {:.0f} + {:.0f} = {:.0f} | {:.2f} ; {:.2f} ; {:.2f} | {:.2f} | {:.0f} |\n", name,
      f.patches, f.points, static_cast<double>(f.graph_bytes) / points,
      static_cast<double>(f.hierarchy_bytes) / points,
      static_cast<double>(f.graph_bytes + f.hierarchy_bytes) / points, f.surfaces, f.seams, f.collapses,
      f.wall, 1e-6 * static_cast<double>(f.peak_bytes));
}

/// Milliseconds of the frames of a walk.
struct WalkFigures {
  std::size_t patches = 0, triangles = 0;  // in the last frame
  double first = 0, middle = 0, of_twenty = 0, most = 0;
};

/// From twice the diagonal to half of it, in steps of seven thousandths.
WalkFigures measure_walk(const CadPart& part, double tolerance) {
  constexpr int k_frames = 200;
  const SeamModel model = build_seam_model(part, {{.tolerance = tolerance}, {}});
  Box3 box;
  for (const Vec3& point : model.graph.positions) box.extend(point);
  SeamViewer viewer(model);
  SeamView view;
  view.target = box.center();
  view.up = Vec3::UnitZ();
  view.view.image_height = 1080;
  view.aspect_ratio = 16.0 / 9;
  WalkFigures figures;
  std::vector<double> milliseconds;
  for (int i = 0; i < k_frames; ++i) {
    const double distance = 2 * std::pow(0.25, i / (k_frames - 1.0)) * box.diagonal().norm();
    view.position = view.target + distance * Vec3(1, -2, 1.5).normalized();
    const SeamFrame frame = viewer.update(view);
    milliseconds.push_back(1000 * frame.seconds);
    figures.patches = frame.drawn_patches;
    figures.triangles = frame.drawn_triangles;
  }
  figures.first = milliseconds.front();
  std::sort(milliseconds.begin() + 1, milliseconds.end());
  figures.middle = milliseconds[k_frames / 2];
  figures.of_twenty = milliseconds[k_frames * 19 / 20];
  figures.most = milliseconds.back();
  return figures;
}

std::string walk_row(const std::string& name, const CadPart& part, double tolerance) {
  const ChildAnswer answer =
      run_in_child([&] { return as_bytes(measure_walk(part, tolerance)); }, k_seconds_allowed);
  if (!answer.succeeded) return fmt::format("| {} | {} |\n", name, answer.failure);
  const auto f = ByteReader(answer.bytes).take<WalkFigures>();
  return fmt::format("| {} | {} | {:.0f} ; {:.2f} ; {:.2f} ; {:.0f} | {} ; {} |\n", name, part.patches.size(),
                     f.first, f.middle, f.of_twenty, f.most, f.patches, f.triangles);
}

}  // namespace

std::string cad_scale_tables(const BenchOptions& options) {
  const std::filesystem::path folder = options.data.parent_path() / "cad/occ";
  const CadSubject top = load_cad({"Top.brep", false, folder / "Top.brep"});
  const CadSubject motor = load_cad({"Motor-c.brep", false, folder / "Motor-c.brep"});
  const CadSubject assembly = load_cad_assembly(4000);
  std::string text =
      "**What the Seam Graph saves:** half a pixel, from large to tiny. All seams: every patch between its "
      "seams as they are set up, within 5e-5 of the diagonal\n\n| model, pixels of its diagonal | triangles "
      "| "
      "patches | triangles with all seams | reduction | patches kept, % | triangles per patch | processor s "
      "to get there | proved, pixels |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const CadSubject* subject : {&assembly, &top, &motor}) text += size_rows(*subject);
  text +=
      "\n**What it costs:** seams within 5e-5 of the diagonal\n\n| model | patches | sewing points | bytes a "
      "point: graph + hierarchy | processor s: surfaces ; seams ; collapses | wall s | MB at most |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const CadSubject* subject : {&top, &motor})
    text += cost_row(subject->name, subject->model.parts, k_setup_share * subject->diagonal);
  constexpr std::size_t k_copies = 16;
  const CadPart many = repeated(top.model.parts.front(), top.diagonal, k_copies);
  const std::string name = fmt::format("{} times Top.brep in one part", k_copies);
  text += cost_row(name, {many}, k_setup_share * top.diagonal);
  constexpr double k_walk_share = 4e-4;
  text +=
      "\n**A walk:** 200 frames of 1080 lines, from twice the diagonal to half of it, half a pixel. Seams "
      "for "
      "4e-4 of the diagonal of one copy\n\n| model | patches | milliseconds: first frame ; median of the "
      "others "
      "; 95th of 100 ; most | patches ; triangles drawn in the last |\n|---|---|---|---|\n";
  text += walk_row("Top.brep", top.model.parts.front(), k_walk_share * top.diagonal);
  text += walk_row(name, many, k_walk_share * top.diagonal);
  return text + '\n';
}

}  // namespace recede::bench
