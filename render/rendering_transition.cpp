#include <recede/geometry/error.h>
#include <recede/render/rendering_transition.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

double slope(double cosine, const TransitionOptions& options) {
  if (!(options.silhouette > 0)) throw OptionError("the transition along silhouettes is above 0");
  return std::max(cosine, 0.0) + options.silhouette;
}

}  // namespace

double transition_value(double distance, double cosine, const TransitionOptions& options) {
  if (!(distance > 0)) throw OptionError("the distance of a transition is above 0");
  return (1 / distance - options.threshold) / slope(cosine, options);
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
  return reciprocal > 0 ? 1 / reciprocal : std::numeric_limits<double>::infinity();
}

DisplacementMap lowered_below_base(const DisplacementMap& map) {
  double highest = -std::numeric_limits<double>::infinity();
  for (int y = 0; y < map.rows(); ++y) {
    for (int x = 0; x < map.columns(); ++x) highest = std::max(highest, map.texel(x, y));
  }
  if (map.whole_samples().empty()) {
    std::vector<float> heights = map.float_samples();
    const auto most = static_cast<float>(highest);
    for (float& height : heights) height -= most;
    return DisplacementMap(map.columns(), map.rows(), std::move(heights), map.border());
  }
  Raster samples;
  samples.width = map.columns();
  samples.height = map.rows();
  samples.bits = map.bits();
  samples.samples = map.whole_samples();
  return DisplacementMap(std::move(samples), map.scale(), map.offset() - highest, map.border());
}

}  // namespace recede
