// The surface of a trimmed patch, prepared to be evaluated often and bounded.
#pragma once

#include <recede/geometry/surface_bounds.h>
#include <recede/geometry/trimmed_patch.h>

#include <span>
#include <vector>

namespace recede {

/// In how many ways a surface bends.
enum class SurfaceBend {
  none,     ///< a parallelogram
  one_way,  ///< along u or v alone, as a cylinder does
  both,     ///< or it isn't known better
};

struct PatchSurface {
  BezierPatches shape;
  SurfaceBounds bounds;
  SurfaceBend bend = SurfaceBend::both;

  /// `finest`: of `SurfaceBounds`.
  explicit PatchSurface(const NurbsSurface& surface, double finest = 0);
};

/// In parallel. `finest`: of `SurfaceBounds`. Throws `InputError` that names the patch.
std::vector<PatchSurface> prepare_surfaces(std::span<const TrimmedPatch> patches, double finest = 0);

}  // namespace recede
