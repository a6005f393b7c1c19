// Normals for smooth shading of surfaces that bring none.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <vector>

namespace recede {

/// Up to which edges are smooth where nothing else is said: in pictures, and in normals for maps. 40 degrees.
inline constexpr double k_crease_angle = 0.698131700797732;

/// A unit normal for every corner of the soup: the mean, weighted by corner angles, of the normals of those
/// faces that can be reached around the vertex across edges with two consistently oriented faces whose
/// normals differ by at most `crease_angle` (radians). (0,0,0) where these faces have no area.
std::vector<Vec3> shading_normals(const PolygonSoup& soup, double crease_angle);

}  // namespace recede
