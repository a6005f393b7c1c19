// What a picture shows, made ready for tracing rays.
#pragma once

#include <recede/geometry/polygon_mesh.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/render/billboards.h>
#include <recede/render/displaced_mesh.h>
#include <recede/render/image.h>
#include <recede/render/shell_volume.h>

#include <memory>
#include <optional>
#include <span>

namespace recede {

class Appearance;

/// A matt floor that touches the models from below and reaches far beyond what a camera near them sees: a
/// disc of 64 times their longest side.
struct Ground {
  Vec3 up = Vec3::UnitY();  ///< from the floor to the models, any length but 0
  Rgb color = Rgb::Constant(0.5f);
};

struct SceneOptions {
  /// Faces whose normals differ by at most this angle (radians) are shaded as one smooth surface where the
  /// input brings no normals. 0: flat facets.
  double crease_angle = 0.698131700797732;  // 40 degrees
  std::optional<Ground> ground = {};
  /// Of a displaced surface: lets pictures show it by other methods than displacement (`Appearance`; see
  /// `RenderOptions::representation`). Normals are then those of the bump map in the frame of the base's
  /// normals, and heights count from the base moved out to their mean, which the other methods draw.
  std::shared_ptr<const Appearance> appearance = {};
};

namespace detail {
struct SceneData;
struct DisplacedLook;
}  // namespace detail

/// Surfaces in Embree. Holds its own copy: the input may go. Coordinates are taken relative to the middle of
/// the models' bounding box and to its longest side before they are rounded to float, so that neither their
/// place nor their size costs detail. Colours are the materials' base colours (light grey where a face
/// has none) times the vertex colours and the textures whose pictures are known; opacity is not drawn. Corner
/// normals are used where they exist and aren't zero.
class Scene {
 public:
  /// Throws `InputError` when there are no faces, `OptionError` for a ground without direction, and `Error`
  /// with Embree's reason.
  explicit Scene(const PolygonSoup& soup, const SceneOptions& options = {});
  explicit Scene(const PolygonMesh& mesh, const SceneOptions& options = {});
  /// Several models, none of them empty.
  explicit Scene(std::span<const PolygonSoup> soups, const SceneOptions& options = {});
  /// Models and billboards, of either perhaps none.
  Scene(std::span<const PolygonSoup> soups, std::span<const PlacedBillboards> billboards,
        const SceneOptions& options = {});
  /// Models and shells with volume textures, of either perhaps none.
  Scene(std::span<const PolygonSoup> soups, std::span<const PlacedVolume> volumes,
        const SceneOptions& options = {});
  /// A level of a hierarchy: its billboards, or else its mesh.
  explicit Scene(const LodLevel& level, const SceneOptions& options = {});
  /// A displaced surface, traced without tessellation; colours are those of the base. It is shaded by the
  /// slopes of its heights, and as facets with a `crease_angle` of 0. Throws like `DisplacedMesh`.
  Scene(const PolygonSoup& base, const DisplacementMap& heights, const DisplacedMeshOptions& displacement,
        const SceneOptions& options = {});
  /// The same for baked maps, shaded by their normal map and coloured by their colour map where there is one.
  /// Throws `InputError` when they have no displacement.
  Scene(const BakedMaps& maps, const DisplacedMeshOptions& displacement, const SceneOptions& options = {});
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// For the renderer.
  const detail::SceneData& data() const { return *data_; }

 private:
  void build(std::span<const PolygonSoup> soups, std::span<const PlacedBillboards> billboards,
             std::span<const PlacedVolume> volumes, const SceneOptions& options);
  void build_displaced(const PolygonSoup& base, std::shared_ptr<detail::DisplacedLook> look,
                       const SceneOptions& options);
  void build_with_appearance(const PolygonSoup& base, const DisplacementMap& heights, const BakedMaps& maps,
                             DisplacedMeshOptions displacement, const SceneOptions& options);
  std::unique_ptr<detail::SceneData> data_;
};

}  // namespace recede
