// The compiled part of the Python module: conversions, and calls without the interpreter's lock.
#include "calls.h"
#include "hierarchy.h"
#include "numpy_arrays.h"
#include "options.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/cad_hierarchy.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/out_of_core.h>
#include <recede/lod/simplify.h>
#include <recede/render/far_level.h>
#include <recede/render/report.h>
#include <recede/version.h>

#include <oneapi/tbb/global_control.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <optional>

namespace recede::python {
namespace {

namespace fs = std::filesystem;

SimplifyTarget read_target(const py::dict& from) {
  SimplifyTarget target;
  read(from, "faces", target.faces);
  read(from, "vertices", target.vertices);
  read(from, "ratio", target.ratio);
  read(from, "error", target.error);
  read(from, "relative_error", target.relative_error);
  return target;
}

}  // namespace

SimplifyOptions read_options(const py::dict& from) {
  SimplifyOptions options;
  options.target = read_target(from);
  read_choice<CostPolicy>(from, "cost",
                          {{"volume", CostPolicy::volume},
                           {"normal_deviation", CostPolicy::normal_deviation},
                           {"texture_deviation", CostPolicy::texture_deviation}},
                          options.cost);
  read_choice<VertexPlacement>(from, "placement",
                               {{"automatic", VertexPlacement::automatic},
                                {"half_edge", VertexPlacement::half_edge},
                                {"midpoint", VertexPlacement::midpoint},
                                {"optimal", VertexPlacement::optimal}},
                               options.placement);
  read(from, "prove_error", options.prove_error);
  read(from, "lock_borders", options.lock_borders);
  read(from, "keep_uv_seams", options.keep_uv_seams);
  read(from, "keep_normal_seams", options.keep_normal_seams);
  read(from, "join_distance", options.join_distance);
  read(from, "drop_parts", options.drop_parts);
  read(from, "uv_weight", options.weights.uv);
  read(from, "normal_weight", options.weights.normal);
  read(from, "color_weight", options.weights.color);
  read(from, "scalar_weights", options.weights.scalars);
  read(from, "keep_polygons", options.keep_polygons);
  read(from, "normal_threshold", options.normal_threshold);
  read(from, "candidate_share", options.candidate_share);
  read(from, "seed", options.seed);
  return options;
}

namespace {

/// The soup, with edges marked that are sharper than the angle (radians).
PolygonSoup with_features(const PolygonSoup& soup, double feature_angle) {
  if (!(feature_angle > 0)) return soup;
  PolygonMesh mesh = repair_to_polygon_mesh(soup).mesh;
  mark_feature_edges(mesh, feature_angle);
  return to_soup(mesh);
}

py::dict refused_counts(const SimplifyReport& report) {
  py::dict counts;
  for (std::size_t i = 0; i < report.refused.counts.size(); ++i) {
    counts[py::str(std::string(to_string(static_cast<Refusal>(i))))] = report.refused.counts[i];
  }
  return counts;
}

struct Simplified {
  Mesh mesh;
  SimplifyReport report;
};

std::vector<Simplified> simplify_mesh(const Mesh& mesh, const py::list& targets, const py::dict& options,
                                      double feature_angle, py::object progress) {
  const SimplifyOptions simplify_options = read_options(options);
  std::vector<SimplifyTarget> levels;
  for (const py::handle target : targets) levels.push_back(read_target(target.cast<py::dict>()));
  std::vector<SimplifySoupResult> results = PythonProgress(std::move(progress)).run([&](Progress* p) {
    const PolygonSoup soup = with_features(*mesh.soup, feature_angle);
    return simplify_levels(soup, levels, simplify_options, p);
  });
  std::vector<Simplified> simplified;
  for (SimplifySoupResult& result : results) {
    simplified.push_back({make_mesh(std::move(result.soup)), result});
  }
  return simplified;
}

Mesh read_repaired(const fs::path& path, bool repair, py::object progress) {
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    if (!repair) {
      ReadSoup unrepaired = read_soup_with_pictures(path, p);
      return make_mesh(std::move(unrepaired.soup), std::move(unrepaired.report.steps));
    }
    MeshFromSoup read = read_mesh(path, p);
    return make_mesh(to_soup(read.mesh), std::move(read.report.steps));
  });
}

