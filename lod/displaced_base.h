// A coarse surface and the heights above it, prepared to be diced for any number of views.
#pragma once

#include <recede/geometry/displacement_levels.h>
#include <recede/lod/displacement_bake.h>

#include <array>
#include <memory>
#include <vector>

namespace recede {

/// Heights of `maps`, of the floats where there are some. Throws `InputError` when they hold none.
DisplacementMap displacement_map_of(const BakedMaps& maps);

/// Triangles over shared points, each point with one direction for heights; texture coordinates may differ on
/// both sides of an edge, which then is a seam of the map.
class DisplacedBase {
 public:
  /// Corners with bit-equal positions are one point. Its direction is that of its `corner_normals`, their
  /// mean where they differ, and where there are none or they cancel out, the mean of the triangles' normals
  /// by angle. Polygons stand for the triangles of `triangulate`; triangles that visit a point twice are left
  /// out. Throws `InputError` for soups that `validate` refuses, without faces or without texture
  /// coordinates, for positions, heights or texture coordinates beyond 1e120, `OptionError` as
  /// `DisplacementLevels` does, and `Cancelled`.
  DisplacedBase(const PolygonSoup& surface, DisplacementMap map, const LevelOptions& levels = {},
                Progress* progress = nullptr);
  /// The surface and the heights of baked maps, with the material of `colored_surface`.
  explicit DisplacedBase(const BakedMaps& maps, const LevelOptions& levels = {},
                         Progress* progress = nullptr);

  struct Triangle {
    std::array<Index, 3> points;
    std::array<Vec2, 3> uvs;
    /// No lookup of any level for a point of it gives a height farther from 0, object units: not in its part
    /// of the map, as much again around, or in those of triangles that share a point with it.
    double reach = 0;
    Index material = k_no_index;  ///< of `materials`
  };

  const std::vector<Vec3>& positions() const { return positions_; }
  const std::vector<Vec3>& directions() const { return directions_; }  ///< unit, one for each position
  const std::vector<Triangle>& triangles() const { return triangles_; }
  std::size_t n_input_triangles() const { return n_input_; }
  const DisplacementLevels& levels() const { return *levels_; }
  const std::vector<Material>& materials() const { return materials_; }
  double largest_reach() const { return largest_reach_; }
  double diagonal() const { return diagonal_; }  ///< of the surface's box, object units

 private:
  void find_points(const PolygonSoup& surface);
  void find_reaches();

  std::vector<Vec3> positions_, directions_;
  std::vector<Triangle> triangles_;
  std::vector<Material> materials_;
  std::size_t n_input_ = 0;
  double largest_reach_ = 0, diagonal_ = 0;
  std::unique_ptr<DisplacementMap> map_;  // levels refer to it
  std::unique_ptr<DisplacementLevels> levels_;
};

}  // namespace recede
