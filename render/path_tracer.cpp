#include <recede/render/detail/path_tracer.h>

#include <algorithm>
#include <limits>

namespace recede::detail {

namespace {

constexpr double k_no_surface = std::numeric_limits<double>::infinity();

// From this bounce on paths end by chance; what goes on is worth the more, so that the mean stays.
constexpr int k_sure_bounces = 3;
constexpr double k_least_survival = 0.05;

bool survives(int bounce, const Vec2& random, Rgb& throughput) {
  if (bounce < k_sure_bounces) return true;
  const double chance = std::clamp(static_cast<double>(throughput.maxCoeff()), k_least_survival, 1.0);
  if (random.x() >= chance) return false;
  throughput /= static_cast<float>(chance);
  return true;
}

}  // namespace

// Equation 3.10: a shadow ray to every light.
Rgb PathTracer::drawn_light(const SurfacePoint& point, SampleStream& numbers) const {
  Rgb light = Rgb::Zero();
  const Vec3 start = point.start.cast<double>();
  ArrivingLight arriving;
  for (std::size_t i = 0; i < lights_.count(); ++i) {
    const Vec2 random = lights_.is_spread(i) ? numbers.next_pair() : Vec2(Vec2::Zero());
    if (!lights_.draw(i, start, random, arriving)) continue;
    const Rgb reflected = scattered(point, arriving.toward).cwiseProduct(arriving.radiance);
    if (reflected.isZero(0)) continue;
    if (occluded(scene_, point.ray_towards(arriving.toward, static_cast<float>(arriving.distance)))) continue;
    const double density = scattering_density(point, arriving.toward);
    light += static_cast<float>(lights_.drawn_share(arriving, density)) * reflected;
  }
  return light;
}

// Where a path ends there is only direct light to find, and the ray goes no farther than it.
Rgb PathTracer::last_light(const SurfacePoint& point, const ScatterSample& scatter) const {
  const Vec3 start = point.start.cast<double>();
  const double reach = lights_.reach(start, scatter.direction);
  if (reach == 0) return Rgb::Zero();
  const Ray ray = point.ray_towards(scatter.direction, static_cast<float>(reach));
  if (!lights_.has_areas()) {
    return occluded(scene_, ray) ? Rgb(Rgb::Zero())
                                 : lights_.found(start, scatter.direction, k_no_surface, scatter.density);
  }
  Hit hit;
  const double distance = nearest_hit(scene_, ray, hit) ? static_cast<double>(hit.distance) : k_no_surface;
  return lights_.found(start, scatter.direction, distance, scatter.density);
}

Rgb PathTracer::radiance(const Hit& first, const Vec3f& direction, MethodShares shares,
                         SampleStream& numbers) const {
  const int bounces = options_.transport == LightTransport::path ? options_.max_bounces : 0;
  Rgb light = Rgb::Zero(), throughput = Rgb::Ones();
  Hit hit = first;
  Vec3f along = direction;
  for (int bounce = 0;; ++bounce) {
    SurfacePoint point = surface_point(scene_, hit, along, shares);
    point.passes_on = bounces > 0;
    // Equation 3.13.
    if (options_.transport == LightTransport::direct)
      light += static_cast<float>(lights_.ambient()) * point.albedo;
    light += throughput.cwiseProduct(drawn_light(point, numbers));

    ScatterSample scatter;
    if (!sample_scattering(point, numbers.next_pair(), scatter)) break;
    throughput = throughput.cwiseProduct(scatter.weight);
    if (throughput.isZero(0)) break;
    const Vec3 start = point.start.cast<double>();
    if (bounce == bounces) {
      light += throughput.cwiseProduct(last_light(point, scatter));
      break;
    }
    const bool met = nearest_hit(scene_, point.ray_towards(scatter.direction), hit);
    const double distance = met ? static_cast<double>(hit.distance) : k_no_surface;
    light += throughput.cwiseProduct(lights_.found(start, scatter.direction, distance, scatter.density));
    if (!met || !survives(bounce, numbers.next_pair(), throughput)) break;
    along = scatter.direction.cast<float>();
    if (shares.is_on_base()) shares.table = 1;
  }
  return light;
}

}  // namespace recede::detail
