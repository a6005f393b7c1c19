// Charts and texture atlases for Python.
#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include <recede/geometry/chart_atlas.h>

#include <pybind11/stl.h>

namespace recede::python {
namespace {

/// Shared, so that arrays may outlive the result.
struct Atlas {
  std::shared_ptr<const AtlasResult> result;
  Mesh mesh;
};

Atlas atlas_of(const Mesh& mesh, const py::dict& from, py::object progress) {
  AtlasOptions options;
  read(from, "charts", options.charts.charts);
  read(from, "bend_limit", options.charts.bend_limit);
  read(from, "compactness", options.charts.compactness);
  read(from, "straighten", options.charts.straighten);
  read(from, "keep_materials", options.charts.keep_materials);
  read(from, "keep_uv_seams", options.charts.keep_uv_seams);
  read(from, "stretch_limit", options.stretch_limit);
  read(from, "scale_by_stretch", options.scale_by_stretch);
  read(from, "map_size", options.packing.resolution);
  read(from, "gutter", options.packing.gutter);
  AtlasResult result = PythonProgress(std::move(progress)).run([&](Progress* p) {
    PolygonSoup soup = *mesh.soup;
    merge_identical_vertices(soup);
    return make_atlas(soup, options, p);
  });
  PolygonSoup soup = std::move(result.soup);
  return {std::make_shared<const AtlasResult>(std::move(result)), make_mesh(std::move(soup))};
}

}  // namespace

void bind_charts(py::module_& m) {
  py::class_<Atlas>(m, "Atlas")
      .def_readonly("mesh", &Atlas::mesh)
      .def_property_readonly("face_charts",
                             [](const py::object& self) {
                               return items_of(self.cast<const Atlas&>().result->face_charts, self);
                             })
      .def_property_readonly("n_charts", [](const Atlas& a) { return a.result->charts.size(); })
      .def_property_readonly("stretch_l2", [](const Atlas& a) { return a.result->stretch.l2; })
      .def_property_readonly("stretch_l_infinity",
                             [](const Atlas& a) { return a.result->stretch.l_infinity; })
      .def_property_readonly("flipped", [](const Atlas& a) { return a.result->flipped; })
      .def_property_readonly("cut_length", [](const Atlas& a) { return a.result->report.cut_length; })
      .def_property_readonly("map_size", [](const Atlas& a) { return a.result->resolution; })
      .def_property_readonly("occupancy", [](const Atlas& a) { return a.result->occupancy; });
  m.def("make_atlas", &atlas_of);
}

}  // namespace recede::python
