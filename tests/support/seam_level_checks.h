// What holds for every level of a seam model, checked without the library's own bounds.
#pragma once

#include "seam_checks.h"
#include <recede/lod/seam_model.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace recede::test {

inline double volume_of(const PolygonSoup& soup) {
  double six_times = 0;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto face = soup.face(f);
    const Vec3& origin = soup.positions[0];
    const Vec3 a = soup.positions[face[0]] - origin, b = soup.positions[face[1]] - origin,
               c = soup.positions[face[2]] - origin;
    six_times += a.dot(b.cross(c));
  }
  return six_times / 6;
}

/// Over all errors of the hierarchy, some of them finer than all, some coarser.
inline std::vector<double> random_tolerances(const SeamModel& model, std::mt19937& random) {
  std::uniform_real_distribution<double> power(-3.5, -0.3);
  std::vector<double> tolerances;
  for (std::size_t patch = 0; patch < model.graph.n_patches(); ++patch)
    tolerances.push_back(model.size * std::pow(10.0, random() % 16 == 0 ? 2 : power(random)));
  return tolerances;
}

/// Half of a pixel's footprint at the nearest point of each patch's box, for a camera somewhere near or far
/// and a picture 1000 pixels high with a field of view of 45 degrees; not finer than 1e-3 of the model.
inline std::vector<double> camera_tolerances(const SeamModel& model, std::mt19937& random) {
  std::uniform_real_distribution<double> coordinate(-1, 1), power(-2, 2.5);
  Box3 box;
  for (const Vec3& point : model.graph.positions) box.extend(point);
  Vec3 direction;
  do {
    direction = Vec3(coordinate(random), coordinate(random), coordinate(random));
  } while (direction.norm() > 1 || direction.norm() < 0.1);
  const Vec3 eye = box.center() + model.size * std::pow(10.0, power(random)) * direction.normalized();
  const double footprint = 2 * std::tan(0.5 * 45 * std::numbers::pi / 180) / 1000;
  std::vector<double> tolerances;
  for (const PatchSurface& surface : model.surfaces) {
    const double distance = surface.bounds.box(surface.shape.domain()).exteriorDistance(eye);
    tolerances.push_back(std::max(0.5 * footprint * distance, 1e-3 * model.size));
  }
  return tolerances;
}

class LevelChecker {
 public:
  /// All of them must live as long.
  LevelChecker(std::string name, const std::vector<TrimmedPatch>& patches, const SeamModel& model)
      : name_(std::move(name)), patches_(patches), model_(model), random_(77) {
    for (std::size_t i = 0; i < patches.size(); ++i) regions_.emplace_back(patches[i], model.surfaces[i], 32);
    for (const Vec3& point : model.graph.positions)
      rounding_ = std::max(rounding_, 1e-13 * point.lpNorm<Eigen::Infinity>());
  }

  /// Every side is there as often one way as the other, nothing is turned over, refused or not finite.
  void expect_closed(const SeamTessellation& tessellation, const SeamUpdate& update) const {
    const PolygonSoup soup = tessellation.soup();
    EXPECT_EQ(update.triangles, soup.n_faces()) << name_;
    EXPECT_TRUE(open_sides(soup).empty()) << name_ << ": " << open_sides(soup).size() << " open sides";
    EXPECT_EQ(update.inverted, 0u) << name_;
    EXPECT_TRUE(update.refused.empty())
        << name_ << ": patch " << update.refused.front() << " of " << update.refused.size();
    for (const Vec3& point : soup.positions) ASSERT_TRUE(point.allFinite()) << name_;
  }

  /// Points of all patches are within their tolerance of the triangles, and those of triangles within the
  /// bound of the update.
  void expect_within(const SeamTessellation& tessellation, const SeamUpdate& update,
                     const std::vector<double>& tolerances, std::size_t n) {
    const PolygonSoup soup = tessellation.soup();
    EXPECT_LE(update.error_bound, *std::max_element(tolerances.begin(), tolerances.end())) << name_;
    ASSERT_GT(soup.n_faces(), 0u) << name_ << ": nothing is near to nothing";
    std::vector<Index> corners(soup.corner_vertices.begin(), soup.corner_vertices.end());
    const ClosestPointTree tree(soup.positions, corners);
    for (std::size_t patch = 0; patch < patches_.size(); ++patch) {
      const PatchSurface& surface = model_.surfaces[patch];
      const TrimmedRegion& region = regions_[patch];
      const double slack = region.slack() + rounding_;
      const double limit = std::min(tolerances[patch], update.error_bound) + slack;
      EXPECT_LE(distance_of_surface(region, surface, tree, n, random_), limit)
          << name_ << ", patch " << patch;
      const PatchTriangles& triangles = tessellation.triangles_of(patch);
      EXPECT_LE(triangles.error_bound, tolerances[patch]) << name_ << ", patch " << patch;
      // Holes that have closed count in the update's bound alone.
      EXPECT_LE(distance_of_triangles(triangles, region, surface, n, random_), limit)
          << name_ << ", patch " << patch;
    }
  }
  void expect_within(const SeamTessellation& tessellation, const SeamUpdate& update, double tolerance,
                     std::size_t n) {
    expect_within(tessellation, update, std::vector<double>(patches_.size(), tolerance), n);
  }

 private:
  std::string name_;
  const std::vector<TrimmedPatch>& patches_;
  const SeamModel& model_;
  std::vector<TrimmedRegion> regions_;
  std::mt19937 random_;
  double rounding_ = 0;  // of points and distances
};

}  // namespace recede::test
