// Billboard clouds for Python.
#include "billboards.h"

#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include <recede/lod/billboard_budget.h>
#include <recede/lod/billboard_level.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <numbers>
#include <type_traits>

namespace recede::python {

namespace fs = std::filesystem;

namespace {

BillboardOptions read_options_of_clouds(const py::dict& from) {
  BillboardOptions options;
  read_choice(from, "method",
              {{"clusters", BillboardMethod::face_clustering},
               {"planes", BillboardMethod::plane_cover},
               {"simplification", BillboardMethod::simplification}},
              options.method);
  double degrees = options.largest_deviation * 180 / std::numbers::pi;
  read(from, "normal_deviation", degrees);
  options.largest_deviation = degrees * std::numbers::pi / 180;
  read(from, "errors", options.errors);
  read(from, "waste", options.largest_waste);
  read(from, "two_sided", options.is_two_sided);
  read(from, "neighbours", options.n_neighbours);
  return options;
}

BillboardTextureOptions read_options_of_textures(const py::dict& from) {
  BillboardTextureOptions options;
  read(from, "texels_per_error", options.texels_per_error);
  read(from, "samples", options.samples);
  read(from, "overlap", options.overlap);
  read(from, "gutter", options.gutter);
  return options;
}

std::vector<Cloud> make_clouds(const Mesh& mesh, const py::dict& settings, bool with_textures,
                               py::object progress) {
  BillboardOptions options = read_options_of_clouds(settings);
  const BillboardTextureOptions textures = read_options_of_textures(settings);
  std::vector<double> relative_errors;
  read(settings, "relative_errors", relative_errors);
  std::optional<std::size_t> most_bytes;
  read(settings, "most_bytes", most_bytes);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    PolygonSoup model = *mesh.soup;
    merge_identical_vertices(model);
    for (const double share : relative_errors)
      options.errors.push_back(share * bounding_box(model).diagonal().norm());
    std::vector<Cloud> clouds;
    if (most_bytes) {
      clouds.push_back(
          cloud_of(billboards_within(model, *most_bytes, options, textures, p), options.is_two_sided));
      return clouds;
    }
    for (BillboardCloud& cloud : build_billboard_clouds(model, options, p)) {
      auto shared = std::make_shared<const BillboardCloud>(std::move(cloud));
      std::shared_ptr<const BillboardTextures> baked;
      if (with_textures)
        baked = std::make_shared<const BillboardTextures>(texture_billboards(model, *shared, textures, p));
      clouds.push_back({std::move(shared), std::move(baked)});
    }
    return clouds;
  });
}

fs::path write_clouds(const fs::path& folder, const Mesh& mesh, const std::vector<Cloud>& clouds,
                      const std::string& name, const py::dict& view, py::object progress) {
  ViewSettings settings;
  read(view, "image_height", settings.image_height);
  read(view, "field_of_view", settings.field_of_view);
  read(view, "pixel_error", settings.pixel_error);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    std::vector<BillboardTextures> textures;
    for (const Cloud& cloud : clouds) {
      if (!cloud.textures) throw OptionError("clouds without textures can't be written");
      textures.push_back(*cloud.textures);
    }
    return write_hierarchy(folder, billboard_hierarchy(*mesh.soup, name, std::move(textures), settings, p))
        .glb;
  });
}

SharedReflectance make_reflectance(const Mesh& mesh, const Cloud& cloud, const py::dict& settings,
                                   py::object progress) {
  if (!cloud.textures) throw OptionError("a cloud without textures has no texels to send light");
  BillboardReflectanceOptions options;
  read(settings, "view_side", options.view_side);
  read(settings, "light_side", options.light_side);
  read(settings, "samples", options.samples);
  read(settings, "shaded", options.shaded);
  read(settings, "bounces", options.bounces);
  read(settings, "largest_share", options.largest_share);
  read(settings, "memory", options.memory);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    PolygonSoup model = *mesh.soup;
    merge_identical_vertices(model);
    return SharedReflectance{std::make_shared<const BillboardReflectance>(
        make_billboard_reflectance(model, *cloud.cloud, *cloud.textures, options, p))};
  });
}

py::object picture(const Raster& raster) {
  std::vector<py::ssize_t> shape{raster.height, raster.width};
  if (raster.channels > 1) shape.push_back(raster.channels);
  const std::vector<std::uint8_t> bytes(raster.samples.begin(), raster.samples.end());
  return py::array_t<std::uint8_t>(shape, bytes.data());
}

/// A number, or some, of each billboard.
template <typename Value>
py::array of_each(const Cloud& cloud, const Value& value) {
  const std::vector<Billboard>& billboards = cloud.billboards();
  const auto columns = static_cast<py::ssize_t>(Vec3::Zero().size());
  py::array_t<double> rows({static_cast<py::ssize_t>(billboards.size()), columns});
  auto place = rows.mutable_unchecked<2>();
  for (std::size_t b = 0; b < billboards.size(); ++b) {
    const Vec3 numbers = value(billboards[b]);
    for (py::ssize_t k = 0; k < columns; ++k) place(static_cast<py::ssize_t>(b), k) = numbers[k];
  }
  return rows;
}

py::array numbers_of(const Cloud& cloud, double Billboard::*member, double scale = 1) {
  std::vector<double> numbers;
  for (const Billboard& billboard : cloud.billboards()) numbers.push_back(scale * billboard.*member);
  return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}

