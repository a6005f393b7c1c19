// The construction that billboard clouds began with, for comparison.
#pragma once

#include <recede/lod/billboard_cloud.h>

namespace recede::bench {

struct HoughOptions {
  std::size_t around = 64, upwards = 32;  ///< cells of directions
  double penalty = 10;                    ///< of the area that a plane only just misses
  /// How far beyond the error a face counts as missed, as a share of the error.
  double missed_reach = 1;
};

/// Planes from a grid over directions and distances from the middle of the model's box: the densest cell
/// next, refined until its middle is near to all faces that made it dense (X. Decoret et al.: Billboard
/// Clouds for Extreme Model Simplification. SIGGRAPH 2003; J. Meseth: Towards Predictive Rendering in Virtual
/// Reality. Dissertation, Bonn 2008, section 7.1). Each plane gets one rectangle around all of the model
/// within `error` of it, units of the model; each face counts to the first plane that takes it, and either
/// side is its front. Throws `InputError` where no face has an area, or one isn't flat within the error.
BillboardCloud hough_billboards(const PolygonSoup& model, double error, const HoughOptions& options = {});

}  // namespace recede::bench
