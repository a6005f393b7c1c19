#include "whole_shells.h"
#include <recede/shells/detail/layer_check.h>
#include <recede/shells/detail/simplex_contact.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

using test::Layer;

void expect_same_contacts(const ShellValidity& found, const ShellValidity& expected) {
  EXPECT_EQ(found.bottom_contacts, expected.bottom_contacts);
  EXPECT_EQ(found.top_contacts, expected.top_contacts);
  EXPECT_EQ(found.layer_contacts, expected.layer_contacts);
  EXPECT_EQ(found.wall_contacts, expected.wall_contacts);
}

std::size_t n_contacts(const ShellValidity& found) {
  return found.bottom_contacts.size() + found.top_contacts.size() + found.layer_contacts.size() +
         found.wall_contacts.size();
}

/// Vertices of the two triangles 0 1 2 and 3 4 5, or with fewer vertices those of `second`.
struct PairCase {
  const char* name;
  std::vector<Vec3> vertices;
  std::array<Index, 3> second;
  bool has_contact;
};

std::vector<PairCase> pair_cases() {
  const Vec3 a(0, 0, 0), b(4, 0, 0), c(0, 4, 0);
  return {
      {"apart, one above the other", {a, b, c, {0, 0, 1}, {4, 0, 1}, {0, 4, 1}}, {3, 4, 5}, false},
      {"a corner on the inside", {a, b, c, {1, 1, 0}, {1, 1, 3}, {2, 1, 3}}, {3, 4, 5}, true},
      {"a corner above the inside", {a, b, c, {1, 1, 1}, {1, 1, 3}, {2, 1, 3}}, {3, 4, 5}, false},
      {"a corner on an edge", {a, b, c, {2, 2, 0}, {1, 1, 3}, {2, 1, 3}}, {3, 4, 5}, true},
      {"a corner at a corner", {a, b, c, {4, 0, 0}, {5, 1, 3}, {6, -1, 3}}, {3, 4, 5}, true},
      {"an edge across an edge", {a, b, c, {2, 0, -1}, {2, 0, 1}, {2, -3, 0}}, {3, 4, 5}, true},
      {"an edge beside an edge", {a, b, c, {2, -1, -1}, {2, -1, 1}, {2, -3, 0}}, {3, 4, 5}, false},
      {"an edge through the inside", {a, b, c, {1, 1, -1}, {1, 1, 1}, {9, 9, 0}}, {3, 4, 5}, true},
      {"on a part of an edge", {a, b, c, {1, 0, 0}, {7, 0, 0}, {3, 0, 5}}, {3, 4, 5}, true},
      {"on the line of an edge", {a, b, c, {5, 0, 0}, {7, 0, 0}, {6, 0, 5}}, {3, 4, 5}, false},
      {"end to end on the line of an edge", {a, b, c, {4, 0, 0}, {7, 0, 0}, {6, 0, 5}}, {3, 4, 5}, true},
      {"in the plane, across", {a, b, c, {1, 1, 0}, {9, 1, 0}, {9, 9, 0}}, {3, 4, 5}, true},
      {"in the plane, inside", {a, b, c, {1, 1, 0}, {2, 1, 0}, {1, 2, 0}}, {3, 4, 5}, true},
      {"in the plane, around", {a, b, c, {-9, -9, 0}, {30, -9, 0}, {-9, 30, 0}}, {3, 4, 5}, true},
      {"in the plane, star",
       {{0, 0, 0}, {6, 0, 0}, {3, 6, 0}, {0, 4, 0}, {6, 4, 0}, {3, -2, 0}},
       {3, 4, 5},
       true},
      {"in the plane, apart", {a, b, c, {3, 3, 0}, {9, 3, 0}, {9, 9, 0}}, {3, 4, 5}, false},
      {"in the plane, at a corner", {a, b, c, {4, 0, 0}, {9, 1, 0}, {9, 9, 0}}, {3, 4, 5}, true},
      {"in the plane, along an edge", {a, b, c, {1, 0, 0}, {2, -1, 0}, {3, 0, 0}}, {3, 4, 5}, true},
      {"the same place", {a, b, c, a, b, c}, {3, 4, 5}, true},
      {"a common corner", {a, b, c, {-4, 0, 1}, {0, -4, 1}}, {0, 3, 4}, false},
      {"a common corner, standing on it", {a, b, c, {1, 1, 3}, {1, 2, 3}}, {0, 3, 4}, false},
      {"a common corner, an edge on the inside", {a, b, c, {1, 1, 0}, {1, 1, 3}}, {0, 3, 4}, true},
      {"a common corner, an edge on an edge", {a, b, c, {2, 0, 0}, {1, 1, 3}}, {0, 3, 4}, true},
      {"a common corner, through the inside", {a, b, c, {1, 1, -1}, {1, 1, 2}}, {0, 3, 4}, true},
      {"a common corner, through the plane outside", {a, b, c, {-1, -1, -1}, {-1, -1, 2}}, {0, 3, 4}, false},
      {"a common corner, through the plane far away", {a, b, c, {9, -1, -1}, {9, -1, 2}}, {0, 3, 4}, false},
      {"a common corner, next to it in the plane", {a, b, c, {-4, 0, 0}, {0, -4, 0}}, {0, 3, 4}, false},
      {"a common corner, on it in the plane", {a, b, c, {9, 2, 0}, {2, 9, 0}}, {0, 3, 4}, true},
      {"a common edge, flat", {a, b, c, {0, -4, 0}}, {1, 0, 3}, false},
      {"a common edge, at an angle", {a, b, c, {0, 4, 1}}, {1, 0, 3}, false},
      {"a common edge, folded onto it", {a, b, c, {9, 9, 0}}, {1, 0, 3}, true},
      {"three common corners", {a, b, c}, {0, 2, 1}, true},
  };
}

