#include "cad_info.h"
#include "common.h"
#include "level_info.h"
#include <recede/geometry/cad_import.h>
#include <recede/lod/hierarchy_folder.h>
#include <recede/shells/textured_shell_io.h>

#include <fmt/format.h>

namespace recede::cli {
namespace {

struct InfoOptions {
  CommonOptions common;
  std::string input;
};

Json to_json(const MeshSummary& summary, const PolygonMesh& mesh) {
  Json materials = Json::array();
  for (const Material& material : mesh.materials) materials.push_back(material.name);
  return {{"vertices", summary.vertices},
          {"edges", summary.edges},
          {"faces", summary.faces},
          {"triangles", summary.triangles},
          {"quads", summary.quads},
          {"larger_polygons", summary.larger_polygons},
          {"border_edges", summary.border_edges},
          {"border_loops", summary.border_loops},
          {"components", summary.components},
          {"split_vertices", summary.split_vertices},
          {"box", box_to_json(summary.box)},
          {"diagonal", summary.box.isEmpty() ? 0 : summary.box.diagonal().norm()},
          {"area", summary.area},
          {"corner_uvs", mesh.has_corner_uvs()},
          {"corner_normals", mesh.has_corner_normals()},
          {"vertex_colors", mesh.has_vertex_colors()},
          {"vertex_scalars", mesh.vertex_scalar_names()},
          {"materials", materials}};
}

std::string attribute_names(const PolygonMesh& mesh) {
  std::string names;
  const auto add = [&](bool present, const char* name) {
    if (present) names += (names.empty() ? "" : ", ") + std::string(name);
  };
  add(mesh.has_corner_uvs(), "texture coordinates");
  add(mesh.has_corner_normals(), "normals");
  add(mesh.has_vertex_colors(), "vertex colours");
  for (const std::string& name : mesh.vertex_scalar_names()) add(true, name.c_str());
  add(mesh.has_face_materials(), "materials");
  add(mesh.has_feature_edges(), "feature edges");
  return names.empty() ? "none" : names;
}

void print_text(const MeshSummary& s, const PolygonMesh& mesh) {
  const Vec3 low = s.box.min(), high = s.box.max();
  fmt::print("vertices     {}{}\n", s.vertices,
             s.split_vertices > 0
                 ? fmt::format(" ({} of them copies at non-manifold places)", s.split_vertices)
                 : "");
  fmt::print("faces        {} ({} triangles, {} quads, {} larger)\n", s.faces, s.triangles, s.quads,
             s.larger_polygons);
  fmt::print("edges        {} ({} on {} borders)\n", s.edges, s.border_edges, s.border_loops);
  fmt::print("components   {}\n", s.components);
  if (s.vertices > 0) {
    fmt::print("box          {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}\n", low.x(), low.y(), low.z(),
               high.x(), high.y(), high.z());
    fmt::print("diagonal     {:.6g}\n", s.box.diagonal().norm());
  }
  fmt::print("area         {:.6g}\n", s.area);
  fmt::print("attributes   {}\n", attribute_names(mesh));
  for (const Material& material : mesh.materials) fmt::print("material     {}\n", material.name);
}

void run(const InfoOptions& options) {
  if (is_cad_path(options.input)) return print_cad_info(options.input, options.common);
  if (const std::filesystem::path folder = hierarchy_folder(options.input); !folder.empty())
    return print_hierarchy_info(options.input, folder, options.common);
  if (std::filesystem::path(options.input).extension() == ".pmesh")
    return print_progressive_info(options.input, options.common);
  if (is_textured_shell(options.input)) return print_shell_info(options.input, options.common);
  TerminalProgress progress(options.common.quiet);
  const Model model = read_model(options.input, &progress);
  progress.clear();
  print_repairs(model.read.report, options.common);
  const MeshSummary summary = summarize(model.read.mesh);
  if (!options.common.json) return print_text(summary, model.read.mesh);
  Json document = {{"command", "info"}, {"input", options.input}, {"kind", "mesh"}};
  document.update(to_json(summary, model.read.mesh));
  document["repairs"] = repairs_to_json(model.read.report);
  print_json(document);
}

}  // namespace

void add_info_command(CLI::App& app) {
  const auto options = std::make_shared<InfoOptions>();
  CLI::App* command =
      app.add_subcommand("info", "Says what a file or hierarchy holds, and what reading it had to repair.");
  command->footer("Example:\n  recede info dragon.ply");
  command
      ->add_option(
          "input", options->input,
          std::string(k_input_help) +
              "; a CAD file (.step .stp .iges .igs .brep .brp); a progressive mesh (.pmesh); a textured "
              "shell (.shell); or a hierarchy (NAME.recede, or the folder that recede bake wrote)")
      ->required();
  add_common_options(*command, options->common);
  command->callback([options] { run(*options); });
}

}  // namespace recede::cli
