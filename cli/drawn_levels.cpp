#include "drawn_levels.h"

#include <recede/geometry/error.h>
#include <recede/lod/lod_selection.h>
#include <recede/lod/view_dependent_remesh.h>
#include <recede/render/image_difference.h>

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

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

Drawn::Drawn(const DrawnOptions& options, Progress* progress) : options_(options) {
  if (fs::is_directory(options.input)) {
    if (!options.heights.file.empty())
      throw OptionError("--displacement-map is for meshes; a hierarchy has its own");
    hierarchy_ = read_hierarchy(options.input);
  } else if (options.heights.file.empty()) {
    Model model = read_model(options.input, progress);
    require_faces(model, options.input);
    hierarchy_.levels.emplace_back().mesh = std::move(model.read.mesh);
  } else {
    displaced_.emplace(read_mesh_with_heights(options.input, options.heights, progress));
    hierarchy_.levels.emplace_back();
  }
  scenes_.resize(hierarchy_.levels.size());
  if (options.level && *options.level >= scenes_.size()) {
    throw OptionError(fmt::format("there is no level {}, only {}", *options.level, scenes_.size()));
  }
  if (scenes_.size() == 1 &&
      (options.false_color == FalseColor::level || options.false_color == FalseColor::error)) {
    throw OptionError(options.input + " has one level, and nothing to show by false colours");
  }
  if (options.false_color == FalseColor::samples && options.lighting.noise == 0)
    throw OptionError("without --noise all pixels have the same number of samples");
  rendering_.samples_per_pixel = options.samples;
  if (options.wireframe) rendering_.wireframe = Wireframe{};
  set_lighting(options.lighting, up_direction(options.view.up, options.input), rendering_);
  finest_ = displaced_ ? displaced_->base : to_soup(hierarchy_.levels[0].mesh);
  if (scenes_.size() > 1) surface_.emplace(finest_.positions, triangulate(finest_));
}

std::size_t Drawn::n_faces(std::size_t level) const {
  return displaced_ ? displaced_->base.n_faces() : hierarchy_.levels[level].mesh.n_faces();
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

Image Drawn::draw(const Camera& camera, std::size_t level, Progress* progress) {
  // A diced surface is another one for every camera; the others are only looked up.
  if (method_of(level) == Displacement::diced) scenes_[level] = make_diced(camera, level, progress);
  const Scene& scene = scene_of(level);
  if (options_.false_color != FalseColor::samples) return render(scene, camera, rendering_, progress);
  ProgressiveRender picture(scene, camera, rendering_);
  picture.add_samples(options_.samples, progress);
  return heat_map(picture.sample_counts(), options_.samples);
}

Displacement Drawn::method_of(std::size_t level) const {
  const std::optional<BakedMaps>& maps = hierarchy_.levels[level].maps;
  const bool has_heights = displaced_ || (maps && !maps->displacement.samples.empty());
  if (options_.no_maps || !has_heights) return Displacement::none;
  // Distances from the input are found at vertices, which a traced surface doesn't have.
  if (options_.false_color == FalseColor::error && options_.displacement == Displacement::traced)
    return Displacement::tessellated;
  return options_.displacement;
}

SceneOptions Drawn::shading() const {
  SceneOptions shading;
  if (options_.flat) shading.crease_angle = 0;
  if (options_.ground) shading.ground = Ground{.up = up_direction(options_.view.up, options_.input)};
  return shading;
}

const Scene& Drawn::scene_of(std::size_t level) {
  if (!scenes_[level]) scenes_[level] = make_scene(level);
  return *scenes_[level];
}

Scene Drawn::make_scene(std::size_t level) const {
  DisplacedMeshOptions displacement;
  displacement.level = options_.subdivision_level;
  const LodLevel& drawn = hierarchy_.levels[level];
  const Displacement method = method_of(level);
  if (method == Displacement::traced && displaced_) {
    PolygonSoup base = displaced_->base;
    paint(base, level);
    return Scene(base, displaced_->map, displacement, shading());
  }
  if (method == Displacement::traced) {
    BakedMaps maps = *drawn.maps;
    paint(maps.surface, level);
    return Scene(maps, displacement, shading());
  }
  PolygonSoup soup;
  const bool is_displaced = method == Displacement::tessellated;
  if (displaced_) {
    soup = is_displaced ? DisplacedMesh(displaced_->base, displaced_->map, displacement).tessellate()
                        : displaced_->base;
  } else {
    // Without heights there may still be a normal map.
    soup = drawn.maps && !options_.no_maps ? dice_surface(*drawn.maps, {.displace = is_displaced})
                                           : to_soup(drawn.mesh);
  }
  paint(soup, level);
  return Scene(soup, shading());
}

Scene Drawn::make_diced(const Camera& camera, std::size_t level, Progress* progress) {
  bases_.resize(hierarchy_.levels.size());
  std::optional<DisplacedBase>& base = bases_[level];
  if (!base && displaced_) base.emplace(displaced_->base, displaced_->map, LevelOptions{}, progress);
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
