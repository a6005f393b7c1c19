// Rays for displaced surfaces.
#pragma once

#include <recede/geometry/vec.h>

#include <embree3/rtcore.h>

#include <limits>
#include <random>

namespace recede::bench {

struct Ray {
  Eigen::Vector3f origin, direction;
};

inline Vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

inline RTCRayHit embree_ray(const Ray& ray) {
  RTCRayHit hit{};
  hit.ray.org_x = ray.origin.x();
  hit.ray.org_y = ray.origin.y();
  hit.ray.org_z = ray.origin.z();
  hit.ray.dir_x = ray.direction.x();
  hit.ray.dir_y = ray.direction.y();
  hit.ray.dir_z = ray.direction.z();
  hit.ray.tfar = std::numeric_limits<float>::infinity();
  hit.ray.mask = 0xffffffffu;
  hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  return hit;
}

}  // namespace recede::bench
