// What others put in the place of a relief's mean reflectance, from its slopes alone.
#pragma once

#include <recede/render/filtered_reflectance.h>

#include <functional>
#include <string>
#include <vector>

namespace recede::bench {

/// A facet's reflectance for light and viewer, by `FacetMaterial`; 0 behind it. `normal` has unit length.
double facet_reflectance(const Vec3& normal, const Vec3& toward_viewer, const Vec3& toward_light,
                         const FacetMaterial& material);

/// Mean radiance of a level surface under light whose irradiance, square to its direction, is 1.
struct ReflectanceFilter {
  std::string name;
  std::string label{};    ///< in plots; empty: not there
  std::size_t bytes = 0;  ///< of what it keeps of the slopes; single floats but for bins and all slopes
  std::function<double(const Vec3& toward_viewer, const Vec3& toward_light, const FacetMaterial& material)>
      radiance;
};

/// Of a map over a square with sides of 1: the mean normal; Toksvig (2005); Gaussian slopes without and with
/// what hides and shades, as LEAN (Olano and Baker 2010) and LEADR (Dupuy et al. 2013) have them; 8 x 8 bins
/// of slopes with their means as doubles; all slopes, four a texel; and ours.
std::vector<ReflectanceFilter> reflectance_filters(const DisplacementMap& map);

}  // namespace recede::bench
