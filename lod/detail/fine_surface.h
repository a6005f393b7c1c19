// The fine surface that maps are baked from.
#pragma once

#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/map_surface.h>

namespace recede::detail {

/// Finds the place of the fine surface that stands over a place of the coarse one.
class FineSurface {
 public:
  /// Keeps a reference.
  explicit FineSurface(const PolygonSoup& soup);

  struct Place {
    double height = 0;  ///< along the normal, object units
    Index triangle = 0;
    Vec3 weights = Vec3::Zero();  ///< of its corners
    bool missed = false;          ///< the line met nothing: the closest point
  };
  Place over(const MapPlace& point, double reach) const;

  /// The soup's own normal, or else smooth but for creases; unit length.
  Vec3 normal_at(const Place& place) const;
  bool has_colors() const { return !soup_.vertex_colors.empty() || !soup_.face_materials.empty(); }
  /// Linear: the material's base colour times the vertex colour.
  Vec3 color_at(const Place& place) const;

 private:
  const PolygonSoup& soup_;
  std::vector<Index> faces_, corners_;  // of the triangles
  std::vector<Vec3> normals_;           // of the soup's corners
  ClosestPointTree tree_;
};

}  // namespace recede::detail
