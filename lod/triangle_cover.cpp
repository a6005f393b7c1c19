// Branch and bound as in geometry/bound_search.cpp, on patches so small that every triangle is looked at: the
// distance to one triangle is convex, so over a piece it is largest at the piece's corners, and the distance
// to the patch is at most the least of these. Pieces for which that isn't good enough are cut along the prism
// over the triangle nearest to their middle, else into four.
#include <recede/geometry/detail/cut_triangle.h>
#include <recede/lod/detail/triangle_cover.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede::detail {
namespace {

constexpr double k_tolerance = 0.1;
/// After these the pieces keep the bounds that they have.
constexpr std::size_t k_most_steps = 400;
constexpr int k_most_depth = 12;

double squared_distance(const Vec3& p, const Triangle& triangle) {
  return (closest_point_on_triangle(p, triangle) - p).squaredNorm();
}

}  // namespace

double TriangleCover::bound(const Triangle& triangle, std::span<const FaceTriangle> targets, double enough) {
  lower_ = upper_ = 0;
  enough_ = enough;
  steps_ = 0;
  used_.clear();
  pieces_.assign(1, {triangle, 0});
  // First come, first served: if the steps run out, what is left is small.
  for (std::size_t next = 0; next < pieces_.size(); ++next) settle(Piece(pieces_[next]), targets);
  return upper_;
}

void TriangleCover::accept(double bound, Index face) {
  upper_ = std::max(upper_, bound);
  if (std::find(used_.begin(), used_.end(), face) == used_.end()) used_.push_back(face);
}

void TriangleCover::settle(const Piece& piece, std::span<const FaceTriangle> targets) {
  const Triangle& t = piece.corners;
  const Vec3 middle = (t.a + t.b + t.c) / 3;
  constexpr double k_infinity = std::numeric_limits<double>::infinity();
  double bound = k_infinity, at_middle = k_infinity;
  std::array<double, 3> at_corners{k_infinity, k_infinity, k_infinity};
  const FaceTriangle *best = nullptr, *nearest = nullptr;
  for (const FaceTriangle& target : targets) {
    const std::array<double, 3> here{squared_distance(t.a, target.corners),
                                     squared_distance(t.b, target.corners),
                                     squared_distance(t.c, target.corners)};
    const double largest = std::max({here[0], here[1], here[2]});
    if (largest < bound || best == nullptr) {
      bound = largest;
      best = &target;
      if (largest <= enough_ * enough_) return accept(std::sqrt(largest), target.face);
    }
    for (std::size_t i = 0; i < 3; ++i) at_corners[i] = std::min(at_corners[i], here[i]);
    const double there = squared_distance(middle, target.corners);
    if (there < at_middle || nearest == nullptr) {
      at_middle = there;
      nearest = &target;
    }
  }
  bound = std::sqrt(bound);
  if (bound <= std::max(enough_, upper_)) return accept(bound, best->face);
  lower_ = std::max(lower_, std::sqrt(std::max({at_middle, at_corners[0], at_corners[1], at_corners[2]})));
  if (bound <= (1 + k_tolerance) * lower_ || ++steps_ > k_most_steps || piece.depth >= k_most_depth) {
    return accept(bound, best->face);
  }
  if (cut_along_prism(piece, nearest->corners)) return;
  for (const Triangle& part : cut_in_four(piece.corners)) pieces_.push_back({part, piece.depth + 1});
}

/// Cuts by the plane through that side of the target, upright on it, beyond which a corner lies farthest.
bool TriangleCover::cut_along_prism(const Piece& piece, const Triangle& target) {
  const std::array<Vec3, 3> ends{target.a, target.b, target.c};
  const std::array<Vec3, 3> corners{piece.corners.a, piece.corners.b, piece.corners.c};
  const Vec3 normal = (target.b - target.a).cross(target.c - target.a);
  std::array<double, 3> heights{};
  double farthest = 0;
  for (std::size_t s = 0; s < 3; ++s) {
    const Vec3 outward = (ends[(s + 1) % 3] - ends[s]).cross(normal);
    const double length = outward.norm();
    if (!(length > 0)) return false;
    std::array<double, 3> here{};
    for (std::size_t i = 0; i < 3; ++i) here[i] = (corners[i] - ends[s]).dot(outward) / length;
    const auto [low, high] = std::minmax_element(here.begin(), here.end());
    if (*high <= farthest || *low >= 0) continue;
    farthest = *high;
    heights = here;
  }
  // What a cut takes off must be worth it.
  if (farthest <= 1e-6 * (corners[1] - corners[0]).norm()) return false;
  cut_triangle(piece.corners, heights, [&](const Triangle& part, bool) {
    pieces_.push_back({part, piece.depth + 1});
  });
  return true;
}

}  // namespace recede::detail
