// What holds for every level of a Seam Graph, and points of trimmed surfaces to check bounds with.
#pragma once

#include "trimmed_patches.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/patch_surface.h>
#include <recede/lod/patch_tessellator.h>
#include <recede/lod/seam_graph.h>

#include <array>
#include <map>
#include <memory>
#include <random>
#include <vector>

namespace recede::test {

/// How often sides run up from the lower to the higher vertex, less how often they run down; none: closed.
using Sides = std::map<std::pair<Index, Index>, int>;

inline void add_side(Sides& sides, Index a, Index b, int times = 1) {
  if (a == b) return;
  const auto at = sides.try_emplace(std::minmax(a, b), 0).first;
  at->second += a < b ? times : -times;
  if (at->second == 0) sides.erase(at);
}

inline Sides open_sides(const PolygonSoup& soup) {
  Sides sides;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const auto face = soup.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) add_side(sides, face[i], face[(i + 1) % face.size()]);
  }
  return sides;
}

inline Sides open_sides(std::span<const SeamLoop> loops) {
  Sides sides;
  for (const SeamLoop& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i)
      add_side(sides, loop[i].vertex, loop[(i + 1) % loop.size()].vertex);
  }
  return sides;
}

/// The true outline of a patch, as fine poly-lines, and what is inside.
class TrimmedRegion {
 public:
  TrimmedRegion(const TrimmedPatch& patch, const PatchSurface& surface, int pieces_of_span = 48) {
    for (const TrimmingLoop& loop : patch.loops) {
      for (const TrimmingCurve& curve : loop.curves) add(curve.curve, surface, pieces_of_span);
    }
    std::vector<Vec3> points;
    std::vector<Index> corners;
    for (const Piece& piece : pieces_) {
      const auto here = static_cast<Index>(points.size());
      points.push_back(surface.shape.evaluate(piece.from));
      points.push_back(surface.shape.evaluate(piece.to));
      corners.insert(corners.end(), {here, here + 1, here + 1});
      box_.extend(piece.from);
    }
    outline_ = std::make_unique<ClosestPointTree>(points, corners);
  }

  const ParameterBox& box() const { return box_; }
  /// In space, between the outline and its poly-lines: twice what is met in the middle of pieces.
  double slack() const { return slack_; }
  /// The same for places of the surface that `holds` takes for inside alone: nothing where the outline is
  /// straight in parameters.
  double slack_of_inside() const { return slack_of_inside_; }

  bool holds(const Vec2& uv) const {
    int turns = 0;
    for (const Piece& piece : pieces_) {
      const bool is_up = piece.from.y() <= uv.y();
      if (is_up == (piece.to.y() <= uv.y())) continue;
      const Vec2 a = piece.from - uv, b = piece.to - uv;
      const double cross = a.x() * b.y() - a.y() * b.x();
      if (is_up && cross > 0) ++turns;
      if (!is_up && cross < 0) --turns;
    }
    return turns > 0;
  }

  double distance_to_outline(const Vec3& point) const {
    return std::sqrt(outline_->closest(point).squared_distance);
  }

  /// Up to `n` places inside, fewer where the region is a small part of its box.
  std::vector<Vec2> places(std::size_t n, std::mt19937& random) const {
    std::uniform_real_distribution<double> share(0, 1);
    std::vector<Vec2> result;
    for (std::size_t i = 0; i < 4 * n && result.size() < n; ++i) {
      const Vec2 at = Vec2(share(random), share(random));
      const Vec2 uv = box_.min() + at.cwiseProduct(box_.sizes());
      if (holds(uv)) result.push_back(uv);
    }
    return result;
  }

 private:
  struct Piece {
    Vec2 from, to;
  };

  void add(const NurbsCurve2& curve, const PatchSurface& surface, int pieces_of_span) {
    for (std::size_t k = 0; k + 1 < curve.knots.size(); ++k) {
      const double begin = std::max(curve.knots[k], curve.domain().begin);
      const double end = std::min(curve.knots[k + 1], curve.domain().end);
      if (!(begin < end)) continue;
      const auto at = [&](int i, double part) {
        return evaluate(
            curve, i + part == pieces_of_span ? end : begin + (i + part) / pieces_of_span * (end - begin));
      };
      for (int i = 0; i < pieces_of_span; ++i) {
        pieces_.push_back({at(i, 0), at(i, 1)});
        const Vec3 middle = surface.shape.evaluate((pieces_.back().from + pieces_.back().to) / 2);
        const Vec3 chord =
            (surface.shape.evaluate(pieces_.back().from) + surface.shape.evaluate(pieces_.back().to)) / 2;
        const Vec3 on_curve = surface.shape.evaluate(at(i, 0.5));
        slack_ = std::max(slack_, 2 * ((middle - on_curve).norm() + (chord - middle).norm()));
        // Curves may run unevenly: only what is across their pieces counts.
        const Vec2 uv = at(i, 0.5), along = pieces_.back().to - pieces_.back().from;
        const double share = (uv - pieces_.back().from).dot(along) / std::max(along.squaredNorm(), 1e-300);
        const Vec2 beside = pieces_.back().from + std::clamp(share, 0.0, 1.0) * along;
        slack_of_inside_ = std::max(slack_of_inside_, 2 * (surface.shape.evaluate(beside) - on_curve).norm());
      }
    }
  }

  std::vector<Piece> pieces_;
  ParameterBox box_;
  double slack_ = 0, slack_of_inside_ = 0;
  std::unique_ptr<ClosestPointTree> outline_;
};

/// Of random points of a trimmed surface from triangles, the largest.
inline double distance_of_surface(const TrimmedRegion& region, const PatchSurface& surface,
                                  const ClosestPointTree& tree, std::size_t n, std::mt19937& random) {
  double largest = 0;
  for (const Vec2& uv : region.places(n, random)) {
    const Vec3 point = surface.shape.evaluate(uv);
    largest = std::max(largest, std::sqrt(tree.closest(point).squared_distance));
  }
  return largest;
}

/// Of random points of triangles: to the surface at their parameters where these are inside, else to the
/// outline.
inline double distance_of_triangles(const PatchTriangles& triangles, const TrimmedRegion& region,
                                    const PatchSurface& surface, std::size_t n, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  double largest = 0;
  for (std::size_t i = 0; i < n && !triangles.triangles.empty(); ++i) {
    const auto& corners = triangles.triangles[random() % triangles.triangles.size()];
    double a = share(random), b = share(random);
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    const std::array<double, 3> weights{1 - a - b, a, b};
    Vec2 uv = Vec2::Zero();
    Vec3 point = Vec3::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      uv += weights[k] * triangles.uvs[corners[k]];
      point += weights[k] * triangles.positions[corners[k]];
    }
    double distance = region.distance_to_outline(point);
    if (region.holds(uv)) distance = std::min(distance, (surface.shape.evaluate(uv) - point).norm());
    largest = std::max(largest, distance);
  }
  return largest;
}

inline ClosestPointTree tree_of(const PatchTriangles& triangles) {
  std::vector<Index> corners;
  for (const auto& triangle : triangles.triangles)
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  return {triangles.positions, corners};
}

}  // namespace recede::test
