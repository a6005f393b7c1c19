#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/gltf_document.h>
#include <recede/geometry/error.h>
#include <recede/geometry/gltf_writer.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/shading_normals.h>
#include <recede/geometry/texture.h>
#include <recede/lod/detail/map_surface.h>
#include <recede/lod/lod_hierarchy.h>

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>

namespace recede {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int k_format_version = 1;

constexpr auto k_height_space = "object units along the interpolated normal";

std::string map_name(std::size_t level, const char* map, const char* extension = "png") {
  return fmt::format("level_{}_{}.{}", level, map, extension);
}

/// How heights follow from the samples of a displacement map.
Json displacement_to_json(const BakedMaps& maps) {
  return {{"scale", maps.height_scale}, {"offset", maps.height_offset}, {"space", k_height_space}};
}

/// Pictures of levels, which are in the folder already, go into the GLB from there.
class Pictures {
 public:
  Pictures(GltfBuilder& builder, std::string name, fs::path folder)
      : builder_(builder), name_(std::move(name)), folder_(std::move(folder)) {}

  /// The path that materials have for a picture.
  std::string path(std::size_t level, const char* map) const { return name_ + "/" + map_name(level, map); }
  /// Returns its position in `images`.
  int add(std::size_t level, const char* map) {
    return builder_.add_picture(path(level, map), read_whole_file(folder_ / map_name(level, map)));
  }

