// Displaced surfaces diced for one view: a mesh whose triangles are about as large as a pixel, without
// cracks.
//
// S. Gumhold, T. Huettner: Multiresolution Rendering With Displacement Mapping. Graphics Hardware 1999.
#pragma once

#include <recede/lod/displaced_base.h>

#include <optional>

namespace recede {

/// A pinhole camera with square pixels; `position` looks to `target`, which lands in the middle of the image.
struct RemeshView {
  Vec3 position{0, 0, 3};
  Vec3 target = Vec3::Zero();
  Vec3 up = Vec3::UnitY();                   ///< any direction but the view's own, need not be unit
  double field_of_view = 0.785398163397448;  ///< vertical, radians, in (0, pi)
  int width = 1080;                          ///< pixels
  int height = 1080;                         ///< pixels
};

/// What heights stand for the surroundings of a vertex, as large as a triangle.
enum class FootprintRule {
  by_side,  ///< the highest seen from the front, the lowest from the back, so that silhouettes keep their
            ///< peaks
  mean,     ///< a level's height, blended with the next
  none  ///< the map's height at the vertex alone: fast, and aliased where triangles are larger than texels
};

struct RemeshOptions {
  double triangle_pixels = 1;  ///< length of the triangles' short sides, pixels
  FootprintRule footprint = FootprintRule::by_side;
  bool cull = true;     ///< leave out triangles of the base of which nothing can be in the image
  bool normals = true;  ///< smooth ones of the displaced mesh
  /// Edges of the base whose ends differ more in depth are halved first, so that pieces look equally long.
  double largest_depth_ratio = 2;
  /// Depth below which triangles don't get smaller, object units. Unset: `k_nearest` of the base's diagonal.
  std::optional<double> nearest{};
  static constexpr double k_nearest = 1e-5;
  std::size_t most_triangles = 50'000'000;  ///< more are an error
};

/// What was done, by stages.
struct RemeshReport {
  std::size_t base_triangles = 0;  ///< of the input
  std::size_t patches = 0;         ///< after edges were halved, those that are left out too
  std::size_t culled = 0;          ///< of them, left out
  std::size_t flat = 0;  ///< of the others: without area among the voxels, so that nothing lies inside
  /// Of the others: by the axis along which they were swept, x and y in the image and z into its depth.
  std::size_t swept_x = 0, swept_y = 0, swept_z = 0;
  // Vertices of the mesh: at corners of patches, on their edges, and inside.
  std::size_t corner_vertices = 0, edge_vertices = 0, inner_vertices = 0;
  std::size_t triangles = 0;  ///< of the mesh
  double largest_move = 0;    ///< by a height, object units
  double seconds = 0;
};

struct RemeshResult {
  /// Triangles with `corner_uvs` and the base's materials, and `corner_normals` when asked for.
  PolygonSoup soup;
  RemeshReport report;
};

/// Triangles of the base become small ones, by a sweep in a space of voxels: pixels, and depth in steps as
/// long as a pixel is wide there, so that what is seen edge-on is diced by its depth. They are as small as
/// `triangle_pixels` in the image and coarser outside. Then every vertex moves by the height of its
/// footprint.
///
/// Without cracks: everything about a vertex on an edge or corner of the base follows from that edge or
/// corner alone, on seams too, where heights are the mean of both sides. Every edge of the mesh has as many
/// triangles on both sides as the base's has there; what `cull` leaves out ends at the image or beyond.
/// Before vertices move, no small triangle is turned over. Same bytes for any number of threads.
///
/// Where the camera stands between surface and heights, or in the surface, the mesh is as defined everywhere
/// else; parts of the base behind the camera that heights move before it are coarse.
///
/// Deviations from the source: columns of vertices are joined instead of walking over cells, limits of the
/// picture are tested in the space of the camera, its near plane is only `nearest`, and voxels grow outside
/// of the picture.
///
/// Throws `OptionError` for numbers out of range and for more than `most_triangles`, and `Cancelled`.
RemeshResult remesh_for_view(const DisplacedBase& base, const RemeshView& view,
                             const RemeshOptions& options = {}, Progress* progress = nullptr);

}  // namespace recede
