#include "reliefs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

constexpr int k_side = 128;
constexpr double k_turn = 2 * std::numbers::pi;

double fraction(double x) { return x - std::floor(x); }

DisplacementMap map_of(const std::function<double(double u, double v)>& height) {
  std::vector<float> heights;
  for (int y = 0; y < k_side; ++y) {
    for (int x = 0; x < k_side; ++x)
      heights.push_back(static_cast<float>(height((x + 0.5) / k_side, 1 - (y + 0.5) / k_side)));
  }
  return {k_side, k_side, std::move(heights), MapBorder::periodic};
}

/// Waves of up to eight to a side whose slopes are alike; longer along v by `stretch`.
DisplacementMap waves(unsigned seed, double steepness, double stretch) {
  constexpr int k_count = 60;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0, 1);
  struct Wave {
    double u, v, phase, height;
  };
  std::vector<Wave> all;
  while (all.size() < k_count) {
    const double u = std::floor(17 * number(random)) - 8;
    const double v = std::trunc((std::floor(17 * number(random)) - 8) / stretch);
    const double phase = k_turn * number(random);
    if (u != 0 || v != 0)
      all.push_back({u, v, phase, steepness / std::hypot(u, v) / k_turn / std::sqrt(k_count)});
  }
  return map_of([&](double u, double v) {
    double sum = 0;
    for (const Wave& wave : all)
      sum += wave.height * std::sin(k_turn * (wave.u * u + wave.v * v) + wave.phase);
    return sum;
  });
}

double v_groove(double u, double) { return 0.6 * std::abs(fraction(8 * u) - 0.5) / 8; }

double brick(double u, double v) {
  const double row = std::floor(8 * v), across = fraction(4 * u + 0.5 * std::fmod(row, 2)),
               up = fraction(8 * v);
  const double to_border = std::min(std::min(across, 1 - across) / 4, std::min(up, 1 - up) / 8);
  return 1.2 * std::min(to_border, 0.02);
}

double half_sphere(double u, double v) {
  constexpr double k_radius = 0.45;
  const double x = fraction(6 * u) - 0.5, y = fraction(6 * v) - 0.5, squares = x * x + y * y;
  if (squares >= k_radius * k_radius) return 0;
  return 0.15 * (std::sqrt(k_radius * k_radius - 0.8 * squares) - std::sqrt(0.2) * k_radius);
}

double scratch(double u, double v) {
  const double across = fraction(5 * u + 0.3 * std::sin(k_turn * v)) - 0.5;
  return -0.012 * std::exp(-std::pow(across / 0.06, 2));
}

/// Domes around points at random, the highest counts.
DisplacementMap cobbles() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(0, 1);
  std::vector<Vec2> middles;
  for (int k = 0; k < 40; ++k) middles.emplace_back(number(random), number(random));
  return map_of([&](double u, double v) {
    double nearest = 1;
    for (const Vec2& middle : middles) {
      const double x = std::remainder(u - middle.x(), 1.0), y = std::remainder(v - middle.y(), 1.0);
      nearest = std::min(nearest, x * x + y * y);
    }
    return 0.05 - 4 * std::min(nearest, 0.0125);
  });
}

DisplacementMap rough_ground() {
  constexpr int k_points = k_side / 4;
  std::mt19937 random(8);
  std::uniform_real_distribution<double> number(0, 0.02);
  std::vector<float> heights;
  for (int k = 0; k < k_points * k_points; ++k) heights.push_back(static_cast<float>(number(random)));
  const DisplacementMap points(k_points, k_points, std::move(heights), MapBorder::periodic);
  return map_of([&](double u, double v) { return points.height_at({u, v}); });
}

}  // namespace

std::vector<Relief> make_reliefs() {
  return {{"Gaussian bumps", waves(1, 0.7, 1), false},
          {"V-grooves", map_of(v_groove), false},
          {"bricks", map_of(brick), false},
          {"half-spheres", map_of(half_sphere), false},
          {"scratches", map_of(scratch), false},
          {"ripples", waves(2, 0.5, 4), true},
          {"cobbles", cobbles(), true},
          {"rough ground", rough_ground(), true}};
}

std::vector<Relief> wanted_reliefs(const BenchOptions& options) {
  constexpr std::size_t k_quick = 2;
  std::vector<Relief> reliefs = make_reliefs();
  if (options.quick) reliefs.erase(reliefs.begin() + k_quick, reliefs.end());
  std::erase_if(reliefs, [&](const Relief& relief) { return !is_wanted(relief.name, options.models); });
  return reliefs;
}

}  // namespace recede::bench
