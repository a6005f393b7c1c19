// The mean reflectance of the facets of a displaced surface, with those that hide and shade each other.
#pragma once

#include <recede/render/facet_distribution.h>

namespace recede {

/// How each facet scatters light: an even part, and a part by micro-facets of the distribution GGX (Walter,
/// Marschner, Li and Torrance 2007), whose masking is Smith's, with Schlick's Fresnel term.
struct FacetMaterial {
  double albedo = 0.5;               ///< of the even part, 0 to 1
  double roughness = 0.2;            ///< alpha of GGX, greater than 0 and at most 1
  double normal_reflectance = 0.04;  ///< of micro-facets, for light along their normal; 0 to 1
  double reflection = 1;             ///< how much the part of the micro-facets counts, 0 to 1
};

/// Reflected radiance over the irradiance of the plane through the facets, whose normal is (-mean slope, 1).
/// The unit vectors are in the frame of the slopes; 0 for those below this plane.
///
/// The facets that look to a viewer have together more area than the plane shows him, so parts of them are
/// hidden. All are taken to lose the same share, by which just the plane's area is left (Smith 1967, with the
/// facets themselves instead of a model of them: Heitz 2014, equation 11), and what is hidden from the viewer
/// and from the light is taken to depend on heights alike (Heitz 2014, equation 99). Light goes from facet to
/// viewer at once, not from facet to facet. So the result doesn't change when light and viewer change places,
/// and no more leaves than arrives as long as that holds for the facets.
///
/// A group with a spread counts as four facets around its mean, and gloss on these is widened by what is left
/// of the spread, as in LEAN mapping (Olano and Baker 2010) but inside of a group. Material and vectors
/// aren't checked.
double filtered_reflectance(const FacetDistribution& facets, const Vec3& toward_viewer,
                            const Vec3& toward_light, const FacetMaterial& material = {});

}  // namespace recede
