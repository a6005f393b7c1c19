// The inside of a Scene, for the renderer only.
#pragma once

#include <recede/geometry/texture.h>
#include <recede/lod/detail/embree_device.h>
#include <recede/render/image.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace recede::detail {

class BillboardLook;
struct DisplacedLook;
class VolumeLook;

/// Base colours by texture coordinates, which are factors of those of triangles.
struct MeshTextures {
  std::vector<Eigen::Vector2f> corner_uvs;        ///< three a triangle
  std::vector<std::uint32_t> triangle_materials;  ///< of `textures`
  BaseColorTextures textures;

  /// `weights` are those of the triangle's corners.
  Rgb color_at(std::uint32_t triangle, const Eigen::Vector3f& weights) const {
    const Texture* const texture = textures.of(triangle_materials[triangle]);
    if (texture == nullptr) return Rgb::Ones();
    Eigen::Vector2f uv = Eigen::Vector2f::Zero();
    for (std::size_t k = 0; k < 3; ++k) uv += weights[static_cast<int>(k)] * corner_uvs[3 * triangle + k];
    return texture->color_at(uv.cast<double>()).cast<float>();
  }
};

/// A mesh in Embree, the base of a displaced surface there, or billboards. Lengths and places are those of
/// the scaled scene.
struct MeshData {
  std::vector<std::array<float, 4>> positions;  ///< the fourth is padding: Embree reads 16 bytes
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Eigen::Vector3f> corner_normals;  ///< three a triangle, on the side of its front; or (0,0,0)
  std::vector<Rgb> triangle_colors;
  std::vector<Rgb> vertex_colors;                     ///< factors, or empty
  std::shared_ptr<const MeshTextures> textures = {};  ///< null: none
  /// Bit k: the side from vertex k to vertex k + 1 is a side of the polygon, not a diagonal.
  std::vector<std::uint8_t> polygon_sides;
  std::vector<float> polygon_areas;                      ///< of the polygon that the triangle belongs to
  std::vector<float> longest_sides;                      ///< of the triangles at each vertex
  std::shared_ptr<const DisplacedLook> displaced = {};   ///< null: the triangles themselves are drawn
  std::shared_ptr<const BillboardLook> billboards = {};  ///< set: drawn instead, and there are no triangles
  std::shared_ptr<const VolumeLook> volume = {};         ///< likewise

  Vec3 position(std::uint32_t vertex) const {
    return Eigen::Vector3f(positions[vertex].data()).cast<double>();
  }
};

/// Scenes with the base of a displaced surface in place of it, and with what holds all heights.
struct AppearanceScenes {
  /// The envelope: the base at its largest height, triangle by triangle, and then strips down from its
  /// borders to the least height, two triangles for each side.
  std::vector<std::array<float, 4>> envelope_positions;
  std::vector<std::array<std::uint32_t, 3>> envelope_triangles;
  std::vector<std::uint32_t> strip_owners;  ///< the base's triangle for each of the strips'

  /// The triangle of the base over which one of the envelope stands.
  std::uint32_t base_triangle(std::uint32_t triangle) const {
    const std::size_t faces = envelope_triangles.size() - strip_owners.size();
    return triangle < faces ? triangle : strip_owners[triangle - faces];
  }

  OwnedScene base, envelope;  // released before the lists that they refer to
};

/// Lengths and places are those of the scaled scene, whose models fill the unit box: (object - center) *
/// scale.
struct SceneData {
  SceneData() = default;
  SceneData(const SceneData&) = delete;
  SceneData& operator=(const SceneData&) = delete;

  /// Scenes with other shapes of a displaced surface; null where it has no appearances.
  std::unique_ptr<AppearanceScenes> appearances;
  std::vector<MeshData> meshes;  ///< by Embree's number of the geometry

  Vec3 center = Vec3::Zero();
  double scale = 1;
  double radius = 0;  ///< of a sphere around the origin that holds all positions

  Vec3 scaled(const Vec3& object) const { return (object - center) * scale; }

  OwnedScene scene;  // released before what it refers to
};

}  // namespace recede::detail
