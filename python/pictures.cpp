// Pictures for Python.
#include "calls.h"
#include <recede/render/renderer.h>

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cstring>
#include <optional>

namespace recede::python {
namespace {

py::array_t<float> array_of(const Image& image) {
  static_assert(sizeof(Rgb) == 3 * sizeof(float));
  py::array_t<float> array({image.height, image.width, 3});
  std::memcpy(array.mutable_data(), image.pixels.data(), image.pixels.size() * sizeof(Rgb));
  return array;
}

py::array_t<float> render_mesh(const Mesh& mesh, const std::optional<Vec3>& eye,
                               const std::optional<Vec3>& look_at, const Vec3& up, double field_of_view,
                               int width, int height, int samples, bool wireframe, bool flat,
                               py::object progress) {
  const Image image = PythonProgress(std::move(progress)).run([&](Progress* p) {
    Camera camera = camera_in_front(mesh.soup->positions, up, field_of_view, width, height);
    if (eye) {
      camera.position = *eye;
      camera.target = bounding_box(*mesh.soup).center();
    }
    if (look_at) camera.target = *look_at;
    SceneOptions shading;
    if (flat) shading.crease_angle = 0;
    RenderOptions options;
    options.samples_per_pixel = samples;
    if (wireframe) options.wireframe = Wireframe{};
    return render(Scene(*mesh.soup, shading), camera, options, p);
  });
  return array_of(image);
}

}  // namespace

void bind_pictures(py::module_& m) { m.def("render", &render_mesh); }

}  // namespace recede::python
