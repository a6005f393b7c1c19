#include "progressive_run.h"

#include "child_process.h"
#include "models.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/displacement_bake.h>
#include <recede/lod/pmesh.h>
#include <recede/lod/selective_mesh.h>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace recede::bench {
namespace {

constexpr unsigned k_seconds_allowed = 900;

ProgressiveFigures::File measure_file(const ProgressiveMesh& mesh, const PmeshOptions& options,
                                      const std::filesystem::path& path, std::size_t repeats) {
  ProgressiveFigures::File file;
  file.write_seconds = median_seconds(repeats, [&] {
    const PmeshReport report = write_pmesh(path, mesh, options);
    file.bytes = report.bytes;
    file.numbering_bytes = report.numbering_bytes;
  });
  file.read_seconds = median_seconds(repeats, [&] {
    if (read_pmesh(path).n_splits() != mesh.n_splits()) throw Error("the file lost splits");
  });
  return file;
}

ProgressiveFigures measure_ours(const PolygonSoup& soup, const std::filesystem::path& path,
                                std::size_t repeats) {
  ProgressiveFigures figures;
  const ProgressiveOptions options = progressive_options(soup, false);
  figures.simplify_seconds = median_seconds(repeats, [&] { simplify(soup, options.simplify); });
  ProgressiveMesh mesh;
  figures.build_seconds = median_seconds(repeats, [&] { mesh = build_progressive_mesh(soup, options); });
  const double with_proof =
      median_seconds(1, [&] { mesh = build_progressive_mesh(soup, progressive_options(soup, true)); });
  figures.proof_seconds = with_proof - figures.build_seconds;
  figures.base_faces = mesh.level_faces.front();
  ProgressiveCursor cursor(mesh);
  // Once around to touch all memory.
  cursor.move_to(mesh.n_splits());
  cursor.move_to(0);
  figures.refine_seconds = median_seconds(
      repeats, [&] { cursor.move_to(mesh.n_splits()); }, [&] { cursor.move_to(0); });
  figures.coarsen_seconds = median_seconds(
      repeats, [&] { cursor.move_to(0); }, [&] { cursor.move_to(mesh.n_splits()); });
  figures.lossless = measure_file(mesh, {}, path, repeats);
  figures.quantised = measure_file(mesh, {.position_bits = k_bits}, path, repeats);
  return figures;
}

SimplifySoupResult simplify_with_texture(const PolygonSoup& soup, CostPolicy cost) {
  SimplifyOptions options;
  options.target.ratio = k_texture_share;
  options.cost = cost;
  options.placement = VertexPlacement::half_edge;
  options.prove_error = false;
  return simplify(soup, options);
}

TextureFigures measure_texture(const PolygonSoup& soup, std::size_t repeats) {
  TextureFigures figures;
  AtlasResult atlas;
  figures.atlas_seconds = median_seconds(repeats, [&] { atlas = make_atlas(soup); });
  figures.charts = atlas.charts.size();
  figures.stretch = atlas.stretch.l2;
  SimplifySoupResult result;
  const auto run = [&](CostPolicy cost) {
    return median_seconds(repeats, [&] { result = simplify_with_texture(atlas.soup, cost); });
  };
  figures.deviation_seconds = run(CostPolicy::texture_deviation);
  figures.deviation_rms = rms_share(soup, result.soup);
  figures.volume_seconds = run(CostPolicy::volume);
  figures.volume_rms = rms_share(soup, result.soup);
  return figures;
}

MapFigures measure_map(const PolygonSoup& soup, std::size_t repeats) {
  SimplifyOptions coarser;
  coarser.target.ratio = k_map_share;
  const SimplifySoupResult coarse = simplify(soup, coarser);
  MapOptions options;
  options.size = k_map_size;
  options.search_distance = MapOptions::k_reach * coarse.error_bound.value();
  BakedMaps maps;
  MapFigures figures;
  figures.seconds = median_seconds(repeats, [&] { maps = bake_maps(soup, coarse.soup, options); });
  const MapAccuracy accuracy = measure_maps(soup, maps);
  const double diagonal = bounding_box(soup).diagonal().norm();
  figures.faces = coarse.faces_after;
  figures.texels = maps.report.texels;
  figures.missed = maps.report.missed;
  figures.bare_rms = accuracy.bare_rms / diagonal;
  figures.rms = accuracy.rms / diagonal;
  figures.bare_max = accuracy.bare_max / diagonal;
  figures.max = accuracy.max / diagonal;
  return figures;
}

WalkFigures measure_walk(const PolygonSoup& soup) {
  const ProgressiveMesh mesh = build_progressive_mesh(soup, progressive_options(soup, true));
  const Box3 box = bounding_box(soup);
  std::optional<SelectiveMesh> selective;
  WalkFigures figures;
  figures.setup_seconds = median_seconds(1, [&] { selective.emplace(mesh); });
  std::vector<double> milliseconds, faces, moves;
  for (int frame = 0; frame < k_walk_frames; ++frame) {
    const RefinementView view = view_of_frame(frame, box);
    RefinementReport report;
    milliseconds.push_back(1e3 * median_seconds(1, [&] { report = selective->update(view); }));
    faces.push_back(static_cast<double>(report.faces));
    moves.push_back(static_cast<double>(report.splits + report.merges));
  }
  figures.first = milliseconds.front();
  std::sort(milliseconds.begin() + 1, milliseconds.end());
  figures.median = milliseconds[milliseconds.size() / 2];
  figures.slow = milliseconds[milliseconds.size() * 95 / 100];
  figures.slowest = milliseconds.back();
  figures.faces = median(faces);
  figures.moves = median(moves);
  return figures;
}

template <class Figures>
Measured<Figures> in_child(const std::function<Figures()>& measure) {
  const ChildAnswer answer = run_in_child(
      [&] {
        const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, std::size_t{1});
        return as_bytes(measure());
      },
      k_seconds_allowed);
  if (!answer.succeeded) return {std::nullopt, answer.failure};
  return {ByteReader(answer.bytes).take<Figures>(), ""};
}

