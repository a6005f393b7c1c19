#include "level_info.h"

#include "drawn_levels.h"
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/pmesh.h>
#include <recede/shells/textured_shell_io.h>

#include <fmt/format.h>

#include <numbers>

namespace recede::cli {
namespace {

namespace fs = std::filesystem;

void print_box(const Box3& box) {
  if (box.isEmpty()) return;
  const Vec3 low = box.min(), high = box.max();
  fmt::print("box          {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}\n", low.x(), low.y(), low.z(),
             high.x(), high.y(), high.z());
  fmt::print("diagonal     {:.6g}\n", box.diagonal().norm());
}

Json start_of(const std::string& input, const char* kind) {
  return {{"command", "info"}, {"input", input}, {"kind", kind}};
}

template <typename List>
Json names_of(const List& list) {
  Json names = Json::array();
  for (const auto& named : list) names.push_back(named.name);
  return names;
}

/// What there is for a level beside its mesh.
std::vector<std::string> extras_of(const LodLevel& level, const fs::path& folder, std::size_t number) {
  std::vector<std::string> extras;
  const auto add = [&](bool is_there, const char* name) {
    if (is_there) extras.emplace_back(name);
  };
  add(level.billboards.has_value(), "billboards");
  add(level.maps && !level.maps->displacement.samples.empty(), "displacement");
  add(level.maps && !level.maps->normal.samples.empty(), "normal");
  add(level.maps && !level.maps->color.samples.empty(), "color");
  add(fs::exists(appearance_file(folder, number)), "appearance");
  add(fs::exists(reflectance_file(folder, number)), "reflectance");
  add(fs::exists(shell_file(folder, number)), "shell");
  return extras;
}

void print_hierarchy_text(const LodHierarchy& hierarchy, const fs::path& folder, const Box3& box) {
  const ViewSettings& view = hierarchy.view;
  const double diagonal = box.diagonal().norm();
  fmt::print("hierarchy    {}, {} levels\n", hierarchy.name, hierarchy.levels.size());
  print_box(box);
  fmt::print("view         {:g} pixels high, {:.4g} degrees, pixel error {:g}\n", view.image_height,
             view.field_of_view * 180 / std::numbers::pi, view.pixel_error);
  fmt::print("level      faces   vertices                bound   from distance  also holds\n");
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const LodLevel& level = hierarchy.levels[i];
    fmt::print("{:5} {:10} {:10} {:>20} {:15.4g}  {}\n", i, level.mesh.n_faces(), level.mesh.n_vertices(),
               length_text(level.error.bound, diagonal), level.switch_distance,
               fmt::join(extras_of(level, folder, i), ", "));
  }
}

}  // namespace

void print_lengths(const ViewSettings& view, const char* unit) {
  fmt::print(
      "Errors and distances are {}; distances count from the bounding sphere, for pictures {:g} pixels high, "
      "{:.4g} degrees, pixel error {:g}.\n",
      unit, view.image_height, view.field_of_view * 180 / std::numbers::pi, view.pixel_error);
}

void print_hierarchy_info(const std::string& input, const fs::path& folder, const CommonOptions& common) {
  const LodHierarchy hierarchy = read_hierarchy(folder);
  Box3 box;
  if (!hierarchy.levels.empty()) box = bounding_box(to_soup(hierarchy.levels.front().mesh));
  if (!common.json) return print_hierarchy_text(hierarchy, folder, box);
  const double diagonal = box.isEmpty() ? 0 : box.diagonal().norm();
  Json levels = Json::array();
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const LodLevel& level = hierarchy.levels[i];
    levels.push_back({{"level", i},
                      {"faces", level.mesh.n_faces()},
                      {"vertices", level.mesh.n_vertices()},
                      {"error", error_to_json(level.error.max, level.error.rms, level.error.bound, diagonal)},
                      {"switch_distance", level.switch_distance},
                      {"screen_coverage", level.screen_coverage},
                      {"stop_reason", level.stop_reason},
                      {"also_holds", extras_of(level, folder, i)}});
  }
  Json document = start_of(input, "hierarchy");
  document["folder"] = folder.string();
  document["name"] = hierarchy.name;
  document["view"] = {{"image_height", hierarchy.view.image_height},
                      {"field_of_view", hierarchy.view.field_of_view * 180 / std::numbers::pi},
                      {"pixel_error", hierarchy.view.pixel_error}};
  document["box"] = box_to_json(box);
  document["diagonal"] = diagonal;
  document["levels"] = std::move(levels);
  print_json(document);
}

