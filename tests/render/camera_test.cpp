#include <recede/geometry/error.h>
#include <recede/render/camera.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace recede {
namespace {

TEST(Camera, TheMiddleOfTheImageLooksAtTheTarget) {
  const Camera camera{.position = Vec3(1, 2, 3), .target = Vec3(-4, 0, 1), .width = 64, .height = 48};
  const Vec3 expected = (camera.target - camera.position).normalized();
  EXPECT_TRUE(frame_of(camera).direction(32, 24).isApprox(expected, 1e-12));
}

TEST(Camera, RowZeroIsOnTopAndColumnsGoRight) {
  const Camera camera{.position = Vec3(0, 0, 5), .width = 64, .height = 64};
  const CameraFrame frame = frame_of(camera);
  EXPECT_GT(frame.direction(32, 0).y(), 0);
  EXPECT_GT(frame.direction(64, 32).x(), 0);
  const double half_angle = std::acos(frame.direction(32, 0).dot(frame.forward));
  EXPECT_NEAR(half_angle, camera.field_of_view / 2, 1e-12);
}

TEST(Camera, AFarSphereCoversTheFootprintThatTheHierarchyCountsWith) {
  const ViewSettings view{.image_height = 1080, .field_of_view = 0.9, .pixel_error = 1};
  const double radius = 2, distance = 4000;
  const Camera camera = look_at(Vec3(5, 6, 7), Vec3(1, 1, 0), distance, Vec3::UnitZ(), view);
  // s(d) = 2 d / r tan(alpha / 2), r pixels high
  const double footprint = 2 * distance / 1080 * std::tan(0.45);
  EXPECT_NEAR(pixel_footprint(distance, view), footprint, 1e-12);
  EXPECT_NEAR(projected_diameter(camera, radius) * footprint, 2 * radius, 1e-5);
}

TEST(Camera, ANearSphereCoversItsTangentCone) {
  const Camera camera{
      .position = Vec3(0, 0, 2), .field_of_view = std::numbers::pi / 2, .width = 100, .height = 100};
  // Half angle asin(1/2) = 30 degrees; the image's half height of 50 pixels stands for tan 45 degrees = 1.
  EXPECT_NEAR(projected_diameter(camera, 1), 2 * 50 / std::sqrt(3.0), 1e-9);
  EXPECT_TRUE(std::isinf(projected_diameter(camera, 2)));
}

TEST(Camera, ACropKeepsTheRaysOfItsPixels) {
  const Camera whole{.position = Vec3(3, 1, 2), .target = Vec3(0, 1, 0), .width = 100, .height = 80};
  const Camera crop = crop_to_middle(whole, 10, 20);
  const Vec3 in_whole = frame_of(whole).direction(45 + 3.5, 30 + 7.5);
  EXPECT_TRUE(frame_of(crop).direction(3.5, 7.5).isApprox(in_whole, 1e-12));
}

TEST(Camera, FramedPointsFillThePictureAndStayInside) {
  const std::vector<Vec3> points{{0, 0, 0}, {10, 0, 0}, {10, 1, 0}, {0, 1, 3}, {5, -1, -2}};
  const Camera camera = frame_points(points, Vec3(1, 1, 2), Vec3::UnitY(), 0.6, 200, 0.1);
  const CameraFrame frame = frame_of(camera);
  double farthest = 0;
  for (const Vec3& point : points) {
    const Vec3 seen = point - frame.position;
    const double depth = seen.dot(frame.forward);
    ASSERT_GT(depth, 0);
    farthest =
        std::max({farthest, std::abs(seen.dot(frame.right)) / depth, std::abs(seen.dot(frame.up)) / depth});
  }
  EXPECT_NEAR(farthest / std::tan(0.3), 0.9, 1e-9);
}

TEST(Camera, StandsBeyondATipThatPointsAtIt) {
  const std::vector<Vec3> points{{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}, {0, 0, 100}};
  const Camera camera = frame_points(points, Vec3::UnitZ(), Vec3::UnitY(), 0.6, 200, 0.1);
  const CameraFrame frame = frame_of(camera);
  EXPECT_GT(frame.position.z(), 100);
  for (const Vec3& point : points) {
    const Vec3 seen = point - frame.position;
    const double aside = std::max(std::abs(seen.dot(frame.right)), std::abs(seen.dot(frame.up)));
    EXPECT_LT(aside, 0.9 * std::tan(0.3) * seen.dot(frame.forward)) << point.transpose();
  }
}

TEST(Camera, LookingAlongUpStillHasAnOrthonormalFrame) {
  const Camera camera{.position = Vec3(0, 7, 0)};
  const CameraFrame frame = frame_of(camera);
  EXPECT_NEAR(frame.right.dot(frame.up), 0, 1e-12);
  EXPECT_NEAR(frame.right.cross(frame.up).dot(frame.forward), -1, 1e-12);
}

TEST(Camera, ImpossibleCamerasAreRefused) {
  EXPECT_THROW(frame_of({.position = Vec3::Zero()}), OptionError);
  EXPECT_THROW(frame_of({.field_of_view = std::numbers::pi}), OptionError);
  EXPECT_THROW(frame_of({.width = 0}), OptionError);
}

TEST(Camera, OrbitsItsTargetAboutItsUpwardAxis) {
  const Camera camera{.position = {1, 2, 6}, .target = {1, 1, 1}, .up = {0, 2, 0}};
  const Camera turned = orbit(camera, std::numbers::pi / 2);
  // Seen from above, z turns to x counter-clockwise. Rounding of a sine and a cosine.
  EXPECT_LT((turned.position - Vec3(6, 2, 1)).norm(), 1e-14);
  EXPECT_EQ(turned.target, camera.target);
}

TEST(Camera, LooksFromInFront) {
  EXPECT_GT(view_from_front(Vec3::UnitY()).z(), 0.5);
  EXPECT_LT(view_from_front(Vec3::UnitZ()).y(), -0.5);
  EXPECT_NEAR(view_from_front({0, 3, 0}).norm(), 1, 1e-15);
}

TEST(Camera, StandsWhereItIsPutAndLooksAtTheMiddleOrAtItsTarget) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 1, 1}, {4, 2, 0}};
  const Camera before{.position = {9, 9, 9}, .target = {8, 8, 8}, .width = 7};
  const Vec3 eye(5, 6, 7), target(1, 0, 1);
  EXPECT_EQ(place_camera(before, points, eye, std::nullopt).position, eye);
  EXPECT_EQ(place_camera(before, points, eye, std::nullopt).target, Vec3(2, 1, 0.5));
  EXPECT_EQ(place_camera(before, points, eye, target).target, target);
  const Camera turned = place_camera(before, points, std::nullopt, target);
  EXPECT_EQ(turned.position, before.position);
  EXPECT_EQ(turned.target, target);
  EXPECT_EQ(turned.width, 7);
  EXPECT_EQ(place_camera(before, points, std::nullopt, std::nullopt).target, before.target);
}

}  // namespace
}  // namespace recede