/// The pair as bottoms, with tops so far away that they don't matter.
bool has_contact(const PairCase& pair, const std::vector<Vec3>& vertices) {
  Layer layer{vertices, {}, {0, 1, 2, pair.second[0], pair.second[1], pair.second[2]}};
  for (const Vec3& p : vertices) layer.top.push_back(p + Vec3(0, 0, 1e300));
  return !test::check(layer).bottom_contacts.empty();
}

TEST(ShellContacts, TwoTrianglesMeetWhereverTheyTouch) {
  for (const PairCase& pair : pair_cases()) {
    SCOPED_TRACE(pair.name);
    EXPECT_EQ(has_contact(pair, pair.vertices), pair.has_contact);
    // The same from every side and in every plane.
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<Vec3> vertices = pair.vertices;
      for (Vec3& p : vertices) p = Vec3(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]);
      EXPECT_EQ(has_contact(pair, vertices), pair.has_contact) << axis;
      for (Vec3& p : vertices) p = Vec3(p.x() + 2 * p.y(), 3 * p.z() - p.y(), p.x() - p.z() + 5 * p.y());
      EXPECT_EQ(has_contact(pair, vertices), pair.has_contact) << axis << ", sheared";
    }
  }
}

TEST(ShellContacts, ScalesAndOffsetsDontMatter) {
  // Maps that round nothing: powers of two, another one for each axis, and steps by whole numbers.
  for (const PairCase& pair : pair_cases()) {
    SCOPED_TRACE(pair.name);
    const std::vector<std::array<int, 3>> exponents = {
        {-30, -30, -30}, {30, 30, 30}, {-400, 300, 17}, {900, -900, 1}, {-1060, -1000, 0}};
    for (const auto& [x, y, z] : exponents) {
      std::vector<Vec3> vertices = pair.vertices;
      for (Vec3& p : vertices) p = {std::ldexp(p.x(), x), std::ldexp(p.y(), y), std::ldexp(p.z(), z)};
      EXPECT_EQ(has_contact(pair, vertices), pair.has_contact) << x << ' ' << y << ' ' << z;
    }
    for (const double offset : {1e6, 0x1p49}) {
      std::vector<Vec3> vertices = pair.vertices;
      for (Vec3& p : vertices) p += Vec3(offset, -offset, 3 * offset);
      EXPECT_EQ(has_contact(pair, vertices), pair.has_contact) << offset;
    }
  }
}

