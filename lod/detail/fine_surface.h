// The fine surface that maps are baked from.
#pragma once

#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/map_surface.h>
#include <recede/lod/detail/surface_attributes.h>

namespace recede::detail {

/// Finds the place of the fine surface that stands over a place of the coarse one.
class FineSurface {
 public:
  /// Keeps a reference.
  explicit FineSurface(const PolygonSoup& soup)
      : attributes_(soup), tree_(soup.positions, attributes_.triangles()) {}

  struct Place : TrianglePlace {
    double height = 0;    ///< along the normal, object units
    bool missed = false;  ///< the line met nothing: the closest point
  };
  Place over(const MapPlace& point, double reach) const;

  const SurfaceAttributes& attributes() const { return attributes_; }

 private:
  SurfaceAttributes attributes_;
  ClosestPointTree tree_;
};

}  // namespace recede::detail
