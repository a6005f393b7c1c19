#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>
#include <recede/geometry/signed_distance.h>

#include <gmock/gmock.h>

#include <array>
#include <numbers>
#include <random>

namespace {

using namespace recede;
using testing::HasSubstr;
using testing::ThrowsMessage;

PolygonSoup box(const Vec3& lower, const Vec3& upper) {
  PolygonSoup soup;
  for (int k = 0; k < 8; ++k)
    soup.positions.emplace_back(k & 1 ? upper.x() : lower.x(), k & 2 ? upper.y() : lower.y(),
                                k & 4 ? upper.z() : lower.z());
  for (const std::array<Index, 4>& face : {std::array<Index, 4>{0, 2, 3, 1},
                                           {4, 5, 7, 6},
                                           {0, 1, 5, 4},
                                           {2, 6, 7, 3},
                                           {0, 4, 6, 2},
                                           {1, 3, 7, 5}})
    soup.add_face(face);
  return soup;
}

double inside_box(const Vec3& p, const Vec3& lower, const Vec3& upper) {
  const Vec3 off = (lower - p).cwiseMax(p - upper);
  return off.maxCoeff() <= 0 ? -off.maxCoeff() : -off.cwiseMax(0).norm();
}

// Also where an edge or a corner is nearest, at any scale and place.
TEST(SignedDistance, OfABoxIsThatOfItsSides) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-2, 2);
  for (const double scale : {1.0, 1e-9, 1e9}) {
    for (const double offset : {0.0, 1e6}) {
      const Vec3 lower = scale * Vec3(offset - 1, offset - 0.5, -0.25),
                 upper = scale * Vec3(offset + 1, offset + 0.5, 0.25);
      const SignedDistance distance(box(lower, upper));
      // Sides of coordinates that are rounded by 1e-10 of their length.
      EXPECT_NEAR(distance.volume() / (scale * scale * scale), 1, offset > 0 ? 1e-8 : 1e-12);
      // Coordinates are rounded by 1e-16 of their size.
      const double tolerance = scale * (offset > 0 ? 1e-9 : 1e-14);
      for (int n = 0; n < 2000; ++n) {
        const Vec3 p = scale * Vec3(offset + number(random), offset + number(random), number(random));
        EXPECT_NEAR(distance.inside_by(p), inside_box(p, lower, upper), tolerance);
      }
    }
  }
}

// Products of such coordinates have no digits left for a volume of 1.
TEST(SignedDistance, KnowsInsideFromOutsideFarFromTheOrigin) {
  for (const double far : {5e6, 1e9}) {
    const Vec3 lower = Vec3::Constant(far) - Vec3(0.5, 0.5, 0.5), upper = lower + Vec3::Ones();
    const SignedDistance distance(box(lower, upper));
    EXPECT_NEAR(distance.volume(), 1, 1e-9) << "whole halves are exact";
    EXPECT_GT(distance.inside_by(Vec3::Constant(far)), 0.49);
    EXPECT_LT(distance.inside_by(upper + Vec3::Ones()), -1);
  }
}

// Beside a sharp edge, which the planes of both faces see from different sides.
TEST(SignedDistance, KnowsTheSideBesideSharpEdgesAndPeaks) {
  // A flat double cone of eight sides: needles at the peak.
  PolygonSoup cone;
  for (int i = 0; i < 8; ++i) {
    const double angle = i * std::numbers::pi / 4;
    cone.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  cone.positions.emplace_back(0, 0, 20);
  cone.positions.emplace_back(0, 0, -0.01);
  for (Index i = 0; i < 8; ++i) {
    cone.add_face(std::array<Index, 3>{i, (i + 1) % 8, 8});
    cone.add_face(std::array<Index, 3>{(i + 1) % 8, i, 9});
  }
  const SignedDistance distance(cone);
  EXPECT_NEAR(distance.inside_by({0, 0, 20.5}), -0.5, 1e-12);
  EXPECT_NEAR(distance.inside_by({0.01, -0.02, 20.5}), -Vec3(0.01, -0.02, 0.5).norm(), 1e-12);
  for (const double z : {1e300, std::nan("")})
    EXPECT_EQ(distance.inside_by({0, 0, z}), -std::numeric_limits<double>::infinity());
  EXPECT_NEAR(distance.inside_by({1.5, 0, 0.001}), -std::hypot(0.5, 0.001), 1e-12);
  EXPECT_NEAR(distance.inside_by({1.5, 0, -0.001}), -std::hypot(0.5, 0.001), 1e-12);
  EXPECT_GT(distance.inside_by({0, 0, 19.9}), 0);
  EXPECT_GT(distance.inside_by({0, 0, -0.009}), 0);
}

// A rough ball: from its middle outwards a line ends outside.
TEST(SignedDistance, ChangesItsSignOnceAlongALine) {
  const SignedDistance distance(make_displaced_sphere(20'000, true));
  std::mt19937 random(7);
  std::normal_distribution<double> number;
  for (int n = 0; n < 300; ++n) {
    const Vec3 direction = Vec3(number(random), number(random), number(random)).normalized();
    int changes = 0;
    bool was_inside = true;
    for (double r = 0.01; r < 2; r += 0.01) {
      const double inside = distance.inside_by(r * direction);
      // The ridges are at most a fifth high.
      if (std::abs(r - 1) > 0.3) {
        EXPECT_EQ(inside > 0, r < 1);
      }
      changes += (inside > 0) != was_inside ? 1 : 0;
      was_inside = inside > 0;
    }
    EXPECT_EQ(changes % 2, 1);
  }
}

TEST(SignedDistance, TurnsOverWhatFacesInwards) {
  PolygonSoup turned = box({0, 0, 0}, {1, 2, 1});
  for (std::size_t f = 0; f < 6; ++f)
    std::swap(turned.corner_vertices[4 * f + 1], turned.corner_vertices[4 * f + 3]);
  const SignedDistance distance(turned);
  EXPECT_NEAR(distance.volume(), 2, 1e-12);
  EXPECT_NEAR(distance.inside_by({0.5, 0.5, 0.75}), 0.25, 1e-12);
  EXPECT_NEAR(distance.inside_by({0.5, 0.5, 1.75}), -0.75, 1e-12);
}

TEST(SignedDistance, RefusesWhatHasNoInside) {
  PolygonSoup open = box({0, 0, 0}, {1, 1, 1});
  open.face_offsets.pop_back();
  open.corner_vertices.resize(20);
  EXPECT_THAT([&] { SignedDistance(open, "tool.ply"); },
              ThrowsMessage<InputError>(HasSubstr("tool.ply: the surface must be closed")));
  PolygonSoup turned = box({0, 0, 0}, {1, 1, 1});
  std::swap(turned.corner_vertices[1], turned.corner_vertices[3]);
  EXPECT_THROW(SignedDistance{turned}, InputError);
  EXPECT_THAT([&] { SignedDistance(PolygonSoup{}, "none.ply"); },
              ThrowsMessage<InputError>(HasSubstr("none.ply: there is no triangle")));
}

}  // namespace