py::array half_sizes(const Cloud& cloud) {
  const std::vector<Billboard>& billboards = cloud.billboards();
  py::array_t<double> rows({static_cast<py::ssize_t>(billboards.size()), py::ssize_t{2}});
  auto place = rows.mutable_unchecked<2>();
  for (std::size_t b = 0; b < billboards.size(); ++b) {
    for (py::ssize_t k = 0; k < 2; ++k) place(static_cast<py::ssize_t>(b), k) = billboards[b].half_sizes[k];
  }
  return rows;
}

py::object places(const Cloud& cloud) {
  if (!cloud.textures) return py::none();
  py::array_t<int> rows({static_cast<py::ssize_t>(cloud.textures->places.size()), py::ssize_t{4}});
  auto place = rows.mutable_unchecked<2>();
  for (std::size_t b = 0; b < cloud.textures->places.size(); ++b) {
    const BillboardPlace& here = cloud.textures->places[b];
    const auto row = static_cast<py::ssize_t>(b);
    place(row, 0) = here.x;
    place(row, 1) = here.y;
    place(row, 2) = here.width;
    place(row, 3) = here.height;
  }
  return rows;
}

/// Something of the textures, or None.
template <typename Value>
auto if_textured(const Value& value) {
  return [value](const Cloud& cloud) -> py::object {
    if (!cloud.textures) return py::none();
    if constexpr (std::is_base_of_v<py::object, decltype(value(*cloud.textures))>)
      return value(*cloud.textures);
    else
      return py::cast(value(*cloud.textures));
  };
}

}  // namespace

Cloud cloud_of(BillboardTextures textures, bool is_two_sided) {
  auto shared = std::make_shared<const BillboardTextures>(std::move(textures));
  BillboardCloud cloud{shared->error, shared->billboards, shared->left_out, is_two_sided};
  return {std::make_shared<const BillboardCloud>(std::move(cloud)), std::move(shared)};
}

void bind_billboards(py::module_& m) {
  py::class_<Cloud>(m, "BillboardCloud")
      .def_property_readonly("error", [](const Cloud& cloud) { return cloud.cloud->error; })
      .def_property_readonly("left_out", [](const Cloud& cloud) { return cloud.cloud->left_out; })
      .def_property_readonly("n_billboards", [](const Cloud& cloud) { return cloud.billboards().size(); })
      .def_property_readonly(
          "centers", [](const Cloud& c) { return of_each(c, [](const Billboard& b) { return b.center; }); })
      .def_property_readonly(
          "axes_u", [](const Cloud& c) { return of_each(c, [](const Billboard& b) { return b.axis_u; }); })
      .def_property_readonly(
          "axes_v", [](const Cloud& c) { return of_each(c, [](const Billboard& b) { return b.axis_v; }); })
      .def_property_readonly("half_sizes", &half_sizes)
      .def_property_readonly("errors", [](const Cloud& c) { return numbers_of(c, &Billboard::error); })
      .def_property_readonly(
          "normal_deviations",
          [](const Cloud& c) { return numbers_of(c, &Billboard::normal_deviation, 180 / std::numbers::pi); })
      .def(
          "faces_of",
          [](const Cloud& cloud, std::size_t billboard) {
            if (billboard >= cloud.billboards().size())
              throw py::index_error("there are " + std::to_string(cloud.billboards().size()) + " billboards");
            return cloud.billboards()[billboard].faces;
          })
      .def_property_readonly("places", &places)
      .def_property_readonly("color",
                             if_textured([](const BillboardTextures& t) { return picture(t.color); }))
      .def_property_readonly("normal",
                             if_textured([](const BillboardTextures& t) { return picture(t.normal); }))
      .def_property_readonly("height",
                             if_textured([](const BillboardTextures& t) { return picture(t.height); }))
      .def_property_readonly("height_range",
                             if_textured([](const BillboardTextures& t) { return t.height_range; }))
      .def_property_readonly("texel", if_textured([](const BillboardTextures& t) { return t.texel; }))
      .def_property_readonly("n_texels", if_textured([](const BillboardTextures& t) { return t.n_texels(); }))
      .def_property_readonly("bytes", if_textured([](const BillboardTextures& t) { return t.bytes(); }))
      .def_property_readonly("covered", if_textured([](const BillboardTextures& t) { return t.covered; }))
      .def_property_readonly("quads",
                             if_textured([](const BillboardTextures& t) { return make_mesh(quads_of(t)); }));
  py::class_<SharedReflectance>(m, "BillboardReflectance")
      .def_property_readonly("bytes", [](const SharedReflectance& r) { return bytes(*r.reflectance); })
      .def_property_readonly("raw_bytes",
                             [](const SharedReflectance& r) { return raw_bytes(*r.reflectance); })
      .def_property_readonly("rms", [](const SharedReflectance& r) { return r.reflectance->error.rms; })
      .def_property_readonly("n_vectors",
                             [](const SharedReflectance& r) { return r.reflectance->vector_count(); })
      .def("write", [](const SharedReflectance& r, const fs::path& path) {
        const py::gil_scoped_release unlocked;
        write_billboard_reflectance(path, *r.reflectance);
      });
  m.def("make_billboard_reflectance", &make_reflectance);
  m.def("read_billboard_reflectance", [](const fs::path& path) {
    const py::gil_scoped_release unlocked;
    return SharedReflectance{std::make_shared<const BillboardReflectance>(read_billboard_reflectance(path))};
  });
  m.def("build_billboards", &make_clouds);
  m.def("write_billboards", &write_clouds);
}

}  // namespace recede::python