ProgressiveRow run_model(const ModelSource& source, const BenchOptions& options) {
  const PolygonSoup soup = load_model(source);
  const std::filesystem::path file = options.out / "bench.pmesh";
  ProgressiveRow row{.model = source.name, .faces = soup.n_faces(), .vertices = soup.positions.size()};
  row.walk = in_child<WalkFigures>([&] { return measure_walk(soup); });
  if (soup.n_faces() > k_large) {
    row.ours.failure = row.openmesh.failure = row.texture.failure = row.maps.failure = "not measured";
    return row;
  }
  row.ours = in_child<ProgressiveFigures>([&] { return measure_ours(soup, file, options.repeats); });
  row.openmesh = in_child<ProgressivePeerFigures>([&] {
    return run_openmesh_progressive(soup, share_of_faces(soup, k_base_share), file, options.repeats);
  });
  row.texture = in_child<TextureFigures>([&] { return measure_texture(soup, options.repeats); });
  row.maps = in_child<MapFigures>([&] { return measure_map(soup, options.repeats); });
  std::filesystem::remove(file);
  return row;
}

}  // namespace

double rms_share(const PolygonSoup& input, const PolygonSoup& result) {
  const MeshDistance distance = measure_distance(input, result);
  return distance.rms / distance.diagonal;
}

std::size_t share_of_faces(const PolygonSoup& soup, double share) {
  return static_cast<std::size_t>(share * static_cast<double>(soup.n_faces()));
}

ProgressiveOptions progressive_options(const PolygonSoup& soup, bool prove) {
  ProgressiveOptions options;
  options.simplify.target.faces = share_of_faces(soup, k_base_share);
  options.simplify.placement = VertexPlacement::half_edge;
  options.simplify.prove_error = prove;
  return options;
}

RefinementView view_of_frame(int frame, const Box3& box) {
  const Vec3 center = box.center();
  const double radius = box.diagonal().norm() / 2;
  const double angle = std::numbers::pi * frame / k_walk_frames;
  const double distance = radius * (1.2 + 0.6 * std::cos(3 * angle));
  RefinementView view;
  view.position = center + distance * Vec3(std::sin(angle), 0.3, std::cos(angle));
  view.target = center + 0.3 * radius * Vec3(std::cos(2 * angle), 0, 0);
  view.aspect_ratio = 16.0 / 9;
  return view;
}

BenchSection measure_progressive(const BenchOptions& options) {
  std::vector<ModelSource> sources = all_models(options.data, options.quick);
  std::erase_if(sources, [&](const ModelSource& source) {
    return source.polygons || !is_wanted(source.name, options.models);
  });
  for (const ModelSource& source : sources) require_file(source);
  std::filesystem::create_directories(options.out);
  std::vector<ProgressiveRow> rows;
  BenchSection section;
  for (const ModelSource& source : sources) {
    rows.push_back(run_model(source, options));
    fmt::print(stderr, "{} is done\n", source.name);
    section.markdown = progressive_tables(rows);
    write_file_atomically(options.out / "progressive.md", section.markdown);
    write_file_atomically(options.out / "progressive.csv", progressive_csv(rows));
  }
  section.curves = progressive_curves(options);
  return section;
}

}  // namespace recede::bench
