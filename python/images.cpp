// Pictures of meshes, picture files, and differences of pictures for Python.
#include "appearance.h"
#include "baked_maps.h"
#include "billboards.h"
#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include "shells.h"
#include <recede/render/coverage.h>
#include <recede/render/image_difference.h>
#include <recede/render/image_io.h>
#include <recede/render/renderer.h>
#include <recede/render/volume_levels.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>

namespace recede::python {
namespace {

namespace fs = std::filesystem;

/// All measures of two pictures.
struct ImageMeasures {
  ImageDifference difference;
  ImageMeasure ssim, flip;
};

using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// Height x width x 3, or height x width for grey. Throws `InputError` that names `what`.
Image read_pixels(const py::handle& source, const std::string& what) {
  const py::array any = py::array::ensure(source);
  const bool shaped = any && (any.ndim() == 2 || (any.ndim() == 3 && any.shape(2) == 3)) && any.size() > 0;
  if (!any) PyErr_Clear();
  if (!shaped) throw InputError(what + " must be an array of height x width x 3 or height x width numbers");
  // Bytes would be taken for light far beyond white.
  if (any.dtype().kind() != 'f') throw InputError(what + " must hold floats of linear light, 1 is white");
  const FloatArray array = FloatArray::ensure(any);
  Image image(static_cast<int>(any.shape(1)), static_cast<int>(any.shape(0)));
  const bool grey = any.ndim() == 2;
  const float* sample = array.data();
  for (Rgb& pixel : image.pixels) {
    pixel = grey ? Rgb(Rgb::Constant(*sample)) : Rgb(sample[0], sample[1], sample[2]);
    if (!pixel.allFinite()) throw InputError(what + " holds a number that isn't finite");
    sample += grey ? 1 : 3;
  }
  return image;
}

Image read_unlocked(const fs::path& path) {
  const py::gil_scoped_release unlocked;
  return read_image(path);
}

bool is_path(const py::handle& source) {
  return py::isinstance<py::str>(source) || py::hasattr(source, "__fspath__");
}

Image image_of(const py::handle& source, const std::string& what) {
  return is_path(source) ? read_unlocked(source.cast<fs::path>()) : read_pixels(source, what);
}

/// None, a path, a picture, or height x width truths or numbers of which those above 0.5 count.
ImageMask read_mask(const py::handle& source) {
  if (source.is_none()) return {};
  if (is_path(source)) return mask_of(image_of(source, "mask"));
  const py::array any = py::array::ensure(source);
  if (!any) PyErr_Clear();
  if (any && any.ndim() == 3) return mask_of(read_pixels(source, "mask"));
  const FloatArray array = any ? FloatArray::ensure(any) : FloatArray();
  if (!array) PyErr_Clear();
  if (!array || array.ndim() != 2 || array.size() == 0)
    throw InputError("mask must be an array of height x width truths or numbers");
  ImageMask mask{static_cast<int>(array.shape(1)), static_cast<int>(array.shape(0)), {}};
  for (py::ssize_t i = 0; i < array.size(); ++i) mask.inside.push_back(array.data()[i] > 0.5f ? 1 : 0);
  return mask;
}

py::array to_array(const Image& image) {
  FloatArray array({image.height, image.width, 3});
  float* to = array.mutable_data();
  for (const Rgb& pixel : image.pixels) to = std::copy(pixel.begin(), pixel.end(), to);
  return array;
}

py::array to_array(const FloatRaster& map) { return FloatArray({map.height, map.width}, map.samples.data()); }

ImageMeasures diff(const py::handle& a, const py::handle& b, const py::handle& mask,
                   double pixels_per_degree) {
  const Image first = image_of(a, "the first picture"), second = image_of(b, "the second picture");
  const ImageMask inside = read_mask(mask);
  const py::gil_scoped_release unlocked;
  return {compare_images(first, second, inside), compute_ssim(first, second, inside),
          compute_flip(first, second, {.pixels_per_degree = pixels_per_degree}, inside)};
}

Rgb color_of(const py::handle& numbers) { return numbers.cast<Vec3>().cast<float>(); }

/// Tuples by kind of light, as `light_tuples` of the package makes them.
Lighting read_lights(const py::dict& from, const Vec3& up) {
  Lighting lighting;
  for (const py::handle item : from["point"]) {
    const auto light = item.cast<py::tuple>();
    lighting.points.push_back({.position = light[0].cast<Vec3>(), .intensity = color_of(light[1])});
  }
  for (const py::handle item : from["directional"]) {
    const auto light = item.cast<py::tuple>();
    lighting.directionals.push_back({.toward = light[0].cast<Vec3>(),
                                     .irradiance = color_of(light[1]),
                                     .angular_radius = light[2].cast<double>()});
  }
  for (const py::handle item : from["area"]) {
    const auto light = item.cast<py::tuple>();
    lighting.areas.push_back({.corner = light[0].cast<Vec3>(),
                              .first_edge = light[1].cast<Vec3>(),
                              .second_edge = light[2].cast<Vec3>(),
                              .radiance = color_of(light[3]),
                              .two_sided = light[4].cast<bool>()});
  }
  for (const py::handle item : from["environment"]) {
    const auto light = item.cast<py::tuple>();
    lighting.environment = EnvironmentLight{.radiance = image_of(light[0], "the environment"),
                                            .up = up,
                                            .rotation = light[1].cast<double>(),
                                            .scale = light[2].cast<double>(),
                                            .visible = light[3].cast<bool>()};
  }
  return lighting;
}

RenderOptions read_rendering(const py::dict& from, const Vec3& up) {
  RenderOptions options;
  read(from, "samples", options.samples_per_pixel);
  bool wireframe = false;
  read(from, "wireframe", wireframe);
  if (wireframe) options.wireframe = Wireframe{};
  read_choice<LightTransport>(from, "lighting",
                              {{"camera", LightTransport::camera},
                               {"direct", LightTransport::direct},
                               {"path", LightTransport::path}},
                              options.transport);
  read_choice<LightSampling>(
      from, "light_sampling",
      {{"both", LightSampling::both}, {"lights", LightSampling::lights}, {"surface", LightSampling::surface}},
      options.light_sampling);
  if (options.transport != LightTransport::camera) {
    options.lighting =
        from["lights"].is_none() ? daylight(up) : read_lights(from["lights"].cast<py::dict>(), up);
  }
  read(from, "ambient", options.lighting.ambient);
  read(from, "bounces", options.max_bounces);
  read(from, "noise", options.noise);
  read_choice<Representation>(from, "representation",
                              {{"auto", Representation::automatic},
                               {"brdf", Representation::brdf},
                               {"bump", Representation::bump},
                               {"displacement", Representation::displacement}},
                              options.representation);
  std::optional<double> distance;
  read(from, "transition_distance", distance);
  if (distance) options.transition = transition_around(*distance);
  read(from, "show_methods", options.show_methods);
  return options;
}

/// What is drawn, taken from Python while its lock is held.
struct Drawn {
  std::shared_ptr<const PolygonSoup> soup;
  std::shared_ptr<const BakedMaps> maps;
  std::optional<DisplacementMap> heights;  ///< over `soup`
  std::optional<PlacedBillboards> billboards;
  std::optional<PlacedVolume> volume;