 private:
  GltfBuilder& builder_;
  std::string name_;
  fs::path folder_;
};

/// The level's surface with materials that name its maps. Where colours are baked, one material takes the
/// place of all.
PolygonSoup surface_with_maps(const BakedMaps& maps, std::size_t level, Pictures& pictures) {
  PolygonSoup soup = maps.surface;
  if (!maps.color.samples.empty()) {
    soup.vertex_colors.clear();
    pictures.add(level, "color");
    soup.materials = {{fmt::format("level {}", level), {1, 1, 1, 1}, pictures.path(level, "color")}};
    soup.face_materials.assign(soup.n_faces(), 0);
  }
  if (maps.normal.samples.empty()) return soup;
  if (soup.face_materials.empty()) soup.face_materials.assign(soup.n_faces(), k_no_index);
  for (Index& material : soup.face_materials)
    material = std::min(material, static_cast<Index>(soup.materials.size()));
  Material rest;  // of faces without one
  if (!soup.vertex_colors.empty()) rest.base_color.setOnes();
  soup.materials.push_back(rest);
  pictures.add(level, "normal");
  for (Material& material : soup.materials) {
    material.normal_texture = pictures.path(level, "normal");
    material.normal_picture = nullptr;
  }
  return soup;
}

/// A node whose children are the instances of parts of which something is left. A part is a mesh for each
/// material that instances give to it; these share its data.
int add_instances(GltfBuilder& builder, const LodHierarchy& hierarchy, const LodLevel& level,
                  const std::string& name, const std::string& suffix) {
  const int whole = builder.add_node(-1, name);
  std::map<Index, int> first_meshes;              // of parts
  std::map<std::pair<Index, Index>, int> meshes;  // of parts and materials
  for (const CadInstance& instance : hierarchy.instances) {
    const PolygonSoup& part = level.parts[instance.part];
    if (part.n_faces() == 0) continue;
    const std::vector<Index>& own = part.face_materials;
    const bool is_bare = own.empty() || std::find(own.begin(), own.end(), k_no_index) != own.end();
    const auto [mesh, is_new] = meshes.try_emplace({instance.part, is_bare ? instance.material : k_no_index});
    if (is_new) {
      const auto [first, is_first] = first_meshes.try_emplace(instance.part);
      if (is_first) first->second = builder.add_mesh(part, hierarchy.part_names[instance.part] + suffix);
      mesh->second = is_first ? first->second : builder.copy_mesh(first->second);
    }
    builder.add_child(whole, builder.add_node(mesh->second, instance.name, instance.placement));
  }
  // Not before: copies are made of what has no colour yet.
  for (const auto& [key, mesh] : meshes) {
    if (key.second != k_no_index) builder.paint_mesh(mesh, level.parts[key.first].materials[key.second]);
  }
  return whole;
}

Json billboards_to_json(const BillboardTextures& textures) {
  return {{"range", textures.height_range}, {"error", textures.error}, {"texel", textures.texel}};
}

int add_billboards(GltfBuilder& builder, const BillboardTextures& textures, std::size_t level,
                   Pictures& pictures, const std::string& name) {
  PolygonSoup quads = quads_of(textures);
  pictures.add(level, "color");
  pictures.add(level, "normal");
  quads.materials = {{.name = fmt::format("level {}", level),
                      .base_color = Vec4::Ones(),
                      .base_color_texture = pictures.path(level, "color"),
                      .normal_texture = pictures.path(level, "normal"),
                      .alpha_cutoff = 0.5}};
  quads.face_materials.assign(quads.n_faces(), 0);
  std::vector<Vec4> tangents;
  for (const Billboard& billboard : textures.billboards) {
    const Vec3& u = billboard.axis_u;
    tangents.insert(tangents.end(), 4, Vec4(u.x(), u.y(), u.z(), 1));
  }
  const int mesh = builder.add_mesh(quads, name, {.corner_tangents = tangents});
  Json extras = billboards_to_json(textures);
  extras["image"] = pictures.add(level, "height");
  builder.document()["meshes"][static_cast<std::size_t>(mesh)]["extras"]["recede_billboards"] = extras;
  return builder.add_node(mesh, name);
}

/// Where others have maps a level has normals too: viewers draw facets where there are none.
PolygonSoup surface_without_maps(const LodHierarchy& hierarchy, const LodLevel& level) {
  PolygonSoup soup = to_soup(level.mesh);
  const bool have_others = std::any_of(hierarchy.levels.begin(), hierarchy.levels.end(),
                                       [](const LodLevel& other) { return other.maps.has_value(); });
  if (!have_others || !soup.corner_normals.empty()) return soup;
  soup.corner_normals = shading_normals(soup, k_crease_angle);
  return soup;
}

int add_level(GltfBuilder& builder, Pictures& pictures, const LodHierarchy& hierarchy, std::size_t i) {
  const std::string suffix = fmt::format(" level {}", i), name = hierarchy.name + suffix;
  const LodLevel& level = hierarchy.levels[i];
  if (level.mesh.n_faces() > 0 && !level.parts.empty())
    return add_instances(builder, hierarchy, level, name, suffix);
  if (level.billboards) return add_billboards(builder, *level.billboards, i, pictures, name);
  if (!level.maps)
    return builder.add_node(builder.add_mesh(surface_without_maps(hierarchy, level), name), name);
  const int mesh = builder.add_mesh(surface_with_maps(*level.maps, i, pictures), name,
                                    {.corner_tangents = level.maps->corner_tangents});
  if (!level.maps->displacement.samples.empty()) {
    Json extras = displacement_to_json(*level.maps);
    extras["image"] = pictures.add(i, "displacement");
    builder.document()["meshes"][static_cast<std::size_t>(mesh)]["extras"]["recede_displacement"] = extras;
  }
  return builder.add_node(mesh, name);
}

/// MSFT_lod: the finest level's node names the others. MSFT_screencoverage: below entry i, level i + 1
/// serves; the last entry is the coverage below which nothing is drawn, which this hierarchy leaves at 0.
std::string to_glb(const LodHierarchy& hierarchy, const fs::path& folder) {
  GltfBuilder builder;
  Pictures pictures(builder, hierarchy.name + ".recede", folder);
  int first = 0;
  nlohmann::json ids = nlohmann::json::array(), coverage = nlohmann::json::array();
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const int node = add_level(builder, pictures, hierarchy, i);
    if (i == 0) {
      first = node;
      builder.add_to_scene(node);
    } else {
      ids.push_back(node);
      coverage.push_back(hierarchy.levels[i].screen_coverage);
    }
  }
  coverage.push_back(0.0);
  if (!ids.empty()) {
    auto& finest = builder.document()["nodes"][static_cast<std::size_t>(first)];
    finest["extensions"]["MSFT_lod"]["ids"] = std::move(ids);
    finest["extras"]["MSFT_screencoverage"] = std::move(coverage);
    builder.document()["extensionsUsed"].push_back("MSFT_lod");
  }
  return builder.to_glb();
}

