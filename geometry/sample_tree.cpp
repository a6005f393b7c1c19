#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace recede {
namespace {

// Of the crown, an ellipsoid that branches end at.
const Vec3 k_crown_center(0, 6.2, 0), k_crown_radii(3.4, 3.7, 3.4);
constexpr Index k_bark = 0, k_leaf = 1;               // materials
constexpr std::size_t k_boughs = 11, k_branches = 6;  // of the trunk, of a bough
constexpr std::size_t k_leaves_of_a_twig = 10;
constexpr std::size_t k_usual_leaves = 2400;

// The standard's own distributions give other numbers from library to library.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}

  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_()) / 4294967296.0;
  }
  Vec3 direction() {
    const double z = between(-1, 1), angle = between(0, 2 * std::numbers::pi), radius = std::sqrt(1 - z * z);
    return {radius * std::cos(angle), radius * std::sin(angle), z};
  }

 private:
  std::mt19937 engine_;
};

// How far it is along a direction to the end of the crown.
double way_in_crown(const Vec3& from, const Vec3& direction) {
  const Vec3 p = (from - k_crown_center).cwiseQuotient(k_crown_radii),
             d = direction.cwiseQuotient(k_crown_radii);
  const double half = p.dot(d), rest = p.squaredNorm() - 1, root = half * half - d.squaredNorm() * rest;
  return root > 0 ? std::max(0.0, (-half + std::sqrt(root)) / d.squaredNorm()) : 0;
}

// A bent line that gets thinner: a trunk, a branch or a twig.
struct Limb {
  std::vector<Vec3> points;
  double radius = 0;  // at its foot

  Vec3 at(double share) const {
    const double place = share * static_cast<double>(points.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(place), points.size() - 2);
    return points[i] + (place - static_cast<double>(i)) * (points[i + 1] - points[i]);
  }
  Vec3 direction(double share) const {
    const auto i = static_cast<std::size_t>(share * static_cast<double>(points.size() - 1));
    return (points[std::min(i + 1, points.size() - 1)] - points[std::min(i, points.size() - 2)]).normalized();
  }
  double radius_at(double share) const { return radius * (1 - 0.8 * share); }
};

struct Growth {
  double length, radius;
  std::size_t pieces;
  double bend, rise;  // by chance and upwards, in each piece
};

Limb grow(const Vec3& foot, Vec3 direction, const Growth& growth, Dice& dice) {
  Limb limb{{foot}, growth.radius};
  for (std::size_t i = 0; i < growth.pieces; ++i) {
    limb.points.push_back(limb.points.back() +
                          growth.length / static_cast<double>(growth.pieces) * direction);
    direction += growth.bend * dice.direction() + growth.rise * Vec3::UnitY();
    direction.normalize();
  }
  return limb;
}

// Away from a limb by an angle, to the side that `around` turns to.
Vec3 branching(const Vec3& along, double angle, double around) {
  const Vec3 u = along.unitOrthogonal(), v = along.cross(u);
  return std::cos(angle) * along + std::sin(angle) * (std::cos(around) * u + std::sin(around) * v);
}

class Tree {
 public:
  explicit Tree(const TreeOptions& options) : n_leaves_(options.leaves), dice_(options.seed) {
    soup_.materials = {{.name = "bark", .base_color = Vec4(0.16, 0.1, 0.06, 1), .base_color_texture = ""},
                       {.name = "leaves", .base_color = Vec4(0.16, 0.36, 0.06, 1), .base_color_texture = ""}};
  }

  PolygonSoup run() {
    const Limb trunk = grow({0, 0, 0}, Vec3(0.02, 1, 0.02).normalized(), {8.2, 0.34, 9, 0.06, 0.03}, dice_);
    add_tube(trunk, 9);
    std::vector<Limb> branches;
    for (std::size_t b = 0; b < k_boughs; ++b) add_bough(trunk, b, branches);
    const std::size_t n_twigs = (n_leaves_ + k_leaves_of_a_twig - 1) / k_leaves_of_a_twig;
    for (std::size_t t = 0; t < n_twigs; ++t) {
      const std::size_t first = t * k_leaves_of_a_twig;
      add_twig(branches[t % branches.size()], std::min(k_leaves_of_a_twig, n_leaves_ - first));
    }
    return std::move(soup_);
  }

 private:
  // The golden angle apart, as they grow: no two of them stand above each other.
  void add_bough(const Limb& trunk, std::size_t number, std::vector<Limb>& branches) {
    const double share = static_cast<double>(number) / static_cast<double>(k_boughs - 1);
    const double height = 0.36 + 0.6 * share,
                 around = 2.4 * static_cast<double>(number) + dice_.between(-0.3, 0.3),
                 tilt = 1.25 - 0.8 * share + dice_.between(-0.12, 0.12);
    const Vec3 foot = trunk.at(height);
    const Vec3 direction(std::sin(tilt) * std::cos(around), std::cos(tilt),
                         std::sin(tilt) * std::sin(around));
    const double length = dice_.between(0.72, 0.88) * std::max(1.2, way_in_crown(foot, direction));
    const Limb bough = grow(foot, direction, {length, 0.55 * trunk.radius_at(height), 6, 0.14, 0.06}, dice_);
    add_tube(bough, 6);
    for (std::size_t b = 0; b < k_branches; ++b) {
      const double at = 0.28 + 0.72 * static_cast<double>(b + 1) / static_cast<double>(k_branches);
      const Vec3 side = branching(bough.direction(at), dice_.between(0.6, 1.1),
                                  2.4 * static_cast<double>(b) + dice_.between(-0.4, 0.4));
      const double reach = std::min(1.9, 0.75 * way_in_crown(bough.at(at), side));
      branches.push_back(
          grow(bough.at(at), side, {std::max(0.5, reach), 0.6 * bough.radius_at(at), 4, 0.2, 0.05}, dice_));
      add_tube(branches.back(), 4);
    }
  }

