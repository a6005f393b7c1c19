// Hierarchies of levels that are baked, for Python.
#include "baked_maps.h"
#include "billboards.h"
#include "calls.h"
#include "hierarchy.h"
#include "options.h"
#include <recede/geometry/mesh_io.h>
#include <recede/lod/cad_hierarchy.h>
#include <recede/lod/out_of_core.h>
#include <recede/render/far_level.h>
#include <recede/render/report.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

namespace recede::python {
namespace {

namespace fs = std::filesystem;

struct BakeResult {
  LodHierarchy hierarchy;
  HierarchyFiles files;
  std::optional<ReportFiles> report;
  std::vector<std::string> far_levels{};  // why billboards or triangles stand far away
  std::vector<CadLevelReport> cad_levels{};
  std::vector<CadSeamReport> cad_parts{};
  std::vector<double> left_out{};
};

/// What to write beside a hierarchy.
struct OutputChoice {
  HierarchyWriteOptions write;
  bool has_report = true;
  ReportOptions report;
};

OutputChoice read_output_choice(const py::dict& from) {
  OutputChoice output;
  read(from, "up", output.report.up);
  read(from, "report", output.has_report);
  read(from, "glb_per_level", output.write.glb_per_level);
  read(from, "viewer_triangles", output.report.viewer_triangles);
  return output;
}

/// What hierarchies of meshes and of CAD models have in common.
template <typename Options>
void read_errors_and_view(const py::dict& from, Options& options) {
  read(from, "errors", options.errors);
  read(from, "relative_errors", options.relative_errors);
  read(from, "distances", options.distances);
  read(from, "image_height", options.view.image_height);
  read(from, "field_of_view", options.view.field_of_view);
  read(from, "pixel_error", options.view.pixel_error);
}

void write(const fs::path& folder, BakeResult& baked, const OutputChoice& output, Progress* progress) {
  baked.files = write_hierarchy(folder, baked.hierarchy, output.write);
  if (output.has_report)
    baked.report = write_report(folder, baked.hierarchy, baked.files, output.report, progress);
}

/// What `recede.bake` was asked for, of a mesh.
struct BakeOrder {
  BakeOrder(const py::dict& levels, const py::dict& options, double feature) : feature_angle(feature) {
    hierarchy.simplify = read_options(options);
    read(levels, "faces", hierarchy.faces);
    read(levels, "ratios", hierarchy.ratios);
    read_errors_and_view(levels, hierarchy);
    if (levels.contains("maps") && py::len(levels["maps"]) > 0) hierarchy.maps = read_map_options(levels);
    output = read_output_choice(levels);
    read(levels, "billboards", with_billboards);
  }

  HierarchyOptions hierarchy;
  OutputChoice output;
  double feature_angle = 0;
  bool with_billboards = true;
};

LodHierarchy hierarchy_of(PolygonMesh mesh, const std::string& name, const BakeOrder& order,
                          Progress* progress) {
  if (order.feature_angle > 0) mark_feature_edges(mesh, order.feature_angle);
  return build_hierarchy(mesh, name, order.hierarchy, progress);
}

BakeResult finish(LodHierarchy hierarchy, const fs::path& folder, const BakeOrder& order,
                  Progress* progress) {
  BakeResult baked;
  baked.hierarchy = std::move(hierarchy);
  if (order.with_billboards) {
    std::vector<FarLevelTrial> trials = compare_far_levels(baked.hierarchy, {}, progress);
    append_far_levels(baked.hierarchy, trials, progress);
    for (const FarLevelTrial& trial : trials) baked.far_levels.push_back(trial.reason);
  }
  write(folder, baked, order.output, progress);
  return baked;
}

BakeResult bake(const Mesh& mesh, const fs::path& folder, const std::string& name, const py::dict& levels,
                const py::dict& options, double feature_angle, py::object progress) {
  const BakeOrder order(levels, options, feature_angle);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    return finish(hierarchy_of(repair_to_polygon_mesh(*mesh.soup).mesh, name, order, p), folder, order, p);
  });
}

BakeResult bake_file(const fs::path& file, const fs::path& folder, const std::string& name,
                     const py::dict& levels, const py::dict& options, double feature_angle,
                     std::size_t memory, py::object progress) {
  const BakeOrder order(levels, options, feature_angle);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    if (!needs_more_than(memory, file))
      return finish(hierarchy_of(read_mesh(file, p).mesh, name, order, p), folder, order, p);
    if (order.feature_angle > 0) throw OptionError("feature_angle is for meshes that fit in memory");
    OutOfCoreHierarchy built =
        build_hierarchy_out_of_core(file, name, order.hierarchy, {.memory = memory, .scratch = folder}, p);
    BakeResult baked = finish(std::move(built.hierarchy), folder, order, p);
    baked.left_out = std::move(built.left_out);
    return baked;
  });
}

