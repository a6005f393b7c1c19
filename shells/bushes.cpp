// Bushes that grow: branches as cones with round ends, leaves as flat pads.
#include <recede/geometry/detail/hashed_number.h>
#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace recede {
namespace {

// A period is 1 long. Branches of a bush: a stem, and two generations more.
constexpr double k_thickness = 0.4, k_height = 0.3, k_stem_radius = 0.012;
constexpr int k_generations = 3, k_children = 5, k_leaves = 3;
constexpr double k_leaf_length = 0.055, k_leaf_half_width = 0.017, k_leaf_half_thickness = 0.006;

struct Branch {
  Vec3 from, along;  // `along` is a unit direction
  double length = 0, radius = 0, end_radius = 0;

  double inside(const Vec3& point) const {
    const double at = std::clamp((point - from).dot(along), 0.0, length);
    const double here = radius + (end_radius - radius) * at / length;
    return here - (point - from - at * along).norm();
  }
};

/// A flat pad with round ends and a round rim.
struct Leaf {
  Vec3 from;
  Eigen::Matrix3d axes;  // unit: along it, across it, and its normal
  double length = 0, half_width = 0, half_thickness = 0;

  double inside(const Vec3& point) const {
    const Vec3 at = axes.transpose() * (point - from);
    const double beyond = at.x() - std::clamp(at.x(), half_width, std::max(half_width, length - half_width));
    const double beside = std::max(0.0, std::hypot(beyond, at.y()) - half_width);
    return half_thickness - std::hypot(beside, at.z());
  }
};

/// A stem, or a branch with all that grows on it.
struct Tuft {
  std::vector<Branch> branches;
  std::vector<Leaf> leaves;
  Vec3 middle = Vec3::Zero();  // of a ball around it
  double radius = 0;

  void set_ball() {
    Box3 box;
    for (const Branch& branch : branches)
      box.extend(branch.from).extend(branch.from + branch.length * branch.along);
    for (const Leaf& leaf : leaves) box.extend(leaf.from);
    // What leaves, and branches, which are thinner, take around that.
    constexpr double k_beyond = k_leaf_length + k_leaf_half_thickness;
    middle = box.center();
    radius = box.diagonal().norm() / 2 + k_beyond;
  }
};

/// Puts together what has grown until now. Numbers of a branch are the same at any time, so that it only
/// grows.
class Growing {
 public:
  Growing(std::uint64_t key, double growth) : key_(key), growth_(growth) {}

  /// Adds the parts of a bush.
  void at(const Vec3& ground, std::vector<Tuft>& tufts) {
    const double height = k_height * (0.75 + 0.25 * number());
    const Vec3 up = Vec3(0.3 * (number() - 0.5), 0.3 * (number() - 0.5), 1).normalized();
    grow(0, {ground, up, 0, 0, 0}, height, 0);
    for (Tuft& tuft : tufts_) {
      if (tuft.branches.empty()) continue;
      tuft.set_ball();
      tufts.push_back(std::move(tuft));
    }
  }

 private:
  double number() { return detail::hashed_number(key_, next_++); }

  // Perpendicular to a direction.
  static Vec3 across(const Vec3& along, double angle) {
    const Vec3 first = along.unitOrthogonal(), second = along.cross(first);
    return std::cos(angle) * first + std::sin(angle) * second;
  }

  // From `birth` on a branch takes the same share of all growth, then its children go on where it is left.
  void grow(int generation, Branch branch, double full_length, double birth) {
    constexpr double k_time = 0.45;  // that a branch takes, of all growth
    const double age = std::clamp((growth_ - birth) / k_time, 0.0, 1.0);
    const double grown = age * (2 - age);
    branch.length = grown * full_length;
    branch.radius = k_stem_radius * grown * std::pow(0.55, generation);
    branch.end_radius = 0.5 * branch.radius;
    if (generation <= 1) tufts_.emplace_back();
    if (branch.length > 0) tufts_.back().branches.push_back(branch);
    const bool is_last = generation + 1 == k_generations;
    const int n = is_last ? k_leaves : k_children;
    for (int child = 0; child < n; ++child) {
      const double share = (child + 0.5 + 0.5 * number()) / (n + 0.5);
      const double angle = 2.4 * child + number(), lean = 0.7 + 0.4 * number();  // the golden angle
      // When the branch's end came by: the inverse of what `grown` is.
      const double passed = birth + k_time * (1 - std::sqrt(1 - share));
      const Vec3 at = branch.from + share * full_length * branch.along;
      const Vec3 side = across(branch.along, angle);
      const Vec3 direction = (std::cos(lean) * branch.along + std::sin(lean) * side).normalized();
      if (is_last) {
        add_leaf(at, direction, passed);
      } else {
        grow(generation + 1, {at, (direction + Vec3(0, 0, 0.2)).normalized(), 0, 0, 0}, 0.55 * full_length,
             passed);
      }
    }
  }

