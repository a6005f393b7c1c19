#include "trimmed_patches.h"
#include <recede/lod/patch_tessellator.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

using test::ball;
using test::whole;

PatchTriangles triangles_of(const TrimmedPatch& patch, double tolerance) {
  const PatchSurface surface(patch.surface);
  const SeamGraph graph = build_seam_graph({&patch, 1}, {&surface, 1}, {.tolerance = tolerance / 2});
  return triangulate_patch(graph.loops_of(0), graph.positions, surface, {.tolerance = tolerance});
}

TEST(PoleTessellation, ProvesFineTolerancesWhereTrianglesAreWideInParametersAndNarrowInSpace) {
  const double radius = 10;
  for (const double tolerance : {0.3, 0.02, 0.002}) {
    const PatchTriangles made = triangles_of(whole(ball(radius)), tolerance);
    EXPECT_TRUE(made.reached_tolerance) << tolerance;
    EXPECT_LE(made.error_bound, tolerance);
    for (const auto& [a, b, c] : made.triangles) {
      // Triangles of a ball are inside of it, farthest at the middle of their circles or sides.
      const Vec3 &p = made.positions[a], &q = made.positions[b], &r = made.positions[c];
      for (const Vec3& point :
           {Vec3((p + q) / 2), Vec3((q + r) / 2), Vec3((r + p) / 2), Vec3((p + q + r) / 3)})
        EXPECT_GE(point.norm(), radius - tolerance);
    }
  }
}

TEST(PoleTessellation, DoesNotCrowdPointsAtPoles) {
  const double tolerance = 0.002;
  const PatchTriangles made = triangles_of(whole(ball(10)), tolerance);
  for (std::size_t i = 0; i < made.positions.size(); ++i) {
    const double from_axis = made.positions[i].head<2>().norm();
    // Halving the way to a pole again and again would come to 1e-9; a hundredth of the tolerance isn't
    // needed.
    if (from_axis > 1e-12) {
      EXPECT_GT(from_axis, tolerance / 100) << i;
    }
  }
}

}  // namespace
}  // namespace recede
