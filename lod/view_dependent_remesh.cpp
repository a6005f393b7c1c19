#include <recede/geometry/error.h>
#include <recede/lod/detail/patch_dicer.h>
#include <recede/lod/view_dependent_remesh.h>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace recede {
namespace {

using detail::DicedMesh;
using detail::FootprintHeights;
using detail::GridSpace;
using detail::PatchDicer;
using detail::PatchPlace;
using detail::ViewEdge;
using detail::ViewPatch;
using detail::ViewPatches;

void check(const RemeshOptions& options) {
  if (!(options.largest_depth_ratio > 1)) throw OptionError("the largest depth ratio must be above 1");
  if (options.most_triangles < 1 || options.most_triangles > std::numeric_limits<Index>::max() / 3) {
    throw OptionError("the number of triangles must lie between 1 and 1.4 billion");
  }
}

/// The stages of one view.
class Remesher {
 public:
  Remesher(const DisplacedBase& base, const RemeshView& view, const RemeshOptions& options)
      : options_(options),
        materials_(base.materials()),
        space_(view, options.triangle_pixels, nearest(base, options), base.largest_reach()),
        patches_(base, space_, options),
        heights_(base.levels(), options.footprint),
        dicer_(patches_, space_, heights_,
               Vec2(base.levels().level(0).columns(), base.levels().level(0).rows()), mesh_) {
    report_.base_triangles = base.n_input_triangles();
  }

  RemeshResult run(Progress* progress) {
    number_vertices();
    allocate();
    report_progress(progress, "dicing", 0);
    place_borders();
    // In parts, so that it can be cancelled.
    constexpr std::size_t k_part = 8192;
    const std::size_t n = patches_.patches.size();
    for (std::size_t first = 0; first < n; first += k_part) {
      report_progress(progress, "dicing", static_cast<double>(first) / static_cast<double>(n));
      dice_patches(first, std::min(n, first + k_part));
    }
    for (const PatchDicer::Workspace& work : workspaces_)
      report_.largest_move = std::max(report_.largest_move, work.largest_move);
    RemeshResult result;
    if (options_.normals) join_normals(result.soup);
    result.soup.positions = std::move(mesh_.positions);
    result.soup.corner_vertices = std::move(mesh_.corners);
    result.soup.corner_uvs = std::move(mesh_.corner_uvs);
    result.soup.face_offsets.resize(report_.triangles + 1);
    for (std::size_t f = 0; f <= report_.triangles; ++f)
      result.soup.face_offsets[f] = static_cast<Index>(3 * f);
    set_materials(result.soup);
    result.report = report_;
    report_progress(progress, "dicing", 1);
    return result;
  }

 private:
  static double nearest(const DisplacedBase& base, const RemeshOptions& options) {
    if (options.nearest) return *options.nearest;
    return base.diagonal() > 0 ? RemeshOptions::k_nearest * base.diagonal() : 1;
  }

  /// Corners first, then edges, then the inside of patches.
  void number_vertices() {
    std::size_t next = 0;
    mesh_.corner_vertices.assign(patches_.positions.size(), DicedMesh::k_unused);
    for (const ViewPatch& patch : patches_.patches) {
      if (patch.culled) continue;
      for (const Index p : patch.points) mesh_.corner_vertices[p] = 0;
    }
    for (std::size_t& vertex : mesh_.corner_vertices) {
      if (vertex != DicedMesh::k_unused) vertex = next++;
    }
    report_.corner_vertices = next;
    for (ViewEdge& edge : patches_.edges) {
      if (!edge.kept) continue;
      edge.first_vertex = next;
      next += edge.pieces - 1;
    }
    report_.edge_vertices = next - report_.corner_vertices;
    measure_patches();
    add_up_places(next);
  }

  void measure_patches() {
    mesh_.places.resize(patches_.patches.size());
    std::vector<std::uint8_t> axes(mesh_.places.size(), 0);
    constexpr std::uint8_t k_flat = 3, k_culled = 4;
    tbb::parallel_for(std::size_t{0}, mesh_.places.size(), [&](std::size_t t) {
      const ViewPatch& patch = patches_.patches[t];
      if (patch.culled) {
        axes[t] = k_culled;
        return;
      }
      detail::GridSweep& sweep = workspaces_.local().sweep;
      sweep.set(dicer_.voxels(patch));
      mesh_.places[t] = {
          .n_inside = sweep.n_inside(), .n_triangles = sweep.n_triangles(), .n_border = sweep.n_border()};
      axes[t] = sweep.plan().is_flat ? k_flat : static_cast<std::uint8_t>(sweep.plan().sweep);
    });
    std::array<std::size_t, k_culled + 1> counts{};
    for (const std::uint8_t axis : axes) ++counts[axis];
    report_.patches = axes.size();
    report_.swept_x = counts[0];
    report_.swept_y = counts[1];
    report_.swept_z = counts[2];
    report_.flat = counts[k_flat];
    report_.culled = counts[k_culled];
  }

