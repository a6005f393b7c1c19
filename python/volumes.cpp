// Volume textures and textured shells for Python.
#include "calls.h"
#include "numpy_arrays.h"
#include "options.h"
#include "shells.h"
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/shell_edit.h>
#include <recede/shells/texture_repeat.h>
#include <recede/shells/textured_shell_io.h>

#include <pybind11/eigen.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>

namespace recede::python {
namespace {

using ByteArray = py::array_t<std::uint8_t, py::array::c_style | py::array::forcecast>;
using Texture = std::shared_ptr<VolumeTexture>;  // Python can't change it

ProceduralVolume procedural(const std::string& name, const py::dict& from) {
  ChainMailOptions mail;
  read(from, "wire", mail.wire);
  WeaveOptions cloth;
  read(from, "thread", cloth.thread);
  BarkOptions plates;
  read(from, "seed", plates.seed);
  read(from, "cracks", plates.cracks);
  BubbleOptions liquid;
  read(from, "seed", liquid.seed);
  read(from, "bubbles", liquid.bubbles);
  read(from, "time", liquid.time);
  BushOptions plants;
  read(from, "seed", plants.seed);
  read(from, "bushes", plants.bushes);
  read(from, "growth", plants.growth);
  enum class Kind { chain_mail, weave, bark, bubbles, bushes };
  switch (choice<Kind>("name", name,
                       {{"chain-mail", Kind::chain_mail},
                        {"weave", Kind::weave},
                        {"bark", Kind::bark},
                        {"bubbles", Kind::bubbles},
                        {"bushes", Kind::bushes}})) {
    case Kind::chain_mail:
      return chain_mail(mail);
    case Kind::weave:
      return weave(cloth);
    case Kind::bark:
      return bark(plates);
    case Kind::bubbles:
      return bubbles(liquid);
    case Kind::bushes:
      break;
  }
  return bushes(plants);
}

Texture make_named(const std::string& name, int texels, const py::dict& from, py::object progress) {
  const ProceduralVolume volume = procedural(name, from);
  return PythonProgress(std::move(progress)).run([&](Progress* p) {
    return std::make_shared<VolumeTexture>(make_volume(volume, texels, p));
  });
}

// Arrays of r x t x s.
Texture from_arrays(const ByteArray& opacity, const std::optional<ByteArray>& colors, const Vec3& extent,
                    bool periodic, double ramp) {
  if (opacity.ndim() != 3) throw InputError("opacity must be an array of r x t x s bytes");
  auto texture = std::make_shared<VolumeTexture>();
  for (int axis = 0; axis < 3; ++axis)
    texture->size[static_cast<std::size_t>(2 - axis)] = static_cast<int>(opacity.shape(axis));
  if (colors) {
    const bool fits = colors->ndim() == 4 && colors->shape(3) == 3 && colors->shape(0) == opacity.shape(0) &&
                      colors->shape(1) == opacity.shape(1) && colors->shape(2) == opacity.shape(2);
    if (!fits) throw InputError("colors must be an array of r x t x s x 3 bytes, as large as opacity");
  }
  for (const int along : texture->size) {
    if (along < 1) throw InputError("opacity must have a texel and more along each axis");
  }
  const auto texels = static_cast<std::size_t>(opacity.size());
  texture->opacity = BrickGrid<std::uint8_t>::from_dense(texture->size, {opacity.data(), texels});
  if (colors) {
    using Color = std::array<std::uint8_t, 3>;
    texture->colors =
        BrickGrid<Color>::from_dense(texture->size, {reinterpret_cast<const Color*>(colors->data()), texels});
  }
  texture->extent = extent;
  texture->is_periodic = periodic;
  texture->ramp = ramp;
  validate(*texture, "the volume texture");
  return texture;
}

py::array opacity_of(const VolumeTexture& texture) {
  py::array_t<std::uint8_t> array({texture.size[2], texture.size[1], texture.size[0]});
  texture.opacity.copy_to({{0, 0, 0}, texture.size}, array.mutable_data());
  return array;
}

py::object colors_of(const VolumeTexture& texture) {
  if (texture.colors.empty()) return py::none();
  py::array_t<std::uint8_t> array({texture.size[2], texture.size[1], texture.size[0], 3});
  texture.colors.copy_to({{0, 0, 0}, texture.size},
                         reinterpret_cast<std::array<std::uint8_t, 3>*>(array.mutable_data()));
  return array;
}

ShellSide side_of(const std::string& name) {
  return choice<ShellSide>("side", name,
                           {{"exterior", ShellSide::exterior}, {"interior", ShellSide::interior}});
}

FilledShell with_volume(const BuiltShell& built, const Texture& texture, const std::string& side,
                        const std::optional<Vec2>& repeat, const Vec2& offset) {
  TexturedShell textured{.shell = built.shell, .side = side_of(side)};
  textured = with_texture(textured, *texture);
  textured.coordinates.offset = offset;
  textured.coordinates.repeat =
      repeat ? *repeat : proportionate_repeat(*built.shell, textured.side, texture->extent);
  textured.layer();
  return {textured};
}

FilledShell with_matter(const BuiltShell& built, double opacity, const std::string& side,
                        const std::array<int, 3>& size) {
  const TexturedShell textured{.shell = built.shell, .side = side_of(side)};
  const py::gil_scoped_release unlocked;
  return {with_texture(textured, make_uniform_volume(LayerGrid(built.shell, textured.side, size), opacity))};
}

py::dict report_of(const EditReport& report, const LayerGrid& grid) {
  py::dict result;
  result["changed"] = report.changed;
  result["volume"] = report.volume;
  result["missed_triangles"] = grid.missed();
  return result;
}

// A mesh, or a middle and a radius.
InsideDistance tool_of(const py::handle& tool) {
  if (py::isinstance<Mesh>(tool))
    return mesh_body(std::make_shared<const SignedDistance>(*tool.cast<const Mesh&>().soup, "the tool"));
  const auto [x, y, z, radius] = tool.cast<std::array<double, 4>>();
  return ball_body({x, y, z}, radius);
}

py::tuple carve(const FilledShell& filled, const py::handle& tool, const std::string& operation,
                const py::dict& from, py::object progress) {
  enum class Edit { carve, unite, intersect, cut };
  const Edit edit = choice<Edit>(
      "operation", operation,
      {{"carve", Edit::carve}, {"unite", Edit::unite}, {"intersect", Edit::intersect}, {"cut", Edit::cut}});
  CombineOptions options;
  options.operation = edit == Edit::unite       ? VolumeOperation::unite
                      : edit == Edit::intersect ? VolumeOperation::intersect
                                                : VolumeOperation::carve;
  read(from, "ramp", options.ramp_texels);
  read(from, "color", options.color);
  std::optional<std::array<int, 3>> size;
  read(from, "size", size);
  const InsideDistance inside = tool_of(tool);
  EditReport report;
  FilledLayer layer = PythonProgress(std::move(progress)).run([&](Progress* p) {
    FilledLayer edited = fill_once(filled.textured, size);
    report = edit == Edit::cut ? cut(edited.texture, edited.grid,
                                     [&](const Vec3&, const Vec3& at) { return inside(at) > 0; })
                               : combine(edited.texture, edited.grid, inside, options, p);
    return edited;
  });
  const py::dict figures = report_of(report, layer.grid);
  return py::make_tuple(FilledShell{with_texture(filled.textured, std::move(layer.texture))}, figures);
}

py::tuple move(const FilledShell& filled, const Vec3& from, const Vec3& to, const py::dict& settings) {
  MoveOptions options{.from = nearest_place(*filled.textured.shell, from),
                      .to = nearest_place(*filled.textured.shell, to)};
  read(settings, "radius", options.radius);
  read(settings, "turn", options.turn);
  read(settings, "copy", options.is_copy);
  std::optional<std::array<int, 3>> size;
  read(settings, "size", size);
  MoveReport report;
  const auto run = [&] {
    const py::gil_scoped_release unlocked;
    FilledLayer edited = fill_once(filled.textured, size);
    report = move_matter(edited.texture, edited.grid, options);
    return edited;
  };
  FilledLayer layer = run();
  py::dict figures = report_of(report.edit, layer.grid);
  figures["stretch"] = report.stretch;
  figures["without_source"] = report.without_source;
  return py::make_tuple(FilledShell{with_texture(filled.textured, std::move(layer.texture))}, figures);
}

}  // namespace

void bind_volumes(py::module_& m) {
  py::class_<VolumeTexture, Texture>(m, "VolumeTexture")
      .def_property_readonly("opacity", &opacity_of)
      .def_property_readonly("colors", &colors_of)
      .def_property_readonly("extent", [](const VolumeTexture& t) { return t.extent; })
      .def_property_readonly("is_periodic", [](const VolumeTexture& t) { return t.is_periodic; })
      .def_property_readonly("ramp", [](const VolumeTexture& t) { return t.ramp; });
  py::class_<FilledShell>(m, "TexturedShell")
      .def_property_readonly("shell",
                             [](const FilledShell& f) {
                               return BuiltShell{f.textured.shell, f.textured.shell->base.positions.size()};
                             })
      .def_property_readonly("side",
                             [](const FilledShell& f) {
                               return f.textured.side == ShellSide::interior ? "interior" : "exterior";
                             })
      .def_property_readonly("volume",
                             [](const FilledShell& f) {
                               return std::make_shared<VolumeTexture>(f.textured.texture->surfaces.front());
                             })
      .def_property_readonly("repeat", [](const FilledShell& f) { return f.textured.coordinates.repeat; })
      .def_property_readonly("offset", [](const FilledShell& f) { return f.textured.coordinates.offset; })
      .def("write", [](const FilledShell& f, const std::filesystem::path& path) {
        if (!is_textured_shell(path)) throw OptionError("a textured shell is written to a .shell file");
        const py::gil_scoped_release unlocked;
        write_textured_shell(path, f.textured);
      });
  m.def("named_volume", &make_named);
  m.def("volume_from_arrays", &from_arrays);
  m.def("fill_with_volume", &with_volume);
  m.def("fill_with_matter", &with_matter);
  m.def("carve", &carve);
  m.def("move_matter", &move);
  m.def("read_textured_shell", [](const std::filesystem::path& path) {
    const py::gil_scoped_release unlocked;
    return FilledShell{read_textured_shell(path, {.make_mipmap = false})};
  });
}

}  // namespace recede::python
