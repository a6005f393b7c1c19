// Progressive meshes for Python.
#include "calls.h"
#include "numpy_arrays.h"
#include <recede/lod/pmesh.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace recede::python {
namespace {

namespace fs = std::filesystem;

/// Shared, so that a level may be made without the interpreter's lock.
struct Progressive {
  std::shared_ptr<const ProgressiveMesh> mesh;
};

Progressive make_progressive(ProgressiveMesh mesh) {
  return {std::make_shared<const ProgressiveMesh>(std::move(mesh))};
}

Progressive build(const Mesh& mesh, const py::dict& settings, double feature_angle, py::object progress) {
  const ProgressiveOptions options{read_options(settings)};
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    if (feature_angle == 0) return make_progressive(build_progressive_mesh(*mesh.soup, options, p));
    PolygonMesh marked = repair_to_polygon_mesh(*mesh.soup).mesh;
    mark_feature_edges(marked, feature_angle);
    return make_progressive(build_progressive_mesh(to_soup(marked), options, p));
  });
}

Mesh level(const Progressive& progressive, std::optional<std::size_t> faces, std::optional<double> error,
           std::optional<std::size_t> splits) {
  if (faces.has_value() + error.has_value() + splits.has_value() > 1) {
    throw OptionError("a level is chosen by one of faces, error and splits");
  }
  const py::gil_scoped_release unlocked;
  const ProgressiveMesh& mesh = *progressive.mesh;
  ProgressiveCursor cursor(mesh);
  cursor.move_to(splits  ? *splits
                 : faces ? mesh.level_for_faces(*faces)
                 : error ? mesh.level_for_error(*error)
                         : mesh.n_splits());
  return make_mesh(cursor.soup());
}

PmeshReport write(const Progressive& progressive, const fs::path& path, std::optional<int> bits,
                  std::optional<int> attribute_bits, bool keep_numbering, std::optional<bool> keep_order) {
  const py::gil_scoped_release unlocked;
  return write_pmesh(
      path, *progressive.mesh,
      {bits, attribute_bits, attribute_bits, attribute_bits, attribute_bits, keep_numbering, keep_order});
}

}  // namespace

void bind_progressive(py::module_& m) {
  py::class_<PmeshReport>(m, "FileReport")
      .def_readonly("bytes", &PmeshReport::bytes)
      .def_readonly("base_bytes", &PmeshReport::base_bytes)
      .def_readonly("connectivity_bytes", &PmeshReport::connectivity_bytes)
      .def_readonly("position_bytes", &PmeshReport::position_bytes)
      .def_readonly("attribute_bytes", &PmeshReport::attribute_bytes)
      .def_readonly("error_bytes", &PmeshReport::error_bytes)
      .def_readonly("numbering_bytes", &PmeshReport::numbering_bytes)
      .def_readonly("batches", &PmeshReport::batches)
      .def_readonly("positions", &PmeshReport::positions)
      .def_readonly("largest_move", &PmeshReport::largest_move);
  py::class_<Progressive>(m, "ProgressiveMesh")
      .def("level", &level)
      .def("write", &write)
      .def_property_readonly("n_splits", [](const Progressive& p) { return p.mesh->n_splits(); })
      .def_property_readonly("level_faces",
                             [](const py::object& self) {
                               return items_of(self.cast<const Progressive&>().mesh->level_faces, self);
                             })
      .def_property_readonly("level_errors",
                             [](const py::object& self) {
                               return items_of(self.cast<const Progressive&>().mesh->level_errors, self);
                             })
      .def_property_readonly("errors_are_proved",
                             [](const Progressive& p) { return p.mesh->errors_are_proved; })
      .def_property_readonly("seconds", [](const Progressive& p) { return p.mesh->report.seconds; })
      .def_property_readonly("proof_seconds",
                             [](const Progressive& p) { return p.mesh->report.proof_seconds; });
  m.def("build_progressive", &build);
  m.def("read_progressive", [](const fs::path& path) {
    const py::gil_scoped_release unlocked;
    return make_progressive(read_pmesh(path));
  });
}

}  // namespace recede::python