/// One level alone.
std::string level_to_glb(const LodHierarchy& hierarchy, std::size_t level, const fs::path& folder) {
  GltfBuilder builder;
  Pictures pictures(builder, hierarchy.name + ".recede", folder);
  builder.add_to_scene(add_level(builder, pictures, hierarchy, level));
  return builder.to_glb();
}

Json to_json(const LodLevel& level, const std::string& file, const MapFiles& maps) {
  Json result{{"file", file},
              {"faces", level.mesh.n_faces()},
              {"vertices", level.mesh.n_vertices()},
              {"error", {{"max", level.error.max}, {"rms", level.error.rms}, {"bound", level.error.bound}}},
              {"switch_distance", level.switch_distance},
              {"screen_coverage", level.screen_coverage},
              {"stop_reason", level.stop_reason}};
  if (!maps.displacement.empty()) {
    Json displacement{{"uri", maps.displacement.filename().string()}};
    displacement.update(displacement_to_json(*level.maps));
    if (!maps.displacement_exr.empty()) displacement["exr"] = maps.displacement_exr.filename().string();
    result["displacement"] = std::move(displacement);
  }
  if (!maps.normal.empty()) result["normal"] = {{"uri", maps.normal.filename().string()}};
  if (!maps.normal_exr.empty()) result["normal"]["exr"] = maps.normal_exr.filename().string();
  if (!maps.color.empty()) result["color"] = {{"uri", maps.color.filename().string()}};
  if (!maps.height.empty()) {
    Json billboards{{"uri", maps.height.filename().string()}};
    billboards.update(billboards_to_json(*level.billboards));
    result["billboards"] = std::move(billboards);
  }
  if (level.maps) result["atlas_reason"] = level.maps->report.atlas_reason;
  return result;
}

/// Writes the maps of a level into `stage` and says where they will be in `folder`.
MapFiles write_maps(const LodLevel& level, std::size_t number, const fs::path& stage,
                    const fs::path& folder) {
  MapFiles files;
  const auto write = [&](const Raster& map, const char* kind, fs::path& file) {
    if (map.samples.empty()) return;
    write_file_atomically(stage / map_name(number, kind), encode_png(map));
    file = folder / map_name(number, kind);
  };
  if (level.billboards) {
    write(level.billboards->color, "color", files.color);
    write(level.billboards->normal, "normal", files.normal);
    write(level.billboards->height, "height", files.height);
  }
  if (!level.maps) return files;
  write(level.maps->displacement, "displacement", files.displacement);
  write(level.maps->normal, "normal", files.normal);
  write(level.maps->color, "color", files.color);
  const auto write_floats = [&](const FloatRaster& map, const char* kind, const ExrOptions& options,
                                fs::path& file) {
    if (map.samples.empty()) return;
    write_file_atomically(stage / map_name(number, kind, "exr"), encode_exr(map, options));
    file = folder / map_name(number, kind, "exr");
  };
  write_floats(level.maps->float_displacement, "displacement", {.half = false, .comments = k_height_space},
               files.displacement_exr);
  write_floats(level.maps->float_normal, "normal",
               {.half = true, .comments = "tangent space, x = 2 R - 1, y up as in OpenGL"}, files.normal_exr);
  return files;
}

/// A map of `channels` and, unless 0, of `size`.
Raster read_map(const fs::path& path, int channels, int size) {
  Raster map = read_png(path);
  if (map.channels != channels || map.width != map.height || (size > 0 && map.width != size)) {
    throw InputError::in_file(
        path.string(), fmt::format("isn't a square map of {} channels and the size of the others", channels));
  }
  return map;
}

