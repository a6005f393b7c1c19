// Where a picture shows its scene, and where the background.
#pragma once

#include <recede/geometry/exr.h>
#include <recede/render/renderer.h>

namespace recede {

/// The share of each pixel that the scene covers, 0 to 1, of the picture that `render` makes with these
/// options. Transparent matter covers as much as it hides. Light, wireframe and noise limit count for
/// nothing; samples are at most 1024 a pixel. Throws what `render` throws.
FloatRaster render_coverage(const Scene& scene, const Camera& camera, const RenderOptions& options = {},
                            Progress* progress = nullptr);

/// A picture whose sRGB-encoded grey is the raster's value: what `mask_of` takes.
Image mask_picture(const FloatRaster& coverage);

}  // namespace recede
