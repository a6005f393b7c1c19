#include <recede/render/detail/camera_rays.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {

CameraRays::CameraRays(const SceneData& scene, const Camera& camera)
    : scene_(scene),
      frame_(frame_of(camera)),
      eye_(scene.scaled(camera.position)),
      width_(camera.width),
      height_(camera.height) {
  column_step_ = frame_.pixel * frame_.right;
  row_step_ = -frame_.pixel * frame_.up;
  upper_left_ = frame_.forward - frame_.middle.x() * column_step_ - frame_.middle.y() * row_step_;
}

// Rays start where they enter the sphere around the scene: from there on, float holds the scaled scene well,
// however far the camera.
void CameraRays::aim(int left, int top, const Places& places, RayPacket& packet) const {
  for (int lane = 0; lane < k_lanes; ++lane) {
    const int x = left + column_of(lane), y = top + row_of(lane);
    const Vec2& place = places[static_cast<std::size_t>(lane)];
    const Vec3 through = upper_left_ + (x + place.x()) * column_step_ + (y + place.y()) * row_step_;
    const Vec3 direction = through * (1 / std::sqrt(through.squaredNorm()));
    const double along = -eye_.dot(direction);
    const double squared_gap = (eye_ + along * direction).squaredNorm();
    const double half_chord_squared = scene_.radius * scene_.radius - squared_gap;
    const double half_chord = std::sqrt(std::max(0.0, half_chord_squared));
    const bool meets = half_chord_squared > 0 && along + half_chord > 0 && x < width_ && y < height_;
    packet.active[lane] = meets ? -1 : 0;
    const double entry = std::max(0.0, along - half_chord);
    const Vec3f origin = (eye_ + entry * direction).cast<float>();
    packet.entry[lane] = static_cast<float>(entry);
    packet.directions[lane] = direction.cast<float>();
    RTCRay16& ray = packet.rays.ray;
    ray.org_x[lane] = origin.x();
    ray.org_y[lane] = origin.y();
    ray.org_z[lane] = origin.z();
    ray.dir_x[lane] = packet.directions[lane].x();
    ray.dir_y[lane] = packet.directions[lane].y();
    ray.dir_z[lane] = packet.directions[lane].z();
    ray.tnear[lane] = 0;
    ray.tfar[lane] = std::numeric_limits<float>::infinity();
    ray.time[lane] = 0;
    ray.mask[lane] = 0xffffffffu;
    ray.id[lane] = static_cast<unsigned>(lane);
    ray.flags[lane] = 0;
    packet.rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

}  // namespace recede::detail
