#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/vanished_patches.h>
#include <recede/lod/patch_tessellator.h>

#include <algorithm>
#include <limits>

namespace recede::detail {

// A triangle is as far from a segment as its farthest corner.
double VanishedPatches::distance(Index patch, std::span<const Segment> segments) {
  if (!samples_[patch]) sample(patch);
  double largest = 0;
  const std::vector<Vec3>& corners = samples_[patch]->corners;
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [from, to] : segments) {
      if (least <= largest) break;  // nothing larger will come of it
      double most = 0;
      for (std::size_t k = i; k < i + 3 && most < least; ++k)
        most = std::max(most, (corners[k] - closest_point_on_segment(corners[k], from, to)).norm());
      least = std::min(least, most);
    }
    largest = std::max(largest, least);
  }
  return largest + samples_[patch]->tolerance;
}

void VanishedPatches::sample(Index patch) {
  constexpr double k_tolerance = 0.02;  // of the patch's size
  const PatchSurface& surface = surfaces_[patch];
  PatchTessellationOptions options;
  const double size = surface.bounds.box(surface.shape.domain()).diagonal().norm();
  options.tolerance = std::max(k_tolerance * size, 4 * graph_.tolerance);
  options.most_points = 2000;
  Sample& made = samples_[patch].emplace();
  try {
    const PatchTriangles triangles =
        triangulate_patch(graph_.loops_of(patch), graph_.positions, surface, options);
    made.tolerance = triangles.error_bound;
    for (const auto& triangle : triangles.triangles) {
      for (const Index corner : triangle) made.corners.push_back(triangles.positions[corner]);
    }
  } catch (const InputError&) {
    made.tolerance = size;  // bad loops: what they go around is somewhere on the surface
  }
}

}  // namespace recede::detail
