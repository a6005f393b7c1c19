// The torus of the tables on transitions, and pictures of it.
#pragma once

#include <recede/render/appearance.h>
#include <recede/render/method_shares.h>

#include <optional>

namespace recede::bench {

/// A torus of 4608 quads (radii 1 and 0.4, around z) with 60 x 25 copies of a map of 64 x 64 texels, forty
/// waves of up to four to a side; the highest crest is 0.005 above the mean.
struct TransitionScene {
  explicit TransitionScene(const AppearanceOptions& options = {});

  PolygonSoup base;
  DisplacementMap map;
  std::shared_ptr<const Appearance> appearance;
  Scene scene;  ///< with the appearance
  Scene bare;   ///< the base alone

  /// Flat, with as steep waves: 16 x 16 copies of the map over the square from -1 to 1.
  Scene plane() const;

  /// The distance at which a wave covers two pixels of this camera.
  double two_pixels(const Camera& camera) const;
};

/// As the appearance's distance goes with the pixel, one picture shows a place from many times that distance
/// or from a share of it, if only its pixels are small enough: from `distance` in its units, the whole torus.
Camera camera_at(const TransitionScene& scene, double distance, int size);
/// Along the surface, from near by; what is farthest is `farthest` of those units away.
Camera camera_along(const TransitionScene& scene, double farthest, int size);

struct DrawnBy {
  Representation representation = Representation::automatic;
  int samples = 4;
  std::optional<TransitionOptions> transition = {};
};
Image draw(const Scene& scene, const Camera& camera, const DrawnBy& by);

/// How a plane is looked at and lit.
struct PlaneView {
  Representation representation = Representation::automatic;
  double view = 0, light = 0;  ///< degrees off its normal; the light stands a quarter around from the viewer
  bool paths = false;          ///< else direct light alone
  std::optional<double> grown{};  ///< the share of the displacement that `automatic` has
};
/// The mean over viewers all around it, of albedo 0.7 under one sun.
double plane_brightness(const Scene& plane, const PlaneView& view);

}  // namespace recede::bench
