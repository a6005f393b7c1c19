// Simplification, and the distance between meshes, for Python.
#include "calls.h"
#include "options.h"
#include <recede/geometry/mesh_distance.h>

#include <pybind11/stl.h>

#include <optional>

namespace recede::python {
namespace {

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

PolygonSoup with_features(const PolygonSoup& soup, double feature_angle) {
  if (!(feature_angle > 0)) return soup;
  PolygonMesh mesh = repair_to_polygon_mesh(soup).mesh;
  mark_feature_edges(mesh, feature_angle);
  return to_soup(mesh);
}

namespace {

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

}  // namespace

void bind_simplification(py::module_& m) {
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
  m.def("simplify", &simplify_mesh);
  m.def("compare", [](const Mesh& a, const Mesh& b, std::size_t samples, std::optional<double> tolerance,
                      py::object progress) {
    const DistanceOptions options{.samples = samples, .bound_tolerance = tolerance};
    return PythonProgress(std::move(progress)).run([&](Progress* p) {
      return measure_distance(*a.soup, *b.soup, options, p);
    });
  });
}

}  // namespace recede::python