  void add_up_places(std::size_t next_vertex) {
    std::size_t triangles = 0, borders = 0;
    for (PatchPlace& place : mesh_.places) {
      place.first_vertex = next_vertex;
      place.first_triangle = triangles;
      place.first_border = borders;
      next_vertex += place.n_inside;
      triangles += place.n_triangles;
      borders += place.n_border;
    }
    report_.inner_vertices = next_vertex - report_.corner_vertices - report_.edge_vertices;
    report_.triangles = triangles;
    n_borders_ = borders;
    if (triangles > options_.most_triangles) {
      throw OptionError(
          fmt::format("the view needs {} triangles, more than {}", triangles, options_.most_triangles));
    }
  }

  void allocate() {
    const std::size_t n = report_.corner_vertices + report_.edge_vertices + report_.inner_vertices;
    mesh_.positions.resize(n);
    mesh_.corners.resize(3 * report_.triangles);
    mesh_.corner_uvs.resize(3 * report_.triangles);
    if (!options_.normals) return;
    mesh_.vertex_normals.assign(n, Vec3::Zero());
    mesh_.border_normals.resize(n_borders_);
  }

  void place_borders() {
    tbb::parallel_for(std::size_t{0}, patches_.positions.size(), [&](std::size_t p) {
      if (mesh_.corner_vertices[p] != DicedMesh::k_unused)
        dicer_.place_corner(p, workspaces_.local().largest_move);
    });
    tbb::parallel_for(std::size_t{0}, patches_.edges.size(), [&](std::size_t e) {
      if (patches_.edges[e].kept) dicer_.place_edge(e, workspaces_.local().largest_move);
    });
  }

  void dice_patches(std::size_t first, std::size_t end) {
    tbb::parallel_for(first, end, [&](std::size_t t) {
      if (!patches_.patches[t].culled) dicer_.dice(t, workspaces_.local());
    });
  }

  /// Sums on corners and edges, over the patches around, and unit vectors everywhere.
  void join_normals(PolygonSoup& soup) {
    std::vector<Vec3>& normals = mesh_.vertex_normals;
    const auto& patches = patches_.patches;
    tbb::parallel_for(std::size_t{0}, patches_.positions.size(), [&](std::size_t p) {
      for (const auto& [t, k] : patches_.uses_of_point(p)) {
        if (!patches[t].culled)
          normals[mesh_.corner_vertices[p]] += mesh_.border_normals[mesh_.places[t].first_border + k];
      }
    });
    tbb::parallel_for(std::size_t{0}, patches_.edges.size(), [&](std::size_t e) {
      const ViewEdge& edge = patches_.edges[e];
      const std::size_t n = edge.pieces - 1;
      for (const auto& [t, k] : patches_.uses_of_edge(e)) {
        if (patches[t].culled) continue;
        std::size_t first = mesh_.places[t].first_border + 3;
        for (std::size_t before = 0; before < k; ++before)
          first += patches_.edges[patches[t].edges[before]].pieces - 1;
        const bool forwards = patches[t].points[k] == edge.from;
        for (std::size_t i = 0; i < n; ++i)
          normals[edge.first_vertex + i] += mesh_.border_normals[first + (forwards ? i : n - 1 - i)];
      }
    });
    tbb::parallel_for(std::size_t{0}, normals.size(),
                      [&](std::size_t v) { normals[v] = normals[v].stableNormalized(); });
    soup.corner_normals.resize(mesh_.corners.size());
    tbb::parallel_for(std::size_t{0}, mesh_.corners.size(),
                      [&](std::size_t c) { soup.corner_normals[c] = normals[mesh_.corners[c]]; });
  }

  void set_materials(PolygonSoup& soup) const {
    soup.materials = materials_;
    if (materials_.empty()) return;
    soup.face_materials.reserve(report_.triangles);
    for (std::size_t t = 0; t < patches_.patches.size(); ++t)
      soup.face_materials.insert(soup.face_materials.end(), mesh_.places[t].n_triangles,
                                 patches_.patches[t].material);
  }

  const RemeshOptions& options_;
  const std::vector<Material>& materials_;
  GridSpace space_;
  ViewPatches patches_;
  FootprintHeights heights_;
  DicedMesh mesh_;
  PatchDicer dicer_;
  tbb::enumerable_thread_specific<PatchDicer::Workspace> workspaces_;
  std::size_t n_borders_ = 0;
  RemeshReport report_;
};

}  // namespace

RemeshResult remesh_for_view(const DisplacedBase& base, const RemeshView& view, const RemeshOptions& options,
                             Progress* progress) {
  check(options);
  const auto start = std::chrono::steady_clock::now();
  report_progress(progress, "patches", 0);
  RemeshResult result = Remesher(base, view, options).run(progress);
  result.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace recede
