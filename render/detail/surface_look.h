// Colours and normals of a model as pictures show it.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/render/image.h>

#include <vector>

namespace recede::detail {

/// Light grey for faces without a material, as `Material` has it; white under vertex colours, which then say
/// it all.
Rgb face_color(const PolygonSoup& soup, Index face);

/// For each corner, its own normal or the computed one, unit, on the front of its face: shading turns normals
/// by the side that is seen.
std::vector<Vec3> drawn_normals(const PolygonSoup& soup, double crease_angle);

}  // namespace recede::detail