struct Baked {
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
  std::vector<double> up{0, 1, 0};
  read(from, "up", up);
  if (up.size() != 3) throw OptionError("up must have three numbers");
  output.report.up = {up[0], up[1], up[2]};
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

void write(const fs::path& folder, Baked& baked, const OutputChoice& output, Progress* progress) {
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

Baked finish(LodHierarchy hierarchy, const fs::path& folder, const BakeOrder& order, Progress* progress) {
  Baked baked;
  baked.hierarchy = std::move(hierarchy);
  if (order.with_billboards) {
    std::vector<FarLevelTrial> trials = compare_far_levels(baked.hierarchy, {}, progress);
    append_far_levels(baked.hierarchy, trials, progress);
    for (const FarLevelTrial& trial : trials) baked.far_levels.push_back(trial.reason);
  }
  write(folder, baked, order.output, progress);
  return baked;
}

Baked bake(const Mesh& mesh, const fs::path& folder, const std::string& name, const py::dict& levels,
           const py::dict& options, double feature_angle, py::object progress) {
  const BakeOrder order(levels, options, feature_angle);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    return finish(hierarchy_of(repair_to_polygon_mesh(*mesh.soup).mesh, name, order, p), folder, order, p);
  });
}

Baked bake_file(const fs::path& file, const fs::path& folder, const std::string& name, const py::dict& levels,
                const py::dict& options, double feature_angle, std::size_t memory, py::object progress) {
  const BakeOrder order(levels, options, feature_angle);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    if (!needs_more_than(memory, file))
      return finish(hierarchy_of(read_mesh(file, p).mesh, name, order, p), folder, order, p);
    if (order.feature_angle > 0) throw OptionError("feature_angle is for meshes that fit in memory");
    OutOfCoreHierarchy built =
        build_hierarchy_out_of_core(file, name, order.hierarchy, {.memory = memory, .scratch = folder}, p);
    Baked baked = finish(std::move(built.hierarchy), folder, order, p);
    baked.left_out = std::move(built.left_out);
    return baked;
  });
}

Baked bake_cad(const CadModel& model, const fs::path& folder, const std::string& name, const py::dict& levels,
               py::object progress) {
  CadHierarchyOptions options;
  read_errors_and_view(levels, options);
  read(levels, "gap", options.gap);
  read(levels, "use_connectivity", options.use_connectivity);
  OutputChoice output = read_output_choice(levels);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    CadHierarchy cad = build_cad_hierarchy(model, name, options, p);
    for (const CadLevelReport& level : cad.levels) output.report.patches.push_back(level.patches);
    Baked baked{.hierarchy = std::move(cad.hierarchy),
                .files = {},
                .report = {},
                .cad_levels = std::move(cad.levels),
                .cad_parts = std::move(cad.parts)};
    write(folder, baked, output, p);
    return baked;
  });
}

Mesh mesh_from_arrays(const py::handle& positions, const py::handle& faces, const py::handle& corner_uvs,
                      const py::handle& corner_normals, const py::handle& vertex_colors,
                      const py::dict& vertex_scalars, const py::handle& face_materials,
                      std::vector<Material> materials, const py::handle& feature_edges) {
  PolygonSoup soup;
  soup.positions = read_rows_of_3(positions, "positions");
  read_faces(faces, soup);
  if (!corner_uvs.is_none()) soup.corner_uvs = read_rows_of_2(corner_uvs, "corner_uvs");
  if (!corner_normals.is_none()) soup.corner_normals = read_rows_of_3(corner_normals, "corner_normals");
  if (!vertex_colors.is_none()) soup.vertex_colors = read_rows_of_4(vertex_colors, "vertex_colors");
  for (const auto& [name, values] : vertex_scalars) {
    const auto text = name.cast<std::string>();
    soup.vertex_scalars.push_back({text, read_numbers(values, text)});
  }
  if (!face_materials.is_none()) soup.face_materials = read_indices(face_materials, "face_materials", true);
  soup.materials = std::move(materials);
  if (!feature_edges.is_none()) {
    const std::vector<Index> ends = read_indices(feature_edges, "feature_edges");
    if (ends.size() % 2 != 0) throw InputError("feature_edges must have two vertices in each row");
    for (std::size_t i = 0; i < ends.size(); i += 2) soup.feature_edges.emplace_back(ends[i], ends[i + 1]);
  }
  validate(soup, "Mesh");
  return make_mesh(std::move(soup));
}

