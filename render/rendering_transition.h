// Which representation of a surface a view needs: geometry, bump map or BRDF.
//
// Becker and Max 1993, "Smooth transitions between bump rendering algorithms"; Ramsey's dissertation on
// displaced levels of detail, its chapter on transitions, with its corrected signs.
#pragma once

namespace recede {

enum class RenderingMethod { brdf, brdf_to_bump, bump, bump_to_displacement, displacement };

struct TransitionOptions {
  /// The length in which distances are measured, object units. T is the same for a model and its larger copy
  /// whose unit is as much larger.
  double unit = 1;
  /// D: the reciprocal of the distance, in units, around which the methods change. Larger: cheaper methods.
  double threshold = 1;
  /// Keeps the transition gradual along silhouettes; the source names no value.
  double silhouette = 0.1;
};

/// T = (unit / d - D) / (cos theta + silhouette) for the distance `d` from the eye, object units, above 0,
/// and the cosine of the angle between surface and view, taken as 0 when it is below.
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

/// Methods change around a distance, object units, 0 or more. With D = 2 in half of it, all five have a
/// place: seen straight, displacement ends at 0.65 of it, the bump map begins at 0.86 and ends at 1.2, and
/// from 2.2 of it on there is the table alone. Throws `OptionError`.
TransitionOptions transition_around(double distance);

/// Around the distance at which a wave of heights of the given length (object units, 0: flat) covers two
/// pixels, which are `pixel` wide at the distance 1: what is shorter can't be told apart.
TransitionOptions transition_for_wavelength(double wavelength, double pixel);

}  // namespace recede