  void add_leaf(const Vec3& at, const Vec3& direction, double birth) {
    constexpr double k_time = 0.2;
    const double size = std::clamp((growth_ - birth) / k_time, 0.0, 1.0);
    const double turn = 6.3 * number();
    if (!(size > 0)) return;
    Leaf leaf{at, {}, size * k_leaf_length, size * k_leaf_half_width, size * k_leaf_half_thickness};
    const Vec3 wide = across(direction, turn);
    leaf.axes << direction, wide, direction.cross(wide);
    tufts_.back().leaves.push_back(leaf);
  }

  std::uint64_t key_, next_ = 0;
  double growth_;
  std::vector<Tuft> tufts_;
};

/// How far inside of branches and of leaves a point is, of the nearest.
struct Nearest {
  double branch = -std::numeric_limits<double>::infinity(), leaf = branch;

  double inside() const { return std::max(branch, leaf); }
};

/// A period's, and their copies in all others.
class Thicket {
 public:
  explicit Thicket(std::vector<Tuft> tufts) : tufts_(std::move(tufts)) {}

  Nearest nearest(const Vec3& point) const {
    // What may be nearest first: most others are farther away than that.
    std::size_t first = 0;
    double most = -std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < tufts_.size(); ++t) {
      const double bound = inside_at_most(tufts_[t], point);
      if (!(bound > most)) continue;
      most = bound;
      first = t;
    }
    Nearest nearest;
    for (std::size_t n = 0; n < tufts_.size(); ++n) {
      const std::size_t t = n == 0 ? first : n == first ? 0 : n;
      if (inside_at_most(tufts_[t], point) > nearest.inside()) add(tufts_[t], point, nearest);
    }
    return nearest;
  }

 private:
  static Vec3 in_period_of(const Tuft& tuft, Vec3 point) {
    for (int axis = 0; axis < 2; ++axis) point[axis] -= std::round(point[axis] - tuft.middle[axis]);
    return point;
  }
  static double inside_at_most(const Tuft& tuft, const Vec3& point) {
    return tuft.radius - (in_period_of(tuft, point) - tuft.middle).norm();
  }
  static void add(const Tuft& tuft, const Vec3& point, Nearest& nearest) {
    const Vec3 at = in_period_of(tuft, point);
    for (const Branch& branch : tuft.branches) nearest.branch = std::max(nearest.branch, branch.inside(at));
    for (const Leaf& leaf : tuft.leaves) nearest.leaf = std::max(nearest.leaf, leaf.inside(at));
  }

  std::vector<Tuft> tufts_;
};

}  // namespace

ProceduralVolume bushes(const BushOptions& options) {
  if (options.bushes < 1) throw OptionError("a texture of bushes needs one");
  if (!(options.growth >= 0) || !(options.growth <= 1))
    throw OptionError("the growth of bushes is from 0 to 1");
  // In a jittered grid, so that they stand apart.
  const int across = static_cast<int>(std::ceil(std::sqrt(options.bushes)));
  std::vector<Tuft> tufts;
  for (int b = 0; b < options.bushes; ++b) {
    const std::uint64_t key = (std::uint64_t{options.seed} << 32) + static_cast<std::uint64_t>(b);
    const auto place = [&](int cell, std::uint64_t which) {
      return (cell + 0.25 + 0.5 * detail::hashed_number(~key, which)) / across;
    };
    // Some are older than others.
    const double late = 0.15 * detail::hashed_number(~key, 2);
    const double growth = std::max(0.0, (options.growth - late) / (1 - late));
    Growing(key, growth).at({place(b % across, 0), place(b / across, 1), 0}, tufts);
  }
  ProceduralVolume volume;
  volume.extent = {1, 1, k_thickness};
  const auto all = std::make_shared<const Thicket>(std::move(tufts));
  // Where nothing grows yet, all is outside.
  volume.inside = [all](const Vec3& point) { return std::max(all->nearest(point).inside(), -1.0); };
  volume.color = [all, wood = options.wood_color, leaves = options.leaf_color](const Vec3& point) {
    const Nearest nearest = all->nearest(point);
    return nearest.leaf > nearest.branch ? leaves : wood;
  };
  return volume;
}

}  // namespace recede