TEST(ShellContacts, OneUnitInTheLastPlaceDecides) {
  // A corner on a slanted plane through points that all have many digits.
  const Vec3 a(0.1, 0.1, 0.3), b(0.7, 0.1, 0.3), c(0.1, 0.9, 0.3);
  const PairCase on{"", {a, b, c, {0.3, 0.3, 0.3}, {0.3, 0.3, 1}, {0.4, 0.3, 1}}, {3, 4, 5}, true};
  EXPECT_TRUE(has_contact(on, on.vertices));
  std::vector<Vec3> above = on.vertices, below = on.vertices;
  above[3].z() = std::nextafter(0.3, 1.0);
  below[3].z() = std::nextafter(0.3, 0.0);
  EXPECT_FALSE(has_contact(on, above));
  EXPECT_TRUE(has_contact(on, below));
  // The plane x + y = z, where rounded determinants are noise.
  std::vector<Vec3> slanted = {{12, 12, 24}, {24, 0.5, 24.5}, {0.5, 24, 24.5}, {12.25, 12.125, 24.375},
                               {12, 12, 30}, {13, 12, 30}};
  EXPECT_TRUE(has_contact(on, slanted));
  slanted[3].z() = std::nextafter(24.375, 25.0);
  EXPECT_FALSE(has_contact(on, slanted));
}

TEST(ShellContacts, OfRandomSimplicesWithoutCommonCornersAreThoseOfBruteForce) {
  // On so few places that many have no area or no volume.
  std::mt19937 random(12);
  std::size_t n_apart = 0, n_contacts_of[3] = {};
  for (int i = 0; i < 60000; ++i) {
    const unsigned width = i % 3 == 0 ? 2 : i % 3 == 1 ? 3 : 7;
    std::vector<Vec3> points;
    for (int k = 0; k < 8; ++k)
      points.emplace_back(random() % width, random() % width, random() % (i % 2 == 0 ? 2u : 3u));
    const int first = 3 + i % 5 % 2, second = 3 + i % 7 % 2;
    if (i % 4 == 0) {  // all on one line
      const Vec3 a = points[0], step = points[1];
      for (Vec3& p : points) p = a + p.x() * step;
    } else if (i % 11 == 0) {  // the second one between the corners of the first
      for (std::size_t k = 0; k < 4; ++k) points[k] *= 8;
      const Vec3 middle = 0.25 * (points[0] + points[1] + points[2] + (first == 3 ? points[0] : points[3]));
      for (std::size_t k = 4; k < 8; ++k) points[k] += middle;
    }
    const detail::Simplex a{{0, 1, 2, 3}, first}, b{{4, 5, 6, 7}, second};
    std::vector<Index> corners = {0, 1, 2, 3}, others = {4, 5, 6, 7};
    corners.resize(static_cast<std::size_t>(first));
    others.resize(static_cast<std::size_t>(second));
    const bool expected = test::meet_apart(points, corners, others);
    ASSERT_EQ(detail::has_contact(points, a, b), expected) << i;
    ASSERT_EQ(detail::has_contact(points, b, a), expected) << i;
    n_apart += expected ? 0 : 1;
    n_contacts_of[first + second - 6] += expected ? 1 : 0;
  }
  EXPECT_GT(n_apart, 5000u);
  for (const std::size_t n : n_contacts_of) EXPECT_GT(n, 2000u);
}