  std::vector<Vec3> points() const {
    if (billboards) return quads_of(*billboards->textures).positions;
    if (volume) return volume->textured.shell->base.positions;
    return maps ? maps->surface.positions : soup->positions;
  }
  Scene scene_of_volume(const Camera& camera, const SceneOptions& shading) const {
    PlacedVolume placed = *volume;
    PolygonSoup solid = placed.textured.shell->base;
    if (placed.textured.side == ShellSide::interior) solid.positions = placed.textured.layer().tops;
    placed.view = volume_view(camera);
    placed.textured = with_levels_for(placed.textured, *placed.view);
    return Scene(std::span(&solid, 1), std::span<const PlacedVolume>(&placed, 1), shading);
  }
  Scene scene(const Camera& camera, const DisplacedMeshOptions& displacement,
              const SceneOptions& shading) const {
    if (volume) return scene_of_volume(camera, shading);
    if (billboards) return Scene(std::span<const PolygonSoup>{}, std::span(&*billboards, 1), shading);
    if (maps) return Scene(*maps, displacement, shading);
    return heights ? Scene(*soup, *heights, displacement, shading) : Scene(*soup, shading);
  }
};

Drawn read_drawn(const py::object& surface, const py::dict& from) {
  Drawn drawn;
  if (py::isinstance<SharedMaps>(surface)) {
    drawn.maps = surface.cast<const SharedMaps&>().maps;
    return drawn;
  }
  if (py::isinstance<FilledShell>(surface)) {
    drawn.volume.emplace(PlacedVolume{surface.cast<const FilledShell&>().textured});
    std::optional<Vec3> color;
    read(from, "matter_color", color);
    if (color) drawn.volume->color = color->cast<float>();
    return drawn;
  }
  if (py::isinstance<Cloud>(surface)) {
    drawn.billboards.emplace(PlacedBillboards{surface.cast<const Cloud&>().textures});
    if (!drawn.billboards->textures) throw OptionError("a cloud without textures can't be drawn");
    if (!from["reflectance"].is_none())
      drawn.billboards->reflectance = from["reflectance"].cast<const SharedReflectance&>().reflectance;
    return drawn;
  }
  drawn.soup = surface.cast<const Mesh&>().soup;
  bool periodic = false;
  read(from, "periodic", periodic);
  if (!from["height"].is_none())
    drawn.heights = read_heights(from["height"], periodic ? MapBorder::periodic : MapBorder::clamped);
  return drawn;
}

py::array render_surface(const py::object& surface, const std::optional<Vec3>& eye,
                         const std::optional<Vec3>& look_at, const Vec3& up, double field_of_view, int width,
                         int height, const py::dict& from, py::object progress) {
  const RenderOptions options = read_rendering(from, up);
  SceneOptions shading;
  bool flat = false, ground = false;
  read(from, "flat", flat);
  read(from, "ground", ground);
  if (flat) shading.crease_angle = 0;
  if (ground) shading.ground = Ground{.up = up};
  if (!from["appearance"].is_none())
    shading.appearance = from["appearance"].cast<const SharedAppearance&>().appearance;
  DisplacedMeshOptions displacement;
  read(from, "subdivision_level", displacement.level);
  const Drawn drawn = read_drawn(surface, from);
  bool coverage = false;
  read(from, "coverage", coverage);
  std::optional<FloatRaster> covered;
  const Image image = PythonProgress(std::move(progress)).run([&](Progress* p) {
    const std::vector<Vec3> points = drawn.points();
    const Camera in_front = camera_in_front(points, up, field_of_view, width, height);
    const Camera camera = place_camera(in_front, points, eye, look_at);
    const Scene scene = drawn.scene(camera, displacement, shading);
    if (!coverage) return render(scene, camera, options, p);
    covered = render_coverage(scene, camera, options, p);
    return Image{};
  });
  return covered ? to_array(*covered) : to_array(image);
}

}  // namespace

void bind_images(py::module_& m) {
  py::class_<ImageMeasures>(m, "ImageDifference")
      .def_property_readonly("rmse", [](const ImageMeasures& d) { return d.difference.rmse; })
      .def_property_readonly("psnr", [](const ImageMeasures& d) { return d.difference.psnr; })
      .def_property_readonly("max", [](const ImageMeasures& d) { return d.difference.max; })
      .def_property_readonly("changed_share",
                             [](const ImageMeasures& d) { return d.difference.changed_share; })
      .def_property_readonly("ssim", [](const ImageMeasures& d) { return d.ssim.mean; })
      .def_property_readonly("flip", [](const ImageMeasures& d) { return d.flip.mean; })
      .def_property_readonly("difference_map",
                             [](const ImageMeasures& d) { return to_array(d.difference.magnitudes); })
      .def_property_readonly("ssim_map", [](const ImageMeasures& d) { return to_array(d.ssim.map); })
      .def_property_readonly("flip_map", [](const ImageMeasures& d) { return to_array(d.flip.map); })
      .def("__repr__", [](const ImageMeasures& d) {
        return "<recede.ImageDifference of FLIP " + std::to_string(d.flip.mean) + ", SSIM " +
               std::to_string(d.ssim.mean) + ", PSNR " + std::to_string(d.difference.psnr) + " dB>";
      });
  m.def("diff", &diff);
  m.def("render", &render_surface);
  m.def("read_image", [](const fs::path& path) { return to_array(read_unlocked(path)); });
  m.def("write_image", [](const fs::path& path, const py::handle& pixels) {
    const Image image = read_pixels(pixels, "the picture");
    const py::gil_scoped_release unlocked;
    write_image(path, image);
  });
}

}  // namespace recede::python
