#include <recede/geometry/patch_surface.h>

#include <tbb/parallel_for.h>

#include <optional>

namespace recede {

namespace {

SurfaceBend bend_of(const SurfaceBounds& bounds, const ParameterBox& domain) {
  constexpr double k_nothing = 1e-12;  // of its size: what is rounding
  const DerivativeBounds most = bounds.derivatives(domain);
  const double width = domain.sizes().x(), height = domain.sizes().y();
  const double size = width * most.u + height * most.v;
  const auto is_nothing = [&](double bend) { return bend <= k_nothing * size; };
  if (!is_nothing(width * height * most.uv)) return SurfaceBend::both;
  const bool is_straight_u = is_nothing(width * width * most.uu),
             is_straight_v = is_nothing(height * height * most.vv);
  if (is_straight_u && is_straight_v) return SurfaceBend::none;
  return is_straight_u || is_straight_v ? SurfaceBend::one_way : SurfaceBend::both;
}

}  // namespace

PatchSurface::PatchSurface(const NurbsSurface& surface, double finest)
    : shape(surface), bounds(shape, finest), bend(bend_of(bounds, shape.domain())) {}

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
