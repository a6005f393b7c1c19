// Light from all directions, ready for looking up and for drawing directions by their light.
#pragma once

#include <recede/render/light.h>

namespace recede::detail {

/// The brightest that a light may be: divided by densities of drawn directions it still fits in a float.
inline constexpr float k_most_light = 1e15f;

class EnvironmentMap {
 public:
  /// Throws `OptionError` and `InputError` for what isn't a light.
  explicit EnvironmentMap(const EnvironmentLight& light);

  /// That of the texel, as the drawing of directions has it.
  Rgb radiance(const Vec3& direction) const;
  /// Between the middles of texels, for showing.
  Rgb smooth_radiance(const Vec3& direction) const;

  /// One and the same from everywhere; then drawing by light has no use.
  bool is_constant() const { return constant_; }
  bool is_black() const { return !(total_ > 0); }
  bool is_visible() const { return visible_; }

  struct Sample {
    Vec3 direction;
    double density = 0;  ///< per solid angle
    Rgb radiance;
  };
  /// A direction drawn in proportion to luminance. Not for black environments.
  Sample sample(const Vec2& random) const;
  /// The density with which `sample` draws a direction.
  double density(const Vec3& direction) const;

 private:
  Vec2 place_of(const Vec3& direction) const;
  std::size_t texel_of(const Vec3& direction) const;

  Image image_;
  Vec3 ahead_, right_, up_;
  bool constant_ = true, visible_ = true;
  double total_ = 0;                 // integral of luminance over the sphere
  std::vector<double> row_cosines_;  // of the angles from `up` to the borders of rows
  std::vector<double> luminances_;   // by texel
  std::vector<double> row_sums_;     // of that integral, from the upper row down
  std::vector<double> column_sums_;  // of luminances along each row
};

}  // namespace recede::detail
