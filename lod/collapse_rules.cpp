// The link condition follows Dey, Edelsbrunner, Guha, Nekhayev 1999 in its form for polygons: the ends of the
// edge share no neighbours but the third corners of triangles on it.
#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/collapse_rules.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

void gather_ring(const CornerTable& table, Index of, Index other, std::vector<RingCorner>& ring) {
  ring.clear();
  if (!table.has_polygons) {
    table.each_corner(of, [&](Index corner) {
      const Index face = corner / 3, place = corner - 3 * face;
      const Index before = table.point[place == 0 ? corner + 2 : corner - 1],
                  after = table.point[place == 2 ? corner - 2 : corner + 1];
      ring.push_back({corner, face, 3, before, after, before == other || after == other});
    });
    return;
  }
  table.each_corner(of, [&](Index corner) {
    const Index before = table.point_before(corner), after = table.point_after(corner);
    const Index f = table.face(corner);
    ring.push_back({corner, f, table.face_size(f), before, after, before == other || after == other});
  });
}

}  // namespace

void EdgeRings::gather(const CornerTable& table, Index removed_point, Index kept_point) {
  gather_ring(table, removed_point, kept_point, removed);
  gather_ring(table, kept_point, removed_point, kept);
}

bool EdgeRings::lie_within(const CornerTable& table, Index first, Index last) const {
  const auto inside = [&](Index p) { return p >= first && p < last; };
  const auto lies_within = [&](const RingCorner& c) {
    if (!inside(c.before) || !inside(c.after)) return false;
    if (c.size == 3) return true;
    bool all = true;
    table.each_corner_of_face(c.face, [&](Index corner) { all = all && inside(table.point[corner]); });
    return all;
  };
  return std::all_of(removed.begin(), removed.end(), lies_within) &&
         std::all_of(kept.begin(), kept.end(), lies_within);
}

Vec3 twice_vector_area(const CornerTable& table, Index face, Index moved_a, Index moved_b,
                       const Vec3& position) {
  const auto at = [&](Index corner) -> const Vec3& {
    const Index p = table.point[corner];
    return p == moved_a || p == moved_b ? position : table.positions[p];
  };
  const Index start = table.face_corner(face);
  const Vec3 origin = at(start);
  Index corner = table.next(start);
  Vec3 a = at(corner) - origin;
  Vec3 sum = Vec3::Zero();
  for (corner = table.next(corner); corner != start; corner = table.next(corner)) {
    const Vec3 b = at(corner) - origin;
    sum += a.cross(b);
    a = b;
  }
  return sum;
}

EdgeFreedom edge_freedom(const CornerTable& table, Index first, Index second) {
  const PointClass a = table.classes[first], b = table.classes[second];
  EdgeFreedom freedom;
  if (table.is_held(first, second)) return freedom;
  if (a == PointClass::smooth && b == PointClass::smooth) return {true, true, true, true};
  if (a != PointClass::smooth && b != PointClass::smooth) {
    // Both on lines: only along a line, and only if one of them may move along it.
    if (a == PointClass::fixed && b == PointClass::fixed) return freedom;
    if (table.edge_kind(first, second) == k_smooth_edge) return freedom;
  }
  freedom.may_remove_first = a != PointClass::fixed && (a == PointClass::smooth || b != PointClass::smooth);
  freedom.may_remove_second = b != PointClass::fixed && (b == PointClass::smooth || a != PointClass::smooth);
  freedom.may_move = a == PointClass::crease && b == PointClass::crease;
  freedom.allowed = freedom.may_remove_first || freedom.may_remove_second;
  return freedom;
}

EdgeFreedom join_freedom(const CornerTable& table, Index first, Index second, bool keep_fixed) {
  EdgeFreedom freedom;
  if (table.is_held(first, second)) return freedom;
  const bool first_is_fixed = table.classes[first] == PointClass::fixed,
             second_is_fixed = table.classes[second] == PointClass::fixed;
  if (first_is_fixed && second_is_fixed && keep_fixed) return freedom;
  freedom.allowed = true;
  freedom.may_remove_first = !first_is_fixed || second_is_fixed;
  freedom.may_remove_second = !second_is_fixed || first_is_fixed;
  freedom.may_move = !first_is_fixed && !second_is_fixed;
  return freedom;
}