void print_progressive_info(const std::string& input, const CommonOptions& common) {
  const ProgressiveMesh mesh = read_pmesh(input);
  Box3 box;
  for (const Vec3& position : mesh.positions) box.extend(position);
  const double diagonal = box.isEmpty() ? 0 : box.diagonal().norm();
  if (!common.json) {
    fmt::print("progressive  {} faces in the base, {} in all\n", mesh.level_faces.front(),
               mesh.level_faces.back());
    fmt::print("splits       {}\n", mesh.n_splits());
    fmt::print("base error   {}, {}\n", length_text(mesh.level_errors.front(), diagonal),
               mesh.errors_are_proved ? "certified" : "estimated");
    print_box(box);
    const auto print_if = [](bool is_there, const char* name) {
      if (is_there) fmt::print("attribute    {}\n", name);
    };
    print_if(!mesh.wedge_uvs.empty(), "texture coordinates");
    print_if(!mesh.wedge_normals.empty(), "normals");
    print_if(!mesh.colors.empty(), "vertex colours");
    for (const VertexScalar& scalar : mesh.scalars) print_if(true, scalar.name.c_str());
    for (const Material& material : mesh.materials) fmt::print("material     {}\n", material.name);
    return;
  }
  Json document = start_of(input, "progressive");
  document["faces"] = mesh.level_faces.back();
  document["base_faces"] = mesh.level_faces.front();
  document["splits"] = mesh.n_splits();
  document["base_error"] = mesh.level_errors.front();
  document["errors_are_proved"] = mesh.errors_are_proved;
  document["box"] = box_to_json(box);
  document["diagonal"] = diagonal;
  document["corner_uvs"] = !mesh.wedge_uvs.empty();
  document["corner_normals"] = !mesh.wedge_normals.empty();
  document["vertex_colors"] = !mesh.colors.empty();
  document["vertex_scalars"] = names_of(mesh.scalars);
  document["materials"] = names_of(mesh.materials);
  print_json(document);
}

void print_shell_info(const std::string& input, const CommonOptions& common) {
  TerminalProgress progress(common.quiet);
  const TexturedShell textured = read_textured_shell(input, {.make_mipmap = false}, &progress);
  progress.clear();
  const Shell& shell = *textured.shell;
  const ShellLayer& layer = textured.layer();
  const VolumeTexture& texture = textured.texture->surfaces.front();
  const Box3 box = bounding_box(shell.base);
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (std::size_t v = 0; v < layer.tops.size(); ++v) {
    const double length = (layer.tops[v] - shell.base.positions[v]).norm();
    least = std::min(least, length);
    most = std::max(most, length);
  }
  const char* const side = textured.side == ShellSide::exterior ? "exterior" : "interior";
  const Vec2& repeat = textured.coordinates.repeat;
  if (!common.json) {
    fmt::print("shell        {} layer over {} triangles, {}\n", side, shell.base.n_faces(),
               layer.validity.is_valid() ? "valid" : "not valid");
    fmt::print("thickness    {:.4g} to {}\n", least, length_text(most, box.diagonal().norm()));
    print_box(box);
    fmt::print("texture      {} x {} x {} texels{}, {:.4g} x {:.4g} times\n", texture.size[0],
               texture.size[1], texture.size[2], texture.colors.empty() ? "" : " with colours", repeat.x(),
               repeat.y());
    return;
  }
  Json document = start_of(input, "shell");
  document["side"] = side;
  document["triangles"] = shell.base.n_faces();
  document["is_valid"] = layer.validity.is_valid();
  document["thickness"] = {{"min", least}, {"max", most}};
  document["box"] = box_to_json(box);
  document["diagonal"] = box.diagonal().norm();
  document["hexahedra"] = layer.hexahedra.size();
  document["size"] = texture.size;
  document["repeat"] = {repeat.x(), repeat.y()};
  document["has_colors"] = !texture.colors.empty();
  document["is_periodic"] = texture.is_periodic;
  print_json(document);
}

}  // namespace recede::cli
