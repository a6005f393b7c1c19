// Two triangles meet where an edge of one meets the other, so that segments decide everything; the sides of
// planes say beforehand, for nearly all pairs, that nothing meets.
#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/space_predicates.h>
#include <recede/shells/detail/simplex_contact.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace recede::detail {
namespace {

constexpr int k_no_axis = -1;

struct Corners {
  Vec3 a, b, c;
};

struct Segment {
  Vec3 a, b;
};

/// Seen along a coordinate axis.
Vec2 flat(const Vec3& p, int axis) { return {p[(axis + 1) % 3], p[(axis + 2) % 3]}; }

int flat_orientation(const Vec3& a, const Vec3& b, const Vec3& c, int axis) {
  return orientation(flat(a, axis), flat(b, axis), flat(c, axis));
}

/// An axis along which the points aren't seen on one line: what happens in their plane is seen there as it
/// is.
int axis_of_plane(const Vec3& a, const Vec3& b, const Vec3& c) {
  for (int axis = 2; axis >= 0; --axis) {
    if (flat_orientation(a, b, c, axis) != 0) return axis;
  }
  return k_no_axis;
}

/// The order of points along any line.
bool is_before(const Vec3& a, const Vec3& b) {
  return std::make_tuple(a.x(), a.y(), a.z()) < std::make_tuple(b.x(), b.y(), b.z());
}

/// Of segments on one line.
bool do_overlap(const Segment& s, const Segment& t) {
  const auto ends = [](const Segment& segment) {
    return is_before(segment.b, segment.a) ? std::pair(segment.b, segment.a)
                                           : std::pair(segment.a, segment.b);
  };
  const auto [first, last] = ends(s);
  const auto [other_first, other_last] = ends(t);
  return !is_before(last, other_first) && !is_before(other_last, first);
}

/// Of segments in a plane that is seen along the axis.
bool do_meet_in_plane(const Segment& s, const Segment& t, int axis) {
  const int c = flat_orientation(s.a, s.b, t.a, axis), d = flat_orientation(s.a, s.b, t.b, axis);
  if (c * d > 0) return false;
  const int a = flat_orientation(t.a, t.b, s.a, axis), b = flat_orientation(t.a, t.b, s.b, axis);
  if (a * b > 0) return false;
  const bool is_one_line = a == 0 && b == 0 && c == 0 && d == 0;
  return !is_one_line || do_overlap(s, t);
}

bool do_meet(const Segment& s, const Segment& t) {
  if (side_of_plane(s.a, s.b, t.a, t.b) != 0) return false;
  int axis = axis_of_plane(s.a, s.b, t.a);
  if (axis == k_no_axis) axis = axis_of_plane(s.a, s.b, t.b);
  if (axis == k_no_axis) axis = axis_of_plane(t.a, t.b, s.a);
  return axis == k_no_axis ? do_overlap(s, t) : do_meet_in_plane(s, t, axis);
}

/// The segment lies in the plane of the triangle, or the triangle has no area.
bool do_meet_in_plane(const Segment& s, const Corners& t) {
  const Segment sides[3] = {{t.a, t.b}, {t.b, t.c}, {t.c, t.a}};
  const int axis = axis_of_plane(t.a, t.b, t.c);
  if (axis == k_no_axis) {
    return std::any_of(std::begin(sides), std::end(sides),
                       [&](const Segment& side) { return do_meet(s, side); });
  }
  bool has_left = false, has_right = false;
  for (const Segment& side : sides) {
    if (do_meet_in_plane(s, side, axis)) return true;
    const int turn = flat_orientation(side.a, side.b, s.a, axis);
    has_left = has_left || turn > 0;
    has_right = has_right || turn < 0;
  }
  return !(has_left && has_right);  // inside
}

bool do_meet(const Segment& s, const Corners& t) {
  const int a = side_of_plane(t.a, t.b, t.c, s.a), b = side_of_plane(t.a, t.b, t.c, s.b);
  if (a * b > 0) return false;
  if (a == 0 && b == 0) return do_meet_in_plane(s, t);
  const int x = side_of_plane(s.a, s.b, t.a, t.b), y = side_of_plane(s.a, s.b, t.b, t.c);
  if (x * y < 0) return false;
  const int z = side_of_plane(s.a, s.b, t.c, t.a);
  return x * z >= 0 && y * z >= 0;
}

bool do_meet(const Corners& s, const Corners& t) {
  for (int swap = 0; swap < 2; ++swap) {
    const Corners& plane = swap == 0 ? s : t;
    const Corners& other = swap == 0 ? t : s;
    const int a = side_of_plane(plane.a, plane.b, plane.c, other.a);
    if (a != 0 && a == side_of_plane(plane.a, plane.b, plane.c, other.b) &&
        a == side_of_plane(plane.a, plane.b, plane.c, other.c)) {
      return false;
    }
  }
  return do_meet(Segment{s.a, s.b}, t) || do_meet(Segment{s.b, s.c}, t) || do_meet(Segment{s.c, s.a}, t) ||
         do_meet(Segment{t.a, t.b}, s) || do_meet(Segment{t.b, t.c}, s) || do_meet(Segment{t.c, t.a}, s);
}

/// Both have the corner a. The segment from there to another common point goes on up to the far side of one
/// of them.
bool do_meet_beyond_corner(const Corners& s, const Corners& t) {
  if (side_of_plane(s.a, s.b, s.c, t.b) * side_of_plane(s.a, s.b, s.c, t.c) > 0) return false;
  if (side_of_plane(t.a, t.b, t.c, s.b) * side_of_plane(t.a, t.b, t.c, s.c) > 0) return false;
  return do_meet(Segment{s.b, s.c}, t) || do_meet(Segment{t.b, t.c}, s);
}

/// Both have the side from a to b: they lie on each other when they are on the same side of it in one plane.
bool do_meet_beyond_side(const Corners& s, const Corners& t) {
  if (side_of_plane(s.a, s.b, s.c, t.c) != 0) return false;
  const int axis = axis_of_plane(s.a, s.b, s.c);
  if (axis == k_no_axis) return axis_of_plane(t.a, t.b, t.c) == k_no_axis;
  return flat_orientation(s.a, s.b, s.c, axis) == flat_orientation(s.a, s.b, t.c, axis);
}

using Three = std::array<Index, 3>;

bool has_contact(std::span<const Vec3> points, Three s, Three t) {
  // Common corners go to the front of both.
  std::size_t common = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = common; j < 3; ++j) {
      if (s[i] != t[j]) continue;
      std::swap(s[common], s[i]);
      std::swap(t[common], t[j]);
      ++common;
      break;
    }
  }
  if (common == 3) return true;
  const Corners first{points[s[0]], points[s[1]], points[s[2]]};
  const Corners second{points[t[0]], points[t[1]], points[t[2]]};
  if (common == 2) return do_meet_beyond_side(first, second);
  return common == 1 ? do_meet_beyond_corner(first, second) : do_meet(first, second);
}