namespace {

/// True when a triangle lies on the far side of the edge from `x` to `y`.
bool has_triangle_on(const CornerTable& table, Index x, Index y) {
  bool found = false;
  table.each_corner(x, [&](Index c) {
    if (table.face_size(table.face(c)) != 3) return;
    if (table.point_after(c) == y || table.point_before(c) == y) found = true;
  });
  return found;
}

}  // namespace

int polygon_loss(const CornerTable& table, Index first, Index second) {
  int triangles = 0, others = 0;
  bool row = false;
  table.each_corner(first, [&](Index c) {
    const Index after = table.next(c), before = table.previous(c);
    if (table.point[after] != second && table.point[before] != second) return;
    const Index size = table.face_size(table.face(c));
    ++(size == 3 ? triangles : others);
    if (size != 4) return;
    const bool runs_along = table.point[after] == second;
    const Index x = table.point[runs_along ? before : after];
    const Index y = table.point[runs_along ? table.next(after) : table.previous(before)];
    row = row || has_triangle_on(table, x, y);
  });
  if (others == 0) return 0;
  return triangles > 0 || row ? 1 : 2;
}

double local_deviation(const CornerTable& table, const EdgeRings& rings, const Collapse& collapse) {
  // Polygons count by their ears at the ends.
  const auto squared_distance = [&](const Vec3& from, bool after) {
    double nearest = std::numeric_limits<double>::infinity();
    const auto place = [&](Index p) {
      const bool moves = after && (p == collapse.removed || p == collapse.kept);
      return moves ? collapse.position : table.positions[p];
    };
    const auto look = [&](const std::vector<RingCorner>& ring, Index end) {
      for (const RingCorner& c : ring) {
        if (after && c.on_edge && c.size == 3) continue;
        const Triangle ear{place(end), place(c.after), place(c.before)};
        nearest = std::min(nearest, (closest_point_on_triangle(from, ear) - from).squaredNorm());
      }
    };
    look(rings.removed, collapse.removed);
    look(rings.kept, collapse.kept);
    return nearest;
  };
  const double here = std::sqrt(squared_distance(collapse.position, false));
  double deviation = 0;
  for (const Index end : {collapse.removed, collapse.kept}) {
    const double left = std::sqrt(squared_distance(table.positions[end], true));
    deviation = std::max(deviation, static_cast<double>(table.deviation[end]) + std::max(left, here));
  }
  return deviation;
}

CollapseRules::CollapseRules(const CornerTable& table, double least_normal_cosine)
    : table_(table), least_cosine_(least_normal_cosine) {}

bool CollapseRules::face_has_both(const RingCorner& corner, Index other) const {
  if (corner.size == 3 || corner.on_edge) return false;
  for (Index c = table_.next(corner.corner); c != corner.corner; c = table_.next(c)) {
    if (table_.point[c] == other) return true;
  }
  return false;
}

bool CollapseRules::is_third(Index point) const {
  return std::find(thirds_.begin(), thirds_.end(), point) != thirds_.end();
}

bool CollapseRules::breaks_link(const EdgeRings& rings, const Collapse& collapse) {
  near_removed_.clear();
  thirds_.clear();
  // Around a smooth point every neighbour comes after one corner and before another.
  const bool removed_is_smooth = table_.classes[collapse.removed] == PointClass::smooth;
  for (const RingCorner& c : rings.removed) {
    near_removed_.push_back(c.after);
    if (!removed_is_smooth) near_removed_.push_back(c.before);
    if (face_has_both(c, collapse.kept)) return true;
    if (c.on_edge && c.size == 3) thirds_.push_back(c.before == collapse.kept ? c.after : c.before);
  }
  constexpr std::size_t k_short = 32;
  const bool is_long = near_removed_.size() > k_short;
  if (is_long) std::sort(near_removed_.begin(), near_removed_.end());
  const auto touches = [&](Index p) {
    if (p == collapse.removed) return false;
    const bool near = is_long
                          ? std::binary_search(near_removed_.begin(), near_removed_.end(), p)
                          : std::find(near_removed_.begin(), near_removed_.end(), p) != near_removed_.end();
    return near && !is_third(p);
  };
  const bool kept_is_smooth = table_.classes[collapse.kept] == PointClass::smooth;
  for (const RingCorner& c : rings.kept) {
    if (touches(c.after) || (!kept_is_smooth && touches(c.before))) return true;
  }
  // A third corner must keep a face beside the new point, or a piece of surface would vanish.
  const auto survives = [&](Index third) {
    const auto holds = [&](const RingCorner& c) {
      return (c.before == third || c.after == third) && !(c.on_edge && c.size == 3);
    };
    return std::any_of(rings.removed.begin(), rings.removed.end(), holds) ||
           std::any_of(rings.kept.begin(), rings.kept.end(), holds);
  };
  return !std::all_of(thirds_.begin(), thirds_.end(), survives);
}

