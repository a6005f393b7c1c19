// CAD models for Python.
#include "calls.h"
#include "numpy_arrays.h"
#include <recede/geometry/cad_import.h>
#include <recede/geometry/nurbs_closest_point.h>
#include <recede/lod/cad_hierarchy.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>
#include <optional>

namespace recede::python {
namespace {

/// Something inside of a model, which it keeps alive; arrays are views that keep this alive.
template <typename Item>
struct Within {
  std::shared_ptr<const CadModel> model;
  const Item* item;
  const Item& operator*() const { return *item; }
  const Item* operator->() const { return item; }
};

using Model = std::shared_ptr<const CadModel>;
using Part = Within<CadPart>;
using Patch = Within<TrimmedPatch>;
using Curve = Within<TrimmingCurve>;

template <typename Item>
std::vector<Within<Item>> all_within(const Model& model, const std::vector<Item>& list) {
  std::vector<Within<Item>> items;
  for (const Item& item : list) items.push_back({model, &item});
  return items;
}

std::optional<Index> index_or_none(Index index) {
  return index == k_no_index ? std::nullopt : std::optional(index);
}

py::object weights_or_none(const py::object& owner, const std::vector<double>& weights) {
  if (weights.empty()) return py::none();
  return items_of(weights, owner);
}

/// n_u x n_v x `columns` or, without columns, n_u x n_v.
py::object as_net(const py::object& rows, const NurbsSurface& surface) {
  if (rows.is_none()) return rows;
  py::list shape;
  shape.append(surface.n_points(0));
  shape.append(surface.n_points(1));
  if (rows.attr("ndim").cast<int>() == 2) shape.append(rows.attr("shape")[py::int_(1)]);
  return rows.attr("reshape")(shape);
}

void bind_curve(py::module_& m) {
  const auto curve_of = [](const py::object& self) -> const NurbsCurve2& {
    return self.cast<const Curve&>()->curve;
  };
  py::class_<Curve>(m, "TrimmingCurve")
      .def_property_readonly("degree", [](const Curve& curve) { return curve->curve.degree; })
      .def_property_readonly("knots", [=](const py::object& s) { return items_of(curve_of(s).knots, s); })
      .def_property_readonly("points", [=](const py::object& s) { return rows_of(curve_of(s).points, s); })
      .def_property_readonly("weights",
                             [=](const py::object& s) { return weights_or_none(s, curve_of(s).weights); })
      .def_property_readonly("edge", [](const Curve& curve) { return index_or_none(curve->edge); })
      .def_property_readonly("runs_against", [](const Curve& curve) { return curve->runs_against; })
      .def_property_readonly("corners", [](const Curve& curve) {
        return py::make_tuple(index_or_none(curve->corners[0]), index_or_none(curve->corners[1]));
      });
}

void bind_patch(py::module_& m) {
  const auto surface_of = [](const py::object& self) -> const NurbsSurface& {
    return self.cast<const Patch&>()->surface;
  };
  py::class_<Patch>(m, "TrimmedPatch")
      .def_property_readonly("name", [](const Patch& patch) { return patch->name; })
      .def_property_readonly("degrees",
                             [](const Patch& patch) {
                               return py::make_tuple(patch->surface.degrees[0], patch->surface.degrees[1]);
                             })
      .def_property_readonly("knots",
                             [=](const py::object& s) {
                               const NurbsSurface& surface = surface_of(s);
                               return py::make_tuple(items_of(surface.knots[0], s),
                                                     items_of(surface.knots[1], s));
                             })
      .def_property_readonly(
          "points",
          [=](const py::object& s) { return as_net(rows_of(surface_of(s).points, s), surface_of(s)); })
      .def_property_readonly("weights",
                             [=](const py::object& s) {
                               return as_net(weights_or_none(s, surface_of(s).weights), surface_of(s));
                             })
      .def_property_readonly("loops",
                             [](const Patch& patch) {
                               std::vector<std::vector<Curve>> loops;
                               for (const TrimmingLoop& loop : patch->loops) {
                                 loops.push_back(all_within(patch.model, loop.curves));
                               }
                               return loops;
                             })
      .def("closest_point",
           [](const Patch& patch, const Vec3& point) {
             const NearestOnSurface nearest = closest_point(patch->surface, point);
             return py::make_tuple(nearest.uv, nearest.point, nearest.distance);
           })
      .def_property_readonly("is_reversed", [](const Patch& patch) { return patch->is_reversed; })
      .def_property_readonly("material", [](const Patch& patch) { return index_or_none(patch->material); });
}

void bind_model(py::module_& m) {
  py::class_<Part>(m, "CadPart")
      .def_property_readonly("name", [](const Part& part) { return part->name; })
      .def_property_readonly("patches",
                             [](const Part& part) { return all_within(part.model, part->patches); })
      .def_property_readonly("n_edges", [](const Part& part) { return part->n_edges; })
      .def_property_readonly("n_corners", [](const Part& part) { return part->n_corners; })
      .def_property_readonly("is_closed", [](const Part& part) { return part->is_closed; });
  py::class_<CadInstance>(m, "CadInstance")
      .def_readonly("part", &CadInstance::part)
      .def_readonly("name", &CadInstance::name)
      .def_property_readonly(
          "placement",
          [](const CadInstance& instance) -> Eigen::Matrix4d { return instance.placement.matrix(); })
      .def_property_readonly("material",
                             [](const CadInstance& instance) { return index_or_none(instance.material); });
  py::class_<CadModel, std::shared_ptr<CadModel>>(m, "CadModel")
      .def_property_readonly(
          "parts",
          [](const std::shared_ptr<CadModel>& model) { return all_within<CadPart>(model, model->parts); })
      .def_readonly("instances", &CadModel::instances)
      .def_readonly("materials", &CadModel::materials)
      .def_readonly("metres_per_unit", &CadModel::metres_per_unit)
      .def_property_readonly("left_out",
                             [](const CadModel& model) {
                               std::vector<std::pair<std::string, std::string>> entries;
                               for (const CadLeftOut& entry : model.left_out) {
                                 entries.emplace_back(entry.entity, entry.reason);
                               }
                               return entries;
                             })
      .def_readonly("repairs", &CadModel::repairs);
}

void bind_levels(py::module_& m) {
  py::class_<CadLevelReport>(m, "CadLevel")
      .def_readonly("patches", &CadLevelReport::patches)
      .def_readonly("triangles", &CadLevelReport::triangles)
      .def_readonly("tightened", &CadLevelReport::tightened)
      .def_readonly("missed", &CadLevelReport::missed);
  py::class_<SeamGap>(m, "CadGap")
      .def_readonly("patch", &SeamGap::patch)
      .def_readonly("other", &SeamGap::other)
      .def_property_readonly(
          "point", [](const SeamGap& g) { return py::make_tuple(g.point.x(), g.point.y(), g.point.z()); })
      .def_readonly("distance", &SeamGap::distance);
  py::class_<CadSeamReport>(m, "CadSeams")
      .def_readonly("part", &CadSeamReport::part)
      .def_readonly("patches", &CadSeamReport::patches)
      .def_readonly("sewing_points", &CadSeamReport::sewing_points)
      .def_property_readonly("edges_of_file", [](const CadSeamReport& r) { return r.seams.edges_of_file; })
      .def_property_readonly("edges_by_position",
                             [](const CadSeamReport& r) { return r.seams.edges_by_position; })
      .def_property_readonly("free_edges", [](const CadSeamReport& r) { return r.seams.free_edges; })
      .def_property_readonly("crowded_edges", [](const CadSeamReport& r) { return r.seams.crowded_edges; })
      .def_readonly("turned", &CadSeamReport::turned)
      .def_property_readonly("largest_move", [](const CadSeamReport& r) { return r.seams.largest_move; })
      .def_property_readonly("gaps", [](const CadSeamReport& r) { return r.seams.gaps; });
}

}  // namespace

void bind_cad(py::module_& m) {
  bind_levels(m);
  bind_curve(m);
  bind_patch(m);
  bind_model(m);
  m.def("can_read_cad", &can_read_cad);
  m.def("read_cad", [](const std::filesystem::path& path, bool repair, py::object progress) {
    return PythonProgress(std::move(progress)).run([&](Progress* p) {
      return std::make_shared<CadModel>(read_cad(path, {.repair = repair}, p));
    });
  });
  m.def("tessellate_cad", [](const std::shared_ptr<CadModel>& model, const std::vector<double>& errors,
                             double gap, bool use_connectivity, py::object progress) {
    CadHierarchyOptions options;
    options.errors = errors;
    options.gap = gap;
    options.use_connectivity = use_connectivity;
    const CadHierarchy cad = PythonProgress(std::move(progress)).run([&](Progress* p) {
      return build_cad_hierarchy(*model, "model", options, p);
    });
    py::list levels;
    for (std::size_t i = 0; i < cad.levels.size(); ++i) {
      const LodLevel& level = cad.hierarchy.levels[i];
      py::dict entry;
      entry["mesh"] = make_mesh(to_soup(level.mesh));
      entry["error_bound"] = level.error.bound;
      entry["max"] = level.error.max;
      entry["rms"] = level.error.rms;
      entry["switch_distance"] = level.switch_distance;
      entry["patches"] = cad.levels[i].patches;
      entry["missed"] = cad.levels[i].missed;
      levels.append(std::move(entry));
    }
    return levels;
  });
}

}  // namespace recede::python
