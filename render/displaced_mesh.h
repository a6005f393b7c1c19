// Displaced surfaces traced without tessellation.
#pragma once

#include <recede/geometry/displacement_map.h>
#include <recede/geometry/polygon_soup.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace recede {

struct DisplacedMeshOptions {
  /// Every triangle of the base is divided into 4^level small ones, 0 to 14. Unset: the least level at which
  /// there are twice as many small triangles as texels that the base covers.
  std::optional<int> level{};
  /// One for each triangle of `triangulate(base)`, instead of `level`. Where two meet, the side has the
  /// points of the coarser one.
  std::vector<std::uint8_t> triangle_levels{};
  /// Rays may ask for a part of the displacement. Costs a little speed where heights are far from 0.
  bool partial = false;
};

/// How a displaced surface is asked for what a ray meets.
struct DisplacedRayOptions {
  double t_min = 0, t_max = std::numeric_limits<double>::infinity();  ///< lengths of the direction
  double fraction = 1;  ///< of the displacement, 0 to 1; below 1 needs `DisplacedMeshOptions::partial`
};

/// A surface P + h N / |N|: a base of triangles whose points P, with their directions N and texture
/// coordinates, are interpolated linearly, and a height h from a map. Every triangle is divided 4 to 1 again
/// and again, as far as its level says, and the points that arise are moved; the small triangles between them
/// are the surface (Ramsey's dissertation on displaced levels of detail, its section on ray tracing). None is
/// ever stored: a ray goes down the subdivision as a quadtree, with bounds from the map's pyramid of least
/// and largest heights and from the lengths that the directions can have. Memory is that of base and map.
///
/// Watertight: where the base is closed, so is the surface, in spite of seams between charts, creases and
/// different levels; no ray slips through between small triangles, whichever side it comes from. Points of
/// the base that are bit-equal are one and have one direction (`BakedMaps::surface` has such normals; else
/// the mean of the corner normals is taken, or of the triangles' by angle). On both sides of a seam, heights
/// are those of one of them.
///
/// Places are rounded to float relative to the surface's middle and extent, so that neither a model's place
/// nor its size costs detail. Queries may run in parallel.
class DisplacedMesh {
 public:
  /// Beside `memory()`, Embree keeps a hierarchy of boxes around pairs of the base's triangles.
  ///
  /// The base is copied. Throws `InputError` for a base that `validate` refuses, without faces, without
  /// texture coordinates or with ones more than 4 million texels away, `OptionError` for levels out of range
  /// or that are not one for each triangle, and `Error` with Embree's reason.
  DisplacedMesh(const PolygonSoup& base, DisplacementMap map, const DisplacedMeshOptions& options = {});
  ~DisplacedMesh();
  DisplacedMesh(DisplacedMesh&&) noexcept;
  DisplacedMesh& operator=(DisplacedMesh&&) noexcept;

  /// The same base with other heights. Throws `OptionError` when the map has another number of columns or
  /// rows.
  void set_map(DisplacementMap map);

  struct Hit {
    double t = 0;             ///< in lengths of the direction
    Index face = 0;           ///< of the base
    Index triangle = 0;       ///< of `triangulate(base)`
    Vec3 weights{0, 0, 0};    ///< of its corners, in `triangulate`'s order
    Vec2 uv{0, 0};            ///< texture coordinate
    Vec3 normal{0, 0, 1};     ///< of the small triangle: unit length, on the base's front
    std::uint64_t small = 0;  ///< a number of the small triangle, the same for all rays that meet it
  };
  /// The first point that a ray meets, from either side; of several at one distance that of the smallest
  /// number. A ray without direction, or with numbers that aren't finite, meets nothing.
  std::optional<Hit> first_hit(const Vec3& origin, const Vec3& direction,
                               const DisplacedRayOptions& options = {}) const;
  /// Whether there is one; faster.
  bool is_hit(const Vec3& origin, const Vec3& direction, const DisplacedRayOptions& options = {}) const;

  /// All small triangles, for comparisons and for export: their points are bit by bit those that rays meet,
  /// up to the change of scale. Points that neighbours share are stored once for each pair of triangles.
  /// Throws `InputError` for more than a soup has numbers for, some 1.4e9.
  PolygonSoup tessellate(double fraction = 1) const;

  std::size_t small_triangles() const;
  struct Memory {
    std::size_t map = 0;      ///< bytes of heights
    std::size_t pyramid = 0;  ///< of their bounds
    std::size_t base = 0;     ///< of triangles, points, directions and texture coordinates
  };
  Memory memory() const;

  struct Data;
  /// For the renderer.
  const Data& data() const { return *data_; }

 private:
  std::unique_ptr<Data> data_;
};

}  // namespace recede
