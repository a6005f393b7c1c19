// How much of a picture is drawn by which method.
#pragma once

#include <recede/render/renderer.h>

#include <array>

namespace recede {

/// Shares of a picture's pixels, by the surface that the ray through each one's middle meets; they sum to 1.
struct PictureShares {
  std::array<double, 5> methods{};  ///< of surfaces with appearances, by `RenderingMethod`
  double others = 0;                ///< of surfaces without
  double background = 0;

  double of(RenderingMethod method) const { return methods[static_cast<std::size_t>(method)]; }
};

/// For the picture that `render` makes. Throws as it does.
PictureShares count_methods(const Scene& scene, const Camera& camera, const RenderOptions& options = {});

}  // namespace recede