std::array<Three, 4> faces(const Simplex& tetrahedron) {
  const auto& k = tetrahedron.corners;
  return {{{k[0], k[1], k[2]}, {k[0], k[1], k[3]}, {k[0], k[2], k[3]}, {k[1], k[2], k[3]}}};
}

/// Whether a corner of `other` that the tetrahedron hasn't lies in it or on it. Not asked of a flat one:
/// its faces cover it.
bool holds_corner(std::span<const Vec3> points, const Simplex& tetrahedron, const Simplex& other) {
  const auto corner = [&](std::size_t k) -> const Vec3& { return points[tetrahedron.corners[k]]; };
  const int side = side_of_plane(corner(0), corner(1), corner(2), corner(3));
  if (side == 0) return false;
  const auto end = tetrahedron.corners.end();
  for (int i = 0; i < other.size; ++i) {
    const Index index = other.corners[static_cast<std::size_t>(i)];
    if (std::find(tetrahedron.corners.begin(), end, index) != end) continue;
    const Vec3& p = points[index];
    if (side_of_plane(corner(0), corner(1), corner(2), p) != -side &&
        side_of_plane(corner(0), corner(1), p, corner(3)) != -side &&
        side_of_plane(corner(0), p, corner(2), corner(3)) != -side &&
        side_of_plane(p, corner(1), corner(2), corner(3)) != -side) {
      return true;
    }
  }
  return false;
}

bool has_contact(std::span<const Vec3> points, const Simplex& tetrahedron, const Three& triangle) {
  for (const Three& face : faces(tetrahedron)) {
    if (has_contact(points, face, triangle)) return true;
  }
  return holds_corner(points, tetrahedron, {{triangle[0], triangle[1], triangle[2]}, 3});
}

Three triangle_of(const Simplex& simplex) {
  return {simplex.corners[0], simplex.corners[1], simplex.corners[2]};
}

}  // namespace

bool has_contact(std::span<const Vec3> points, const Simplex& a, const Simplex& b) {
  if (a.size == 3) {
    return b.size == 3 ? has_contact(points, triangle_of(a), triangle_of(b))
                       : has_contact(points, b, triangle_of(a));
  }
  if (b.size == 3) return has_contact(points, a, triangle_of(b));
  for (const Three& face : faces(a)) {
    if (has_contact(points, b, face)) return true;
  }
  return holds_corner(points, a, b);
}

}  // namespace recede::detail
