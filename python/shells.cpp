// Shells for Python.
#include "shells.h"

#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include <recede/shells/subdivided_shell.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace recede::python {
namespace {

struct BuiltLayer {
  std::shared_ptr<const Shell> shell;
  const ShellLayer* layer;
};

void read_form(const py::dict& from, LpForm& form) {
  read_choice<LpForm>(from, "form", {{"calibrated", LpForm::calibrated}, {"averaged", LpForm::averaged}},
                      form);
}

LpDistanceOptions read_field(const py::dict& from) {
  LpDistanceOptions options;
  read(from, "p", options.p);
  read_form(from, options.form);
  read_choice<LpSource>(from, "source", {{"triangles", LpSource::triangles}, {"points", LpSource::points}},
                        options.source);
  read_choice<LpExpansion>(from, "expansion",
                           {{"monopole", LpExpansion::monopole}, {"quadrupole", LpExpansion::quadrupole}},
                           options.expansion);
  read(from, "opening", options.opening);
  read(from, "error", options.error);
  read(from, "support", options.support);
  return options;
}

ShellOptions read_shell(const py::dict& from) {
  ShellOptions options;
  read(from, "thickness", options.thickness);
  read(from, "thicknesses", options.thicknesses);
  read_choice<ShellSide>(from, "side",
                         {{"exterior", ShellSide::exterior},
                          {"interior", ShellSide::interior},
                          {"envelope", ShellSide::envelope}},
                         options.side);
  read_choice<DirectorMethod>(from, "directors",
                              {{"averaged", DirectorMethod::averaged_distance},
                               {"exact", DirectorMethod::exact_distance},
                               {"normals", DirectorMethod::normals}},
                              options.method);
  read(from, "power", options.field.p);
  read_form(from, options.field.form);
  read(from, "step", options.step);
  read(from, "border_extension", options.border_extension);
  read(from, "repair", options.repair);
  read(from, "at_least_normals", options.at_least_normals);
  return options;
}

BuiltShell make_shell(const Mesh& mesh, const py::dict& from, py::object progress) {
  const ShellOptions options = read_shell(from);
  const std::shared_ptr<const PolygonSoup> soup = mesh.soup;
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    auto shell = std::make_shared<const Shell>(build_shell(*soup, options, p));
    const std::size_t traced = shell->base.positions.size();
    return BuiltShell{std::move(shell), traced};
  });
}

BuiltShell make_subdivided_shell(const Mesh& control, const py::dict& from, py::object progress) {
  SubdividedShellOptions options;
  options.shell = read_shell(from);
  read(from, "level", options.subdivision.level);
  read_choice<SubdivisionScheme>(
      from, "scheme",
      {{"catmull-clark", SubdivisionScheme::catmull_clark}, {"loop", SubdivisionScheme::loop}},
      options.subdivision.scheme);
  read(from, "crease_angle", options.subdivision.crease_angle);
  read(from, "interpolated_levels", options.interpolated_levels);
  const std::shared_ptr<const PolygonSoup> soup = control.soup;
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    SubdividedShell built = build_subdivided_shell(*soup, options, p);
    return BuiltShell{std::make_shared<const Shell>(std::move(built.shell)), built.traced};
  });
}

py::object layer_of(const BuiltShell& built, const std::optional<ShellLayer>& layer) {
  return layer ? py::cast(BuiltLayer{built.shell, &*layer}) : py::object(py::none());
}

/// Of averaged distances at points.
struct Evaluated {
  std::vector<double> distances;
  std::vector<Vec3> gradients;
};

std::shared_ptr<Evaluated> evaluate(const Mesh& mesh, const py::handle& points, const py::dict& from,
                                    py::object progress) {
  const std::vector<Vec3> places = read_rows_of_3(points, "points");
  const LpDistanceOptions options = read_field(from);
  const std::shared_ptr<const PolygonSoup> soup = mesh.soup;
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    auto result = std::make_shared<Evaluated>();
    for (const LpValue& value : LpDistance(*soup, options).at(places, p)) {
      result->distances.push_back(value.distance);
      result->gradients.push_back(value.gradient);
    }
    return result;
  });
}

}  // namespace

void bind_shells(py::module_& m) {
  py::class_<Evaluated, std::shared_ptr<Evaluated>>(m, "AveragedDistance")
      .def_property_readonly(
          "distances",
          [](const py::object& self) { return items_of(self.cast<const Evaluated&>().distances, self); })
      .def_property_readonly("gradients", [](const py::object& self) {
        return rows_of(self.cast<const Evaluated&>().gradients, self);
      });
  py::class_<BuiltLayer>(m, "ShellLayer")
      .def_property_readonly(
          "tops",
          [](const py::object& self) { return rows_of(self.cast<const BuiltLayer&>().layer->tops, self); })
      .def_property_readonly("is_valid", [](const BuiltLayer& l) { return l.layer->validity.is_valid(); })
      .def_property_readonly("is_valid_elsewhere",
                             [](const BuiltLayer& l) { return l.layer->is_valid_elsewhere; })
      .def_property_readonly("excused", [](const BuiltLayer& l) { return l.layer->excused; })
      .def_property_readonly("given_up", [](const BuiltLayer& l) { return l.layer->given_up; })
      .def_property_readonly("inverted", [](const BuiltLayer& l) { return l.layer->validity.inverted; })
      .def_property_readonly("top_contacts",
                             [](const BuiltLayer& l) { return l.layer->validity.top_contacts; })
      .def_property_readonly("layer_contacts",
                             [](const BuiltLayer& l) { return l.layer->validity.layer_contacts; })
      .def_property_readonly("base_contacts",
                             [](const BuiltLayer& l) { return l.layer->validity.bottom_contacts; })
      .def_property_readonly("inverted_before", [](const BuiltLayer& l) { return l.layer->inverted_before; })
      .def_property_readonly("contacts_before", [](const BuiltLayer& l) { return l.layer->contacts_before; })
      .def_property_readonly("shortened", [](const BuiltLayer& l) { return l.layer->shortened; })
      .def_property_readonly("is_of_normals", [](const BuiltLayer& l) { return l.layer->is_of_normals; })
      .def_property_readonly("hexahedra", [](const BuiltLayer& l) { return l.layer->hexahedra.size(); })
      .def_property_readonly("thickness", [](const BuiltLayer& l) {
        const ShellThickness reached = reached_thickness(*l.shell, *l.layer);
        return py::make_tuple(reached.least, reached.mean, reached.most);
      });
  py::class_<BuiltShell>(m, "Shell")
      .def_property_readonly("is_valid", [](const BuiltShell& s) { return s.shell->is_valid(); })
      .def_property_readonly("base", [](const BuiltShell& s) { return make_mesh(s.shell->base); })
      .def_property_readonly("exterior", [](const BuiltShell& s) { return layer_of(s, s.shell->exterior); })
      .def_property_readonly("interior", [](const BuiltShell& s) { return layer_of(s, s.shell->interior); })
      .def_property_readonly("traced", [](const BuiltShell& s) { return s.traced; })
      .def_property_readonly("boundary",
                             [](const BuiltShell& s) { return make_mesh(shell_boundary(*s.shell)); });
  m.def("build_shell", &make_shell);
  m.def("build_subdivided_shell", &make_subdivided_shell);
  m.def("averaged_distance", &evaluate);
}

}  // namespace recede::python