/// The list as a view that keeps the mesh alive, or None when it is absent.
template <typename List>
py::object view_or_none(const py::object& self, const List& list, bool absent,
                        py::array (*view)(const List&, py::handle)) {
  if (absent) return py::none();
  return view(list, self);
}

py::object faces_of(const py::object& self) {
  const PolygonSoup& soup = *self.cast<const Mesh&>().soup;
  const std::size_t n = soup.n_faces(), size = n > 0 ? soup.face_size(0) : 3;
  for (std::size_t f = 0; f < n; ++f) {
    if (soup.face_size(f) == size) continue;
    py::list faces;
    for (std::size_t g = 0; g < n; ++g) {
      faces.append(py::cast(std::vector<Index>(soup.face(g).begin(), soup.face(g).end())));
    }
    return faces;
  }
  return items_of(soup.corner_vertices, self).attr("reshape")(n, size);
}

void bind_mesh(py::module_& m) {
  py::class_<Material>(m, "Material")
      .def(py::init([](std::string name, std::array<double, 4> color, std::string texture) {
             return Material{std::move(name), Vec4(color[0], color[1], color[2], color[3]),
                             std::move(texture)};
           }),
           py::arg("name"), py::arg("base_color") = std::array<double, 4>{0.8, 0.8, 0.8, 1.0},
           py::arg("base_color_texture") = "")
      .def_readonly("name", &Material::name)
      .def_property_readonly("base_color",
                             [](const Material& material) {
                               const Vec4& c = material.base_color;
                               return py::make_tuple(c[0], c[1], c[2], c[3]);
                             })
      .def_readonly("base_color_texture", &Material::base_color_texture)
      .def_property_readonly("base_color_picture", [](const Material& material) -> py::object {
        if (!material.base_color_picture) return py::none();
        return py::bytes(*material.base_color_picture);
      });
  py::class_<RepairStep>(m, "RepairStep")
      .def_readonly("name", &RepairStep::name)
      .def_readonly("changed", &RepairStep::changed)
      .def_readonly("detail", &RepairStep::detail);
  const auto soup_of = [](const py::object& self) -> const PolygonSoup& {
    return *self.cast<const Mesh&>().soup;
  };
  py::class_<Mesh>(m, "Mesh")
      .def(py::init(&mesh_from_arrays), py::arg("positions"), py::arg("faces"), py::kw_only(),
           py::arg("corner_uvs") = py::none(), py::arg("corner_normals") = py::none(),
           py::arg("vertex_colors") = py::none(), py::arg("vertex_scalars") = py::dict(),
           py::arg("face_materials") = py::none(), py::arg("materials") = std::vector<Material>{},
           py::arg("feature_edges") = py::none())
      .def_property_readonly("n_vertices", [](const Mesh& mesh) { return mesh.soup->positions.size(); })
      .def_property_readonly("n_faces", [](const Mesh& mesh) { return mesh.soup->n_faces(); })
      .def_property_readonly("positions",
                             [=](const py::object& s) { return rows_of(soup_of(s).positions, s); })
      .def_property_readonly("faces", &faces_of)
      .def_property_readonly("face_offsets",
                             [=](const py::object& s) { return items_of(soup_of(s).face_offsets, s); })
      .def_property_readonly("corner_vertices",
                             [=](const py::object& s) { return items_of(soup_of(s).corner_vertices, s); })
      .def_property_readonly("triangles",
                             [](const Mesh& mesh) {
                               auto list = std::make_unique<std::vector<Index>>(triangulate(*mesh.soup));
                               const auto n = static_cast<py::ssize_t>(list->size() / 3);
                               const Index* const data = list->data();
                               const py::capsule owner(list.release(), [](void* p) {
                                 delete static_cast<std::vector<Index>*>(p);
                               });
                               return py::array_t<Index>({n, py::ssize_t{3}}, data, owner);
                             })
      .def_property_readonly("corner_uvs",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).corner_uvs;
                               return view_or_none<std::vector<Vec2>>(s, list, list.empty(), &rows_of);
                             })
      .def_property_readonly("corner_normals",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).corner_normals;
                               return view_or_none<std::vector<Vec3>>(s, list, list.empty(), &rows_of);
                             })
      .def_property_readonly("vertex_colors",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).vertex_colors;
                               return view_or_none<std::vector<Vec4>>(s, list, list.empty(), &rows_of);
                             })
      .def_property_readonly("vertex_scalars",
                             [=](const py::object& s) {
                               py::dict scalars;
                               for (const VertexScalar& scalar : soup_of(s).vertex_scalars) {
                                 scalars[py::str(scalar.name)] = items_of(scalar.values, s);
                               }
                               return scalars;
                             })
      .def_property_readonly("face_materials",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).face_materials;
                               return view_or_none<std::vector<Index>>(s, list, list.empty(), &items_of);
                             })
      .def_property_readonly("materials", [](const Mesh& mesh) { return mesh.soup->materials; })
      .def_property_readonly("feature_edges", [](const Mesh& mesh) { return mesh.soup->feature_edges; })
      .def_property_readonly("diagonal",
                             [](const Mesh& mesh) {
                               const Box3 box = bounding_box(*mesh.soup);
                               return box.isEmpty() ? 0.0 : box.diagonal().norm();
                             })
      .def_property_readonly("repairs", [](const Mesh& mesh) { return mesh.repairs; })
      .def("__repr__", [](const Mesh& mesh) {
        return "<recede.Mesh of " + std::to_string(mesh.soup->n_faces()) + " faces over " +
               std::to_string(mesh.soup->positions.size()) + " vertices>";
      });
}

