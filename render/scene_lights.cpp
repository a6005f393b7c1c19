#include <recede/geometry/error.h>
#include <recede/render/camera.h>
#include <recede/render/detail/scene_lights.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace recede {

Lighting daylight(const Vec3& up) {
  if (!(up.norm() > 0) || !up.allFinite()) throw OptionError("daylight needs a direction that points up");
  const Vec3 y = up.normalized(), front = front_of(y), right = y.cross(front);
  constexpr double k_degree = std::numbers::pi / 180;
  Lighting lighting;
  lighting.directionals.push_back({.toward = 0.7 * front - right + 1.2 * y,
                                   .irradiance = Rgb(2.6f, 2.45f, 2.25f),
                                   .angular_radius = 2.5 * k_degree});
  // Bright above, darker below the horizon.
  constexpr int k_rows = 16;
  const Rgb zenith(0.24f, 0.3f, 0.4f), horizon(0.42f, 0.44f, 0.46f), below(0.18f, 0.18f, 0.18f);
  Image sky(1, k_rows);
  for (int row = 0; row < k_rows; ++row) {
    const float down = (static_cast<float>(row) + 0.5f) / (k_rows / 2);
    sky.at(0, row) = down < 1 ? Rgb(zenith + down * (horizon - zenith)) : below;
  }
  lighting.environment = EnvironmentLight{.radiance = std::move(sky), .up = y, .visible = false};
  return lighting;
}

