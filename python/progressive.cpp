// Progressive meshes for Python.
#include "calls.h"
#include "numpy_arrays.h"
#include <recede/lod/geomorph.h>
#include <recede/lod/pmesh.h>
#include <recede/lod/selective_mesh.h>

#include <pybind11/eigen.h>
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
    return make_progressive(build_progressive_mesh(with_features(*mesh.soup, feature_angle), options, p));
  });
}

struct LevelChoice {
  std::optional<std::size_t> faces;
  std::optional<double> error;
  std::optional<std::size_t> splits;
  std::size_t of(const ProgressiveMesh& mesh, std::size_t otherwise) const {
    if (faces.has_value() + error.has_value() + splits.has_value() > 1) {
      throw OptionError("a level is chosen by one of faces, error and splits");
    }
    if (splits) return *splits;
    if (faces) return mesh.level_for_faces(*faces);
    return error ? mesh.level_for_error(*error) : otherwise;
  }
};

Mesh level(const Progressive& progressive, const LevelChoice& choice) {
  const py::gil_scoped_release unlocked;
  const ProgressiveMesh& mesh = *progressive.mesh;
  ProgressiveCursor cursor(mesh);
  cursor.move_to(choice.of(mesh, mesh.n_splits()));
  return make_mesh(cursor.soup());
}

Geomorph geomorph(const Progressive& progressive, const LevelChoice& coarse, const LevelChoice& fine) {
  const py::gil_scoped_release unlocked;
  const ProgressiveMesh& mesh = *progressive.mesh;
  return make_geomorph(mesh, coarse.of(mesh, 0), fine.of(mesh, mesh.n_splits()));
}

/// Owns what it refers to.
struct Selective {
  std::shared_ptr<const ProgressiveMesh> mesh;
  std::unique_ptr<SelectiveMesh> selective;
};

Selective make_selective(const Progressive& progressive) {
  const py::gil_scoped_release unlocked;
  return {progressive.mesh, std::make_unique<SelectiveMesh>(*progressive.mesh)};
}

RefinementReport update(Selective& self, const RefinementView& view) {
  const py::gil_scoped_release unlocked;
  return self.selective->update(view);
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
      .def("geomorph", &geomorph)
      .def("selective", &make_selective)
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
  py::class_<LevelChoice>(m, "LevelChoice")
      .def(py::init([](std::optional<std::size_t> faces, std::optional<double> error,
                       std::optional<std::size_t> splits) {
        return LevelChoice{faces, error, splits};
      }));
  py::class_<Geomorph>(m, "Geomorph")
      .def("at",
           [](const Geomorph& morph, double share) {
             const py::gil_scoped_release unlocked;
             return make_mesh(morph.at(share));
           })
      .def("write",
           [](const Geomorph& morph, const fs::path& path) {
             const py::gil_scoped_release unlocked;
             return write_geomorph(path, morph).written_without;
           })
      .def_property_readonly(
          "parents",
          [](const py::object& self) { return items_of(self.cast<const Geomorph&>().parents, self); })
      .def_readonly("coarse_splits", &Geomorph::coarse_level)
      .def_readonly("fine_splits", &Geomorph::fine_level);
  py::class_<RefinementReport>(m, "RefinementReport")
      .def_readonly("faces", &RefinementReport::faces)
      .def_readonly("splits", &RefinementReport::splits)
      .def_readonly("forced", &RefinementReport::forced)
      .def_readonly("merges", &RefinementReport::merges)
      .def_readonly("pixel_error", &RefinementReport::pixel_error)
      .def_readonly("seconds", &RefinementReport::seconds);
  py::class_<RefinementView>(m, "RefinementView")
      .def(py::init<>())
      .def_readwrite("position", &RefinementView::position)
      .def_readwrite("target", &RefinementView::target)
      .def_readwrite("up", &RefinementView::up)
      .def_property(
          "image_height", [](const RefinementView& v) { return v.view.image_height; },
          [](RefinementView& v, double value) { v.view.image_height = value; })
      .def_property(
          "field_of_view", [](const RefinementView& v) { return v.view.field_of_view; },
          [](RefinementView& v, double value) { v.view.field_of_view = value; })
      .def_property(
          "pixel_error", [](const RefinementView& v) { return v.view.pixel_error; },
          [](RefinementView& v, double value) { v.view.pixel_error = value; })
      .def_readwrite("aspect_ratio", &RefinementView::aspect_ratio)
      .def_readwrite("cull", &RefinementView::cull)
      .def_readwrite("back_pixel_error", &RefinementView::back_pixel_error)
      .def_readwrite("silhouette_pixel_error", &RefinementView::silhouette_pixel_error)
      .def_readwrite("faces", &RefinementView::faces);
  py::class_<Selective>(m, "SelectiveMesh")
      .def("update", &update)
      .def("update_error",
           [](Selective& self, double error) {
             const py::gil_scoped_release unlocked;
             return self.selective->update(error);
           })
      .def("mesh",
           [](const Selective& self) {
             const py::gil_scoped_release unlocked;
             return make_mesh(self.selective->soup());
           })
      .def_property_readonly("n_faces", [](const Selective& self) { return self.selective->n_faces(); });
  m.def("build_progressive", &build);
  m.def("read_progressive", [](const fs::path& path) {
    const py::gil_scoped_release unlocked;
    return make_progressive(read_pmesh(path));
  });
}

}  // namespace recede::python
