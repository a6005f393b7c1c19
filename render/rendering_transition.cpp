#include <recede/geometry/error.h>
#include <recede/render/rendering_transition.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

double slope(double cosine, const TransitionOptions& options) {
  if (!(options.silhouette > 0)) throw OptionError("the transition along silhouettes is above 0");
  if (!(options.unit >= 0) || !std::isfinite(options.unit) || !std::isfinite(options.threshold))
    throw OptionError("unit and threshold of a transition are finite numbers, the unit not below 0");
  return std::max(cosine, 0.0) + options.silhouette;
}

}  // namespace

double transition_value(double distance, double cosine, const TransitionOptions& options) {
  if (!(distance > 0)) throw OptionError("the distance of a transition is above 0");
  return (options.unit / distance - options.threshold) / slope(cosine, options);
}

RenderingTransition rendering_transition(double value) {
  const auto& [e1, e2, e3, e4] = k_transition_values;
  if (value < e1) return {RenderingMethod::brdf, 0};
  if (value < e2) return {RenderingMethod::brdf_to_bump, (value - e1) / (e2 - e1)};
  if (value < e3) return {RenderingMethod::bump, 0};
  if (value <= e4) return {RenderingMethod::bump_to_displacement, (value - e3) / (e4 - e3)};
  return {RenderingMethod::displacement, 0};
}

double transition_distance(double value, double cosine, const TransitionOptions& options) {
  const double reciprocal = options.threshold + value * slope(cosine, options);
  return reciprocal > 0 ? options.unit / reciprocal : std::numeric_limits<double>::infinity();
}

TransitionOptions transition_around(double distance) {
  if (!(distance >= 0) || !std::isfinite(distance))
    throw OptionError("the distance at which methods change is finite and not below 0");
  constexpr double k_threshold = 2;
  return {.unit = k_threshold * distance, .threshold = k_threshold};
}

TransitionOptions transition_for_wavelength(double wavelength, double pixel) {
  if (!(pixel > 0)) throw OptionError("pixels have a size");
  constexpr double k_pixels = 2;
  return transition_around(wavelength / (k_pixels * pixel));
}

}  // namespace recede
