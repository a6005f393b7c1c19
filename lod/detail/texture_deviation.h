// How far a half-edge collapse moves the surface under its texture.
//
// Two points with the same texture coordinates, one on the surface before and one after the collapse, are
// apart by the texture deviation (Cohen, Olano, Manocha 1998; Sander et al. 2001). Both surfaces are linear
// over the pieces of their common overlay in the texture plane, so the largest deviation is found at a corner
// of a piece: at the removed point, or where an edge from it crosses an edge from the kept one. All of that
// lies within the polygons around the removed point; on a seam, every side is looked at by itself.
#pragma once

#include <recede/lod/detail/collapse_rules.h>

#include <optional>

namespace recede::detail {

/// Keeps lists between collapses, so that no memory is allocated: one object per thread.
class TextureDeviation {
 public:
  explicit TextureDeviation(const CornerTable& table) : table_(table) {}

  /// The largest deviation, table units, of moving a point to the other end of an edge; nothing when a
  /// polygon would turn over in the texture plane. `ring` is that of the removed point. Polygons with more
  /// than three sides count by their ears.
  std::optional<double> measure(const std::vector<RingCorner>& ring, Index removed, Index kept);

 private:
  /// A place on the surface and in the texture plane.
  struct Place {
    Vec3 position;
    Vec2 uv;
  };
  struct Fan {
    Place from, to;  ///< of a polygon around the removed point: the corner after it and the one before it
    bool on_edge;
  };
  Place place_of(Index corner) const;
  std::optional<double> measure_side(Index wedge, const std::vector<RingCorner>& ring, Index kept);
  double deviation_at_removed(const Place& removed, const Place& kept) const;
  double deviation_at_crossings(const Place& removed, const Place& kept) const;

  const CornerTable& table_;
  std::vector<Fan> fans_;
  std::vector<Index> sides_;
};

}  // namespace recede::detail
