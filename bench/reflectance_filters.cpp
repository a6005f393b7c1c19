#include "reflectance_filters.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_pi = std::numbers::pi;

/// Slopes with shares, in the place of all facets.
using Facets = std::vector<FacetGroup>;

Facets all_slopes(const DisplacementMap& map) {
  Facets facets;
  const int columns = 2 * map.columns(), rows = 2 * map.rows();
  for (int at = 0; at < columns * rows; ++at)
    facets.push_back(
        {.share = 1.0 / (columns * rows),
         .slope = map.derivative_at({(at % columns + 0.5) / columns, (at / columns + 0.5) / rows})});
  return facets;
}

Vec3 upward(const Vec2& slope) { return {-slope.x(), -slope.y(), 1}; }

/// With what hides and shades: parts of all facets alike, by heights alike.
double hidden_and_shaded(const Facets& facets, const Vec3& v, const Vec3& l, const FacetMaterial& material) {
  double scattered = 0, seen = 0, lit = 0;
  for (const FacetGroup& facet : facets) {
    const Vec3 n = upward(facet.slope);
    const double to_viewer = std::max(0.0, n.dot(v)), to_light = std::max(0.0, n.dot(l));
    seen += facet.share * to_viewer;
    lit += facet.share * to_light;
    if (!(to_viewer > 0 && to_light > 0)) continue;
    const double area = n.norm();
    scattered += facet.share * to_viewer * to_light / area * facet_reflectance(n / area, v, l, material);
  }
  return scattered / v.z() / (std::max(1.0, seen / v.z()) + std::max(1.0, lit / l.z()) - 1);
}

double in_the_open(const Facets& facets, const Vec3& v, const Vec3& l, const FacetMaterial& material) {
  double sum = 0;
  for (const FacetGroup& facet : facets) {
    const Vec3 n = upward(facet.slope).normalized();
    sum += facet.share * facet_reflectance(n, v, l, material) * std::max(0.0, n.dot(l));
  }
  return sum;
}

/// 48 x 48 slopes of the Gaussian with the same mean and variances.
Facets gaussian_slopes(const Facets& facets) {
  Vec2 mean = Vec2::Zero();
  for (const FacetGroup& facet : facets) mean += facet.share * facet.slope;
  double xx = 0, xy = 0, yy = 0;
  for (const FacetGroup& facet : facets) {
    const Vec2 d = facet.slope - mean;
    xx += facet.share * d.x() * d.x();
    xy += facet.share * d.x() * d.y();
    yy += facet.share * d.y() * d.y();
  }
  constexpr double k_least = 1e-9;
  const double a = std::sqrt(std::max(k_least, xx)), b = xy / a, c = std::sqrt(std::max(k_least, yy - b * b));
  constexpr int k_side = 48;
  Facets result;
  for (int i = 0; i < k_side; ++i) {
    // The last part of the tail is cut off, as in the study that this follows.
    const double radius = std::sqrt(-2 * std::log(1 - (i + 0.5) / k_side * 0.99995));
    for (int j = 0; j < k_side; ++j) {
      const double angle = 2 * k_pi * (j + 0.5) / k_side;
      const double x = radius * std::cos(angle), y = radius * std::sin(angle);
      result.push_back({.share = 1.0 / (k_side * k_side), .slope = mean + Vec2(a * x, b * x + c * y)});
    }
  }
  return result;
}

/// Bins of slopes, each at the mean of its own.
Facets histogram(const Facets& facets) {
  constexpr int k_side = 8;
  double reach = 1e-9;
  for (const FacetGroup& facet : facets) reach = std::max(reach, facet.slope.cwiseAbs().maxCoeff());
  Facets bins(k_side * k_side);
  for (const FacetGroup& facet : facets) {
    const auto along = [&](double slope) {
      return std::min(k_side - 1, static_cast<int>((slope + reach) / (2 * reach) * k_side));
    };
    FacetGroup& bin =
        bins[static_cast<std::size_t>(along(facet.slope.y()) * k_side + along(facet.slope.x()))];
    bin.share += facet.share;
    bin.slope += facet.share * facet.slope;
  }
  std::erase_if(bins, [](const FacetGroup& bin) { return !(bin.share > 0); });
  for (FacetGroup& bin : bins) bin.slope /= bin.share;
  return bins;
}