TEST(ShellContacts, ATetrahedronInsideAnotherIsOne) {
  const std::vector<Vec3> points = {{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {0, 0, 9},
                                    {1, 1, 1}, {2, 1, 1}, {1, 2, 1}, {1, 1, 2}};
  const detail::Simplex outer{{0, 1, 2, 3}, 4}, inner{{4, 5, 6, 7}, 4};
  EXPECT_TRUE(detail::has_contact(points, outer, inner));
  EXPECT_TRUE(detail::has_contact(points, inner, outer));
  EXPECT_TRUE(detail::has_contact(points, {{0, 5, 6, 7}, 4}, outer)) << "from a common corner inward";
  EXPECT_TRUE(detail::has_contact(points, outer, {{0, 5, 6, 7}, 4}));
  EXPECT_TRUE(detail::has_contact(points, outer, {{0, 5, 6}, 3}));
  EXPECT_TRUE(detail::has_contact(points, {{4, 5, 6}, 3}, outer));
}

/// Loose and connected triangles between whole points of a small cube.
Layer random_triangles(std::size_t n_vertices, std::size_t n_triangles, unsigned size, std::mt19937& random) {
  Layer layer;
  const auto coordinate = [&] { return static_cast<double>(random() % (2 * size + 1)) - size; };
  for (std::size_t v = 0; v < n_vertices; ++v) {
    layer.bottom.emplace_back(coordinate(), coordinate(), coordinate());
    layer.top.push_back(layer.bottom.back() + Vec3(coordinate(), coordinate(), coordinate()));
  }
  const auto is_flat = [&](const std::vector<Vec3>& points, Index a, Index b, Index c) {
    return (points[b] - points[a]).cross(points[c] - points[a]).isZero(0);
  };
  while (layer.triangles.size() < 3 * n_triangles) {
    const auto vertex = [&] { return static_cast<Index>(random() % n_vertices); };
    const Index a = vertex(), b = vertex(), c = vertex();
    if (is_flat(layer.bottom, a, b, c) || is_flat(layer.top, a, b, c)) continue;
    for (const Index v : {a, b, c}) layer.triangles.push_back(v);
  }
  return layer;
}

/// Whether a wall has a face without area: those are left to the prism at it.
bool has_flat_wall_face(const Layer& layer) {
  for (const test::WholePart& part : test::parts_of(layer)) {
    if (part.kind != ShellPart::wall) continue;
    const Vec3 &a = layer.bottom[part.points[0]], &b = layer.bottom[part.points[1]];
    const Vec3 &c = layer.top[part.points[0]], &d = layer.top[part.points[1]];
    for (const Vec3& normal : {Vec3((b - a).cross(c - a)), Vec3((b - a).cross(d - a)),
                               Vec3((c - a).cross(d - a)), Vec3((c - b).cross(d - b))}) {
      if (normal.isZero(0)) return true;
    }
  }
  return false;
}

TEST(ShellContacts, OfRandomTrianglesAreThoseOfBruteForce) {
  std::mt19937 random(11);
  std::size_t n = 0, n_walls = 0;
  for (int i = 0; i < 250; ++i) {
    const unsigned size = i % 3 == 0 ? 2 : i % 3 == 1 ? 5 : 300;
    const Layer layer = random_triangles(4 + random() % 8, 2 + random() % 8, size, random);
    if (has_flat_wall_face(layer)) continue;
    SCOPED_TRACE(i);
    const ShellValidity expected = test::contacts_by_brute_force(layer);
    expect_same_contacts(test::check(layer), expected);
    n += n_contacts(expected);
    n_walls += expected.wall_contacts.size();
  }
  EXPECT_GT(n - n_walls, 1000u);
  EXPECT_GT(n_walls, 1000u);
}

/// Layers over meshes of some hundred triangles, valid ones and others.
std::vector<std::pair<std::string, Layer>> meshed_layers() {
  std::vector<std::pair<std::string, Layer>> layers;
  for (const unsigned seed : {1u, 2u, 3u}) {
    for (const double height : {1.2, 0.8, 0.5}) {
      layers.emplace_back("bumpy sphere", test::sphere_layer(2, 500, 0.12 * seed, height, seed));
    }
    Layer noisy = test::sphere_layer(2, 400, 0.1, 1.2, seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> noise(-70, 70);
    for (Vec3& p : noisy.top) p += Vec3(noise(random), noise(random), noise(random));
    layers.emplace_back("noisy tops", noisy);
  }
  for (const double gap : {0.0, 40.0, 41.0, 120.0}) {
    const auto sheet = [&](double z) {
      return test::sheet_layer(5, 5, [&](Index i, Index j, Index r) {
        return Vec3(60 * i, 60 * j, 40 * r + z + 10 * std::sin(i + 2.0 * j));
      });
    };
    layers.emplace_back("two close sheets", test::joined(sheet(0), sheet(gap)));
  }
  for (const double radius : {40.0, 120.0}) {  // a strip around half a turn, thicker than its radius or not
    layers.emplace_back("folded strip", test::sheet_layer(24, 2, [&](Index i, Index j, Index r) {
                          const double s = 20.0 * i - 240, bend = std::clamp(s / radius, -1.6, 1.6),
                                       rest = s - bend * radius;
                          const double size = radius - 60 * r;
                          return Vec3(size * std::sin(bend) + rest * std::cos(bend), 70 * j,
                                      -size * std::cos(bend) + rest * std::sin(bend));
                        }));
  }
  layers.emplace_back(
      "nearly closed ring", test::sheet_layer(20, 2, [](Index i, Index j, Index r) {
        const double angle = -2 * M_PI * i / 20.2, size = 200 + 80 * r + (i == 0 ? -3.0 : 0.0);
        return Vec3(size * std::cos(angle), 50 * j + (i == 0 ? 40.0 * r : 0.0), size * std::sin(angle));
      }));
  layers.emplace_back("needles", test::sheet_layer(30, 1, [](Index i, Index j, Index r) {
                        return Vec3(2 * i, 900 * j, 9 * r + (i % 2));
                      }));
  Layer flat = test::sheet_layer(6, 6, [](Index i, Index j, Index r) { return Vec3(10 * i, 10 * j, 7 * r); });
  layers.emplace_back("flat sheet", flat);
  flat.top = flat.bottom;
  layers.emplace_back("top on bottom", flat);
  for (auto& [name, layer] : layers) layer = test::whole(layer);
  return layers;
}

TEST(ShellContacts, OfMeshesAreThoseOfBruteForce) {
  std::size_t n_valid = 0, n_invalid = 0;
  for (const auto& [name, layer] : meshed_layers()) {
    SCOPED_TRACE(name);
    const ShellValidity expected = test::contacts_by_brute_force(layer);
    const ShellValidity found = test::check(layer);
    expect_same_contacts(found, expected);
    (n_contacts(expected) == 0 ? n_valid : n_invalid) += 1;
  }
  EXPECT_GE(n_valid, 6u);
  EXPECT_GE(n_invalid, 6u);
}

bool has_one_of(const Layer& layer, Index triangle, const std::vector<Index>& vertices) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Index v = layer.triangles[3 * std::size_t{triangle} + k];
    if (std::find(vertices.begin(), vertices.end(), v) != vertices.end()) return true;
  }
  return false;
}

