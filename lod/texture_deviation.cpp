#include <recede/lod/detail/texture_deviation.h>

#include <algorithm>
#include <limits>

namespace recede::detail {
namespace {

double turn(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Twice the signed area of a triangle in the texture plane.
double signed_area(const Vec2& a, const Vec2& b, const Vec2& c) { return turn(b - a, c - a); }

}  // namespace

TextureDeviation::Place TextureDeviation::place_of(Index corner) const {
  return {table_.positions[table_.point[corner]], table_.wedges[table_.wedge[corner]].uv};
}

std::optional<double> TextureDeviation::measure(const std::vector<RingCorner>& ring, Index removed,
                                                Index kept) {
  sides_.clear();
  for (const RingCorner& c : ring) {
    const Index wedge = table_.wedge[c.corner];
    if (std::find(sides_.begin(), sides_.end(), wedge) == sides_.end()) sides_.push_back(wedge);
  }
  double deviation = 0;
  for (const Index wedge : sides_) {
    const auto side = measure_side(wedge, ring, kept);
    if (!side) return std::nullopt;
    deviation = std::max(deviation, *side);
  }
  return sides_.empty() ? (table_.positions[removed] - table_.positions[kept]).norm() : deviation;
}

std::optional<double> TextureDeviation::measure_side(Index wedge, const std::vector<RingCorner>& ring,
                                                     Index kept) {
  fans_.clear();
  Place removed{}, target{};
  bool has_edge = false;
  for (const RingCorner& c : ring) {
    if (table_.wedge[c.corner] != wedge) continue;
    const Index after = table_.next(c.corner), before = table_.previous(c.corner);
    removed = place_of(c.corner);
    fans_.push_back({place_of(after), place_of(before), c.on_edge});
    if (!c.on_edge) continue;
    has_edge = true;
    target = place_of(c.after == kept ? after : before);
  }
  // A side that the edge doesn't touch has nowhere to go in the texture.
  if (!has_edge) return std::nullopt;
  for (const Fan& fan : fans_) {
    if (fan.on_edge) continue;
    const double before = signed_area(removed.uv, fan.from.uv, fan.to.uv),
                 after = signed_area(target.uv, fan.from.uv, fan.to.uv);
    if (!(before * after > 0)) return std::nullopt;
  }
  return std::max(deviation_at_removed(removed, target), deviation_at_crossings(removed, target));
}

/// Distance from the removed point to the new triangle that has its texture coordinates; on the rim of a
/// chart it may lie outside of all, and then the nearest one counts.
double TextureDeviation::deviation_at_removed(const Place& removed, const Place& kept) const {
  double least_outside = std::numeric_limits<double>::infinity();
  double deviation = (removed.position - kept.position).norm();
  for (const Fan& fan : fans_) {
    if (fan.on_edge) continue;
    const double area = signed_area(kept.uv, fan.from.uv, fan.to.uv);
    Vec3 weights(signed_area(removed.uv, fan.from.uv, fan.to.uv), signed_area(kept.uv, removed.uv, fan.to.uv),
                 signed_area(kept.uv, fan.from.uv, removed.uv));
    weights /= area;
    const double outside = -std::min(0.0, weights.minCoeff());
    if (outside >= least_outside) continue;
    least_outside = outside;
    weights = weights.cwiseMax(0.0);
    weights /= weights.sum();
    const Vec3 place =
        weights[0] * kept.position + weights[1] * fan.from.position + weights[2] * fan.to.position;
    deviation = (removed.position - place).norm();
  }
  return deviation;
}

double TextureDeviation::deviation_at_crossings(const Place& removed, const Place& kept) const {
  double largest = 0;
  // Every edge comes after the removed point in one polygon, but for the last one of an open fan; those of a
  // rim cross nothing.
  for (const Fan& old_fan : fans_) {
    const Place& old_end = old_fan.from;
    const Vec2 old_way = old_end.uv - removed.uv;
    for (const Fan& new_fan : fans_) {
      if (new_fan.on_edge) continue;
      const Place& new_end = new_fan.from;
      const Vec2 new_way = new_end.uv - kept.uv;
      const double area = turn(old_way, new_way);
      if (area == 0) continue;
      const Vec2 between = kept.uv - removed.uv;
      const double on_old = turn(between, new_way) / area, on_new = turn(between, old_way) / area;
      if (!(on_old > 0 && on_old < 1 && on_new > 0 && on_new < 1)) continue;
      const Vec3 was = removed.position + on_old * (old_end.position - removed.position),
                 is = kept.position + on_new * (new_end.position - kept.position);
      largest = std::max(largest, (was - is).norm());
    }
  }
  return largest;
}

}  // namespace recede::detail
