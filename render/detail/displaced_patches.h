// A base mesh made ready for the displaced kernel: triangles in pairs, and what neighbours must agree on.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/render/detail/displaced_kernel.h>

#include <array>
#include <vector>

namespace recede::detail {

/// Where the base lies in the scaled scene: (object - center) * scale.
struct SceneFrame {
  Vec3 center = Vec3::Zero();
  double scale = 1;

  Vec3 to_scene(const Vec3& point) const { return (point - center) * scale; }
  Vec3 to_object(const Vec3& point) const { return point / scale + center; }
};

struct DisplacedPatches {
  std::vector<PatchPart> parts;  ///< of all patches; empty when every one is a single part
  std::vector<DisplacedPatch> patches;
  std::vector<DisplacedVertex> vertices;
  std::vector<PatchException> exceptions;
  std::vector<std::array<Index, 2>> triangles;  ///< of each patch, their numbers in `triangulate`
  std::vector<Index> faces;                     ///< of each triangle of `triangulate`
};

/// Divides patches into parts of 16 by 16 squares or more, as long as there are not many: Embree's boxes are
/// faster than those that are found on the way, and cost a fifth of a byte for each small triangle at most.
void divide_into_parts(DisplacedPatches& patches);

/// Pairs triangles of one level that share a side with the same texture coordinates. Points that are
/// bit-equal are one, displaced in one direction: the mean of its corners' normals, or of its triangles' by
/// angle when the base brings none. Along lines with different texture coordinates on their two sides,
/// heights are those of the triangle of the least number. `columns` and `rows` are those of the map; `levels`
/// one for each triangle.
DisplacedPatches make_displaced_patches(const PolygonSoup& base, const SceneFrame& frame, int columns,
                                        int rows, const std::vector<std::uint8_t>& levels);

}  // namespace recede::detail
