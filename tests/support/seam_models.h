// Models of trimmed patches, put together by hand, that Seam Graphs are tested with.
#pragma once

#include "trimmed_patches.h"
#include <recede/geometry/cad_import.h>

#include <string>
#include <vector>

namespace recede::test {

/// A can with a bore along its axis: four patches around a ring.
inline std::vector<TrimmedPatch> ring(double outer, double inner, double height) {
  std::vector<TrimmedPatch> patches = can(outer, height);
  TrimmedPatch wall = can(inner, height)[0];
  wall.name = "bore";
  wall.is_reversed = true;
  for (const std::size_t cap : {std::size_t{1}, std::size_t{2}})
    patches[cap].loops.push_back(circle({0.5, 0.5}, inner / outer / 4, true));
  patches.push_back(wall);
  return patches;
}

/// A box of which each face is n x n patches.
inline std::vector<TrimmedPatch> tiled_box(const Vec3& size, int n) {
  std::vector<TrimmedPatch> patches;
  for (const TrimmedPatch& face : box_faces(size)) {
    const std::vector<Vec3>& corners = face.surface.points;
    const Vec3 u = (corners[2] - corners[0]) / n, v = (corners[1] - corners[0]) / n;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j)
        patches.push_back(whole(parallelogram(corners[0] + i * u + j * v, u, v), face.name));
    }
  }
  return patches;
}

/// A pillow: two sheets over a square, that bulge by polynomials of higher degree and meet at their sides.
inline std::vector<TrimmedPatch> pillow(double height, int degree = 4) {
  const auto side = [&](double factor) {
    NurbsSurface surface{{degree, degree}, {}, {}, {}};
    for (auto& knots : surface.knots) {
      knots.assign(static_cast<std::size_t>(degree) + 1, 0);
      knots.insert(knots.end(), static_cast<std::size_t>(degree) + 1, 1);
    }
    for (int i = 0; i <= degree; ++i) {
      for (int j = 0; j <= degree; ++j) {
        const bool is_border = i == 0 || j == 0 || i == degree || j == degree;
        // Sides wave in the plane, alike for both.
        const double wave = i == 0 || i == degree ? (j % 2 == 0 ? 0.0 : 0.2) : 0.0;
        surface.points.emplace_back(static_cast<double>(i) / degree + wave, static_cast<double>(j) / degree,
                                    is_border ? 0 : factor * height);
      }
    }
    return surface;
  };
  TrimmedPatch top = whole(side(1), "top"), bottom = whole(side(-1), "bottom");
  bottom.is_reversed = true;
  return {top, bottom};
}

/// A square plate with n x n bores through it.
inline std::vector<TrimmedPatch> bored_plate(double size, double height, double radius, int n) {
  std::vector<TrimmedPatch> patches = box_faces({size, size, height});
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const Vec2 center((i + 0.5) / n, (j + 0.5) / n);
      // The bottom's u is the plate's y.
      patches[0].loops.push_back(circle({center.y(), center.x()}, radius / size, true));
      patches[1].loops.push_back(circle(center, radius / size, true));
      TrimmedPatch wall = can(radius, height)[0];
      for (Vec3& point : wall.surface.points) point += Vec3(size * center.x(), size * center.y(), 0);
      wall.name = "bore";
      wall.is_reversed = true;
      patches.push_back(wall);
    }
  }
  return patches;
}

/// A round rod with a bore beside its middle.
inline std::vector<TrimmedPatch> off_centre_bore(double height) {
  std::vector<TrimmedPatch> patches = can(1, height);
  constexpr double k_radius = 0.2, k_off = 0.7;
  TrimmedPatch wall = can(k_radius, height)[0];
  for (Vec3& point : wall.surface.points) point.x() += k_off;
  wall.name = "bore";
  wall.is_reversed = true;
  // Both caps are from -2 to 2; the bottom's u is y.
  patches[1].loops.push_back(circle({0.5, 0.5 + k_off / 4}, k_radius / 4, true));
  patches[2].loops.push_back(circle({0.5 + k_off / 4, 0.5}, k_radius / 4, true));
  patches.push_back(wall);
  return patches;
}

inline std::vector<TrimmedPatch> moved(std::vector<TrimmedPatch> patches, const Vec3& by, double scale = 1) {
  for (TrimmedPatch& patch : patches) {
    for (Vec3& point : patch.surface.points) point = scale * point + by;
  }
  return patches;
}

inline std::vector<TrimmedPatch> together(const std::vector<std::vector<TrimmedPatch>>& bodies) {
  std::vector<TrimmedPatch> patches;
  for (const auto& body : bodies) patches.insert(patches.end(), body.begin(), body.end());
  return patches;
}

struct NamedPatches {
  std::string name;
  std::vector<TrimmedPatch> patches;
  std::size_t pieces = 1;  ///< that nothing but the inside of a patch holds together
};

/// All of them closed. Nothing but the inside of caps holds a bore to the outside.
inline std::vector<NamedPatches> closed_models() {
  return {{"box", box_faces({3, 2, 1})},
          {"can", can(1, 2)},
          {"ball", {whole(ball(1))}},
          {"ring", ring(1, 0.5, 0.7), 2},
          {"pillow", pillow(0.8)},
          {"bored plate", bored_plate(4, 0.5, 0.3, 3)},
          {"bore off the centre", off_centre_bore(3), 2},
          {"tiled box", tiled_box({3, 2, 1}, 4)},
          {"two cans and a ball",
           together({can(1, 2), moved(can(1, 1), {3, 0, 0}), {whole(ball(1, {0, 4, 0}))}}), 3}};
}

inline CadPart part_of(const std::vector<TrimmedPatch>& patches) {
  CadPart part;
  part.patches = patches;
  return part;
}

}  // namespace recede::test
