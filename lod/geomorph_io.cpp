#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/error.h>
#include <recede/geometry/gltf_writer.h>
#include <recede/lod/geomorph.h>

#include <limits>

namespace recede {
namespace {

/// From here on floats skip integers.
constexpr std::size_t k_largest_float_index = 1u << 24;

WriteResult write_gltf(const std::filesystem::path& path, const Geomorph& morph, bool is_binary) {
  WriteResult result{.written_without = detail::left_out_of_gltf(morph.fine)};
  GltfMeshExtras extras{.morph_target = &morph.coarse, .morph_name = "coarse"};
  if (morph.parents.size() <= k_largest_float_index)
    extras.parents = morph.parents;
  else
    result.written_without.emplace_back("parents (floats don't tell so many vertices apart)");
  GltfBuilder builder;
  const std::string name = path.stem().string();
  try {
    builder.add_to_scene(builder.add_node(builder.add_mesh(morph.fine, name, extras), name));
  } catch (const InputError& error) {
    throw InputError::in_file(path.string(), error.what());
  }
  const std::string content = is_binary ? builder.to_glb() : builder.to_gltf();
  result.bytes = content.size();
  write_file_atomically(path, content);
  return result;
}

WriteResult write_ply(const std::filesystem::path& path, const Geomorph& morph) {
  PolygonSoup soup = morph.fine;
  const auto add = [&](const char* name, auto&& value) {
    VertexScalar& scalar = soup.vertex_scalars.emplace_back();
    scalar.name = name;
    for (std::size_t v = 0; v < soup.positions.size(); ++v) scalar.values.push_back(value(v));
  };
  add("parent", [&](std::size_t v) {
    return morph.parents[v] == k_no_index ? std::numeric_limits<double>::quiet_NaN() : morph.parents[v];
  });
  add("coarse_x", [&](std::size_t v) { return morph.coarse.positions[v].x(); });
  add("coarse_y", [&](std::size_t v) { return morph.coarse.positions[v].y(); });
  add("coarse_z", [&](std::size_t v) { return morph.coarse.positions[v].z(); });
  WriteResult result = write_soup(path, soup);
  const auto leave_out = [&](const auto& fine, const auto& coarse, const char* what) {
    if (fine != coarse) result.written_without.push_back(std::string("the coarse level's ") + what);
  };
  leave_out(morph.fine.corner_uvs, morph.coarse.corner_uvs, "texture coordinates");
  leave_out(morph.fine.corner_normals, morph.coarse.corner_normals, "normals");
  leave_out(morph.fine.vertex_colors, morph.coarse.vertex_colors, "colours");
  leave_out(morph.fine.vertex_scalars, morph.coarse.vertex_scalars, "scalars");
  return result;
}

}  // namespace

WriteResult write_geomorph(const std::filesystem::path& path, const Geomorph& morph) {
  const std::string extension = detail::lower_case_extension(path);
  if (extension == ".glb" || extension == ".gltf") return write_gltf(path, morph, extension == ".glb");
  if (extension == ".ply") return write_ply(path, morph);
  throw InputError::in_file(path.string(), "a geomorph is written as .glb, .gltf or .ply");
}

}  // namespace recede