std::optional<fs::path> path_or_none(const fs::path& path) {
  return path.empty() ? std::nullopt : std::optional(path);
}

void bind_results(py::module_& m) {
  py::class_<Simplified>(m, "SimplifyResult")
      .def_readonly("mesh", &Simplified::mesh)
      .def_property_readonly("faces_before", [](const Simplified& s) { return s.report.faces_before; })
      .def_property_readonly("faces_after", [](const Simplified& s) { return s.report.faces_after; })
      .def_property_readonly("vertices_before", [](const Simplified& s) { return s.report.vertices_before; })
      .def_property_readonly("vertices_after", [](const Simplified& s) { return s.report.vertices_after; })
      .def_property_readonly("collapses", [](const Simplified& s) { return s.report.collapses; })
      .def_property_readonly("joined", [](const Simplified& s) { return s.report.joined; })
      .def_property_readonly("dropped_parts", [](const Simplified& s) { return s.report.dropped_parts; })
      .def_property_readonly("dropped_faces", [](const Simplified& s) { return s.report.dropped_faces; })
      .def_property_readonly("passes", [](const Simplified& s) { return s.report.passes; })
      .def_property_readonly("error_bound", [](const Simplified& s) { return s.report.error_bound; })
      .def_property_readonly("error_lower", [](const Simplified& s) { return s.report.error_lower; })
      .def_property_readonly("error_estimate", [](const Simplified& s) { return s.report.error_estimate; })
      .def_property_readonly("stop_reason",
                             [](const Simplified& s) { return std::string(to_string(s.report.stop_reason)); })
      .def_property_readonly("refused", [](const Simplified& s) { return refused_counts(s.report); })
      .def_property_readonly("seconds", [](const Simplified& s) { return s.report.seconds; })
      .def_property_readonly("proof_seconds", [](const Simplified& s) { return s.report.proof_seconds; });
  const auto place = [](const Vec3& p) { return py::make_tuple(p.x(), p.y(), p.z()); };
  py::class_<OneSidedDistance>(m, "OneSidedDistance")
      .def_readonly("max", &OneSidedDistance::max)
      .def_readonly("rms", &OneSidedDistance::rms)
      .def_readonly("mean", &OneSidedDistance::mean)
      .def_property_readonly("at", [place](const OneSidedDistance& d) { return place(d.at); });
  py::class_<MeshDistance>(m, "Distance")
      .def_readonly("forward", &MeshDistance::forward)
      .def_readonly("backward", &MeshDistance::backward)
      .def_readonly("max", &MeshDistance::max)
      .def_readonly("rms", &MeshDistance::rms)
      .def_readonly("max_bound", &MeshDistance::max_bound)
      .def_readonly("max_lower", &MeshDistance::max_lower)
      .def_readonly("diagonal", &MeshDistance::diagonal)
      .def_readonly("samples", &MeshDistance::samples);
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
                             [](const LodLevel& level) { return level.billboards.has_value(); });
  py::class_<MapFiles>(m, "MapFiles")
      .def_property_readonly("displacement", [](const MapFiles& f) { return path_or_none(f.displacement); })
      .def_property_readonly("normal", [](const MapFiles& f) { return path_or_none(f.normal); })
      .def_property_readonly("color", [](const MapFiles& f) { return path_or_none(f.color); })
      .def_property_readonly("displacement_exr",
                             [](const MapFiles& f) { return path_or_none(f.displacement_exr); })
      .def_property_readonly("normal_exr", [](const MapFiles& f) { return path_or_none(f.normal_exr); })
      .def_property_readonly("height", [](const MapFiles& f) { return path_or_none(f.height); });
  py::class_<Baked>(m, "BakeResult")
      .def_property_readonly(
          "levels",
          [](const py::object& self) { return levels_of(self.cast<const Baked&>().hierarchy, self); })
      .def_property_readonly("glb", [](const Baked& baked) { return baked.files.glb; })
      .def_property_readonly("level_glbs", [](const Baked& baked) { return baked.files.level_glbs; })
      .def_property_readonly("folder", [](const Baked& baked) { return baked.files.folder; })
      .def_readonly("far_levels", &Baked::far_levels)
      .def_readonly("cad_levels", &Baked::cad_levels)
      .def_readonly("cad_parts", &Baked::cad_parts)
      .def_property_readonly("source_faces",
                             [](const Baked& baked) {
                               const std::size_t faces = baked.hierarchy.source_faces;
                               return faces > 0 ? std::optional(faces) : std::nullopt;
                             })
      .def_readonly("left_out", &Baked::left_out)
      .def_property_readonly("map_files", [](const Baked& baked) { return baked.files.map_files; })
      .def_property_readonly("report", [](const Baked& baked) {
        return baked.report ? std::optional(baked.report->html) : std::nullopt;
      });
}

