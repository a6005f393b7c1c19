// Rays from a camera into a scene.
#pragma once

#include <recede/render/camera.h>
#include <recede/render/detail/tracing.h>

#include <array>

namespace recede::detail {

class CameraRays {
 public:
  /// The scene must live as long as this. Throws `OptionError` as `frame_of` does.
  CameraRays(const SceneData& scene, const Camera& camera);

  /// Where in its pixel each lane's ray goes through, (0, 0) to (1, 1).
  using Places = std::array<Vec2, k_lanes>;

  /// Rays through the pixels of the block whose upper left one is (left, top). Lanes outside the image, and
  /// whose rays miss the scene's sphere, stay idle.
  void aim(int left, int top, const Places& places, RayPacket& packet) const;

  const CameraFrame& frame() const { return frame_; }
  const Vec3& eye() const { return eye_; }  ///< in the scaled scene
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  const SceneData& scene_;
  CameraFrame frame_;
  Vec3 eye_;
  Vec3 upper_left_, column_step_, row_step_;  // of the image on the plane at distance 1
  int width_, height_;
};

/// Lane of a block's pixel, row by row.
inline int column_of(int lane) { return lane % k_packet_side; }
inline int row_of(int lane) { return lane / k_packet_side; }
inline std::size_t lane_of(int x, int y) {
  return static_cast<std::size_t>(y % k_packet_side * k_packet_side + x % k_packet_side);
}

}  // namespace recede::detail
