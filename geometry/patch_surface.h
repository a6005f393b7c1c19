// The surface of a trimmed patch, prepared to be evaluated often and bounded.
#pragma once

#include <recede/geometry/surface_bounds.h>
#include <recede/geometry/trimmed_patch.h>

#include <span>
#include <vector>

namespace recede {

struct PatchSurface {
  BezierPatches shape;
  SurfaceBounds bounds;

  explicit PatchSurface(const NurbsSurface& surface, double finest = 0)
      : shape(surface), bounds(shape, finest) {}
};

/// In parallel. `finest`: of `SurfaceBounds`. Throws `InputError` that names the patch.
std::vector<PatchSurface> prepare_surfaces(std::span<const TrimmedPatch> patches, double finest = 0);

}  // namespace recede