/// A triangle with creases on two sides would make them one line.
bool CollapseRules::closes_crease(const Collapse& collapse) const {
  return std::any_of(thirds_.begin(), thirds_.end(), [&](Index third) {
    return table_.classes[third] != PointClass::smooth &&
           table_.classes[collapse.removed] != PointClass::smooth &&
           table_.edge_kind(collapse.removed, third) != k_smooth_edge &&
           table_.edge_kind(collapse.kept, third) != k_smooth_edge;
  });
}

bool CollapseRules::makes_duplicate(const EdgeRings& rings, const Collapse& collapse, bool look_at_all) {
  // After the collapse, twins at the new point have the same two neighbours. Faces of different rings share
  // none but third corners, so on triangle meshes most are out at once; a larger polygon that is shortened
  // brings neighbours of both ends together.
  shapes_.clear();
  const bool shortens =
      look_at_all || std::any_of(rings.removed.begin(), rings.removed.end(),
                                 [](const RingCorner& c) { return c.on_edge && c.size > 3; });
  const auto add = [&](const RingCorner& c, bool from_removed) {
    if (c.on_edge && c.size == 3) return;
    if (c.on_edge) {
      if (!from_removed) return;  // met once, from the removed end
      const bool kept_is_before = c.before == collapse.kept;
      const Index at_kept = kept_is_before ? table_.previous(c.corner) : table_.next(c.corner);
      const Index beyond = table_.point[kept_is_before ? table_.previous(at_kept) : table_.next(at_kept)];
      shapes_.push_back({beyond, kept_is_before ? c.after : c.before, c.size - 1, c.face});
    } else if (shortens || (is_third(c.before) && is_third(c.after))) {
      shapes_.push_back({c.before, c.after, c.size, c.face});
    }
  };
  for (const RingCorner& c : rings.removed) add(c, true);
  for (const RingCorner& c : rings.kept) add(c, false);
  const auto vertices = [&](Index face) {
    std::vector<Index> points;
    table_.each_corner_of_face(face, [&](Index c) {
      const Index p = table_.point[c];
      if (p != collapse.removed && p != collapse.kept) points.push_back(p);
    });
    std::sort(points.begin(), points.end());
    return points;
  };
  for (std::size_t i = 0; i < shapes_.size(); ++i) {
    for (std::size_t j = i + 1; j < shapes_.size(); ++j) {
      const Shape &x = shapes_[i], &y = shapes_[j];
      if (x.size != y.size || std::minmax(x.before, x.after) != std::minmax(y.before, y.after)) continue;
      if (x.size == 3 || vertices(x.face) == vertices(y.face)) return true;
    }
  }
  return false;
}

/// True when a corner of a polygon with more than three sides begins to turn the wrong way: the vector area
/// alone doesn't see a polygon that crosses itself.
bool CollapseRules::turns_corner(const RingCorner& corner, Index moved, const Collapse& collapse,
                                 const Vec3& normal_before, const Vec3& normal_after) const {
  const auto place = [&](Index p, bool after) -> const Vec3& {
    const bool moves = p == moved || (after && (p == collapse.removed || p == collapse.kept));
    return after && moves ? collapse.position : table_.positions[p];
  };
  const auto turn = [&](Index before, Index middle, Index next, bool after) {
    const Vec3 &a = place(before, after), &b = place(middle, after), &c = place(next, after);
    return (b - a).cross(c - b).dot(after ? normal_after : normal_before);
  };
  // The corner itself and its two neighbours change; those of the collapsed edge are skipped as they vanish.
  const Index c0 = corner.corner;
  for (const Index middle : {table_.previous(c0), c0, table_.next(c0)}) {
    Index before = table_.previous(middle), next = table_.next(middle);
    if (corner.on_edge) {
      const Index other = moved == collapse.removed ? collapse.kept : collapse.removed;
      if (table_.point[middle] == other) continue;
      if (table_.point[before] == other && middle == c0) before = table_.previous(before);
      if (table_.point[next] == other && middle == c0) next = table_.next(next);
    }
    const Index p = table_.point[before], q = table_.point[middle], r = table_.point[next];
    if (turn(p, q, r, false) > 0 && !(turn(p, q, r, true) > 0)) return true;
  }
  return false;
}

