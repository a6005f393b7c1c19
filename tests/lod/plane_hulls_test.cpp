#include "plane_integers.h"
#include <recede/lod/detail/plane_hulls.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

namespace recede::detail {
namespace {

using test::is_on_segment;
using test::whole_orientation;

using Points = std::vector<Vec2>;

// Whole coordinates, so that all signs are exact; a small range makes collinear and equal points common.
Points random_points(std::mt19937& random, std::size_t n, int range) {
  std::uniform_int_distribution<int> coordinate(0, range);
  Points points(n);
  for (Vec2& p : points) p = Vec2(coordinate(random), coordinate(random));
  return points;
}

bool in_triangle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& p) {
  const int one = whole_orientation(a, b, p), two = whole_orientation(b, c, p),
            three = whole_orientation(c, a, p);
  if (whole_orientation(a, b, c) == 0)
    return is_on_segment(a, b, p) || is_on_segment(b, c, p) || is_on_segment(c, a, p);
  return (one >= 0 && two >= 0 && three >= 0) || (one <= 0 && two <= 0 && three <= 0);
}

// Whether a point is in the hull of others, by Caratheodory: in a triangle between three of them.
bool in_hull(const Points& points, const Vec2& p) {
  for (const Vec2& a : points) {
    for (const Vec2& b : points) {
      for (const Vec2& c : points) {
        if (in_triangle(a, b, c, p)) return true;
      }
    }
  }
  return false;
}

bool segments_meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  return test::cross(a, b, c, d) || is_on_segment(a, b, c) || is_on_segment(a, b, d) ||
         is_on_segment(c, d, a) || is_on_segment(c, d, b);
}

// A point of one in the other, or segments between points that meet.
bool meet_by_brute_force(const Points& a, const Points& b) {
  for (const Vec2& p : a) {
    if (in_hull(b, p)) return true;
  }
  for (const Vec2& p : b) {
    if (in_hull(a, p)) return true;
  }
  for (const Vec2& p : a) {
    for (const Vec2& q : a) {
      for (const Vec2& r : b) {
        for (const Vec2& s : b) {
          if (segments_meet(p, q, r, s)) return true;
        }
      }
    }
  }
  return false;
}

TEST(ConvexHull, OfASquareAndItsMiddleIsTheSquare) {
  const Points hull = convex_hull({{1, 1}, {2, 0}, {0, 2}, {2, 2}, {0, 0}, {1, 0}});
  EXPECT_EQ(hull, (Points{{0, 0}, {2, 0}, {2, 2}, {0, 2}}));
}

TEST(ConvexHull, OfPointsOnALineIsItsEndsAndOfEqualOnesIsOne) {
  EXPECT_EQ(convex_hull({{2, 2}, {0, 0}, {1, 1}, {3, 3}, {1, 1}}), (Points{{0, 0}, {3, 3}}));
  EXPECT_EQ(convex_hull({{4, 1}, {4, 3}, {4, 2}}), (Points{{4, 1}, {4, 3}}));
  EXPECT_EQ(convex_hull({{5, 7}, {5, 7}, {5, 7}}), (Points{{5, 7}}));
  EXPECT_TRUE(convex_hull({}).empty());
}

TEST(ConvexHull, TurnsLeftAtEachCornerAndHoldsAllPoints) {
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    const int range = round % 3 == 0 ? 3 : round % 3 == 1 ? 8 : 1000;
    const Points points = random_points(random, 1 + random() % 12, range);
    const Points hull = convex_hull(points);
    for (const Vec2& corner : hull) EXPECT_NE(std::find(points.begin(), points.end(), corner), points.end());
    for (std::size_t i = 0; hull.size() > 2 && i < hull.size(); ++i) {
      const Vec2 &a = hull[i], &b = hull[(i + 1) % hull.size()], &c = hull[(i + 2) % hull.size()];
      EXPECT_EQ(whole_orientation(a, b, c), 1);
      for (const Vec2& p : points) EXPECT_GE(whole_orientation(a, b, p), 0);
    }
    if (hull.size() == 2) {
      for (const Vec2& p : points) EXPECT_TRUE(is_on_segment(hull[0], hull[1], p));
    }
  }
}

TEST(HullsMeet, AtACornerOnASideAndInside) {
  const Points square = convex_hull({{0, 0}, {4, 0}, {4, 4}, {0, 4}});
  EXPECT_TRUE(hulls_meet(square, {{4, 4}}));
  EXPECT_TRUE(hulls_meet(square, {{4, 1}}));
  EXPECT_TRUE(hulls_meet(square, {{1, 2}}));
  EXPECT_FALSE(hulls_meet(square, {{5, 2}}));
  EXPECT_TRUE(hulls_meet(square, {{4, 1}, {6, 1}}));
  EXPECT_FALSE(hulls_meet(square, {{5, 1}, {6, 1}}));
  // The boxes meet, the corner is beside the line.
  EXPECT_FALSE(hulls_meet(square, {{3, 6}, {6, 3}}));
  // On the same line.
  EXPECT_FALSE(hulls_meet({{0, 0}, {1, 1}}, {{2, 2}, {3, 3}}));
  EXPECT_TRUE(hulls_meet({{0, 0}, {2, 2}}, {{2, 2}, {3, 3}}));
}

