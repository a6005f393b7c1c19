// Cells of a shell with a texture in it, and rays through them.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/shells/detail/shell_cell.h>

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

/// Over the face, and the height from 0 to 1.
struct CellPlace : FacePlace {
  double height = 0;
};

struct LayerCell {
  std::uint32_t primitive;
  std::size_t n_corners;  ///< of the face: 3 or 4
  std::array<std::uint32_t, 4> vertices;
  std::array<Vec3, 4> bottoms, directors;
  std::array<Vec2, 4> st;

  Vec3 corner(std::size_t k, double height) const { return bottoms[k] + height * directors[k]; }
  /// Twice the vector area of the face at a height.
  Vec3 normal(double height) const {
    const std::size_t last = n_corners - 1;
    return (corner(n_corners - 2, height) - corner(0, height))
        .cross(corner(last, height) - corner(last - 2, height));
  }
  Vec3 point(const CellPlace& place) const {
    const FaceWeights weights = weights_at(n_corners, place);
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < n_corners; ++k) sum += weights[k] * corner(k, place.height);
    return sum;
  }
  Eigen::Matrix3d jacobian(const CellPlace& place) const {
    const FaceWeights weights = weights_at(n_corners, place);
    const auto [u, v] = weight_steps_at(n_corners, place);
    Eigen::Matrix3d columns = Eigen::Matrix3d::Zero();
    for (std::size_t k = 0; k < n_corners; ++k) {
      const Vec3 at = corner(k, place.height);
      columns.col(0) += u[k] * at;
      columns.col(1) += v[k] * at;
      columns.col(2) += weights[k] * directors[k];
    }
    return columns;
  }
  Vec3 texture(const CellPlace& place) const {
    const FaceWeights weights = weights_at(n_corners, place);
    Vec2 sum = Vec2::Zero();
    for (std::size_t k = 0; k < n_corners; ++k) sum += weights[k] * st[k];
    return {sum.x(), sum.y(), place.height};
  }
  Vec3 texture_step(const CellPlace& place, const Vec3& step) const {
    const auto [u, v] = weight_steps_at(n_corners, place);
    Vec2 sum = Vec2::Zero();
    for (std::size_t k = 0; k < n_corners; ++k) sum += (u[k] * step.x() + v[k] * step.y()) * st[k];
    return {sum.x(), sum.y(), step.z()};
  }
  /// Moves a place to where a ray is, and returns how it goes on: change of u, v and height for a length
  /// of 1.
  Vec3 follow(const VolumeRay& ray, double distance, CellPlace& place) const;
};

/// A part of a ray inside of a cell.
struct CellPassage {
  double from = 0, to = 0;
  CellPlace start;
  enum class Side { wall, border, bottom, top } side = Side::wall;  ///< through which it comes in
};

}  // namespace recede::detail
