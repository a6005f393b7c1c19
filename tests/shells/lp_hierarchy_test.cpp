// What summing up parts of a surface adds to its averaged distance.
#include "lp_shapes.h"
#include <recede/shells/detail/lp_field.h>
#include <recede/shells/detail/lp_tree.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

using namespace test;

struct Errors {
  double value = 0, gradient = 0;  ///< of I and its gradient, relative, at most
  double degrees = 0;
};

/// Places next to the surface's vertices, on both sides.
std::vector<Vec3> places_around(const PolygonSoup& surface) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Vec3> places;
  for (int i = 0; i < 300; ++i) {
    const Vec3& at = surface.positions[random() % surface.positions.size()];
    const double off = 0.03 * std::pow(10.0, unit(random));
    places.push_back(at + (i % 2 == 0 ? off : -off) * at.normalized());
  }
  return places;
}

Errors errors_of(const PolygonSoup& surface, const LpDistanceOptions& options) {
  const LpDistance exact_distance(surface, exact(options.p)), distance(surface, options);
  Errors worst;
  for (const Vec3& x : places_around(surface)) {
    const CubicIntegral a = cubic_integral(exact_distance.at(x)), b = cubic_integral(distance.at(x));
    worst.value = std::max(worst.value, std::abs(b.value / a.value - 1));
    worst.gradient = std::max(worst.gradient, (b.gradient - a.gradient).norm() / a.gradient.norm());
    worst.degrees = std::max(worst.degrees, angle_between(a.gradient, b.gradient) * 180 / k_pi);
  }
  return worst;
}

TEST(LpHierarchy, ErrorsOfMonopolesAreThoseOfTheTable) {
  // 8192 triangles; the table's are another ellipsoid of 5120.
  const PolygonSoup surface = bumpy_ellipsoid(5);
  struct Row {
    double opening, value, gradient, degrees;
  };
  for (const Row& row :
       {Row{1, 7.2e-2, 1.1e-1, 1.85}, Row{1.5, 3.5e-2, 4.9e-2, .58}, Row{2, 1.8e-2, 2.5e-2, .27},
        Row{3, 6.7e-3, 9.6e-3, .10}, Row{5, 1.6e-3, 1.7e-3, .013}}) {
    const Errors errors = errors_of(surface, {.expansion = LpExpansion::monopole, .opening = row.opening});
    // Within a factor of 2; at 5 it may be better, as triangles are never summed up one by one.
    const double least = row.opening < 5 ? 0.5 : 0.25;
    EXPECT_LT(errors.value, 2 * row.value) << row.opening;
    EXPECT_GT(errors.value, least * row.value) << row.opening;
    EXPECT_LT(errors.gradient, 2 * row.gradient) << row.opening;
    EXPECT_GT(errors.gradient, least * row.gradient) << row.opening;
    EXPECT_LT(errors.degrees, 2 * row.degrees) << row.opening;
    EXPECT_GT(errors.degrees, least * row.degrees) << row.opening;
  }
}

TEST(LpHierarchy, QuadrupolesAreBetterAndAnOrderMoreFarAway) {
  const PolygonSoup surface = bumpy_ellipsoid(5);
  EXPECT_LT(errors_of(surface, {}).gradient, 1.6e-2) << "as the header says";
  EXPECT_LT(errors_of(surface, {.opening = 2}).gradient, 2e-3) << "as the header says";
  EXPECT_LT(errors_of(surface, {.opening = 2.5}).gradient, 5e-4) << "as the header says";
  // One node, from farther and farther away: errors fall by 4 with the distance's double, or by 8.
  const PolygonSoup triangle = one_triangle(Vec3(0, 0, 0), Vec3(1, 0.2, 0), Vec3(0.1, 0.7, 0.3));
  const Vec3 middle(1.1 / 3, 0.3, 0.1);
  for (const LpExpansion expansion : {LpExpansion::monopole, LpExpansion::quadrupole}) {
    const LpDistance distance(triangle, {.expansion = expansion, .opening = 0}), closed(triangle, exact());
    std::array<double, 2> values{}, gradients{};
    for (std::size_t k = 0; k < 2; ++k) {
      const double r = k == 0 ? 16 : 32;
      for (const Vec3& direction : sphere(1).positions) {
        const CubicIntegral a = cubic_integral(closed.at(middle + r * direction)),
                            b = cubic_integral(distance.at(middle + r * direction));
        values[k] = std::max(values[k], std::abs(b.value / a.value - 1));
        gradients[k] = std::max(gradients[k], (b.gradient - a.gradient).norm() / a.gradient.norm());
      }
    }
    const double order = expansion == LpExpansion::monopole ? 2 : 3;
    EXPECT_NEAR(std::log2(values[0] / values[1]), order, 0.1);
    EXPECT_NEAR(std::log2(gradients[0] / gradients[1]), order, 0.1);
  }
}

