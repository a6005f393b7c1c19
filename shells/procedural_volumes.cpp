#include <recede/geometry/detail/hashed_number.h>
#include <recede/geometry/error.h>
#include <recede/shells/procedural_volumes.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede {

VolumeTexture make_volume(const ProceduralVolume& volume, int texels, Progress* progress) {
  if (texels < 1)
    throw OptionError(fmt::format("a volume texture can't have {} texels along an axis", texels));
  VolumeOptions options{.extent = volume.extent, .color = volume.color};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double length = volume.extent[static_cast<int>(axis)] / volume.extent.x();
    options.size[axis] =
        std::max(1, static_cast<int>(std::lround(texels * std::exp2(std::round(std::log2(length))))));
  }
  return make_volume(volume.inside, options, progress);
}

namespace {

// Of both axes, radii of rings: by search, where wires have most room (0.46 between their middles) and each
// ring goes through four others.
constexpr double k_ring_pitch = 1.3, k_ring_lean = 0.5;

double distance_to_ring(const Vec3& from_center, double lean) {
  const Vec3 axis(-std::sin(lean), 0, std::cos(lean));
  const double height = from_center.dot(axis);
  const double radius = (from_center - height * axis).norm();
  return std::hypot(radius - 1, height);
}

void check_share(double value, double most, const char* what) {
  if (!(value > 0) || !(value <= most))
    throw OptionError(fmt::format("{} must be above 0 and at most {}", what, most));
}

double random_at(std::uint32_t seed, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  return detail::hashed_number((std::uint64_t{seed} << 32) ^ (std::uint64_t{a} << 16) ^ b, c);
}

/// Gradient noise that repeats every `periods` cells along x and y; about -1 to 1.
class GradientNoise {
 public:
  GradientNoise(std::uint32_t seed, int period_x, int period_y) : seed_(seed), period_{period_x, period_y} {}

  double at(const Vec3& point) const {
    const Vec3 cell(std::floor(point.x()), std::floor(point.y()), std::floor(point.z()));
    const Vec3 share = point - cell;
    const Vec3 eased = share.unaryExpr([](double x) { return x * x * x * (x * (6 * x - 15) + 10); });
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 at_corner(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
      double weight = 1;
      for (int axis = 0; axis < 3; ++axis) weight *= at_corner[axis] > 0 ? eased[axis] : 1 - eased[axis];
      sum += weight * gradient(cell + at_corner).dot(share - at_corner);
    }
    return sum / 0.7;  // what sums of unit gradients seldom get beyond
  }

 private:
  static std::uint32_t wrapped(double cell, int period) {
    const int whole = static_cast<int>(cell) % period;
    return static_cast<std::uint32_t>(whole < 0 ? whole + period : whole);
  }
  Vec3 gradient(const Vec3& corner) const {
    const std::uint32_t x = wrapped(corner.x(), period_[0]), y = wrapped(corner.y(), period_[1]),
                        z = static_cast<std::uint32_t>(static_cast<int>(corner.z()));
    const double height = 2 * random_at(seed_, x, y, z) - 1,
                 turn = 2 * std::numbers::pi * random_at(seed_ + 1, x, y, z);
    const double radius = std::sqrt(1 - height * height);
    return {radius * std::cos(turn), radius * std::sin(turn), height};
  }

  std::uint32_t seed_;
  std::array<int, 2> period_;
};

}  // namespace

ProceduralVolume chain_mail(const ChainMailOptions& options) {
  check_share(options.wire, 0.22, "the wire of chain mail");
  const double wire = options.wire, middle = std::sin(k_ring_lean) + wire + 0.05;
  const auto inside = [wire, middle](const Vec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    const int near_row = static_cast<int>(std::floor(point.y() / k_ring_pitch));
    for (int row = near_row - 1; row <= near_row + 2; ++row) {
      const bool is_odd = (row & 1) != 0;
      const double shift = is_odd ? 0.5 : 0;
      const int near_ring = static_cast<int>(std::floor(point.x() / k_ring_pitch - shift));
      for (int ring = near_ring - 1; ring <= near_ring + 2; ++ring) {
        const Vec3 center((ring + shift) * k_ring_pitch, row * k_ring_pitch, middle);
        nearest = std::min(nearest, distance_to_ring(point - center, is_odd ? -k_ring_lean : k_ring_lean));
      }
    }
    return wire - nearest;
  };
  return {inside, Vec3(k_ring_pitch, 2 * k_ring_pitch, 2 * middle)};
}

namespace {

// Height of the middle of the thread along the first coordinate that is `thread`-th beside others.
double thread_height(double along, int thread, double swing) {
  return swing * std::cos(std::numbers::pi * (along + thread));
}

struct Threads {
  double radius, middle, swing;

