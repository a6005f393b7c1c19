#include "torture_set.h"

#include "hard_cases.h"
#include <recede/geometry/sample_models.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <random>

namespace recede::test {
namespace {

/// From 0 to 1, the same everywhere: distributions of the standard library aren't.
double share(std::mt19937& random) {
  return static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

PolygonSoup joined(PolygonSoup soup, const PolygonSoup& other) {
  append(soup, other);
  return soup;
}

PolygonSoup flipped(const PolygonSoup& soup, double part) {
  std::mt19937 random(7);
  PolygonSoup result;
  result.positions = soup.positions;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    std::vector<Index> face(soup.face(f).begin(), soup.face(f).end());
    if (share(random) < part) std::reverse(face.begin(), face.end());
    result.add_face(face);
  }
  return result;
}

/// Some triangles are cut at the middle of a side, a thousand-millionth beside it, and their neighbours
/// aren't: needles of that width stay between the two.
PolygonSoup with_t_junctions(const PolygonSoup& soup) {
  constexpr double k_beside = 1e-9;
  constexpr std::size_t k_every = 23;
  PolygonSoup result;
  result.positions = soup.positions;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const Index a = soup.face(f)[0], b = soup.face(f)[1], c = soup.face(f)[2];
    if (f % k_every != 0) {
      result.add_face(soup.face(f));
      continue;
    }
    const auto middle = static_cast<Index>(result.positions.size());
    result.positions.push_back((1 + k_beside) * (soup.positions[a] + soup.positions[b]) / 2);
    result.add_face(std::array<Index, 3>{a, middle, c});
    result.add_face(std::array<Index, 3>{middle, b, c});
    if (f % (2 * k_every) == 0) result.add_face(std::array<Index, 3>{a, b, middle});
  }
  return result;
}

PolygonSoup with_repeated_corners(PolygonSoup soup) {
  const std::size_t n = soup.n_faces();
  for (std::size_t f = 0; f < n; f += 13) {
    const Index a = soup.face(f)[0], b = soup.face(f)[1];
    soup.add_face(std::array<Index, 3>{a, b, a});
    if (f % 2 == 0) soup.add_face(std::array<Index, 3>{b, b, b});
  }
  return soup;
}

PolygonSoup with_noise(PolygonSoup soup, double size) {
  std::mt19937 random(11);
  for (Vec3& p : soup.positions) {
    for (int axis = 0; axis < 3; ++axis) p[axis] += size * (2 * share(random) - 1);
  }
  return soup;
}

PolygonSoup squashed(PolygonSoup soup, double height) {
  for (Vec3& p : soup.positions) p.z() *= height;
  return soup;
}

}  // namespace

void PrintTo(const TortureVariant& variant, std::ostream* out) { *out << variant.name; }

std::vector<TortureVariant> torture_set(std::size_t faces) {
  const PolygonSoup base = make_displaced_sphere(faces, true);
  const Vec3 none = Vec3::Zero();
  // Of a radius of 1, and about the length of a side.
  const double side = 4 / std::sqrt(static_cast<double>(faces));
  return {
      {"base", "a ball with ridges", base},
      {"far", "1e7 from the origin along each axis", transformed(base, 1, Vec3(1e7, 1e7, 1e7))},
      {"tiny", "a thousand-millionth of the size", transformed(base, 1e-9, none)},
      {"huge", "a thousand million times the size", transformed(base, 1e9, none)},
      {"overlapping_copies", "two of it, half a radius apart",
       joined(base, transformed(base, 1, Vec3(0.5, 0.03, 0.02)))},
      {"holes", "without every 37th triangle", with_holes(base)},
      {"flipped", "30 % of the triangles turned over", flipped(base, 0.3)},
      {"duplicate_faces", "every seventh triangle twice", with_duplicates(base)},
      {"fins", "third triangles at some edges", with_fins(base)},
      {"t_junctions", "sides cut on one side only, needles 1e-9 wide", with_t_junctions(base)},
      {"repeated_corners", "triangles that have a vertex twice", with_repeated_corners(base)},
      {"collinear_caps", "triangles without area at some edges", with_caps(base)},
      {"soup", "no vertices are shared", unwelded(base)},
      {"noise", "vertices moved by up to a side's length, so that it meets itself", with_noise(base, side)},
      {"near_copies", "two of it, 1e-6 apart", joined(base, transformed(base, 1, Vec3(1e-6, 0, 0)))},
      {"squashed", "1e-5 as high as wide", squashed(base, 1e-5)},
  };
}

}  // namespace recede::test
