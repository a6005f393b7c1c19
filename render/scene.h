// What a picture shows, made ready for tracing rays.
#pragma once

#include <recede/geometry/polygon_mesh.h>

#include <memory>

namespace recede {

struct SceneOptions {
  /// Faces whose normals differ by at most this angle (radians) are shaded as one smooth surface where the
  /// input brings no normals. 0: flat facets.
  double crease_angle = 0.698131700797732;  // 40 degrees
};

namespace detail {
struct SceneData;
}

/// A surface in Embree. Holds its own copy: the input may go. Its coordinates are taken relative to the
/// middle of the bounding box and to its longest side before they are rounded to float, so that neither a
/// model's place nor its size costs detail. Colours are the materials' base colours (light grey where a face
/// has none) times the vertex colours; opacity and textures are not drawn. Corner normals are used where they
/// exist and aren't zero.
class Scene {
 public:
  /// Throws `InputError` when there are no faces, and `Error` with Embree's reason.
  explicit Scene(const PolygonSoup& soup, const SceneOptions& options = {});
  explicit Scene(const PolygonMesh& mesh, const SceneOptions& options = {});
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// For the renderer.
  const detail::SceneData& data() const { return *data_; }

 private:
  std::unique_ptr<detail::SceneData> data_;
};

}  // namespace recede
