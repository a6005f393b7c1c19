// Heights for vertices that stand for their surroundings.
#pragma once

#include <recede/geometry/displacement_levels.h>
#include <recede/lod/view_dependent_remesh.h>

namespace recede::detail {

/// Lookups in the levels of a map by the rule of a view. `facing` is the cosine
/// between a vertex's direction and that to the eye; around 0 the two sides are blended.
///
/// A peak of a footprint has to be among its samples to be kept, so `FootprintRule::by_side` takes up to
/// `k_across` samples across and `k_along` along a footprint, from a level as fine as they are dense. A
/// single one from the level of the whole footprint loses more of a skyline than no filter does.
class FootprintHeights {
 public:
  FootprintHeights(const DisplacementLevels& levels, FootprintRule rule);

  /// For a footprint with two sides, in texture coordinates.
  double inside(const Vec2& uv, const Vec2& side, const Vec2& other_side, double facing) const;
  /// For a vertex of an edge, whose step stands for a square.
  double on_edge(const Vec2& uv, const Vec2& step, double facing) const;
  /// For a corner, which belongs to no edge: a square with sides of so many texels, along those of the map.
  double at_corner(const Vec2& uv, double texels, double facing) const;

  static constexpr int k_across = 3, k_along = 6;

 private:
  struct Samples;
  double by_side(const Vec2& uv, const Vec2& side, const Vec2& other_side, double facing) const;
  double filtered(const Samples& samples, double front) const;

  const DisplacementLevels& levels_;
  FootprintRule rule_;
  Vec2 texels_;  ///< of level 0 along both sides of the map
};

}  // namespace recede::detail