TEST(LpHierarchy, AnErrorThatWasAskedForIsKeptAndReported) {
  const PolygonSoup surface = bumpy_ellipsoid(3);
  std::vector<Vec3> places = places_around(surface);
  places.resize(20);
  // Where much may be summed up, whatever the error.
  for (const double far : {3.0, 10.0, 30.0}) places.push_back(far * Vec3(1, -2, 2).normalized());
  for (const double p : {3.0, 4.5}) {
    for (const LpForm form : {LpForm::calibrated, LpForm::averaged}) {
      for (const LpExpansion expansion : {LpExpansion::monopole, LpExpansion::quadrupole}) {
        for (const double error : {0.3, 0.01}) {
          for (const double support : {std::numeric_limits<double>::infinity(), 0.5}) {
            LpDistanceOptions options{
                .p = p, .form = form, .expansion = expansion, .error = error, .support = support};
            const LpDistance bounded(surface, options);
            options.error.reset();
            options.opening = std::numeric_limits<double>::infinity();
            const LpDistance all(surface, options);
            double largest = 0;
            for (const Vec3& x : places) {
              const LpValue a = all.at(x), b = bounded.at(x);
              if (std::isinf(a.distance)) {
                EXPECT_TRUE(std::isinf(b.distance)) << "nothing within the support";
                continue;
              }
              // I is a power of the distance; with a support, the area is exact.
              const double power = form == LpForm::calibrated ? p - 2 : p;
              const double off = std::abs(std::pow(a.distance / b.distance, power) - 1);
              constexpr double k_rounding = 1e-9;
              EXPECT_LE(off, b.error_bound + k_rounding);
              EXPECT_LE(b.error_bound, error * (1 + k_rounding));
              EXPECT_LE((a.gradient - b.gradient).norm(), b.gradient_error + k_rounding);
              largest = std::max(largest, b.error_bound);
            }
            // Something was summed up, or none of this says anything.
            if (std::isinf(support)) {
              EXPECT_GT(largest, 0.05 * error);
            }
          }
        }
      }
    }
  }
}

TEST(LpHierarchy, SumsOfPointsAreSummedUpAsWell) {
  const PolygonSoup surface = bumpy_ellipsoid(4);
  LpDistanceOptions all = exact(), some{.opening = 2};
  all.source = some.source = LpSource::points;
  const LpDistance a(surface, all), b(surface, some);
  for (const Vec3& x : places_around(surface)) {
    const LpValue exact_value = a.at(x), value = b.at(x);
    EXPECT_NEAR(value.distance / exact_value.distance, 1, 5e-3);
    EXPECT_LT((value.gradient - exact_value.gradient).norm(), 1e-2 * exact_value.gradient.norm() + 1e-3);
  }
}