void bind_errors(py::module_& m) {
  // The one registered last is asked first: bases come first.
  const auto& error = py::register_exception<Error>(m, "Error", PyExc_RuntimeError);
  py::register_exception<InputError>(m, "InputError", error);
  py::register_exception<OptionError>(m, "OptionError", error);
  py::register_exception<Cancelled>(m, "Cancelled", error);
}

void set_threads(std::size_t count) {
  static std::unique_ptr<tbb::global_control> limit;
  limit.reset();
  if (count > 0) {
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, count);
  }
}

}  // namespace

PYBIND11_MODULE(_recede, m) {
  m.attr("__version__") = RECEDE_VERSION;
  bind_errors(m);
  bind_mesh(m);
  bind_results(m);
  m.def("read", &read_repaired);
  m.def("write", [](const fs::path& path, const Mesh& mesh) {
    const py::gil_scoped_release unlocked;
    return write_soup(path, *mesh.soup).written_without;
  });
  m.def("simplify", &simplify_mesh);
  m.def("compare", [](const Mesh& a, const Mesh& b, std::size_t samples, std::optional<double> tolerance,
                      py::object progress) {
    const DistanceOptions options{.samples = samples, .bound_tolerance = tolerance};
    return PythonProgress(std::move(progress)).run([&](Progress* p) {
      return measure_distance(*a.soup, *b.soup, options, p);
    });
  });
  m.def("bake", &bake);
  m.def("bake_file", &bake_file);
  m.def("bake_cad", &bake_cad);
  m.def("make_teapot", [](std::size_t quads_per_side, double relief) {
    return make_mesh(make_teapot(quads_per_side, relief));
  });
  m.def("make_displaced_sphere",
        [](std::size_t faces, bool triangles) { return make_mesh(make_displaced_sphere(faces, triangles)); });
  m.def("make_tree", [](std::size_t leaves, std::uint32_t seed) {
    return make_mesh(make_tree({.leaves = leaves, .seed = seed}));
  });
  bind_shells(m);
  bind_volumes(m);
  bind_subdivision(m);
  bind_billboards(m);
  bind_cad(m);
  bind_charts(m);
  bind_hierarchy(m);
  bind_progressive(m);
  bind_maps(m);
  bind_dicing(m);
  bind_appearance(m);
  bind_images(m);
  m.def("set_threads", &set_threads);
}

}  // namespace recede::python