TEST(ShellContacts, AtChangedVerticesAreThoseOfAllRestrictedToThem) {
  std::mt19937 random(4);
  std::size_t n = 0;
  std::vector<std::pair<std::string, Layer>> layers = meshed_layers();
  for (int i = 0; i < 20; ++i) layers.emplace_back("triangles", random_triangles(12, 14, 5, random));
  for (const auto& named : layers) {
    const Layer& layer = named.second;
    SCOPED_TRACE(named.first);
    const ShellValidity all = test::check(layer);
    for (const std::size_t count : {0u, 1u, 4u, 30u}) {
      std::vector<Index> changed;
      for (std::size_t i = 0; i < count; ++i)
        changed.push_back(static_cast<Index>(random() % layer.bottom.size()));
      const auto has = [&](Index triangle) { return has_one_of(layer, triangle, changed); };
      const auto lacks_both = [&](const std::pair<Index, Index>& p) {
        return !has(p.first) && !has(p.second);
      };
      ShellValidity expected = all;
      std::erase_if(expected.inverted, [&](Index t) { return !has(t); });
      std::erase_if(expected.bottom_contacts, lacks_both);
      std::erase_if(expected.top_contacts, lacks_both);
      std::erase_if(expected.layer_contacts, lacks_both);
      std::erase_if(expected.overlapping_neighbours, lacks_both);
      std::erase_if(expected.wall_contacts, [&](const WallContact& wall) {
        return !has(wall.corner / 3) && !has(wall.part == ShellPart::wall ? wall.other / 3 : wall.other);
      });
      ShellValidity found = test::check(layer, {.changed_vertices = changed});
      // These have a test of their own.
      found.nested_pieces = expected.nested_pieces;
      EXPECT_EQ(found, expected);
      n += n_contacts(found);
    }
  }
  EXPECT_GT(n, 500u);
}

// What is found in all of it, without what no part that moves with these vertices takes part in.
ShellValidity of_moved(ShellValidity found, const Layer& layer, const std::vector<Index>& moved) {
  const auto has = [&](Index triangle) { return has_one_of(layer, triangle, moved); };
  std::erase_if(found.inverted, [&](Index t) { return !has(t); });
  found.bottom_contacts.clear();
  found.overlapping_neighbours.clear();
  std::erase_if(found.top_contacts, [&](const auto& p) { return !has(p.first) && !has(p.second); });
  std::erase_if(found.layer_contacts, [&](const auto& p) { return !has(p.second); });
  std::erase_if(found.wall_contacts, [&](const WallContact& wall) {
    const bool is_other_moved = wall.part == ShellPart::wall  ? has(wall.other / 3)
                                : wall.part == ShellPart::top ? has(wall.other)
                                                              : false;
    return !has(wall.corner / 3) && !is_other_moved;
  });
  return found;
}

// Those of some vertices, a few perhaps twice; returns which.
std::vector<Index> move_some_tops(int count, Layer& layer, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::vector<Index> moved;
  for (int i = 0; i < count; ++i) {
    const auto v = static_cast<Index>(random() % layer.bottom.size());
    const double length = (layer.top[v] - layer.bottom[v]).norm();
    layer.top[v] += length * Vec3(normal(random), normal(random), normal(random));
    moved.push_back(v);
  }
  return moved;
}

