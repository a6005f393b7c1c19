// Meshes and their materials for Python: made of arrays, read, written, and sampled.
#include "calls.h"
#include "numpy_arrays.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/raster.h>
#include <recede/geometry/sample_models.h>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>

namespace recede::python {
namespace {

namespace fs = std::filesystem;

Mesh read_repaired(const fs::path& path, bool repair, py::object progress) {
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    if (!repair) {
      ReadSoup unrepaired = read_soup_with_pictures(path, p);
      return make_mesh(std::move(unrepaired.soup), std::move(unrepaired.report.steps));
    }
    MeshFromSoup read = read_mesh(path, p);
    return make_mesh(to_soup(read.mesh), std::move(read.report.steps));
  });
}

Mesh mesh_from_arrays(const py::handle& positions, const py::handle& faces, const py::handle& corner_uvs,
                      const py::handle& corner_normals, const py::handle& vertex_colors,
                      const py::dict& vertex_scalars, const py::handle& face_materials,
                      std::vector<Material> materials, const py::handle& feature_edges) {
  PolygonSoup soup;
  soup.positions = read_rows_of_3(positions, "positions");
  read_faces(faces, soup);
  if (!corner_uvs.is_none()) soup.corner_uvs = read_rows_of_2(corner_uvs, "corner_uvs");
  if (!corner_normals.is_none()) soup.corner_normals = read_rows_of_3(corner_normals, "corner_normals");
  if (!vertex_colors.is_none()) soup.vertex_colors = read_rows_of_4(vertex_colors, "vertex_colors");
  for (const auto& [name, values] : vertex_scalars) {
    if (!py::isinstance<py::str>(name)) throw py::type_error("the names of vertex_scalars are texts");
    const auto text = name.cast<std::string>();
    soup.vertex_scalars.push_back({text, read_numbers(values, text)});
  }
  if (!face_materials.is_none()) soup.face_materials = read_indices(face_materials, "face_materials", true);
  soup.materials = std::move(materials);
  if (!feature_edges.is_none()) {
    const std::vector<Index> ends = read_indices(feature_edges, "feature_edges");
    if (ends.size() % 2 != 0) throw InputError("feature_edges must have two vertices in each row");
    for (std::size_t i = 0; i < ends.size(); i += 2) soup.feature_edges.emplace_back(ends[i], ends[i + 1]);
  }
  validate(soup, "Mesh");
  return make_mesh(std::move(soup));
}

/// The list as a view that keeps the mesh alive, or None when it is absent.
template <typename List>
py::object view_or_none(const py::object& self, const List& list, bool absent,
                        py::array (*view)(const List&, py::handle)) {
  if (absent) return py::none();
  return view(list, self);
}

py::object faces_of(const py::object& self) {
  const PolygonSoup& soup = *self.cast<const Mesh&>().soup;
  const std::size_t n = soup.n_faces(), size = n > 0 ? soup.face_size(0) : 3;
  for (std::size_t f = 0; f < n; ++f) {
    if (soup.face_size(f) == size) continue;
    py::list faces;
    for (std::size_t g = 0; g < n; ++g) {
      faces.append(py::cast(std::vector<Index>(soup.face(g).begin(), soup.face(g).end())));
    }
    return faces;
  }
  return items_of(soup.corner_vertices, self).attr("reshape")(n, size);
}

Material make_material(std::string name, const std::array<double, 4>& color, std::string texture,
                       const std::optional<py::bytes>& picture) {
  Material material{std::move(name), Vec4(color[0], color[1], color[2], color[3]), std::move(texture)};
  if (picture) {
    if (material.base_color_texture.empty())
      throw OptionError("base_color_picture needs a name, base_color_texture");
    std::string bytes = *picture;
    decode_picture(bytes, material.base_color_texture);
    material.base_color_picture = std::make_shared<const std::string>(std::move(bytes));
  }
  return material;
}

}  // namespace

