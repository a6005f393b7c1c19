// Baked maps for Python.
#include "baked_maps.h"
#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include <recede/lod/displacement_bake.h>

#include <pybind11/stl.h>

namespace recede::python {
namespace {

/// Size x size, or size x size x channels; None when there is no such map.
template <typename Sample>
py::object picture(const BakedMaps& maps, const std::vector<Sample>& samples, py::ssize_t channels) {
  if (samples.empty()) return py::none();
  const auto size = static_cast<py::ssize_t>(maps.size);
  std::vector<py::ssize_t> shape{size, size};
  if (channels > 1) shape.push_back(channels);
  return py::array_t<Sample>(shape, samples.data());
}

py::object height(const SharedMaps& baked) {
  const BakedMaps& maps = *baked.maps;
  if (maps.displacement.samples.empty()) return py::none();
  if (!maps.float_displacement.samples.empty()) return picture(maps, maps.float_displacement.samples, 1);
  std::vector<float> heights;
  heights.reserve(maps.displacement.samples.size());
  for (const std::uint16_t sample : maps.displacement.samples)
    heights.push_back(static_cast<float>(maps.height_offset + maps.height_scale * sample / 65535));
  return picture(maps, heights, 1);
}

/// Unit vectors of tangent space.
py::object normal(const SharedMaps& baked) {
  const BakedMaps& maps = *baked.maps;
  const bool whole = maps.float_normal.samples.empty();
  const std::size_t n = whole ? maps.normal.samples.size() : maps.float_normal.samples.size();
  const float most = whole ? static_cast<float>((1 << maps.normal.bits) - 1) : 1;
  std::vector<float> normals;
  normals.reserve(n);
  for (std::size_t i = 0; i < n; i += 3) {
    Eigen::Vector3f coded;
    for (std::size_t k = 0; k < 3; ++k) {
      coded[static_cast<Eigen::Index>(k)] =
          whole ? static_cast<float>(maps.normal.samples[i + k]) : maps.float_normal.samples[i + k];
    }
    const Eigen::Vector3f unit = (2 * coded / most - Eigen::Vector3f::Ones()).normalized();
    normals.insert(normals.end(), unit.begin(), unit.end());
  }
  return picture(maps, normals, 3);
}

py::object color(const SharedMaps& baked) {
  const std::vector<std::uint16_t>& samples = baked.maps->color.samples;
  return picture(*baked.maps, std::vector<std::uint8_t>(samples.begin(), samples.end()), 3);
}

py::dict report(const SharedMaps& baked) {
  const MapReport& report = baked.maps->report;
  py::dict result;
  result["atlas_reason"] = report.atlas_reason;
  result["search_distance"] = report.search_distance;
  result["texels"] = report.texels;
  result["missed"] = report.missed;
  result["seam_edges"] = report.seam_edges;
  result["seam_difference_before"] = report.seam_difference_before;
  result["seam_difference"] = report.seam_difference;
  result["seconds"] = report.seconds;
  return result;
}

SharedMaps bake(const Mesh& fine, const Mesh& coarse, const py::dict& settings, py::object progress) {
  const MapOptions options = read_map_options(settings);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    return SharedMaps{std::make_shared<const BakedMaps>(bake_maps(*fine.soup, *coarse.soup, options, p))};
  });
}

py::dict measure(const SharedMaps& baked, const Mesh& fine, py::object progress) {
  const MapAccuracy accuracy = PythonProgress(std::move(progress)).run([&](Progress* p) {
    return measure_maps(*fine.soup, *baked.maps, p);
  });
  py::dict result;
  result["bare_max"] = accuracy.bare_max;
  result["bare_rms"] = accuracy.bare_rms;
  result["max"] = accuracy.max;
  result["rms"] = accuracy.rms;
  return result;
}

}  // namespace

MapOptions read_map_options(const py::dict& from) {
  MapOptions options;
  options.displacement = options.normal = options.color = false;
  for (const std::string& map : value_of<std::vector<std::string>>(from, "maps")) {
    const std::map<std::string, bool*> wanted{
        {"displacement", &options.displacement}, {"normal", &options.normal}, {"color", &options.color}};
    *choice("maps", map, wanted) = true;
  }
  read(from, "map_size", options.size);
  read(from, "map_normal_bits", options.normal_bits);
  read(from, "map_seam_weight", options.seam_weight);
  read(from, "search_distance", options.search_distance);
  read_choice<MapFormat>(from, "map_format", {{"png", MapFormat::png}, {"exr", MapFormat::exr}},
                         options.format);
  return options;
}

void bind_maps(py::module_& m) {
  const auto uvs = [](const SharedMaps& b) -> const std::vector<Vec2>& { return b.maps->surface.corner_uvs; };
  py::class_<SharedMaps>(m, "BakedMaps")
      .def_property_readonly("surface", [](const SharedMaps& b) { return make_mesh(b.maps->surface); })
      .def_property_readonly("size", [](const SharedMaps& b) { return b.maps->size; })
      .def_property_readonly("height", &height)
      .def_property_readonly("normal", &normal)
      .def_property_readonly("color", &color)
      .def_property_readonly(
          "uvs", [uvs](const py::object& s) { return rows_of(uvs(s.cast<const SharedMaps&>()), s); })
      .def_property_readonly("normals",
                             [](const py::object& s) {
                               return rows_of(s.cast<const SharedMaps&>().maps->surface.corner_normals, s);
                             })
      .def_property_readonly(
          "tangents",
          [](const py::object& s) { return rows_of(s.cast<const SharedMaps&>().maps->corner_tangents, s); })
      .def_property_readonly("report", &report)
      .def("measure", &measure, py::arg("fine"), py::kw_only(), py::arg("progress") = py::none());
  m.def("bake_maps", &bake);
}

}  // namespace recede::python