TEST(ShellContacts, OfTopsThatMoveAgainAndAgainAreThoseOfAll) {
  std::mt19937 random(9);
  std::size_t n = 0;
  for (const auto& named : meshed_layers()) {
    Layer layer = named.second;
    SCOPED_TRACE(named.first);
    detail::LayerCheck check(layer.bottom, layer.top, layer.triangles, {}, false, nullptr);
    EXPECT_EQ(check.check_all(), test::check(layer));
    for (int round = 0; round < 5; ++round) {
      const std::vector<Index> moved = move_some_tops(3 * round, layer, random);
      const ShellValidity found = check.check_moved(layer.top, moved);
      EXPECT_EQ(found, of_moved(test::check(layer), layer, moved));
      n += n_contacts(found);
      EXPECT_EQ(check.check_all(), test::check(layer));
    }
  }
  EXPECT_GT(n, 500u);
}

// By a check of the whole and one of the rest alone, which has the walls around the excused triangles.
ShellValidity expected_beside(const Layer& layer, const std::vector<unsigned char>& is_excused) {
  ShellValidity found = test::check(layer);
  const auto are_excused = [&](const auto& p) {
    return is_excused[p.first] != 0 && is_excused[p.second] != 0;
  };
  std::erase_if(found.inverted, [&](Index t) { return is_excused[t] != 0; });
  for (ShellValidity::Pairs* pairs :
       {&found.bottom_contacts, &found.overlapping_neighbours, &found.top_contacts, &found.layer_contacts})
    std::erase_if(*pairs, are_excused);
  std::erase_if(found.wall_contacts, [&](const WallContact& wall) {
    return are_excused(
        std::pair(wall.corner / 3, wall.part == ShellPart::wall ? wall.other / 3 : wall.other));
  });
  std::vector<Index> rest;
  Layer alone = layer;
  alone.triangles.clear();
  for (std::size_t t = 0; t < is_excused.size(); ++t) {
    if (is_excused[t] != 0) continue;
    rest.push_back(static_cast<Index>(t));
    for (std::size_t k = 0; k < 3; ++k) alone.triangles.push_back(layer.triangles[3 * t + k]);
  }
  const ShellValidity of_rest = test::check(alone);
  found.nested_pieces.clear();
  for (const auto& [a, b] : of_rest.nested_pieces) found.nested_pieces.emplace_back(rest[a], rest[b]);
  const auto corner_of = [&](Index corner) { return 3 * rest[corner / 3] + corner % 3; };
  for (const WallContact& wall : of_rest.wall_contacts) {
    const bool is_wall = wall.part == ShellPart::wall;
    found.wall_contacts.push_back(
        {corner_of(wall.corner), wall.part, is_wall ? corner_of(wall.other) : rest[wall.other]});
  }
  std::sort(found.wall_contacts.begin(), found.wall_contacts.end());
  found.wall_contacts.erase(std::unique(found.wall_contacts.begin(), found.wall_contacts.end()),
                            found.wall_contacts.end());
  return found;
}

TEST(ShellContacts, BesideExcusedTrianglesAreThoseOfTheRestAndWithThem) {
  std::mt19937 random(10);
  std::size_t n = 0, n_nested = 0;
  for (const auto& named : meshed_layers()) {
    SCOPED_TRACE(named.first);
    for (const unsigned one_of : {2u, 6u}) {
      Layer layer = named.second;
      std::vector<unsigned char> is_excused;
      std::vector<Index> excused;
      for (Index t = 0; 3 * t < layer.triangles.size(); ++t) {
        is_excused.push_back(random() % one_of == 0);
        if (is_excused.back() != 0) excused.push_back(t);
      }
      detail::LayerCheck check(layer.bottom, layer.top, layer.triangles, excused, false, nullptr);
      EXPECT_EQ(check.check_all(), expected_beside(layer, is_excused));
      for (int round = 0; round < 3; ++round) {
        const std::vector<Index> moved = move_some_tops(6 * round, layer, random);
        const ShellValidity found = check.check_moved(layer.top, moved),
                            expected = expected_beside(layer, is_excused);
        EXPECT_EQ(found, of_moved(expected, layer, moved));
        EXPECT_EQ(check.check_all(), expected);
        n += n_contacts(found);
        n_nested += found.nested_pieces.size();
      }
    }
  }
  EXPECT_GT(n, 500u);
  EXPECT_GT(n_nested, 0u);
}

}  // namespace
}  // namespace recede