TEST(HullsMeet, AsBruteForceSays) {
  std::mt19937 random(2);
  int n_meeting = 0;
  for (int round = 0; round < 4000; ++round) {
    const int range = round % 2 == 0 ? 5 : 12;
    Points a = random_points(random, 1 + random() % 5, range);
    Points b = random_points(random, 1 + random() % 5, range);
    if (round % 4 == 3) b[0] = a[0];
    // Some beside each other.
    if (round % 5 == 4) {
      for (Vec2& p : b) p.x() += range;
    }
    const bool expected = meet_by_brute_force(a, b);
    n_meeting += expected ? 1 : 0;
    const Points of_a = convex_hull(a), of_b = convex_hull(b);
    EXPECT_EQ(hulls_meet(of_a, of_b), expected) << round;
    EXPECT_EQ(hulls_meet(of_b, of_a), expected) << round;
  }
  EXPECT_GT(n_meeting, 400);
  EXPECT_LT(n_meeting, 3600);
}

TEST(HullsOverlapBeside, TellsATouchFromAnOverlap) {
  const Vec2 o(0, 0);
  // In quarters that are across, and in the same one.
  const Points right = convex_hull({o, {3, 1}, {1, 3}}), left = convex_hull({o, {-3, -1}, {-1, -3}});
  EXPECT_FALSE(hulls_overlap_beside(right, left, o));
  EXPECT_TRUE(hulls_overlap_beside(right, convex_hull({o, {2, 2}}), o));
  EXPECT_FALSE(hulls_overlap_beside(right, convex_hull({o, {2, -2}}), o));
  // Segments on the same line, to opposite sides and to the same.
  EXPECT_FALSE(hulls_overlap_beside({o, {1, 1}}, {{-1, -1}, o}, o));
  EXPECT_TRUE(hulls_overlap_beside({o, {1, 1}}, {o, {2, 2}}, o));
  // A side in common.
  EXPECT_TRUE(hulls_overlap_beside(right, convex_hull({o, {3, 1}, {3, -1}}), o));
}

TEST(HullsOverlapBeside, SeesThatNothingIsBesideAPointThatOneHoldsInside) {
  const Vec2 o(0, 0);
  const Points around = convex_hull({{0, 3}, {-3, -2}, {3, -2}});
  for (int i = 0; i < 12; ++i) {
    const double angle = i * std::numbers::pi / 6;
    const Points away{o, {std::cos(angle), std::sin(angle)}};
    EXPECT_TRUE(hulls_overlap_beside(around, away, o)) << i;
    EXPECT_TRUE(hulls_overlap_beside(away, around, o)) << i;
  }
}

// Convex sets with a point in common have another one in common exactly if a ray from it enters both.
bool overlap_by_brute_force(const Points& a, const Points& b, const Vec2& common) {
  const auto has_direction = [&](const Points& points, const Vec2& to) {
    // In the cone of the points: in a triangle from the common point to two of them, made large.
    for (const Vec2& p : points) {
      for (const Vec2& q : points) {
        if (p == common || q == common) continue;
        const Vec2 far_p = common + 1000 * (p - common), far_q = common + 1000 * (q - common);
        // Across from each other, the middle of the segment is the point itself.
        if (whole_orientation(common, p, q) == 0) {
          if (is_on_segment(common, far_p, to) || is_on_segment(common, far_q, to)) return true;
          if ((p - common).dot(q - common) < 0) {
            // All that other points add to the line is a side of it.
            for (const Vec2& r : points) {
              const int side = whole_orientation(p, q, r);
              if (side != 0 && whole_orientation(p, q, to) == side) return true;
            }
          }
        } else if (in_triangle(common, far_p, far_q, to)) {
          return true;
        }
      }
    }
    return false;
  };
  for (const Vec2& p : a) {
    if (p != common && has_direction(b, p)) return true;
  }
  for (const Vec2& p : b) {
    if (p != common && has_direction(a, p)) return true;
  }
  return false;
}

TEST(HullsOverlapBeside, AsBruteForceSays) {
  std::mt19937 random(3);
  int n_overlapping = 0;
  for (int round = 0; round < 4000; ++round) {
    const int range = round % 2 == 0 ? 4 : 10;
    Points a = random_points(random, 2 + random() % 3, range);
    Points b = random_points(random, 2 + random() % 3, range);
    const Vec2 common = a[0];
    b[0] = common;
    if (round % 3 == 2) {
      for (std::size_t i = 1; i < b.size(); ++i) b[i].x() -= range;
    }
    const bool expected = overlap_by_brute_force(a, b, common);
    n_overlapping += expected ? 1 : 0;
    const bool found = hulls_overlap_beside(convex_hull(a), convex_hull(b), common);
    EXPECT_EQ(found, expected) << round;
    EXPECT_EQ(hulls_overlap_beside(convex_hull(b), convex_hull(a), common), expected) << round;
  }
  EXPECT_GT(n_overlapping, 400);
  EXPECT_LT(n_overlapping, 3600);
}

}  // namespace
}  // namespace recede::detail