BakeResult bake_cad(const CadModel& model, const fs::path& folder, const std::string& name,
                    const py::dict& levels, py::object progress) {
  CadHierarchyOptions options;
  read_errors_and_view(levels, options);
  read(levels, "gap", options.gap);
  read(levels, "use_connectivity", options.use_connectivity);
  OutputChoice output = read_output_choice(levels);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    CadHierarchy cad = build_cad_hierarchy(model, name, options, p);
    for (const CadLevelReport& level : cad.levels) output.report.patches.push_back(level.patches);
    BakeResult baked{.hierarchy = std::move(cad.hierarchy),
                     .files = {},
                     .report = {},
                     .cad_levels = std::move(cad.levels),
                     .cad_parts = std::move(cad.parts)};
    write(folder, baked, output, p);
    return baked;
  });
}

std::optional<fs::path> path_or_none(const fs::path& path) {
  return path.empty() ? std::nullopt : std::optional(path);
}
std::optional<SharedMaps> maps_of(const LodLevel& level) {
  if (!level.maps) return std::nullopt;
  return SharedMaps{std::make_shared<const BakedMaps>(*level.maps)};
}

}  // namespace

void bind_baking(py::module_& m) {
  py::class_<LevelError>(m, "LevelError")
      .def_readonly("max", &LevelError::max)
      .def_readonly("rms", &LevelError::rms)
      .def_readonly("bound", &LevelError::bound);
  py::class_<LodLevel>(m, "Level")
      .def_property_readonly("mesh", [](const LodLevel& level) { return make_mesh(to_soup(level.mesh)); })
      .def_readonly("error", &LodLevel::error)
      .def_readonly("switch_distance", &LodLevel::switch_distance)
      .def_readonly("screen_coverage", &LodLevel::screen_coverage)
      .def_readonly("stop_reason", &LodLevel::stop_reason)
      .def_property_readonly("is_billboards",
                             [](const LodLevel& level) { return level.billboards.has_value(); })
      .def_property_readonly("maps", &maps_of)
      .def_property_readonly("billboards", [](const LodLevel& level) {
        return level.billboards ? std::optional(cloud_of(*level.billboards)) : std::nullopt;
      });
  py::class_<MapFiles>(m, "MapFiles")
      .def_property_readonly("displacement", [](const MapFiles& f) { return path_or_none(f.displacement); })
      .def_property_readonly("normal", [](const MapFiles& f) { return path_or_none(f.normal); })
      .def_property_readonly("color", [](const MapFiles& f) { return path_or_none(f.color); })
      .def_property_readonly("displacement_exr",
                             [](const MapFiles& f) { return path_or_none(f.displacement_exr); })
      .def_property_readonly("normal_exr", [](const MapFiles& f) { return path_or_none(f.normal_exr); })
      .def_property_readonly("height", [](const MapFiles& f) { return path_or_none(f.height); });
  py::class_<BakeResult>(m, "BakeResult")
      .def_property_readonly(
          "levels",
          [](const py::object& self) { return levels_of(self.cast<const BakeResult&>().hierarchy, self); })
      .def_property_readonly("glb", [](const BakeResult& baked) { return baked.files.glb; })
      .def_property_readonly("level_glbs", [](const BakeResult& baked) { return baked.files.level_glbs; })
      .def_property_readonly("folder", [](const BakeResult& baked) { return baked.files.folder; })
      .def_readonly("far_levels", &BakeResult::far_levels)
      .def_readonly("cad_levels", &BakeResult::cad_levels)
      .def_readonly("cad_parts", &BakeResult::cad_parts)
      .def_property_readonly("source_faces",
                             [](const BakeResult& baked) {
                               const std::size_t faces = baked.hierarchy.source_faces;
                               return faces > 0 ? std::optional(faces) : std::nullopt;
                             })
      .def_readonly("left_out", &BakeResult::left_out)
      .def_property_readonly("map_files", [](const BakeResult& baked) { return baked.files.map_files; })
      .def_property_readonly("report", [](const BakeResult& baked) {
        return baked.report ? std::optional(baked.report->html) : std::nullopt;
      });
  m.def("bake", &bake);
  m.def("bake_file", &bake_file);
  m.def("bake_cad", &bake_cad);
}

}  // namespace recede::python
