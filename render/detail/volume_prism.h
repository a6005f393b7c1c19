// A prism of a shell with a texture in it, and rays through it.
#pragma once

#include <recede/geometry/vec.h>

#include <array>
#include <bit>
#include <cstdint>

namespace recede::detail {

/// In the scaled scene.
struct VolumeRay {
  Vec3 origin, direction;
  std::uint64_t key;  ///< differs from ray to ray

  VolumeRay(const Eigen::Vector3f& from, const Eigen::Vector3f& along)
      : origin(from.cast<double>()), direction(along.cast<double>()), key(key_of(from, along)) {}

  Vec3 at(double distance) const { return origin + distance * direction; }

 private:
  static std::uint64_t key_of(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction) {
    std::uint64_t key = 0;
    for (int k = 0; k < 3; ++k) {
      key = (key ^ std::bit_cast<std::uint32_t>(origin[k])) * 0x100000001b3ull;
      key = (key ^ std::bit_cast<std::uint32_t>(direction[k])) * 0x100000001b3ull;
      key ^= key >> 29;
    }
    return key;
  }
};

/// Weights of the triangle's second and third corner, and the height from 0 to 1.
struct PrismPlace {
  double u = 0, v = 0, height = 0;
};

struct VolumePrism {
  std::uint32_t primitive;
  std::array<std::uint32_t, 3> vertices;
  std::array<Vec3, 3> bottoms, directors;
  Vec2 st, st_u, st_v;  ///< at the first corner, and from there to the others

  Vec3 corner(std::size_t k, double height) const { return bottoms[k] + height * directors[k]; }
  Vec3 point(const PrismPlace& place) const {
    const double first = 1 - place.u - place.v;
    return first * corner(0, place.height) + place.u * corner(1, place.height) +
           place.v * corner(2, place.height);
  }
  Eigen::Matrix3d jacobian(const PrismPlace& place) const {
    const Vec3 origin = corner(0, place.height);
    Eigen::Matrix3d columns;
    columns << corner(1, place.height) - origin, corner(2, place.height) - origin,
        (1 - place.u - place.v) * directors[0] + place.u * directors[1] + place.v * directors[2];
    return columns;
  }
  Vec3 texture(const PrismPlace& place) const {
    const Vec2 at = st + place.u * st_u + place.v * st_v;
    return {at.x(), at.y(), place.height};
  }
  Vec3 texture_step(const Vec3& step) const {
    const Vec2 along = step.x() * st_u + step.y() * st_v;
    return {along.x(), along.y(), step.z()};
  }
  /// Moves a place to where a ray is, and returns how it goes on: change of u, v and height for a length
  /// of 1.
  Vec3 follow(const VolumeRay& ray, double distance, PrismPlace& place) const;
};

/// A part of a ray inside of a prism.
struct PrismPassage {
  double from = 0, to = 0;
  PrismPlace start;
  enum class Side { wall, border, bottom, top } side = Side::wall;  ///< through which it comes in
};

}  // namespace recede::detail