TEST(LpHierarchy, KernelsForAllProcessorsHaveTheSameBits) {
  const PolygonSoup surface = bumpy_ellipsoid(3);
  std::vector<detail::LpElement> elements;
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const Vec3 a = surface.positions[surface.face(f)[0]], b = surface.positions[surface.face(f)[1]],
               c = surface.positions[surface.face(f)[2]];
    elements.push_back({{a, b, c}, 0.5 * (b - a).cross(c - a).norm()});
  }
  const detail::LpTree tree(elements, {});
  const detail::LpArrays arrays{tree.nodes.data(), tree.extents.data(), tree.blocks.data(), nullptr};
  for (const double support : {0.8, std::numeric_limits<double>::infinity()}) {
    for (const bool is_bounded : {false, true}) {
      for (const Vec3& x : places_around(surface)) {
        const detail::LpQuery query{{x.x(), x.y(), x.z()},      3, 1, support, is_bounded,
                                    tree.first_order_left_out()};
        const detail::LpSums a = detail::k_lp_kernel_baseline.sum(arrays, query),
                             b = detail::lp_kernel().sum(arrays, query);
        EXPECT_EQ(a.integral, b.integral);
        EXPECT_EQ(a.gradient[0], b.gradient[0]);
        EXPECT_EQ(a.gradient[1], b.gradient[1]);
        EXPECT_EQ(a.gradient[2], b.gradient[2]);
        EXPECT_EQ(a.area, b.area);
        EXPECT_EQ(a.error, b.error);
        EXPECT_EQ(a.gradient_error, b.gradient_error);
      }
    }
  }
  const std::vector<Vec3> places = places_around(surface);
  std::vector<detail::LpVisit> visits(tree.nodes.size() + detail::k_lp_visits_ahead);
  for (const double support : {0.8, std::numeric_limits<double>::infinity()}) {
    const std::vector<detail::LpFade> fades = detail::fades_of(tree, support);
    const auto sum = [&](const detail::LpKernel& kernel, const std::array<detail::LpQuery, 5>& queries) {
      std::array<detail::LpSums, 5> sums;
      if (std::isinf(support)) {
        kernel.sum_each(arrays, queries.data(), 5, visits.data(), sums.data());
      } else {
        kernel.sum_packet(arrays, fades.data(), queries.data(), 5, sums.data());
      }
      return sums;
    };
    for (std::size_t first = 0; first + 5 <= places.size(); first += 5) {
      std::array<detail::LpQuery, 5> queries;
      for (std::size_t i = 0; i < 5; ++i) {
        const Vec3& x = places[first + i];
        queries[i] = {{x.x(), x.y(), x.z()}, 3, 1, support, false, tree.first_order_left_out()};
      }
      const std::array<detail::LpSums, 5> a = sum(detail::k_lp_kernel_baseline, queries),
                                          b = sum(detail::lp_kernel(), queries);
      for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_GT(a[i].integral, 0);
        EXPECT_EQ(a[i].integral, b[i].integral);
        EXPECT_EQ(a[i].gradient[0], b[i].gradient[0]);
        EXPECT_EQ(a[i].gradient[1], b[i].gradient[1]);
        EXPECT_EQ(a[i].gradient[2], b[i].gradient[2]);
        EXPECT_EQ(a[i].area, b[i].area);
      }
    }
  }
}

TEST(LpHierarchy, PointsAskedForTogetherHaveTheSameBitsInAnyCompany) {
  const PolygonSoup surface = bumpy_ellipsoid(4);
  const std::vector<Vec3> places = places_around(surface);
  // Within the last two the surface counts in part and nowhere in full.
  for (const double support : {std::numeric_limits<double>::infinity(), 2.0, 0.8, 0.2, 0.03}) {
    const LpDistanceOptions options{.support = support};
    const detail::LpField field(surface, options);
    std::vector<LpValue> together(places.size()), alone(places.size());
    field.at_each(places, together);
    for (std::size_t i = 0; i < places.size(); ++i)
      field.at_each(std::span(places).subspan(i, 1), std::span(alone).subspan(i, 1));
    for (std::size_t i = 0; i < places.size(); ++i) {
      EXPECT_EQ(together[i].distance, alone[i].distance);
      EXPECT_EQ(together[i].gradient, alone[i].gradient);
      const LpValue value = field.at(places[i]);
      if (std::isinf(value.distance)) {
        EXPECT_EQ(together[i].distance, value.distance);
        continue;
      }
      // Sums of some hundred parts in another order.
      EXPECT_NEAR(together[i].distance / value.distance, 1, 1e-12);
      EXPECT_LT((together[i].gradient - value.gradient).norm(), 1e-11 * (1 + value.gradient.norm()));
    }
  }
}

}  // namespace
}  // namespace recede