void bind_mesh(py::module_& m) {
  py::class_<Material>(m, "Material")
      .def(py::init(&make_material), py::arg("name"),
           py::arg("base_color") = std::array<double, 4>{0.8, 0.8, 0.8, 1.0},
           py::arg("base_color_texture") = "", py::arg("base_color_picture") = py::none())
      .def_readonly("name", &Material::name)
      .def_property_readonly("base_color",
                             [](const Material& material) {
                               const Vec4& c = material.base_color;
                               return py::make_tuple(c[0], c[1], c[2], c[3]);
                             })
      .def_readonly("base_color_texture", &Material::base_color_texture)
      .def_property_readonly("base_color_picture", [](const Material& material) -> py::object {
        if (!material.base_color_picture) return py::none();
        return py::bytes(*material.base_color_picture);
      });
  py::class_<RepairStep>(m, "RepairStep")
      .def_readonly("name", &RepairStep::name)
      .def_readonly("changed", &RepairStep::changed)
      .def_readonly("detail", &RepairStep::detail);
  const auto soup_of = [](const py::object& self) -> const PolygonSoup& {
    return *self.cast<const Mesh&>().soup;
  };
  py::class_<Mesh>(m, "Mesh")
      .def(py::init(&mesh_from_arrays), py::arg("positions"), py::arg("faces"), py::kw_only(),
           py::arg("corner_uvs") = py::none(), py::arg("corner_normals") = py::none(),
           py::arg("vertex_colors") = py::none(), py::arg("vertex_scalars") = py::dict(),
           py::arg("face_materials") = py::none(), py::arg("materials") = std::vector<Material>{},
           py::arg("feature_edges") = py::none())
      .def_property_readonly("n_vertices", [](const Mesh& mesh) { return mesh.soup->positions.size(); })
      .def_property_readonly("n_faces", [](const Mesh& mesh) { return mesh.soup->n_faces(); })
      .def_property_readonly("positions",
                             [=](const py::object& s) { return rows_of(soup_of(s).positions, s); })
      .def_property_readonly("faces", &faces_of)
      .def_property_readonly("face_offsets",
                             [=](const py::object& s) { return items_of(soup_of(s).face_offsets, s); })
      .def_property_readonly("corner_vertices",
                             [=](const py::object& s) { return items_of(soup_of(s).corner_vertices, s); })
      .def_property_readonly("triangles",
                             [](const Mesh& mesh) {
                               auto list = std::make_unique<std::vector<Index>>(triangulate(*mesh.soup));
                               const auto n = static_cast<py::ssize_t>(list->size() / 3);
                               const Index* const data = list->data();
                               const py::capsule owner(list.release(), [](void* p) {
                                 delete static_cast<std::vector<Index>*>(p);
                               });
                               return py::array_t<Index>({n, py::ssize_t{3}}, data, owner);
                             })
      .def_property_readonly("corner_uvs",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).corner_uvs;
                               return view_or_none<std::vector<Vec2>>(s, list, list.empty(), &rows_of);
                             })
      .def_property_readonly("corner_normals",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).corner_normals;
                               return view_or_none<std::vector<Vec3>>(s, list, list.empty(), &rows_of);
                             })
      .def_property_readonly("vertex_colors",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).vertex_colors;
                               return view_or_none<std::vector<Vec4>>(s, list, list.empty(), &rows_of);
                             })
      .def_property_readonly("vertex_scalars",
                             [=](const py::object& s) {
                               py::dict scalars;
                               for (const VertexScalar& scalar : soup_of(s).vertex_scalars) {
                                 scalars[py::str(scalar.name)] = items_of(scalar.values, s);
                               }
                               return scalars;
                             })
      .def_property_readonly("face_materials",
                             [=](const py::object& s) {
                               const auto& list = soup_of(s).face_materials;
                               return view_or_none<std::vector<Index>>(s, list, list.empty(), &items_of);
                             })
      .def_property_readonly("materials", [](const Mesh& mesh) { return mesh.soup->materials; })
      .def_property_readonly("feature_edges", [](const Mesh& mesh) { return mesh.soup->feature_edges; })
      .def_property_readonly("diagonal",
                             [](const Mesh& mesh) {
                               const Box3 box = bounding_box(*mesh.soup);
                               return box.isEmpty() ? 0.0 : box.diagonal().norm();
                             })
      .def_property_readonly("repairs", [](const Mesh& mesh) { return mesh.repairs; })
      .def("__repr__", [](const Mesh& mesh) {
        return "<recede.Mesh of " + std::to_string(mesh.soup->n_faces()) + " faces over " +
               std::to_string(mesh.soup->positions.size()) + " vertices>";
      });
  m.def("read", &read_repaired);
  m.def("write", [](const fs::path& path, const Mesh& mesh) {
    const py::gil_scoped_release unlocked;
    return write_soup(path, *mesh.soup).written_without;
  });
  m.def("make_teapot", [](std::size_t quads_per_side, double relief) {
    return make_mesh(make_teapot(quads_per_side, relief));
  });
  m.def("make_displaced_sphere",
        [](std::size_t faces, bool triangles) { return make_mesh(make_displaced_sphere(faces, triangles)); });
  m.def("make_tree", [](std::size_t leaves, std::uint32_t seed) {
    return make_mesh(make_tree({.leaves = leaves, .seed = seed}));
  });
}

}  // namespace recede::python
