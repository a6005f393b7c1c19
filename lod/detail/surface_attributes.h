// Normals and colours at places of a surface, as pictures show them.
#pragma once

#include <recede/geometry/texture.h>

namespace recede::detail {

/// A place of a triangle of `triangulate`.
struct TrianglePlace {
  Index triangle = 0;
  Vec3 weights = Vec3::Zero();  ///< of its corners
};

class SurfaceAttributes {
 public:
  /// Keeps a reference.
  explicit SurfaceAttributes(const PolygonSoup& soup);

  /// Three vertices a triangle.
  const std::vector<Index>& triangles() const { return triangles_; }
  Index face_of(Index triangle) const { return faces_[triangle]; }
  /// The soup's own normal, or else smooth but for creases; unit length.
  Vec3 normal_at(const TrianglePlace& place) const;
  bool has_colors() const { return !soup_.vertex_colors.empty() || !soup_.face_materials.empty(); }
  /// Linear: the product of the material's base colour, its texture and the vertex colour. Light grey where
  /// there is none. The texture's mean over `width`, object units.
  Vec3 color_at(const TrianglePlace& place, double width = 0) const;

 private:
  Vec3 texture_color(const Texture& texture, const TrianglePlace& place, double width) const;

  const PolygonSoup& soup_;
  BaseColorTextures textures_;
  std::vector<Index> faces_, corners_;  // of the triangles
  std::vector<Index> triangles_;        // made together with those, so behind them
  std::vector<Vec3> normals_;           // of the soup's corners
};

}  // namespace recede::detail