  void add_twig(const Limb& branch, std::size_t n_leaves) {
    const double at = dice_.between(0.25, 1);
    const Vec3 direction =
        branching(branch.direction(at), dice_.between(0.4, 1.2), dice_.between(0, 2 * std::numbers::pi));
    const Limb twig = grow(branch.at(at), direction, {dice_.between(0.45, 0.75), 0.016, 1, 0, 0}, dice_);
    add_tube(twig, 3);
    for (std::size_t leaf = 0; leaf < n_leaves; ++leaf) {
      const double place = 0.25 + 0.75 * static_cast<double>(leaf + 1) / static_cast<double>(n_leaves);
      add_leaf(twig.at(place), twig.direction(place), 2.4 * static_cast<double>(leaf));
    }
  }

  Index add_point(const Vec3& point, const Vec3& tint) {
    soup_.positions.push_back(point);
    soup_.vertex_colors.emplace_back(tint.x(), tint.y(), tint.z(), 1);
    return static_cast<Index>(soup_.positions.size() - 1);
  }

  template <std::size_t n>
  void add_face(const std::array<Index, n>& corners, Index material) {
    soup_.add_face(corners);
    soup_.face_materials.push_back(material);
  }

  // Rings whose directions are carried along the line, and a point at its end.
  void add_tube(const Limb& limb, Index n_sides) {
    const std::size_t n_pieces = limb.points.size() - 1;
    const auto first = static_cast<Index>(soup_.positions.size());
    Vec3 u = limb.direction(0).unitOrthogonal();
    for (std::size_t i = 0; i < n_pieces; ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(n_pieces);
      const Vec3 along = limb.direction(share);
      u = (u - u.dot(along) * along).normalized();
      const Vec3 v = along.cross(u);
      const Vec3 tint = dice_.between(0.75, 1) * Vec3::Ones();
      // The foot of the trunk is wide.
      const double radius = limb.radius_at(share) * (n_sides > 8 && i == 0 ? 1.6 : 1);
      for (Index side = 0; side < n_sides; ++side) {
        const double angle = 2 * std::numbers::pi * side / n_sides;
        add_point(limb.points[i] + radius * (std::cos(angle) * u + std::sin(angle) * v), tint);
      }
    }
    const Index tip = add_point(limb.points.back(), Vec3::Ones());
    for (Index i = 0; i < n_pieces; ++i) {
      for (Index side = 0; side < n_sides; ++side) {
        const Index a = first + i * n_sides + side, b = first + i * n_sides + (side + 1) % n_sides;
        if (i + 1 < n_pieces) {
          add_face(std::array{a, b, b + n_sides, a + n_sides}, k_bark);
        } else {
          add_face(std::array{a, b, tip}, k_bark);
        }
      }
    }
  }

  // Four triangles, folded along its middle and bent down to its end, face up rather than down.
  void add_leaf(const Vec3& foot, const Vec3& twig, double around) {
    const Vec3 outward = (foot - k_crown_center).cwiseQuotient(k_crown_radii);
    const Vec3 along =
        (branching(twig, dice_.between(0.7, 1.3), around) + 0.4 * outward - 0.25 * Vec3::UnitY())
            .normalized();
    Vec3 up = 0.9 * Vec3::UnitY() + 0.6 * outward + 0.7 * dice_.direction();
    up -= up.dot(along) * along;
    if (!(up.norm() > 0.1)) up = along.unitOrthogonal();
    up.normalize();
    // Many leaves are small ones.
    const double size = std::sqrt(static_cast<double>(k_usual_leaves) /
                                  static_cast<double>(std::max(n_leaves_, k_usual_leaves)));
    const double length = size * dice_.between(0.32, 0.46), width = length * dice_.between(0.26, 0.32);
    const Vec3 across = along.cross(up);
    const Vec3 stalk = foot + 0.06 * size * along, middle = stalk + 0.45 * length * along;
    const double fold = width * dice_.between(0.15, 0.4), droop = length * dice_.between(0.05, 0.2);
    // Some yellow, some dark.
    const double light = dice_.between(0.55, 1), yellow = dice_.between(0, 1);
    const Vec3 tint = light * Vec3(0.7 + 0.3 * yellow, 1, 1 - 0.3 * yellow);
    const Index base = add_point(stalk, tint), center = add_point(middle, tint),
                left = add_point(middle - width * across + fold * up, tint),
                right = add_point(middle + width * across + fold * up, tint),
                end = add_point(stalk + length * along - droop * up, tint);
    add_face(std::array{base, right, center}, k_leaf);
    add_face(std::array{center, right, end}, k_leaf);
    add_face(std::array{base, center, left}, k_leaf);
    add_face(std::array{center, end, left}, k_leaf);
  }

  std::size_t n_leaves_;
  Dice dice_;
  PolygonSoup soup_;
};

}  // namespace

PolygonSoup make_tree(const TreeOptions& options) { return Tree(options).run(); }

}  // namespace recede
