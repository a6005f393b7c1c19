// Several meshes in one glTF 2.0 file, with access to the JSON for extensions and extras.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <nlohmann/json_fwd.hpp>

#include <memory>
#include <span>
#include <string>

namespace recede {

/// What a mesh of a glTF document has beside a soup.
struct GltfMeshExtras {
  /// C unit vectors, each with 1 or -1 as its fourth number: glTF's TANGENT. Or empty.
  std::span<const Vec4> corner_tangents{};
  /// The same polygons in another shape, as a morph target: positions, and the normals, texture coordinates
  /// and colours that the soup has.
  const PolygonSoup* morph_target = nullptr;
  std::string morph_name{};
  /// V numbers below 2^24, or k_no_index, which becomes -1: attribute `_PARENT`. Or empty.
  std::span<const Index> parents{};
};

/// Builds a glTF document with one buffer. Meshes become triangles, one primitive for each material, with
/// vertices split where the attributes of their corners differ. Positions are 32-bit floats; a mesh far from
/// the origin is stored around its own centre, and its nodes carry the offset as their translation. Texture
/// coordinates are turned from v up (OBJ, PLY) to glTF's v down. Equal materials of several meshes are
/// written once. Pictures that materials have are put into the document, others are named.
class GltfBuilder {
 public:
  GltfBuilder();
  GltfBuilder(GltfBuilder&&) noexcept;
  GltfBuilder& operator=(GltfBuilder&&) noexcept;
  ~GltfBuilder();

  /// Adds a mesh and returns its position in `meshes`. Corner normals are made unit length; where some corner
  /// has none, the face's normal is written. Throws `InputError` for a soup without triangles (glTF can't
  /// hold it) or with values outside the range of floats.
  int add_mesh(const PolygonSoup& soup, const std::string& name, const GltfMeshExtras& extras = {});

  /// The same mesh once more, over the same data. Returns its position in `meshes`.
  int copy_mesh(int mesh);

  /// Gives the material to what has none of the mesh.
  void paint_mesh(int mesh, const Material& material);

  /// Puts a PNG or JPEG file into the document as what `path` names: materials that are added later, have it
  /// as a texture and no picture, refer to it. Our reader finds the path again. Returns its position in
  /// `images`.
  int add_picture(const std::string& path, std::string_view picture);

  /// Adds a node that shows `mesh` (-1: none) and returns its position in `nodes`. It isn't in the scene yet.
  /// glTF wants placements without shear: a rotation after factors along the axes.
  int add_node(int mesh, const std::string& name,
               const Eigen::Affine3d& placement = Eigen::Affine3d::Identity());

  /// Puts a node into the document's scene, or below another one.
  void add_to_scene(int node);
  void add_child(int parent, int node);

  /// The document without `buffers`, which `to_glb` and `to_gltf` add. Nodes, scenes and meshes may get
  /// extensions and extras; `extensionsUsed` is the caller's to fill.
  nlohmann::json& document();

  /// A binary file. Throws `InputError` when it exceeds 4 GiB.
  std::string to_glb() const;
  /// A text file with its buffer inside.
  std::string to_gltf() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace recede
