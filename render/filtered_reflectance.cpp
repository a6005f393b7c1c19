#include <recede/render/filtered_reflectance.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace recede {
namespace {

/// Of a group's variance, what its four facets don't show and their gloss does.
constexpr double k_left = 0.5;
/// By how much of that variance alpha^2 grows. Two would be right for lobes without tails; these have them,
/// and fit the traced reflectance of the surfaces in docs/filtered-reflectance.md best with less.
constexpr double k_widening = 1.5;

double power_of_five(double x) { return x * x * x * x * x; }

/// Sums over facets for one pair of directions, which may change places everywhere.
class FacetSum {
 public:
  FacetSum(const Vec3& toward_viewer, const Vec3& toward_light, const FacetMaterial& material)
      : viewer_(toward_viewer),
        light_(toward_light),
        roughness_squared_(material.roughness * material.roughness) {
    const Vec3 sum = viewer_ + light_;
    const double length = sum.norm();
    half_ = length > 0 ? Vec3(sum / length) : Vec3::Zero();
    // The cosine between half vector and either direction is half of the sum's length.
    const double fresnel = material.normal_reflectance +
                           (1 - material.normal_reflectance) * power_of_five(1 - std::min(1.0, length / 2));
    even_ = material.albedo / std::numbers::pi;
    shiny_ = material.reflection * fresnel / std::numbers::pi;
  }

  void add(const FacetGroup& group) {
    const double steepness = 1 + group.slope.squaredNorm(), variance = group.spread * group.spread;
    // A spread of slopes turns the normal by its length over that of (-slope, 1) across the slope, and by
    // this length once more along it, so the lobe is wider across.
    const double widening = k_widening * k_left * variance / steepness;
    const Lobe lobe(roughness_squared_ + widening, roughness_squared_ + widening / steepness);
    if (group.spread > 0) {
      // Two along each axis: together they have the variance that their gloss doesn't.
      const double away = std::sqrt(2 * (1 - k_left) * variance);
      const double x = group.slope.x(), y = group.slope.y();
      add_facets<4>({x + away, x - away, x, x}, {y, y, y + away, y - away}, group.share / 4, lobe);
    } else {
      add_facets<1>({group.slope.x()}, {group.slope.y()}, group.share, lobe);
    }
  }

  double area_to_viewer = 0, area_to_light = 0;  ///< of the facets that look there, projected
  double scattered = 0;                          ///< as if nothing hid them

 private:
  /// Squared widths of GGX across the slope and along it.
  struct Lobe {
    Lobe(double its_across, double its_along)
        : across(its_across),
          along(its_along),
          by_across(1 / across),
          by_along(1 / along),
          by_area(1 / std::sqrt(across * along)) {}
    double across, along, by_across, by_along, by_area;
  };

  /// Of a direction beside a facet with a slope: what its length of 1 is made of, squared.
  struct Parts {
    double normal, across, along;
  };
  static Parts parts_of(const Vec3& w, double cosine, double x, double y, double by_flat) {
    const double level = w.x() * y - w.y() * x, across = level * level * by_flat;
    return {cosine * cosine, across, std::max(0.0, 1 - cosine * cosine - across)};
  }

  /// Facets of one share each. n = (-x, -y, 1) has the length of the facet's area for the base's. Without
  /// jumps, so that the loop is one of lanes.
  template <std::size_t k_count>
  void add_facets(const std::array<double, k_count>& x, const std::array<double, k_count>& y, double share,
                  const Lobe& lobe) {
    std::array<double, k_count> to_viewer, to_light, value;
    for (std::size_t k = 0; k < k_count; ++k) {
      to_viewer[k] = std::max(0.0, viewer_.z() - viewer_.x() * x[k] - viewer_.y() * y[k]);
      to_light[k] = std::max(0.0, light_.z() - light_.x() * x[k] - light_.y() * y[k]);
      const double flat = x[k] * x[k] + y[k] * y[k] + 1e-300, by_flat = 1 / flat;
      const double by_area = 1 / std::sqrt(1 + flat);
      const double cos_viewer = to_viewer[k] * by_area, cos_light = to_light[k] * by_area;
      const double cos_half = (half_.z() - half_.x() * x[k] - half_.y() * y[k]) * by_area;
      const Parts half = parts_of(half_, cos_half, x[k], y[k], by_flat);
      const double q = half.normal + half.across * lobe.by_across + half.along * lobe.by_along;
      const Parts v = parts_of(viewer_, cos_viewer, x[k], y[k], by_flat);
      const Parts l = parts_of(light_, cos_light, x[k], y[k], by_flat);
      const double shown =
          (cos_viewer + std::sqrt(v.normal + lobe.across * v.across + lobe.along * v.along)) *
          (cos_light + std::sqrt(l.normal + lobe.across * l.across + lobe.along * l.along));
      // pi D G / (4 cos cos).
      const double gloss = lobe.by_area / (q * q * shown);
      value[k] = to_viewer[k] * to_light[k] * by_area * (even_ + shiny_ * gloss);
    }
    for (std::size_t k = 0; k < k_count; ++k) {
      area_to_viewer += share * to_viewer[k];
      area_to_light += share * to_light[k];
      scattered += share * value[k];
    }
  }

  Vec3 viewer_, light_, half_;
  double roughness_squared_, even_ = 0, shiny_ = 0;
};

}  // namespace

double filtered_reflectance(const FacetDistribution& facets, const Vec3& toward_viewer,
                            const Vec3& toward_light, const FacetMaterial& material) {
  const Vec2 mean = facets.mean_slope();
  const double seen = toward_viewer.z() - toward_viewer.head<2>().dot(mean);
  const double lit = toward_light.z() - toward_light.head<2>().dot(mean);
  if (!(seen > 0 && lit > 0)) return 0;
  FacetSum sum(toward_viewer, toward_light, material);
  for (const FacetGroup& group : facets.groups()) sum.add(group);
  // How many times too much is there; never less than 1, but for rounding.
  const double too_much_seen = std::max(1.0, sum.area_to_viewer / seen);
  const double too_much_lit = std::max(1.0, sum.area_to_light / lit);
  const double area = std::sqrt(1 + mean.squaredNorm());
  return area * sum.scattered / (seen * lit * (too_much_seen + too_much_lit - 1));
}

}  // namespace recede
