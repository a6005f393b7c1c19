// Hierarchies of levels of detail, as they are read back.
#include "hierarchy.h"

#include <recede/lod/hierarchy_folder.h>
#include <recede/lod/lod_selection.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>
#include <numbers>
#include <optional>

namespace recede::python {
namespace {

namespace fs = std::filesystem;

constexpr double k_degree = std::numbers::pi / 180;

std::unique_ptr<LodHierarchy> read(const fs::path& path) {
  const py::gil_scoped_release unlocked;
  const fs::path folder = hierarchy_folder(path);
  if (folder.empty()) throw InputError::in_file(path.string(), "isn't a hierarchy's folder");
  return std::make_unique<LodHierarchy>(read_hierarchy(folder));
}

std::size_t level_for(const LodHierarchy& hierarchy, double distance, std::optional<double> image_height,
                      std::optional<double> field_of_view, std::optional<double> pixel_error) {
  ViewSettings view = hierarchy.view;
  if (image_height) view.image_height = *image_height;
  if (field_of_view) view.field_of_view = *field_of_view * k_degree;
  if (pixel_error) view.pixel_error = *pixel_error;
  return level_by_error(hierarchy, distance, {.view = view});
}

}  // namespace

py::list levels_of(const LodHierarchy& hierarchy, const py::object& owner) {
  py::list levels;
  for (const LodLevel& level : hierarchy.levels)
    levels.append(py::cast(&level, py::return_value_policy::reference_internal, owner));
  return levels;
}

void bind_hierarchy(py::module_& m) {
  py::class_<LodHierarchy>(m, "Hierarchy")
      .def_readonly("name", &LodHierarchy::name)
      .def_property_readonly(
          "levels", [](const py::object& self) { return levels_of(self.cast<const LodHierarchy&>(), self); })
      .def_property_readonly("n_levels", [](const LodHierarchy& h) { return h.levels.size(); })
      .def_property_readonly(
          "center",
          [](const LodHierarchy& h) { return py::make_tuple(h.center[0], h.center[1], h.center[2]); })
      .def_readonly("radius", &LodHierarchy::radius)
      .def_property_readonly("image_height", [](const LodHierarchy& h) { return h.view.image_height; })
      .def_property_readonly("field_of_view",
                             [](const LodHierarchy& h) { return h.view.field_of_view / k_degree; })
      .def_property_readonly("pixel_error", [](const LodHierarchy& h) { return h.view.pixel_error; })
      .def("level_for", &level_for, py::arg("distance"), py::kw_only(), py::arg("image_height") = py::none(),
           py::arg("field_of_view") = py::none(), py::arg("pixel_error") = py::none());
  m.def("read_hierarchy", &read);
}

}  // namespace recede::python