/// The maps that `to_json` named, and the surface that the level's file holds. What baking met isn't in the
/// files.
std::optional<BakedMaps> read_maps(const Json& entry, const fs::path& folder, PolygonSoup surface) {
  BakedMaps maps;
  const auto read = [&](const char* kind, int channels, Raster& map) {
    if (!entry.contains(kind)) return false;
    map = read_map(folder / entry.at(kind).at("uri").get<std::string>(), channels, maps.size);
    maps.size = map.width;
    return true;
  };
  const auto read_floats = [&](const char* kind, std::size_t channels, FloatRaster& map) {
    if (!entry.contains(kind) || !entry.at(kind).contains("exr")) return;
    const fs::path path = folder / entry.at(kind).at("exr").get<std::string>();
    map = read_exr(path);
    if (map.channels.size() != channels || map.width != maps.size || map.height != maps.size) {
      throw InputError::in_file(path.string(), "isn't the map that its PNG file holds");
    }
  };
  if (read("displacement", 1, maps.displacement)) {
    if (maps.displacement.bits != 16) {
      const std::string file = entry.at("displacement").at("uri");
      throw InputError::in_file((folder / file).string(), "isn't a map of heights, which has 16 bits");
    }
    maps.height_scale = entry.at("displacement").at("scale");
    maps.height_offset = entry.at("displacement").at("offset");
  }
  read("normal", 3, maps.normal);
  read("color", 3, maps.color);
  read_floats("displacement", 1, maps.float_displacement);
  read_floats("normal", 3, maps.float_normal);
  if (maps.size == 0) return std::nullopt;
  maps.report.atlas_reason = entry.value("atlas_reason", "");
  if (surface.corner_uvs.empty() || surface.corner_normals.empty()) {
    throw InputError::in_file((folder / entry.at("file").get<std::string>()).string(),
                              "has maps but no texture coordinates or no normals");
  }
  maps.surface = std::move(surface);
  maps.corner_tangents = detail::tangents_of(maps.surface);
  return maps;
}

/// From the rectangles in a level's file: their corners and texture coordinates say where billboards are.
BillboardTextures read_billboards(const Json& entry, const fs::path& folder, const PolygonSoup& quads) {
  const auto read = [&](const std::string& file, int channels) {
    Raster map = read_png(folder / file);
    if (map.channels != channels || map.bits != 8)
      throw InputError::in_file((folder / file).string(),
                                fmt::format("isn't a picture of {} channels of 8 bits", channels));
    return map;
  };
  const std::string file = (folder / entry.at("file").get<std::string>()).string();
  BillboardTextures textures;
  const Json& billboards = entry.at("billboards");
  textures.error = billboards.at("error");
  textures.texel = billboards.at("texel");
  textures.height_range = billboards.at("range");
  textures.color = read(entry.at("color").at("uri"), 4);
  textures.normal = read(entry.at("normal").at("uri"), 3);
  textures.height = read(billboards.at("uri"), 1);
  const auto same_size = [&](const Raster& map) {
    return map.width == textures.color.width && map.height == textures.color.height;
  };
  if (!same_size(textures.normal) || !same_size(textures.height))
    throw InputError::in_file(file, "has textures of different sizes");
  if (!place_billboards(quads, textures))
    throw InputError::in_file(file, "holds other faces than rectangles with places in their textures");
  return textures;
}

/// A folder that takes its final name only when everything in it was written.
class StagedFolder {
 public:
  explicit StagedFolder(fs::path target)
      : target_(std::move(target)), stage_(target_.string() + suffix(".part")) {
    std::error_code failed;
    fs::create_directories(stage_, failed);
    if (failed) throw InputError::in_file(stage_.string(), failed.message());
  }
  ~StagedFolder() {
    std::error_code ignored;
    fs::remove_all(stage_, ignored);
  }
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  const fs::path& path() const { return stage_; }

  /// Replaces an earlier folder of the same name; when that fails, the earlier one stays.
  void commit() {
#ifdef RENAME_EXCHANGE  // Linux
    // At no moment without a folder; what was there goes with the stage.
    if (::renameat2(AT_FDCWD, stage_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) return;
#endif
    // There was none, or folders can't be exchanged here.
    std::error_code failed;
    const fs::path old = target_.string() + suffix(".old");
    const bool replaces = fs::exists(target_);
    if (replaces) fs::rename(target_, old, failed);
    if (!failed) {
      fs::rename(stage_, target_, failed);
      std::error_code ignored;
      if (failed && replaces) fs::rename(old, target_, ignored);
    }
    if (failed) throw InputError::in_file(target_.string(), failed.message());
    if (replaces) fs::remove_all(old, failed);
  }

 private:
  static std::string suffix(const char* what) { return what + std::to_string(::getpid()); }
  fs::path target_, stage_;
};

}  // namespace

