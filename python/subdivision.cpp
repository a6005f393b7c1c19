// Subdivision surfaces for Python.
#include "calls.h"
#include "options.h"
#include <recede/geometry/subdivision_surface.h>

#include <pybind11/stl.h>

#include <tuple>

namespace recede::python {
namespace {

struct Subdivision {
  Mesh mesh;
  int level;
  double error_estimate;
  std::size_t crease_edges, triangulated;
};

SubdivisionOptions read_subdivision_options(const py::dict& from) {
  SubdivisionOptions options;
  read_choice<SubdivisionScheme>(
      from, "scheme",
      {{"catmull-clark", SubdivisionScheme::catmull_clark}, {"loop", SubdivisionScheme::loop}},
      options.scheme);
  read_choice<SubdivisionBoundary>(from, "border",
                                   {{"edge-only", SubdivisionBoundary::edge_only},
                                    {"edge-and-corner", SubdivisionBoundary::edge_and_corner}},
                                   options.boundary);
  read_choice<UvInterpolation>(from, "uv_interpolation",
                               {{"smooth", UvInterpolation::smooth},
                                {"corners-only", UvInterpolation::corners_only},
                                {"corners-plus-1", UvInterpolation::corners_plus_1},
                                {"corners-plus-2", UvInterpolation::corners_plus_2},
                                {"boundaries", UvInterpolation::boundaries},
                                {"linear", UvInterpolation::linear}},
                               options.uv_interpolation);
  read_choice<Creasing>(from, "creasing", {{"uniform", Creasing::uniform}, {"chaikin", Creasing::chaikin}},
                        options.creasing);
  read(from, "subdivision_level", options.level);
  read(from, "error", options.error);
  read(from, "crease_angle", options.crease_angle);
  read(from, "crease_sharpness", options.crease_sharpness);
  read(from, "feature_sharpness", options.feature_sharpness);
  std::vector<std::tuple<Index, Index, double>> creases;
  std::vector<std::pair<Index, double>> corners;
  read(from, "creases", creases);
  read(from, "corners", corners);
  for (const auto& [first, second, sharpness] : creases)
    options.creases.push_back({first, second, sharpness});
  for (const auto& [vertex, sharpness] : corners) options.corners.push_back({vertex, sharpness});
  return options;
}

Subdivision subdivide_mesh(const Mesh& mesh, const py::dict& from, py::object progress) {
  const SubdivisionOptions options = read_subdivision_options(from);
  SubdivisionResult result =
      PythonProgress(std::move(progress)).run([&](Progress* p) { return subdivide(*mesh.soup, options, p); });
  return {make_mesh(std::move(result.soup)), result.level, result.error_estimate, result.crease_edges,
          result.triangulated};
}

}  // namespace

void bind_subdivision(py::module_& m) {
  py::class_<Subdivision>(m, "Subdivision")
      .def_readonly("mesh", &Subdivision::mesh)
      .def_readonly("level", &Subdivision::level)
      .def_readonly("error_estimate", &Subdivision::error_estimate)
      .def_readonly("crease_edges", &Subdivision::crease_edges)
      .def_readonly("triangulated", &Subdivision::triangulated);
  m.def("subdivide", &subdivide_mesh);
}

}  // namespace recede::python