namespace detail {

namespace {

// Of the way to a light or a surface: a light that lies in a surface is neither hidden nor lost by rounding.
constexpr double k_coincident = 1e-5;

// The square of the least distance to a point light, in the scaled scene: rays start this far off surfaces at
// least, and infinite light would spoil a picture.
constexpr double k_least_squared_distance = 1e-16;

// More light of one sample than that could overflow float where several come together.
constexpr double k_most_arriving = 1e30;

void require_light(const Rgb& color, const std::string& what) {
  if (!color.allFinite() || color.minCoeff() < 0 || color.maxCoeff() > k_most_light)
    throw OptionError(what + " lies between 0 and 1e15");
}

void require_direction(const Vec3& direction, const std::string& what) {
  if (!direction.allFinite() || !(direction.stableNorm() > 0))
    throw OptionError(what + " must be finite and not 0");
}

}  // namespace

double share_of(double density, double other_density) {
  const double ratio = other_density / density;
  return 1 / (1 + ratio * ratio);
}

SceneLights::SceneLights(const Lighting& lighting, const SceneData& scene, LightSampling sampling)
    : sampling_(sampling), ambient_(lighting.ambient) {
  if (!(ambient_ >= 0) || !std::isfinite(ambient_))
    throw OptionError("the ambient light is a number from 0 on");
  for (const PointLight& light : lighting.points) {
    require_light(light.intensity, "the intensity of a point light");
    if (!light.position.allFinite()) throw OptionError("the position of a point light must be finite");
    // Distances grow by the scale, and intensities must with their square, which float may not hold.
    points_.push_back(
        {scene.scaled(light.position), scene.scale * scene.scale * light.intensity.cast<double>()});
  }
  for (const DirectionalLight& light : lighting.directionals) {
    require_light(light.irradiance, "the irradiance of a directional light");
    require_direction(light.toward, "the direction of a directional light");
    if (!(light.angular_radius >= 0 && light.angular_radius < std::numbers::pi / 2))
      throw OptionError("the angular radius of a directional light lies between 0 and pi/2 radians");
    const Vec3 toward = light.toward.stableNormalized(), across = toward.unitOrthogonal();
    const double half_sine = std::sin(light.angular_radius / 2);
    directionals_.push_back(
        {toward, across, toward.cross(across), light.irradiance, 2 * half_sine * half_sine});
  }
  for (const AreaLight& light : lighting.areas) {
    require_light(light.radiance, "the radiance of an area light");
    const Vec3 first = light.first_edge * scene.scale, second = light.second_edge * scene.scale;
    const Vec3 normal = first.cross(second);
    const double area = normal.norm();
    if (!light.corner.allFinite() || !std::isfinite(area) || !(area > 0))
      throw OptionError("an area light needs a finite corner and two edges that span an area");
    areas_.push_back(
        {scene.scaled(light.corner), first, second, normal / area, area, light.radiance, light.two_sided});
  }
  if (lighting.environment) environment_.emplace(*lighting.environment);
}

bool SceneLights::is_spread(std::size_t light) const {
  if (light < points_.size()) return false;
  light -= points_.size();
  return light >= directionals_.size() || directionals_[light].widest > 0;
}

bool SceneLights::draw(std::size_t light, const Vec3& place, const Vec2& random,
                       ArrivingLight& arriving) const {
  if (light < points_.size()) {
    const Point& point = points_[light];
    const Vec3 way = point.position - place;
    const double squared = way.squaredNorm();
    if (!(squared > 0)) return false;
    const double distance = std::sqrt(squared);
    const Vec3 irradiance = point.intensity / std::max(squared, k_least_squared_distance);
    arriving = {way / distance, distance * (1 - k_coincident),
                irradiance.cwiseMin(k_most_arriving).cast<float>()};
    return true;
  }
  light -= points_.size();
  if (light < directionals_.size()) {
    const Directional& sun = directionals_[light];
    // Evenly over the disc's solid angle; its radiance is such that a surface which faces the middle has the
    // irradiance that was asked for: over the density, 2 / (1 + cosine of the radius) times that.
    const double below = random.x() * sun.widest, angle = 2 * std::numbers::pi * random.y();
    const double off = std::sqrt(below * (2 - below));
    const Vec3 toward =
        (1 - below) * sun.toward + off * (std::cos(angle) * sun.across + std::sin(angle) * sun.along);
    arriving = {toward.normalized(), std::numeric_limits<double>::infinity(),
                static_cast<float>(2 / (2 - sun.widest)) * sun.irradiance};
    return true;
  }
  light -= directionals_.size();
  if (sampling_ == LightSampling::surface) return false;
  return light < areas_.size() ? draw_area(areas_[light], place, random, arriving)
                               : draw_environment(random, arriving);
}

// Evenly over the rectangle (equation 3.11 over the density of 1 / area).
bool SceneLights::draw_area(const Area& area, const Vec3& place, const Vec2& random,
                            ArrivingLight& arriving) const {
  const Vec3 way = area.corner + random.x() * area.first + random.y() * area.second - place;
  const double squared = way.squaredNorm();
  if (!(squared > 0)) return false;
  const double distance = std::sqrt(squared), cosine = -area.normal.dot(way) / distance;
  if (area.two_sided ? cosine == 0 : !(cosine > 0)) return false;
  const double density = squared / (area.area * std::abs(cosine));
  arriving = {way / distance, distance * (1 - k_coincident), static_cast<float>(1 / density) * area.radiance,
              density};
  return true;
}

bool SceneLights::draw_environment(const Vec2& random, ArrivingLight& arriving) const {
  if (!environment_ || environment_->is_black()) return false;
  if (environment_->is_constant() && sampling_ == LightSampling::both) return false;
  const EnvironmentMap::Sample sample = environment_->sample(random);
  arriving = {sample.direction, std::numeric_limits<double>::infinity(),
              static_cast<float>(1 / sample.density) * sample.radiance, sample.density};
  return true;
}

double SceneLights::drawn_share(const ArrivingLight& arriving, double scattering_density) const {
  if (arriving.density == 0 || sampling_ == LightSampling::lights) return 1;
  return share_of(arriving.density, scattering_density);
}

double SceneLights::found_share(double density, double scattering_density) const {
  return sampling_ == LightSampling::surface ? 1.0 : share_of(scattering_density, density);
}

bool SceneLights::meet(const Area& area, const Vec3& origin, const Vec3& direction, double& distance,
                       double& density) {
  const double cosine = -area.normal.dot(direction);
  if (area.two_sided ? cosine == 0 : !(cosine > 0)) return false;
  distance = area.normal.dot(origin - area.corner) / cosine;
  if (!(distance > 0)) return false;
  // In the parallelogram's own coordinates.
  const Vec3 place = origin + distance * direction - area.corner;
  const double along_first = area.normal.dot(place.cross(area.second)) / area.area;
  const double along_second = area.normal.dot(area.first.cross(place)) / area.area;
  if (!(along_first >= 0 && along_first <= 1 && along_second >= 0 && along_second <= 1)) return false;
  density = distance * distance / (area.area * std::abs(cosine));
  return true;
}

double SceneLights::reach(const Vec3& origin, const Vec3& direction) const {
  if (sampling_ == LightSampling::lights) return 0;
  if (environment_ && !environment_->is_black()) return std::numeric_limits<double>::infinity();
  double farthest = 0, distance, density;
  for (const Area& area : areas_) {
    if (meet(area, origin, direction, distance, density)) farthest = std::max(farthest, distance);
  }
  return farthest;
}

Rgb SceneLights::found(const Vec3& origin, const Vec3& direction, double distance,
                       double scattering_density) const {
  Rgb light = Rgb::Zero();
  if (sampling_ == LightSampling::lights) return light;
  double at, density;
  for (const Area& area : areas_) {
    if (!meet(area, origin, direction, at, density) || at * (1 - k_coincident) > distance) continue;
    light += static_cast<float>(found_share(density, scattering_density)) * area.radiance;
  }
  if (environment_ && std::isinf(distance)) {
    const bool alone = environment_->is_constant() && sampling_ == LightSampling::both;
    const double share = alone ? 1.0 : found_share(environment_->density(direction), scattering_density);
    light += static_cast<float>(share) * environment_->radiance(direction);
  }
  return light;
}

Rgb SceneLights::seen(const Vec3& origin, const Vec3& direction, double distance) const {
  Rgb light = Rgb::Zero();
  double at, density;
  for (const Area& area : areas_) {
    if (meet(area, origin, direction, at, density) && at * (1 - k_coincident) <= distance)
      light += area.radiance;
  }
  return light;
}

std::optional<Rgb> SceneLights::seen_environment(const Vec3& direction) const {
  if (!environment_ || !environment_->is_visible()) return std::nullopt;
  return environment_->smooth_radiance(direction);
}

}  // namespace detail
}  // namespace recede
