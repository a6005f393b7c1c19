// How displaced surfaces look from afar, for Python.
#include "appearance.h"

#include "baked_maps.h"
#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"

#include <pybind11/eigen.h>
#include <pybind11/stl/filesystem.h>

namespace recede::python {
namespace {

SharedAppearance make(const py::object& surface, const py::object& height, const py::dict& settings,
                      py::object progress) {
  AppearanceOptions options;
  read(settings, "bins", options.normals.bins);
  read(settings, "views", options.normals.views);
  read(settings, "azimuths", options.normals.azimuths);
  read(settings, "samples", options.normals.samples);
  bool periodic = false;
  read(settings, "periodic", periodic);
  if (height.is_none()) {
    const std::shared_ptr<const BakedMaps> maps = surface.cast<const SharedMaps&>().maps;
    return PythonProgress(std::move(progress)).run([&](Progress* p) {
      return SharedAppearance{make_appearance(*maps, options, p)};
    });
  }
  const std::shared_ptr<const PolygonSoup> soup = surface.cast<const Mesh&>().soup;
  const DisplacementMap map = read_heights(height, periodic ? MapBorder::periodic : MapBorder::clamped);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    return SharedAppearance{make_appearance(*soup, map, options, p)};
  });
}

}  // namespace

void bind_appearance(py::module_& m) {
  py::class_<SharedAppearance>(m, "Appearance")
      .def_property_readonly("sides", [](const SharedAppearance& a) { return a.appearance->stretch().sides; })
      .def_property_readonly("stretch_spread",
                             [](const SharedAppearance& a) { return a.appearance->stretch().spread; })
      .def_property_readonly("wavelength",
                             [](const SharedAppearance& a) { return a.appearance->wavelength(); })
      .def("brightness",
           [](const SharedAppearance& a, const Vec3& toward_viewer, const Vec3& toward_light) {
             return a.appearance->unshadowed(toward_viewer.stableNormalized(),
                                             toward_light.stableNormalized());
           })
      .def("write", [](const SharedAppearance& a, const std::filesystem::path& path) {
        const py::gil_scoped_release unlocked;
        write_appearance(path, *a.appearance);
      });
  m.def("make_appearance", &make);
  m.def("read_appearance", [](const std::filesystem::path& path) {
    const py::gil_scoped_release unlocked;
    return SharedAppearance{read_appearance(path)};
  });
}

}  // namespace recede::python
