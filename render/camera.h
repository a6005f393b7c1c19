// A pinhole camera with square pixels.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/lod/lod_hierarchy.h>
#include <recede/lod/view_dependent_remesh.h>

#include <optional>
#include <span>

namespace recede {

/// Looks from `position` to `target`, which lands in the middle of the image.
struct Camera {
  Vec3 position{0, 0, 3};
  Vec3 target = Vec3::Zero();
  Vec3 up =
      Vec3::UnitY();  ///< points upwards in the image; any direction but the view's own, need not be unit
  double field_of_view = 0.785398163397448;  ///< vertical, radians, in (0, pi)
  int width = 512;                           ///< pixels
  int height = 512;                          ///< pixels
};

/// A camera's axes in object space, orthonormal, and its pixel size.
struct CameraFrame {
  Vec3 position, right, up, forward;
  double pixel = 0;  ///< side of a pixel on the plane at distance 1
  Vec2 middle;       ///< of the image, pixels

  /// Unit direction through the image point (x, y) in pixels; (0, 0) is the upper left corner of the upper
  /// left pixel, whose middle is (0.5, 0.5).
  Vec3 direction(double x, double y) const;
};

/// Throws `OptionError` when position and target coincide, or a number of `camera` is out of range. When `up`
/// is parallel to the view, some perpendicular direction serves.
CameraFrame frame_of(const Camera& camera);

/// A square image of `view.image_height` pixels, seen from `distance` (object units) away from `center`,
/// towards which the camera looks. `direction` points from the center to the camera, any length.
Camera look_at(const Vec3& center, const Vec3& direction, double distance, const Vec3& up,
               const ViewSettings& view);

/// The middle `width` x `height` pixels of the same picture; both sides should have the camera's parity, or
/// the pixels lie half a pixel off. Larger sizes show more around it.
Camera crop_to_middle(const Camera& camera, int width, int height);

/// Where a model's front looks to, a unit vector across `up`: nearest to +z for y up, as glTF has it, and to
/// -y for z up, as CAD and Blender have it.
Vec3 front_of(const Vec3& up);

/// Towards a camera in front of a model (`front_of`), a little to the right and above: a unit vector.
Vec3 view_from_front(const Vec3& up);

/// A picture of `width` x `height` pixels from in front (`view_from_front`) whose shorter side holds all
/// points. Throws `InputError` when there are none.
Camera camera_in_front(std::span<const Vec3> points, const Vec3& up, double field_of_view, int width,
                       int height);

/// The camera, moved to `position` and turned to `target` where they are given. Moved without a target it
/// looks at the middle of the points' box.
Camera place_camera(Camera camera, std::span<const Vec3> points, const std::optional<Vec3>& position,
                    const std::optional<Vec3>& target);

/// The same view for dicing.
RemeshView remesh_view_of(const Camera& camera);

/// The camera turned around its target by `angle` (radians), about the axis `up`, counter-clockwise seen from
/// above.
Camera orbit(const Camera& camera, double angle);

/// Diameter in pixels of the disc that a sphere around the camera's target covers. Infinite from inside.
double projected_diameter(const Camera& camera, double radius);

/// The square picture of `size` pixels with the given vertical field of view (radians) that holds all points
/// as large as possible but for `margin`, a share of the picture's half side. `direction` points towards the
/// camera. Throws `InputError` when there are no points.
Camera frame_points(std::span<const Vec3> points, const Vec3& direction, const Vec3& up, double field_of_view,
                    int size, double margin);

}  // namespace recede