HierarchyFiles write_hierarchy(const fs::path& folder, const LodHierarchy& hierarchy,
                               const HierarchyWriteOptions& options) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) throw InputError::in_file(folder.string(), failed.message());
  HierarchyFiles files;
  files.glb = folder / (hierarchy.name + ".glb");
  files.folder = folder / (hierarchy.name + ".recede");
  if (fs::is_directory(files.glb)) throw InputError::in_file(files.glb.string(), "is a folder");
  StagedFolder staged(files.folder);
  Json levels = Json::array();
  for (std::size_t i = 0; i < hierarchy.levels.size(); ++i) {
    const std::string file = fmt::format("level_{}.ply", i);
    const LodLevel& level = hierarchy.levels[i];
    const fs::path target = staged.path() / file;
    const WriteResult written = level.maps         ? write_soup(target, level.maps->surface)
                                : level.billboards ? write_soup(target, quads_of(*level.billboards))
                                                   : write_mesh(target, level.mesh);
    files.level_bytes.push_back(written.bytes);
    files.level_files.push_back(files.folder / file);
    files.map_files.push_back(write_maps(level, i, staged.path(), files.folder));
    levels.push_back(to_json(level, file, files.map_files.back()));
  }
  Json document = {{"format", "recede hierarchy"},
                   {"version", k_format_version},
                   {"name", hierarchy.name},
                   {"view",
                    {{"image_height", hierarchy.view.image_height},
                     {"field_of_view", hierarchy.view.field_of_view},
                     {"pixel_error", hierarchy.view.pixel_error}}},
                   {"center", {hierarchy.center.x(), hierarchy.center.y(), hierarchy.center.z()}},
                   {"radius", hierarchy.radius},
                   {"levels", levels}};
  if (hierarchy.source_faces > 0) document["source_faces"] = hierarchy.source_faces;
  // Names may hold bytes that aren't UTF-8.
  const std::string list = document.dump(2, ' ', false, Json::error_handler_t::replace);
  write_file_atomically(staged.path() / "hierarchy.json", list + "\n");
  write_file_atomically(files.glb, to_glb(hierarchy, staged.path()));
  for (std::size_t i = 0; i < hierarchy.levels.size() && options.glb_per_level; ++i) {
    files.level_glbs.push_back(folder / fmt::format("{}_level_{}.glb", hierarchy.name, i));
    write_file_atomically(files.level_glbs.back(), level_to_glb(hierarchy, i, staged.path()));
  }
  staged.commit();
  return files;
}

LodHierarchy read_hierarchy(const fs::path& folder) {
  const fs::path file = folder / "hierarchy.json";
  const std::string text = read_whole_file(file);
  LodHierarchy hierarchy;
  try {
    const Json document = Json::parse(text);
    if (document.at("format") != "recede hierarchy" || document.at("version") != k_format_version) {
      throw InputError::in_file(file.string(), "isn't a hierarchy of format version 1");
    }
    hierarchy.name = document.at("name");
    const Json& view = document.at("view");
    hierarchy.view = {view.at("image_height"), view.at("field_of_view"), view.at("pixel_error")};
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      hierarchy.center[axis] = document.at("center").at(static_cast<std::size_t>(axis));
    hierarchy.radius = document.at("radius");
    hierarchy.source_faces = document.value("source_faces", std::size_t{0});
    PictureLoader pictures(folder);
    for (const Json& entry : document.at("levels")) {
      LodLevel level;
      PolygonSoup soup = read_soup(folder / entry.at("file").get<std::string>());
      if (!entry.contains("billboards")) pictures.load(soup.materials);
      level.mesh = to_polygon_mesh(soup);
      const Json& error = entry.at("error");
      level.error = {error.at("max"), error.at("rms"), error.at("bound")};
      level.switch_distance = entry.at("switch_distance");
      level.screen_coverage = entry.at("screen_coverage");
      level.stop_reason = entry.at("stop_reason");
      if (entry.contains("billboards")) {
        level.billboards = read_billboards(entry, folder, soup);
      } else {
        level.maps = read_maps(entry, folder, std::move(soup));
      }
      hierarchy.levels.push_back(std::move(level));
    }
    if (hierarchy.levels.empty()) throw InputError::in_file(file.string(), "names no levels");
  } catch (const nlohmann::json::exception& error) {
    throw InputError::in_file(file.string(), error.what());
  }
  return hierarchy;
}

}  // namespace recede