  // To the middle of the nearest thread of those along the first coordinate; `sign` turns them over.
  double distance(double along, double beside, double height, double sign) const {
    const int near_thread = static_cast<int>(std::floor(beside));
    double nearest = std::numeric_limits<double>::infinity();
    for (int thread = near_thread - 1; thread <= near_thread + 1; ++thread) {
      const double slope = -std::numbers::pi * swing * std::sin(std::numbers::pi * (along + thread));
      const double off =
          (height - middle - sign * thread_height(along, thread, swing)) / std::hypot(1, slope);
      nearest = std::min(nearest, std::hypot(beside - thread - 0.5, off));
    }
    return nearest;
  }
  double weft(const Vec3& point) const { return distance(point.x() - 0.5, point.y(), point.z(), 1); }
  double warp(const Vec3& point) const { return distance(point.y() - 0.5, point.x(), point.z(), -1); }
};

}  // namespace

ProceduralVolume weave(const WeaveOptions& options) {
  check_share(options.thread, 0.3, "the thread of a weave");
  const Threads threads{options.thread, 2 * options.thread + 0.05, options.thread};
  ProceduralVolume volume;
  volume.inside = [threads](const Vec3& point) {
    return threads.radius - std::min(threads.weft(point), threads.warp(point));
  };
  volume.color = [threads, warp = options.warp_color, weft = options.weft_color](const Vec3& point) {
    return threads.weft(point) < threads.warp(point) ? weft : warp;
  };
  volume.extent = {2, 2, 2 * threads.middle};
  return volume;
}

ProceduralVolume bark(const BarkOptions& options) {
  if (!(options.cracks >= 0) || !(options.cracks <= 1))
    throw OptionError("cracks of bark must be from 0 to 1");
  // Cells of the noise along s and t in a period.
  constexpr int k_across = 5, k_along = 2;
  const GradientNoise wide(options.seed, k_across, k_along), bend(options.seed + 3, k_across, 4 * k_along),
      fine(options.seed + 7, 5 * k_across, 8 * k_along);
  const auto height = [=, cracks = options.cracks](const Vec3& point) {
    const double ridge = std::abs(
        wide.at({k_across * point.x() + 0.3 * bend.at({k_across * point.x(), 4 * k_along * point.y(), 0.5}),
                 k_along * point.y(), 0.5}));
    const double plate = std::min(1.0, ridge / 0.22);  // 0 in the middle of a crack
    const double rough = 0.05 * fine.at({5 * k_across * point.x(), 8 * k_along * point.y(), 9 * point.z()});
    return 0.9 - cracks * 0.85 * (1 - plate * (2 - plate)) + rough;
  };
  constexpr double k_thickness = 0.16;  // of a period
  ProceduralVolume volume;
  volume.extent = {1, 1, k_thickness};
  // Walls of cracks are steep: what is a height of 1 there is less far away.
  constexpr double k_slope = 3;
  volume.inside = [height](const Vec3& point) { return (height(point) * k_thickness - point.z()) / k_slope; };
  volume.color = [height](const Vec3& point) {
    const double depth = std::clamp(1 - height(point), 0.0, 1.0);
    return Vec3((1 - 0.6 * depth) * Vec3(0.52, 0.41, 0.32));
  };
  return volume;
}

ProceduralVolume bubbles(const BubbleOptions& options) {
  if (options.bubbles < 1) throw OptionError("a liquid without bubbles doesn't boil");
  if (!std::isfinite(options.time)) throw OptionError("the time of bubbles must be finite");
  constexpr double k_thickness = 0.3, k_level = 0.12;  // of a period
  struct Ball {
    Vec3 center;
    double radius;
  };
  std::vector<Ball> balls;
  for (int b = 0; b < options.bubbles; ++b) {
    const auto number = static_cast<std::uint32_t>(b);
    const double life = options.time + random_at(options.seed, number, 0, 0);
    const double age = life - std::floor(life);
    const auto lives = static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(life)));
    const double radius = (0.02 + 0.05 * random_at(options.seed, number, lives, 1)) * std::sqrt(age);
    // Up to the level and beyond; at the end it shrinks away within a tenth of its life.
    const double burst = std::min(1.0, 10 * (1 - age));
    balls.push_back({{random_at(options.seed, number, lives, 2), random_at(options.seed, number, lives, 3),
                      k_level * (0.4 + 0.9 * age)},
                     radius * burst});
  }
  ProceduralVolume volume;
  volume.extent = {1, 1, k_thickness};
  volume.inside = [balls = std::move(balls)](const Vec3& point) {
    double inside = k_level - point.z();
    for (const Ball& ball : balls) {
      if (!(ball.radius > 0)) continue;
      Vec3 off = point - ball.center;
      for (int axis = 0; axis < 2; ++axis) off[axis] -= std::round(off[axis]);
      inside = std::max(inside, ball.radius - off.norm());
    }
    return inside;
  };
  return volume;
}

}  // namespace recede
