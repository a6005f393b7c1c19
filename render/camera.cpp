#include <recede/geometry/error.h>
#include <recede/render/camera.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace recede {

Vec3 CameraFrame::direction(double x, double y) const {
  const Vec3 along = forward + (x - middle.x()) * pixel * right - (y - middle.y()) * pixel * up;
  return along.normalized();
}

namespace {

void check_size(int width, int height) {
  if (width < 1 || height < 1) throw OptionError("a camera's image needs at least one pixel a side");
}

}  // namespace

CameraFrame frame_of(const Camera& camera) {
  if (!(camera.field_of_view > 0) || !(camera.field_of_view < std::numbers::pi)) {
    throw OptionError("a camera's field of view lies between 0 and pi radians");
  }
  check_size(camera.width, camera.height);
  const Vec3 view = camera.target - camera.position;
  const double distance = view.norm();
  if (!(distance > 0) || !std::isfinite(distance)) {
    throw OptionError("a camera's position and target must be finite and apart");
  }
  CameraFrame frame;
  frame.position = camera.position;
  frame.forward = view / distance;
  const Vec3 right = frame.forward.cross(camera.up);
  // Below this sine the view runs along `up`, and the image has no upright of its own.
  constexpr double k_parallel = 1e-9;
  const bool upright = right.norm() > k_parallel * camera.up.norm();
  frame.right = upright ? right.normalized() : frame.forward.unitOrthogonal();
  frame.up = frame.right.cross(frame.forward);
  frame.pixel = 2 * std::tan(camera.field_of_view / 2) / camera.height;
  frame.middle = Vec2(camera.width, camera.height) / 2;
  return frame;
}

Camera look_at(const Vec3& center, const Vec3& direction, double distance, const Vec3& up,
               const ViewSettings& view) {
  const int side = std::max(1, static_cast<int>(std::lround(view.image_height)));
  return {.position = center + distance * direction.normalized(),
          .target = center,
          .up = up,
          .field_of_view = view.field_of_view,
          .width = side,
          .height = side};
}

Camera crop_to_middle(const Camera& camera, int width, int height) {
  Camera crop = camera;
  crop.field_of_view = 2 * std::atan(std::tan(camera.field_of_view / 2) * height / camera.height);
  crop.width = width;
  crop.height = height;
  return crop;
}

Vec3 front_of(const Vec3& up) {
  const Vec3 y = up.normalized();
  const Vec3 front = std::abs(y.z()) < 0.9 ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitY());
  return y.cross(front).normalized().cross(y);
}

Vec3 view_from_front(const Vec3& up) {
  const Vec3 y = up.normalized(), front = front_of(up);
  return (0.62 * y.cross(front) + 0.5 * y + front).normalized();
}

Camera place_camera(Camera camera, std::span<const Vec3> points, const std::optional<Vec3>& position,
                    const std::optional<Vec3>& target) {
  if (position) {
    Box3 box;
    for (const Vec3& point : points) box.extend(point);
    camera.position = *position;
    camera.target = box.center();
  }
  if (target) camera.target = *target;
  return camera;
}

RemeshView remesh_view_of(const Camera& camera) {
  return {.position = camera.position,
          .target = camera.target,
          .up = camera.up,
          .field_of_view = camera.field_of_view,
          .width = camera.width,
          .height = camera.height};
}

Camera orbit(const Camera& camera, double angle) {
  Camera turned = camera;
  turned.position =
      camera.target + Eigen::AngleAxisd(angle, camera.up.normalized()) * (camera.position - camera.target);
  return turned;
}

double projected_diameter(const Camera& camera, double radius) {
  const double distance = (camera.target - camera.position).norm();
  if (distance <= radius) return std::numeric_limits<double>::infinity();
  // The cone that touches the sphere has half angle asin(radius / distance).
  const double slope = radius / std::sqrt(distance * distance - radius * radius);
  return 2 * slope / frame_of(camera).pixel;
}

namespace {

// Points in a camera's axes: right, up, towards the camera.
using SeenPoints = std::vector<Vec3>;

// From where on the axis through `middle` all points lie inside a picture of this half side at distance 1.
// Those on the axis itself, as a tip that points at the camera, lie at least as far off it as `least`.
double fitting_distance(const SeenPoints& points, const Vec3& middle, double slope, double least) {
  double distance = 0;
  for (const Vec3& point : points) {
    const Vec3 offset = point - middle;
    const double aside = std::max(offset.head<2>().cwiseAbs().maxCoeff(), least);
    distance = std::max(distance, offset.z() + aside / slope);
  }
  return distance > 0 ? distance : 1.0;  // a single point looks the same from anywhere
}

// Middle of the points' box in the picture, as an offset from the axis at the depth of `middle`.
Vec2 offset_in_picture(const SeenPoints& points, const Vec3& middle, double distance) {
  Eigen::AlignedBox2d box;
  for (const Vec3& point : points) {
    const Vec3 offset = point - middle;
    box.extend(Vec2(offset.head<2>() / (distance - offset.z())));
  }
  return distance * box.center();
}

}  // namespace

Camera frame_points(std::span<const Vec3> points, const Vec3& direction, const Vec3& up, double field_of_view,
                    int size, double margin) {
  if (points.empty()) throw InputError("no points to look at");
  if (!(margin >= 0 && margin < 1)) throw OptionError("a picture's margin is a share of its half side");
  Camera camera{.position = direction.normalized(),
                .target = Vec3::Zero(),
                .up = up,
                .field_of_view = field_of_view,
                .width = size,
                .height = size};
  const CameraFrame frame = frame_of(camera);
  Eigen::Matrix3d axes;
  axes << frame.right.transpose(), frame.up.transpose(), -frame.forward.transpose();
  SeenPoints seen(points.size());
  Box3 box;
  for (std::size_t i = 0; i < points.size(); ++i) {
    seen[i] = axes * (points[i] - points[0]);
    box.extend(seen[i]);
  }
  const double slope = std::tan(field_of_view / 2) * (1 - margin);
  const double least = 1e-3 * box.sizes().maxCoeff();
  Vec3 middle = box.center();
  double distance = fitting_distance(seen, middle, slope, least);
  // Near parts look larger than far ones, so the box's middle isn't the picture's. Each round moves the axis
  // to the middle of what the camera saw before; few rounds do, since the shifts shrink fast.
  constexpr int k_rounds = 3;
  for (int round = 0; round < k_rounds; ++round) {
    middle.head<2>() += offset_in_picture(seen, middle, distance);
    distance = fitting_distance(seen, middle, slope, least);
  }
  camera.target = points[0] + axes.transpose() * middle;
  camera.position = camera.target - frame.forward * distance;
  return camera;
}

Camera camera_in_front(std::span<const Vec3> points, const Vec3& up, double field_of_view, int width,
                       int height) {
  constexpr double k_margin = 0.05;
  check_size(width, height);
  const int side = std::min(width, height);
  const double of_side = 2 * std::atan(std::tan(field_of_view / 2) * side / height);
  Camera camera = frame_points(points, view_from_front(up), up, of_side, side, k_margin);
  camera.field_of_view = field_of_view;
  camera.width = width;
  camera.height = height;
  return camera;
}

}  // namespace recede
