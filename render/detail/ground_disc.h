// The floor under the models of a scene.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/render/scene.h>

#include <span>

namespace recede::detail {

/// A disc that touches the models, which are their points, from below. Throws `OptionError` when `ground.up`
/// has no direction.
PolygonSoup ground_disc(std::span<const std::span<const Vec3>> models, const Ground& ground);

}  // namespace recede::detail
