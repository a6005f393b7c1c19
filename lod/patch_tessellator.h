// Triangles of a trimmed patch between given points of its loops: no point is added to a loop, so that
// patches which share points share sides, and nothing opens between them.
//
// How far triangles are from the surface is proved by bounds of second derivatives, not sampled.
#pragma once

#include <recede/lod/seam_graph.h>

#include <array>
#include <span>
#include <vector>

namespace recede {

struct PatchTessellationOptions {
  /// Largest distance allowed between surface and triangles, in units of the model. Above 0.
  double tolerance = 0;
  /// Points within the patch that may be added.
  std::size_t most_points = 4'000'000;
};

/// Triangles of one patch. Points of its loops come first, loop by loop in order.
struct PatchTriangles {
  std::vector<Vec2> uvs;
  std::vector<Vec3> positions;  ///< those of loops are the graph's
  /// Numbers of points, counter-clockwise in the plane of (u, v). Where corners are the same point in space,
  /// as at poles, the triangle is left out.
  std::vector<std::array<Index, 3>> triangles;
  /// No point of the surface that the trimming curves of these loops enclose is farther from the triangles.
  /// No point of the triangles is farther from the surface, which goes on beyond the trimming curves, over
  /// strips as wide as the loops say, and over holes whose loops aren't given.
  double error_bound = 0;
  bool reached_tolerance = false;
  /// Triangles whose normal points away from that of the surface at all of their corners, by more than a
  /// millionth of a right angle's sine.
  std::size_t inverted = 0;
};

/// Triangulates what loops of a patch enclose; `positions` are those of the graph. Throws `InputError` when
/// loops cross one another, don't go around anything, or run around it clockwise.
PatchTriangles triangulate_patch(std::span<const SeamLoop> loops, std::span<const Vec3> positions,
                                 const PatchSurface& surface, const PatchTessellationOptions& options);

}  // namespace recede
