// Cameras around seam models, and what holds for every frame that a viewer makes for them.
#pragma once

#include "seam_level_checks.h"
#include <recede/lod/seam_viewer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

namespace recede::test {

inline Box3 box_of(const SeamModel& model) {
  Box3 box;
  for (const Vec3& point : model.graph.positions) box.extend(point);
  return box;
}

/// From near or far, half of them beside the middle of the model so that some of it is outside of the image.
inline SeamView random_view(const SeamModel& model, std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1, 1), power(-0.7, 2);
  const auto vector = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  const Box3 box = box_of(model);
  SeamView view;
  Vec3 direction;
  do {
    direction = vector();
  } while (direction.norm() > 1 || direction.norm() < 0.1);
  view.position = box.center() + model.size * std::pow(10.0, power(random)) * direction.normalized();
  view.target = box.center();
  if (random() % 2 == 0) view.target += vector().cwiseProduct(box.sizes());
  do {
    view.up = vector();
  } while (view.up.cross(view.target - view.position).norm() < 1e-3 * model.size);
  view.view.image_height = 500;
  view.aspect_ratio = std::pow(2.0, coordinate(random));
  return view;
}

/// Whether a point, with a normal of its side that is to be seen, is in the image and looks at the eye.
inline bool may_be_seen(const SeamView& view, const Vec3& point, const Vec3& normal) {
  const Vec3 to = point - view.position, forward = (view.target - view.position).normalized();
  const Vec3 right = forward.cross(view.up).normalized(), up = right.cross(forward);
  const double half = std::tan(view.view.field_of_view / 2), depth = forward.dot(to);
  return depth > 0 && std::abs(right.dot(to)) <= half * view.aspect_ratio * depth &&
         std::abs(up.dot(to)) <= half * depth && normal.dot(to) < 0;
}

/// Points of every patch, inside and along its outline, with their normals.
class PatchPoints {
 public:
  PatchPoints(const std::vector<TrimmedPatch>& patches, const SeamModel& model, std::size_t n) {
    std::mt19937 random(5);
    for (std::size_t patch = 0; patch < patches.size(); ++patch) {
      const PatchSurface& surface = model.surfaces[patch];
      std::vector<Vec2> places = TrimmedRegion(patches[patch], surface, 16).places(n, random);
      for (const SeamLoop& loop : model.graph.loops_of(patch)) {
        for (const SeamSlot& slot : loop) places.push_back(slot.uv);
      }
      const double side = model.is_reversed[patch] ? -1 : 1;
      points_.emplace_back();
      for (const Vec2& uv : places) {
        points_.back().push_back({surface.shape.evaluate(uv), side * surface.shape.normal(uv)});
      }
    }
  }

  bool any_may_be_seen(std::size_t patch, const SeamView& view) const {
    for (const auto& [point, normal] : points_[patch]) {
      if (may_be_seen(view, point, normal)) return true;
    }
    return false;
  }
  double distance(std::size_t patch, const Vec3& eye) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [point, normal] : points_[patch]) least = std::min(least, (point - eye).norm());
    return least;
  }

 private:
  struct Point {
    Vec3 point, normal;
  };
  std::vector<std::vector<Point>> points_;
};

/// Every side is there as often one way as the other, and no triangle is turned over.
inline void expect_nothing_open(const SeamTessellation& tessellation, const SeamUpdate& update,
                                const std::string& place) {
  const PolygonSoup soup = tessellation.soup();
  EXPECT_EQ(update.triangles, soup.n_faces()) << place;
  EXPECT_TRUE(open_sides(soup).empty()) << place << ": " << open_sides(soup).size() << " open sides";
  EXPECT_EQ(update.inverted, 0u) << place;
  for (const Vec3& point : soup.positions) ASSERT_TRUE(point.allFinite()) << place;
}

/// How coarse a patch may be where seams are coarser than what is tolerated, in errors of the finest seams:
/// as far as it takes that no triangle is turned over.
constexpr double k_coarsest_of_seams = 4;

/// Goes through random views, some with a budget. Every frame is closed and nothing of it is turned over,
/// what is culled can't be seen, and what isn't postponed is within its tolerance, or near enough that the
/// seams' own error is more than that.
inline void expect_sound_views(const std::string& name, const std::vector<TrimmedPatch>& patches,
                               const SeamModel& model, int n_views) {
  const PatchPoints points(patches, model, 100);
  const double seams = model.graph.tolerance;
  SeamViewer viewer(model);
  std::mt19937 random(61);
  for (int round = 0; round < n_views; ++round) {
    SeamView view = random_view(model, random);
    if (round % 4 == 3) view.most_new_triangles = 200;
    const SeamFrame frame = viewer.update(view);
    const std::string place = name + ", view " + std::to_string(round);
    expect_nothing_open(viewer.tessellation(), frame.update, place);
    std::vector<bool> is_refused(patches.size(), false);
    for (const Index patch : frame.update.refused) is_refused[patch] = true;
    for (std::size_t patch = 0; patch < patches.size(); ++patch) {
      const bool is_culled = viewer.is_culled(patch);
      if (is_culled) {
        EXPECT_FALSE(points.any_may_be_seen(patch, view)) << place << ", patch " << patch;
      }
      if (frame.postponed > 0) continue;
      const double half_a_pixel =
          view.view.pixel_error * pixel_footprint(points.distance(patch, view.position), view.view);
      const double allowed = std::max(half_a_pixel * (is_culled ? view.culled_factor : 1.0), 0.1 * seams);
      if (is_refused[patch]) {
        // The untrimmed surface may be nearer.
        const PatchSurface& surface = model.surfaces[patch];
        const double nearest = surface.bounds.distance(surface.shape.domain(), view.position);
        EXPECT_LT(view.view.pixel_error * pixel_footprint(nearest, view.view),
                  k_coarsest_of_seams * seams / (is_culled ? view.culled_factor : 1.0))
            << place << ", patch " << patch;
      }
      EXPECT_LE(viewer.tessellation().triangles_of(patch).error_bound,
                is_refused[patch] ? k_coarsest_of_seams * seams : allowed)
          << place << ", patch " << patch;
    }
  }
}

}  // namespace recede::test
