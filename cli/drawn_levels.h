// What `recede render` and `recede turntable` draw: a level of a hierarchy, or a mesh, its own way.
#pragma once

#include "common.h"
#include "lighting_options.h"
#include <recede/geometry/closest_point.h>
#include <recede/lod/displaced_base.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/render/appearance.h>
#include <recede/render/method_shares.h>
#include <recede/render/progressive_render.h>
#include <recede/shells/textured_shell.h>

#include <filesystem>
#include <memory>
#include <optional>

namespace recede::cli {

enum class FalseColor { none, level, error, method, samples };
enum class ChooseBy { error, distance };
/// How heights come into the picture.
enum class Displacement { traced, diced, tessellated, none };

struct DrawnOptions {
  CommonOptions common;
  std::string input;
  ViewOptions view;
  int width = 800, height = 600;
  std::optional<std::size_t> level;
  ChooseBy level_rule = ChooseBy::error;
  double pixel_error = 1;
  std::optional<double> distance_unit;
  double near_limit = 0;
  int samples = 16;
  bool wireframe = false, flat = false, no_maps = false, ground = false, reflectance = false;
  Displacement displacement = Displacement::traced;
  HeightMapOptions heights;
  std::optional<int> subdivision_level;
  std::optional<Representation> appearance;
  std::optional<double> transition_distance;
  LightingOptions lighting;
  std::optional<std::array<double, 3>> matter_color;
  FalseColor false_color = FalseColor::none;
};

/// Levels that can be drawn: those of a hierarchy, or a mesh alone.
class Drawn {
 public:
  Drawn(const DrawnOptions& options, Progress* progress);

  const PolygonSoup& finest() const { return finest_; }
  const LodHierarchy& hierarchy() const { return hierarchy_; }
  /// Faces of a level, without heights.
  std::size_t n_faces(std::size_t level) const;

  /// The level for a camera, from the one that was shown before.
  std::size_t choose(const Camera& camera, std::optional<std::size_t> before) const;
  Image draw(const Camera& camera, std::size_t level, Progress* progress);
  /// White where the level is, without the ground.
  Image draw_mask(const Camera& camera, std::size_t level, Progress* progress);
  /// By which methods it was drawn; with `--appearance`, for levels with heights.
  std::optional<PictureShares> methods_of(const Camera& camera, std::size_t level) const;
  /// How a level comes into the picture.
  Displacement method_of(std::size_t level) const;

 private:
  SceneOptions shading() const;
  const Scene& scene_for(const Camera& camera, std::size_t level, Progress* progress);
  const Scene& scene_of(std::size_t level, Progress* progress);
  void read_input(Progress* progress);
  void check_options() const;
  bool has_heights(std::size_t level) const;
  bool is_painted() const;
  bool draws_texture(std::size_t level) const;
  PolygonSoup base_of_map(std::size_t level) const;
  std::shared_ptr<const Appearance> appearance_of(std::size_t level, Progress* progress);
  Scene make_scene(std::size_t level, Progress* progress);
  Scene make_reflecting(std::size_t level) const;
  const TexturedShell& shell_for(const VolumeView& view, std::size_t level);
  Scene make_textured(const Camera& camera, std::size_t level);
  Scene make_diced(const Camera& camera, std::size_t level, Progress* progress);
  void paint(PolygonSoup& soup, std::size_t level) const;
  double level_share(std::size_t level) const;
  double error_share(const Vec3& position) const;

  const DrawnOptions& options_;
  bool has_ground_ = options_.ground;
  std::filesystem::path folder_;  // of the hierarchy; empty of a mesh
  LodHierarchy hierarchy_;
  PolygonSoup finest_;
  std::optional<ClosestPointTree> surface_;
  std::vector<std::optional<Scene>> scenes_;
  std::vector<std::optional<TexturedShell>> shells_;  // of levels that are one
  std::vector<std::optional<int>> made_levels_;       // of their textures: the coarsest
  std::optional<PolygonSoup> mesh_;                   // with heights, instead of levels
  std::optional<DisplacementMap> heights_;            // over it, or over all levels
  std::vector<std::optional<DisplacedBase>> bases_;   // of levels that were diced
  std::vector<std::shared_ptr<const Appearance>> appearances_;
  RenderOptions rendering_;
};

std::string_view name_of(Displacement method);

/// Where `recede bake --appearance` writes that of a level.
std::filesystem::path appearance_file(const std::filesystem::path& folder, std::size_t level);
/// Where `recede shell --texture` writes that of a level.
std::filesystem::path shell_file(const std::filesystem::path& folder, std::size_t level);
/// Where `recede billboards --reflectance` does.
std::filesystem::path reflectance_file(const std::filesystem::path& folder, std::size_t level);

}  // namespace recede::cli
