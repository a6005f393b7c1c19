// The lights of a scene, ready for sampling.
#pragma once

#include <recede/render/detail/environment_map.h>
#include <recede/render/detail/scene_data.h>
#include <recede/render/light.h>
#include <recede/render/renderer.h>

#include <limits>
#include <optional>
#include <vector>

namespace recede::detail {

/// Light that reaches a place from one direction, unless something is in the way. Lengths of the scaled
/// scene.
struct ArrivingLight {
  Vec3 toward;  ///< the light, unit
  double distance = std::numeric_limits<double>::infinity();
  Rgb radiance;        ///< over the density; for light without a density, its irradiance across `toward`
  double density = 0;  ///< per solid angle with which `toward` was drawn; 0: no other way finds this light
};

/// What share of the sum of two ways to find the same light the first one gets, by the densities with which
/// they draw its direction: the power heuristic with the exponent 2 (Veach and Guibas 1995, "Optimally
/// combining sampling techniques for Monte Carlo rendering").
double share_of(double density, double other_density);

class SceneLights {
 public:
  /// Throws `OptionError` and `InputError` for lights that can't be.
  SceneLights(const Lighting& lighting, const SceneData& scene, LightSampling sampling);

  std::size_t count() const { return points_.size() + directionals_.size() + areas_.size() + 1; }
  /// Whether the light takes random numbers; always the same for one light.
  bool is_spread(std::size_t light) const;

  /// Draws a direction towards the light as seen from a place. False: no light comes from there, or it is
  /// left to rays that the surface scatters.
  bool draw(std::size_t light, const Vec3& place, const Vec2& random, ArrivingLight& arriving) const;

  /// The share of what `draw` drew beside rays that the surface scatters with this density.
  double drawn_share(const ArrivingLight& arriving, double scattering_density) const;

  /// How far along a ray there are lights that such rays find: infinite for an environment, 0 for none.
  double reach(const Vec3& origin, const Vec3& direction) const;

  /// The light that a ray finds which was drawn with `scattering_density`, up to the surface at `distance`
  /// (infinite: none). Each light counts by its share beside `draw`.
  Rgb found(const Vec3& origin, const Vec3& direction, double distance, double scattering_density) const;

  /// What a camera sees of rectangles in front of the surface at `distance`.
  Rgb seen(const Vec3& origin, const Vec3& direction, double distance) const;
  /// What a camera sees where there is no surface. Nothing: the picture's background.
  std::optional<Rgb> seen_environment(const Vec3& direction) const;

  bool has_areas() const { return !areas_.empty(); }
  double ambient() const { return ambient_; }

 private:
  struct Point {
    Vec3 position, intensity;
  };
  struct Directional {
    Vec3 toward, across, along;  // orthonormal
    Rgb irradiance;
    double widest = 0;  // 1 - cosine of the angular radius
  };
  struct Area {
    Vec3 corner, first, second, normal;
    double area = 0;
    Rgb radiance;
    bool two_sided = false;
  };
  // Where a ray meets a rectangle from a side that shines.
  static bool meet(const Area& area, const Vec3& origin, const Vec3& direction, double& distance,
                   double& density);
  bool draw_area(const Area& area, const Vec3& place, const Vec2& random, ArrivingLight& arriving) const;
  bool draw_environment(const Vec2& random, ArrivingLight& arriving) const;
  double found_share(double density, double scattering_density) const;

  std::vector<Point> points_;
  std::vector<Directional> directionals_;
  std::vector<Area> areas_;
  std::optional<EnvironmentMap> environment_;
  LightSampling sampling_;
  double ambient_ = 0;
};

}  // namespace recede::detail