std::optional<Refusal> CollapseRules::shape_refusal(const RingCorner& corner, Index moved,
                                                    const Collapse& collapse) const {
  const Vec3 &from = table_.positions[moved], &p = table_.positions[corner.before],
             &q = table_.positions[corner.after];
  Vec3 before, after;
  if (corner.size == 3) {
    before = (q - from).cross(p - from);
    after = (q - collapse.position).cross(p - collapse.position);
  } else {
    before = twice_vector_area(table_, corner.face);
    after = corner.on_edge
                ? twice_vector_area(table_, corner.face, collapse.removed, collapse.kept, collapse.position)
                : twice_vector_area(table_, corner.face, moved, k_no_index, collapse.position);
  }
  const double area_before = before.squaredNorm(), area_after = after.squaredNorm();
  const double cosine = before.dot(after);
  const bool turns =
      !(cosine * std::abs(cosine) > least_cosine_ * std::abs(least_cosine_) * area_before * area_after);
  // Most polygons keep their direction and most of their area, and that is all there is to ask of a triangle.
  constexpr double k_most_area = 0.01;
  if (corner.size == 3 && !turns && area_after > k_most_area * area_before) return std::nullopt;
  // Areas and sides are squared here. Below this ratio of area to squared side, a normal is rounding noise in
  // coordinates of size 1.
  constexpr double k_flat = 1e-10 * 1e-10;
  const double longest_before = std::max((p - from).squaredNorm(), (q - from).squaredNorm());
  const double longest =
      std::max((p - collapse.position).squaredNorm(), (q - collapse.position).squaredNorm());
  // Nor has a polygon a direction that is thinner than what coordinates in single precision tell apart.
  constexpr double k_thin = 3e-8;
  const bool was_flat = !(area_before > k_flat * longest_before * longest_before) ||
                        area_before < k_thin * k_thin * longest_before;
  if (!(area_after > k_flat * longest * longest)) {
    if (was_flat) return std::nullopt;
    return Refusal::degenerate;
  }
  if (was_flat) return std::nullopt;
  if (turns) return Refusal::flip;
  if (corner.size > 3 && turns_corner(corner, moved, collapse, before, after)) return Refusal::flip;
  return std::nullopt;
}

std::optional<Refusal> CollapseRules::refusal(const EdgeRings& rings, const Collapse& collapse) {
  if (!collapse.position.allFinite()) return Refusal::degenerate;
  if (breaks_link(rings, collapse)) return Refusal::topology;
  if (closes_crease(collapse)) return Refusal::border;
  if (makes_duplicate(rings, collapse, false)) return Refusal::duplicate;
  return shapes_refusal(rings, collapse);
}

std::optional<Refusal> CollapseRules::join_refusal(const EdgeRings& rings, const Collapse& collapse) {
  if (!collapse.position.allFinite()) return Refusal::degenerate;
  thirds_.clear();
  for (const RingCorner& c : rings.removed) {
    if (c.on_edge || face_has_both(c, collapse.kept)) return Refusal::topology;
  }
  if (makes_duplicate(rings, collapse, true)) return Refusal::duplicate;
  return shapes_refusal(rings, collapse);
}

std::optional<Refusal> CollapseRules::shapes_refusal(const EdgeRings& rings, const Collapse& collapse) const {
  for (const RingCorner& c : rings.removed) {
    if (c.on_edge && c.size == 3) continue;
    if (const auto refused = shape_refusal(c, collapse.removed, collapse)) return refused;
  }
  if (collapse.position == table_.positions[collapse.kept]) return std::nullopt;
  for (const RingCorner& c : rings.kept) {
    if (c.on_edge) continue;  // those were seen from the removed end
    if (const auto refused = shape_refusal(c, collapse.kept, collapse)) return refused;
  }
  return std::nullopt;
}

}  // namespace recede::detail
