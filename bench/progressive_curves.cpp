// Progressive meshes as plots: what a level, a byte and a millisecond give.
#include "models.h"
#include "plot_sheet.h"
#include "progressive_run.h"
#include "systems.h"
#include <recede/lod/pmesh.h>

#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>

namespace recede::bench {
namespace {

constexpr const char* k_model = "bunny00";
constexpr double k_shares[]{0.5, 0.2, 0.1, 0.05, 0.02, 0.01};

/// What OpenMesh's decimater, whose collapses its progressive mesh records, comes to.
PolygonSoup openmesh_level(const PolygonSoup& soup, std::size_t faces) {
  std::vector<System> systems;
  add_openmesh(systems);
  SimplifyTarget target;
  target.faces = faces;
  return systems.front().run(soup, target).result;
}

/// Of its file: a head, base points and triangles of 12 bytes each, and 24 for every vertex that comes back.
double openmesh_bytes(const PolygonSoup& level, const PolygonSoup& base) {
  constexpr double k_head = 20, k_element = 12, k_split = 24;
  const auto base_elements = static_cast<double>(base.positions.size() + base.n_faces());
  return k_head + k_element * base_elements +
         k_split * static_cast<double>(level.positions.size() - base.positions.size());
}

PolygonSoup simplified(const PolygonSoup& soup, std::size_t faces) {
  SimplifyOptions options;
  options.target.faces = faces;
  options.prove_error = false;
  return simplify(soup, options).soup;
}

/// As the bytes come: after each that has come so far, how far the finest level is off.
void add_stream(Plot& plot, const std::string& series, const PolygonSoup& soup, const ProgressiveMesh& mesh,
                const PmeshOptions& options) {
  const std::string bytes = encode_pmesh(mesh, options);
  PmeshReader reader(series);
  std::size_t fed = 0;
  for (const double share : {0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 0.9}) {
    const auto until = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
    reader.feed(std::string_view(bytes).substr(fed, until - fed));
    fed = until;
    if (reader.n_batches() == 0) continue;
    const ProgressiveMesh come = reader.mesh();
    ProgressiveCursor cursor(come);
    cursor.move_to(come.n_splits());
    add_point(plot, series, static_cast<double>(fed), rms_share(soup, cursor.soup()));
  }
}

/// Median of the updates of a walk.
double walk_milliseconds(const ProgressiveMesh& mesh, const Box3& box, double pixel_error) {
  SelectiveMesh selective(mesh);
  std::vector<double> milliseconds;
  for (int frame = 0; frame < k_walk_frames; ++frame) {
    RefinementView view = view_of_frame(frame, box);
    view.view.pixel_error = pixel_error;
    const double seconds = median_seconds(1, [&] { selective.update(view); });
    if (frame > 0) milliseconds.push_back(1e3 * seconds);
  }
  return median(milliseconds);
}

}  // namespace

std::vector<Plot> progressive_curves(const BenchOptions& options) {
  const std::vector<ModelSource> sources = all_models(options.data, true);
  const auto source = std::find_if(sources.begin(), sources.end(),
                                   [](const ModelSource& one) { return one.name == k_model; });
  if (source == sources.end() || !is_wanted(source->name, options.models)) return {};
  const PolygonSoup soup = load_model(*source);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, std::size_t{1});
  const ProgressiveMesh mesh = build_progressive_mesh(soup, progressive_options(soup, true));
  Plot over_faces = log_plot(fmt::format("{}: levels", k_model), "faces", "RMS / diagonal"),
       over_bytes = log_plot("As bytes come", "bytes", "RMS / diagonal"),
       over_time = log_plot("A walk around it", "milliseconds of an update, median", "error in pixels");
  ProgressiveCursor cursor(mesh);
  const PolygonSoup openmesh_base = openmesh_level(soup, share_of_faces(soup, k_base_share));
  add_stream(over_bytes, "Recede, floats", soup, mesh, {});
  add_stream(over_bytes, fmt::format("Recede, {} bits", k_bits), soup, mesh, {.position_bits = k_bits});
  for (const double share : k_shares) {
    const std::size_t faces = share_of_faces(soup, share);
    const auto size = static_cast<double>(faces);
    cursor.move_to(mesh.level_for_faces(faces));
    add_point(over_faces, "Recede, progressive", size, rms_share(soup, cursor.soup()));
    const PolygonSoup peer = openmesh_level(soup, faces);
    const double peer_error = rms_share(soup, peer);
    add_point(over_faces, "OpenMesh, progressive", size, peer_error);
    add_point(over_bytes, "OpenMesh, floats", openmesh_bytes(peer, openmesh_base), peer_error);
    add_point(over_faces, "Recede, simplify", size, rms_share(soup, simplified(soup, faces)));
  }
  for (const double pixels : {0.5, 1.0, 2.0, 4.0, 8.0})
    add_point(over_time, "Recede", walk_milliseconds(mesh, bounding_box(soup), pixels), pixels);
  return {over_faces, over_bytes, over_time};
}

}  // namespace recede::bench
