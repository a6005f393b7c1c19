// Which representation of a surface a view needs: geometry, bump map or BRDF.
//
// Becker and Max 1993, "Smooth transitions between bump rendering algorithms"; Ramsey's dissertation on
// displaced levels of detail, its chapter on transitions, with its corrected signs.
#pragma once

#include <recede/geometry/displacement_map.h>

namespace recede {

enum class RenderingMethod { brdf, brdf_to_bump, bump, bump_to_displacement, displacement };

struct TransitionOptions {
  /// D: the reciprocal of the distance (object units) around which the methods change. Larger: cheaper
  /// methods.
  double threshold = 1;
  /// Keeps the transition gradual along silhouettes; the source names no value.
  double silhouette = 0.1;
};

/// T = (1 / d - D) / (cos theta + silhouette) for the distance `d` from the eye, object units, above 0, and
/// the cosine of the angle between surface and view, taken as 0 when it is below.
double transition_value(double distance, double cosine, const TransitionOptions& options = {});

/// What a value of T asks for, and how far a transition went: from 0 to 1 within `brdf_to_bump` (the share of
/// the bump map's intensity) and `bump_to_displacement` (the share of the displacement), linear in T; else 0.
struct RenderingTransition {
  RenderingMethod method = RenderingMethod::displacement;
  double progress = 0;
};
RenderingTransition rendering_transition(double value);
inline constexpr double k_transition_values[4] = {-1, -0.3, 0.3, 1};  ///< of T, between the five methods

/// The distance at which T has a value, object units; infinite when it is nowhere so small.
double transition_distance(double value, double cosine, const TransitionOptions& options = {});

/// The map with its heights lowered so that the largest is 0: what is displaced lies within its base, which a
/// ray must meet first. Floats stay floats, whole samples whole.
DisplacementMap lowered_below_base(const DisplacementMap& map);

}  // namespace recede