/// Toksvig: the shorter the mean of the normals, the rougher.
ReflectanceFilter toksvig(const Facets& facets) {
  Vec3 sum = Vec3::Zero();
  for (const FacetGroup& facet : facets) sum += facet.share * upward(facet.slope).normalized();
  const double length = sum.norm();
  return {"Toksvig", "Toksvig", 3 * sizeof(float),
          [normal = Vec3(sum / length), length](const Vec3& v, const Vec3& l, FacetMaterial material) {
            const double exponent = 2 / (material.roughness * material.roughness) - 2;
            const double factor = length / (length + exponent * (1 - length));
            material.roughness = std::sqrt(2 / (factor * exponent + 2));
            return facet_reflectance(normal, v, l, material) * std::max(0.0, normal.dot(l));
          }};
}

}  // namespace

double facet_reflectance(const Vec3& normal, const Vec3& toward_viewer, const Vec3& toward_light,
                         const FacetMaterial& material) {
  const double cos_v = normal.dot(toward_viewer), cos_l = normal.dot(toward_light);
  if (cos_v <= 0 || cos_l <= 0) return 0;
  const Vec3 half = (toward_viewer + toward_light).normalized();
  const double squared = material.roughness * material.roughness, cos_half = normal.dot(half);
  const double lobe = cos_half * cos_half * (squared - 1) + 1;
  const auto shown = [&](double cosine) {
    return cosine + std::sqrt(squared + (1 - squared) * cosine * cosine);
  };
  const double fresnel =
      material.normal_reflectance +
      (1 - material.normal_reflectance) * std::pow(1 - std::max(0.0, half.dot(toward_light)), 5);
  return (material.albedo +
          material.reflection * fresnel * squared / (lobe * lobe * shown(cos_v) * shown(cos_l))) /
         k_pi;
}

std::vector<ReflectanceFilter> reflectance_filters(const DisplacementMap& map) {
  const auto all = std::make_shared<Facets>(all_slopes(map));
  const auto gaussian = std::make_shared<Facets>(gaussian_slopes(*all));
  const auto bins = std::make_shared<Facets>(histogram(*all));
  const PackedFacets packed(facets_of(map));
  const auto smith = [](const std::shared_ptr<Facets>& facets) {
    return [facets](const Vec3& v, const Vec3& l, const FacetMaterial& material) {
      return hidden_and_shaded(*facets, v, l, material);
    };
  };
  constexpr std::size_t k_moments = 5 * sizeof(float), k_slope = 3 * sizeof(double);
  return {{"mean normal", "mean normal", 2 * sizeof(float),
           [](const Vec3& v, const Vec3& l, const FacetMaterial& material) {
             return facet_reflectance(Vec3::UnitZ(), v, l, material) * l.z();
           }},
          toksvig(*all),
          {"Gaussian, open (LEAN)", "LEAN", k_moments,
           [gaussian](const Vec3& v, const Vec3& l, const FacetMaterial& material) {
             return in_the_open(*gaussian, v, l, material);
           }},
          {"Gaussian (LEADR)", "LEADR", k_moments, smith(gaussian)},
          {"8 x 8 slopes", "8 x 8", bins->size() * k_slope, smith(bins)},
          {"all slopes", "", all->size() * k_slope, smith(all)},
          {"**64 bytes**", "64 bytes", sizeof(PackedFacets),
           [facets = packed.unpacked()](const Vec3& v, const Vec3& l, const FacetMaterial& material) {
             return filtered_reflectance(facets, v, l, material) * l.z();
           }}};
}

}  // namespace recede::bench
