// Diced views for Python.
#include "baked_maps.h"
#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include <recede/render/camera.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>

namespace recede::python {
namespace {

struct Diced {
  Mesh mesh;
  RemeshReport report;
};

Camera read_camera(const py::dict& from) {
  Camera camera;
  read(from, "up", camera.up);
  read(from, "field_of_view", camera.field_of_view);
  read(from, "image_width", camera.width);
  read(from, "image_height", camera.height);
  return camera;
}

Diced dice(const py::object& surface, const py::object& height, const std::optional<Vec3>& eye,
           const std::optional<Vec3>& look_at, const py::dict& settings, py::object progress) {
  RemeshOptions options;
  LevelOptions levels;
  bool periodic = false;
  read(settings, "triangle_pixels", options.triangle_pixels);
  read(settings, "cull", options.cull);
  read(settings, "normals", options.normals);
  read(settings, "periodic", periodic);
  read_choice<FootprintRule>(
      settings, "footprint",
      {{"by_side", FootprintRule::by_side}, {"mean", FootprintRule::mean}, {"none", FootprintRule::none}},
      options.footprint);
  read_choice<LevelRule>(settings, "map_levels",
                         {{"mean", LevelRule::mean}, {"least_volume", LevelRule::least_volume}}, levels.rule);
  std::shared_ptr<const BakedMaps> maps;
  std::shared_ptr<const PolygonSoup> soup;
  std::optional<DisplacementMap> map;
  if (height.is_none()) {
    maps = surface.cast<const SharedMaps&>().maps;
  } else {
    soup = surface.cast<const Mesh&>().soup;
    map = read_heights(height, periodic ? MapBorder::periodic : MapBorder::clamped);
  }
  const Camera camera = read_camera(settings);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    const DisplacedBase base =
        maps ? DisplacedBase(*maps, levels, p) : DisplacedBase(*soup, std::move(*map), levels, p);
    const std::vector<Vec3>& points = base.positions();
    const Camera in_front =
        camera_in_front(points, camera.up, camera.field_of_view, camera.width, camera.height);
    const Camera placed = place_camera(in_front, points, eye, look_at);
    RemeshResult result = remesh_for_view(base, remesh_view_of(placed), options, p);
    return Diced{make_mesh(std::move(result.soup)), result.report};
  });
}

py::dict report(const Diced& diced) {
  const RemeshReport& report = diced.report;
  py::dict result;
  result["base_triangles"] = report.base_triangles;
  result["patches"] = report.patches;
  result["culled"] = report.culled;
  result["flat"] = report.flat;
  result["corner_vertices"] = report.corner_vertices;
  result["edge_vertices"] = report.edge_vertices;
  result["inner_vertices"] = report.inner_vertices;
  result["largest_move"] = report.largest_move;
  result["seconds"] = report.seconds;
  return result;
}

}  // namespace

void bind_dicing(py::module_& m) {
  py::class_<Diced>(m, "DicedView")
      .def_property_readonly("mesh", [](const Diced& d) { return d.mesh; })
      .def_property_readonly("report", &report);
  m.def("dice", &dice);
}

}  // namespace recede::python
