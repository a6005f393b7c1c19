#include "drawn_levels.h"

#include <recede/geometry/error.h>
#include <recede/lod/hierarchy_folder.h>
#include <recede/lod/lod_selection.h>
#include <recede/lod/view_dependent_remesh.h>
#include <recede/render/coverage.h>
#include <recede/render/image_difference.h>
#include <recede/render/volume_levels.h>
#include <recede/shells/textured_shell_io.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

namespace recede::cli {
namespace {

namespace fs = std::filesystem;

Rgb method_color(Displacement method) {
  switch (method) {
    case Displacement::traced:
      return {0.1f, 0.6f, 0.15f};
    case Displacement::diced:
      return {0.6f, 0.5f, 0.05f};
    case Displacement::tessellated:
      return {0.1f, 0.5f, 0.6f};
    case Displacement::none:
      break;
  }
  return {0.45f, 0.45f, 0.45f};
}

template <typename Color>
void paint_by(PolygonSoup& soup, const Color& color_at) {
  soup.materials.clear();
  soup.face_materials.clear();
  soup.vertex_colors.clear();
  for (const Vec3& position : soup.positions) {
    const Rgb color = color_at(position);
    soup.vertex_colors.emplace_back(color.x(), color.y(), color.z(), 1);
  }
}

}  // namespace

std::string_view name_of(Displacement method) {
  switch (method) {
    case Displacement::traced:
      return "traced";
    case Displacement::diced:
      return "diced";
    case Displacement::tessellated:
      return "tessellated";
    case Displacement::none:
      break;
  }
  return "none";
}

fs::path appearance_file(const fs::path& folder, std::size_t level) {
  return folder / fmt::format("level_{}.appearance", level);
}

fs::path shell_file(const fs::path& folder, std::size_t level) {
  return folder / fmt::format("level_{}.shell", level);
}

fs::path reflectance_file(const fs::path& folder, std::size_t level) {
  return folder / fmt::format("level_{}.reflectance", level);
}

Drawn::Drawn(const DrawnOptions& options, Progress* progress)
    : options_(options), folder_(hierarchy_folder(options.input)) {
  read_input(progress);
  scenes_.resize(hierarchy_.levels.size());
  shells_.resize(hierarchy_.levels.size());
  appearances_.resize(hierarchy_.levels.size());
  check_options();
  rendering_.samples_per_pixel = options.samples;
  if (options.wireframe) rendering_.wireframe = Wireframe{};
  set_lighting(options.lighting, up_direction(options.view.up, options.input), rendering_);
  if (options.appearance) {
    rendering_.representation = *options.appearance;
    rendering_.show_methods = options.false_color == FalseColor::method;
    if (options.transition_distance) rendering_.transition = transition_around(*options.transition_distance);
  }
  finest_ = mesh_ ? *mesh_ : to_soup(hierarchy_.levels[0].mesh);
  if (scenes_.size() > 1) surface_.emplace(finest_.positions, triangulate(finest_));
}

void Drawn::read_input(Progress* progress) {
  const std::string& input = options_.input;
  const bool has_map = !options_.heights.file.empty();
  if (is_textured_shell(input) && fs::is_regular_file(input)) {
    if (has_map) throw OptionError("--displacement-map is for meshes and hierarchies");
    shells_.emplace_back(read_textured_shell(input, {.make_mipmap = false}, progress));
    mesh_ = shells_[0]->shell->base;
    hierarchy_.levels.emplace_back();
  } else if (!folder_.empty()) {
    hierarchy_ = read_hierarchy(folder_);
    print_missing_pictures(hierarchy_.levels.front().mesh.materials, options_.common);
    shells_.resize(hierarchy_.levels.size());
    for (std::size_t level = 0; level < shells_.size(); ++level) {
      if (const fs::path file = shell_file(folder_, level); fs::exists(file))
        shells_[level] = read_textured_shell(file, {.make_mipmap = false}, progress);
    }
    if (!has_map) return;
    for (const LodLevel& level : hierarchy_.levels) {
      if (level.maps)
        throw OptionError("--displacement-map is for meshes and for hierarchies without maps of their own");
      if (to_soup(level.mesh).corner_uvs.empty())
        throw InputError::in_file(input, "has no texture coordinates for the displacement map");
    }
    heights_ = cli::read_heights(options_.heights);
  } else if (has_map) {
    MeshWithHeights read = read_mesh_with_heights(input, options_.heights, options_.common, progress);
    mesh_ = std::move(read.base);
    heights_ = std::move(read.map);
    hierarchy_.levels.emplace_back();
  } else {
    Model model = read_model(input, progress);
    require_faces(model, input);
    print_repairs(model.read.report, options_.common);
    hierarchy_.levels.emplace_back().mesh = std::move(model.read.mesh);
  }
}

void Drawn::check_options() const {
  if (options_.level && *options_.level >= scenes_.size()) {
    throw OptionError(fmt::format("there is no level {}, only {}", *options_.level, scenes_.size()));
  }
  if (scenes_.size() == 1 &&
      (options_.false_color == FalseColor::level || options_.false_color == FalseColor::error)) {
    throw OptionError(options_.input + " has one level, and nothing to show by false colours");
  }
  if (options_.false_color == FalseColor::samples && options_.lighting.noise == 0)
    throw OptionError("without --noise all pixels have the same number of samples");
  if (options_.reflectance && std::none_of(hierarchy_.levels.begin(), hierarchy_.levels.end(),
                                           [](const LodLevel& level) { return !!level.billboards; }))
    throw OptionError(options_.input + " has no billboards, whose reflectance could be drawn");
  if (options_.matter_color &&
      std::none_of(shells_.begin(), shells_.end(), [](const auto& shell) { return !!shell; }))
    throw OptionError(options_.input + " has no textured shell, whose matter could have a colour");
  if (!options_.appearance) {
    if (options_.transition_distance) throw OptionError("--transition-distance needs --appearance");
    return;
  }
  if (options_.displacement != Displacement::traced || options_.no_maps)
    throw OptionError("--appearance chooses how heights are drawn; it goes with --displacement traced only");
  if (options_.false_color == FalseColor::error)
    throw OptionError("errors are found at vertices, and --appearance draws heights without any");
  for (std::size_t level = 0; level < scenes_.size(); ++level) {
    if (has_heights(level)) return;
  }
  throw OptionError(options_.input + " has no heights, and one appearance only");
}

std::size_t Drawn::n_faces(std::size_t level) const {
  return mesh_ ? mesh_->n_faces() : hierarchy_.levels[level].mesh.n_faces();
}

std::size_t Drawn::choose(const Camera& camera, std::optional<std::size_t> before) const {
  if (options_.level) return *options_.level;
  if (!surface_) return 0;
  const double distance = std::sqrt(surface_->closest(camera.position).squared_distance);
  if (options_.level_rule == ChooseBy::distance) {
    const double to_sphere = (camera.position - hierarchy_.center).norm() - hierarchy_.radius;
    return level_by_distance(
        hierarchy_, to_sphere, distance,
        {.unit = options_.distance_unit.value_or(hierarchy_.radius), .near_limit = options_.near_limit});
  }
  const ViewSettings view{static_cast<double>(camera.height), camera.field_of_view, options_.pixel_error};
  return level_by_error(hierarchy_, distance, {.view = view, .current = before});
}

const Scene& Drawn::scene_for(const Camera& camera, std::size_t level, Progress* progress) {
  // A diced surface is another one for every camera; the others are only looked up.
  if (method_of(level) == Displacement::diced) scenes_[level] = make_diced(camera, level, progress);
  // Which versions of a texture are seen depends on the camera, too.
  if (draws_texture(level)) scenes_[level] = make_textured(camera, level);
  return scene_of(level, progress);
}

Image Drawn::draw(const Camera& camera, std::size_t level, Progress* progress) {
  const Scene& scene = scene_for(camera, level, progress);
  if (options_.false_color != FalseColor::samples) return render(scene, camera, rendering_, progress);
  ProgressiveRender picture(scene, camera, rendering_);
  picture.add_samples(options_.samples, progress);
  return heat_map(picture.sample_counts(), options_.samples);
}

Image Drawn::draw_mask(const Camera& camera, std::size_t level, Progress* progress) {
  if (options_.ground) scenes_[level].reset();
  has_ground_ = false;
  const Image mask =
      mask_picture(render_coverage(scene_for(camera, level, progress), camera, rendering_, progress));
  if (options_.ground) scenes_[level].reset();
  has_ground_ = options_.ground;
  return mask;
}

std::optional<PictureShares> Drawn::methods_of(const Camera& camera, std::size_t level) const {
  if (!options_.appearance || !scenes_[level] || !has_heights(level)) return {};
  return count_methods(*scenes_[level], camera, rendering_);
}

bool Drawn::has_heights(std::size_t level) const {
  const std::optional<BakedMaps>& maps = hierarchy_.levels[level].maps;
  return heights_ || (maps && !maps->displacement.samples.empty());
}

/// With false colours of the surface's own.
bool Drawn::is_painted() const {
  return options_.false_color != FalseColor::none && options_.false_color != FalseColor::samples;
}

bool Drawn::draws_texture(std::size_t level) const {
  return shells_[level] && !options_.no_maps && !is_painted();
}

Displacement Drawn::method_of(std::size_t level) const {
  if (options_.no_maps || !has_heights(level)) return Displacement::none;
  // Distances from the input are found at vertices, which a traced surface doesn't have.
  if (options_.false_color == FalseColor::error && options_.displacement == Displacement::traced)
    return Displacement::tessellated;
  return options_.displacement;
}

SceneOptions Drawn::shading() const {
  SceneOptions shading;
  if (options_.flat) shading.crease_angle = 0;
  if (has_ground_) shading.ground = Ground{.up = up_direction(options_.view.up, options_.input)};
  return shading;
}

const Scene& Drawn::scene_of(std::size_t level, Progress* progress) {
  if (!scenes_[level]) scenes_[level] = make_scene(level, progress);
  return *scenes_[level];
}

/// What the heights of the map, or the texture of the shell, stand on.
PolygonSoup Drawn::base_of_map(std::size_t level) const {
  return mesh_ ? *mesh_ : to_soup(hierarchy_.levels[level].mesh);
}

/// As it was baked, or made now. A map over all levels has one.
std::shared_ptr<const Appearance> Drawn::appearance_of(std::size_t level, Progress* progress) {
  std::shared_ptr<const Appearance>& appearance = appearances_[heights_ ? 0 : level];
  if (appearance) return appearance;
  if (heights_) return appearance = make_appearance(base_of_map(0), *heights_, {}, progress);
  const fs::path file = appearance_file(folder_, level);
  return appearance = fs::exists(file) ? read_appearance(file)
                                       : make_appearance(*hierarchy_.levels[level].maps, {}, progress);
}

Scene Drawn::make_scene(std::size_t level, Progress* progress) {
  DisplacedMeshOptions displacement;
  displacement.level = options_.subdivision_level;
  const LodLevel& drawn = hierarchy_.levels[level];
  const Displacement method = method_of(level);
  SceneOptions shading = this->shading();
  if (method == Displacement::traced && options_.appearance)
    shading.appearance = appearance_of(level, progress);
  if (method == Displacement::traced && heights_) {
    PolygonSoup base = base_of_map(level);
    paint(base, level);
    return Scene(base, *heights_, displacement, shading);
  }
  if (method == Displacement::traced) {
    BakedMaps maps = *drawn.maps;
    if (is_painted()) maps.color = {};
    paint(maps.surface, level);
    return Scene(maps, displacement, shading);
  }
  if (drawn.billboards && !options_.no_maps && !is_painted())
    return options_.reflectance ? make_reflecting(level) : Scene(drawn, shading);
  PolygonSoup soup;
  const bool is_displaced = method == Displacement::tessellated;
  if (heights_ || mesh_) {
    soup = base_of_map(level);
    if (is_displaced) soup = DisplacedMesh(soup, *heights_, displacement).tessellate();
  } else {
    // Without heights there may still be a normal map.
    soup = drawn.maps && !options_.no_maps ? dice_surface(*drawn.maps, {.displace = is_displaced})
                                           : to_soup(drawn.mesh);
  }
  paint(soup, level);
  return Scene(soup, shading);
}

Scene Drawn::make_reflecting(std::size_t level) const {
  const fs::path file = reflectance_file(folder_, level);
  if (!fs::exists(file))
    throw InputError::in_file(file, "isn't there; recede billboards --reflectance writes it");
  PlacedBillboards placed{std::make_shared<const BillboardTextures>(*hierarchy_.levels[level].billboards)};
  placed.reflectance = std::make_shared<const BillboardReflectance>(read_billboard_reflectance(file));
  return Scene(std::span<const PolygonSoup>{}, std::span(&placed, 1), shading());
}

/// With the levels of its texture that the view needs; where a later one needs more, with all.
const TexturedShell& Drawn::shell_for(const VolumeView& view, std::size_t level) {
  TexturedShell& shell = *shells_[level];
  const int needed = coarsest_level_seen(shell, view);
  made_levels_.resize(shells_.size());
  std::optional<int>& made = made_levels_[level];
  if (made && *made >= needed) return shell;
  shell.texture = made ? std::make_shared<const VolumeMipmap>(make_mipmap(shell.texture->surfaces.front()))
                       : with_levels_for(shell, view).texture;
  made = made ? std::numeric_limits<int>::max() : needed;
  return shell;
}

/// Under matter the base is seen, within it what is left of the body.
Scene Drawn::make_textured(const Camera& camera, std::size_t level) {
  PlacedVolume placed{shell_for(volume_view(camera), level)};
  PolygonSoup solid = placed.textured.shell->base;
  if (placed.textured.side == ShellSide::interior) solid.positions = placed.textured.layer().tops;
  if (options_.matter_color) placed.color = to_vector(*options_.matter_color).cast<float>();
  placed.view = volume_view(camera);
  return Scene(std::span(&solid, 1), std::span<const PlacedVolume>(&placed, 1), shading());
}

Scene Drawn::make_diced(const Camera& camera, std::size_t level, Progress* progress) {
  bases_.resize(hierarchy_.levels.size());
  std::optional<DisplacedBase>& base = bases_[level];
  if (!base && heights_) base.emplace(base_of_map(level), *heights_, LevelOptions{}, progress);
  if (!base) base.emplace(*hierarchy_.levels[level].maps, LevelOptions{}, progress);
  RemeshOptions dicing;
  // Light also comes from what isn't in the picture.
  dicing.cull = rendering_.transport == LightTransport::camera;
  PolygonSoup soup = remesh_for_view(*base, remesh_view_of(camera), dicing, progress).soup;
  if (soup.n_faces() == 0) throw InputError("nothing of " + options_.input + " is in the picture");
  paint(soup, level);
  return Scene(soup, shading());
}

// False colours of the vertices.
void Drawn::paint(PolygonSoup& soup, std::size_t level) const {
  switch (options_.false_color) {
    case FalseColor::level:
      return paint_by(soup, [&](const Vec3&) { return heat_map_color(level_share(level)); });
    case FalseColor::error:
      return paint_by(soup, [&](const Vec3& p) { return heat_map_color(error_share(p)); });
    case FalseColor::method:
      return paint_by(soup, [&](const Vec3&) { return method_color(method_of(level)); });
    case FalseColor::none:
    case FalseColor::samples:
      return;
  }
}

double Drawn::level_share(std::size_t level) const {
  return static_cast<double>(level) / static_cast<double>(std::max<std::size_t>(scenes_.size() - 1, 1));
}
// Distance from the input over the coarsest level's bound.
double Drawn::error_share(const Vec3& position) const {
  const double most = hierarchy_.levels.back().error.bound;
  return surface_ && most > 0 ? std::sqrt(surface_->closest(position).squared_distance) / most : 0;
}

}  // namespace recede::cli
