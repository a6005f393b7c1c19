// Lines along the sides of polygons.
#pragma once

#include <recede/render/detail/tracing.h>
#include <recede/render/renderer.h>

namespace recede::detail {

/// Factor of the light where a ray hits: 1 off lines, less on them. `pixel` is the side of a pixel there, in
/// the scaled scene.
float line_factor(const MeshData& mesh, const Wireframe& wireframe, const Hit& hit, const Vec3f& direction,
                  float pixel);

}  // namespace recede::detail
