#include <recede/geometry/patch_surface.h>

#include <tbb/parallel_for.h>

#include <optional>

namespace recede {

std::vector<PatchSurface> prepare_surfaces(std::span<const TrimmedPatch> patches, double finest) {
  for (const TrimmedPatch& patch : patches) validate(patch.surface, "patch " + patch.name);
  std::vector<std::optional<PatchSurface>> made(patches.size());
  tbb::parallel_for(std::size_t{0}, patches.size(),
                    [&](std::size_t i) { made[i].emplace(patches[i].surface, finest); });
  std::vector<PatchSurface> surfaces;
  surfaces.reserve(patches.size());
  for (std::optional<PatchSurface>& surface : made) surfaces.push_back(std::move(*surface));
  return surfaces;
}

}  // namespace recede
