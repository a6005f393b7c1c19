#include "displaced_planes.h"
#include "sanitized.h"
#include <recede/geometry/error.h>
#include <recede/render/hemisphere_square.h>
#include <recede/render/redistributed_bump.h>
#include <recede/render/reflectance_table.h>

#include <gtest/gtest.h>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr double k_degree = k_pi / 180;
constexpr int k_places = 1 << 17;

/// A displaced plane with all that is made of it.
struct Surface {
  const char* name;
  DisplacementMap map;
  Vec2 sides;
  VisibleNormalsOptions options;
  DisplacedPlane plane{map, sides};
  VisibleNormals normals = sample_visible_normals(plane, options);
  RedistributedBump bump{normals};
  ReflectanceTable table = make_reflectance_table(normals);

  Surface(const char* its_name, DisplacementMap its_map, double side, VisibleNormalsOptions its_options = {})
      : name(its_name), map(std::move(its_map)), sides(side, side), options(its_options) {}
  Surface(const Surface&) = delete;
};

/// Cells of one length; crests of 1.4 lengths, or other shapes of about that steepness.
const Surface& smooth_waves() {
  static const Surface surface("waves", test::random_waves(1, 1.4), 32);
  return surface;
}
const Surface& steep_waves() {
  static const Surface surface("steep waves", test::random_waves(2, 3), 32);
  return surface;
}
const Surface& rough_ground() {
  static const Surface surface("rough ground", test::rough_ground(4, 1), 24);
  return surface;
}
/// Round, with flat ground between them.
const Surface& bumps() {
  static const Surface surface("bumps", test::round_bumps(0.5), 6);
  return surface;
}
/// Longer along v by four, with a table for every 30 degrees around.
const Surface& ridges() {
  static const Surface surface("ridges", test::random_waves(3, 1.4, 32, 4), 32,
                               {.bins = 61, .azimuths = 12, .samples = 32'768});
  return surface;
}

std::size_t bin_of(const Vec3& normal) {
  const Vec2 place = 31 * hemisphere_to_square(normal);
  return static_cast<std::size_t>(std::min(static_cast<int>(place.x()), 30) * 31 +
                                  std::min(static_cast<int>(place.y()), 30));
}

/// The distribution in the viewer's frame, and the mean light for each of some directions towards a light.
struct Seen {
  std::vector<double> shares = std::vector<double>(31 * 31, 0.0);
  std::vector<double> light;
  double count = 0;

  explicit Seen(std::size_t lights) : light(lights, 0.0) {}
  void add(const Vec3& normal, const std::vector<Vec3>& lights) {
    ++count;
    shares[bin_of(normal)] += 1;
    for (std::size_t i = 0; i < lights.size(); ++i) light[i] += std::max(0.0, lights[i].dot(normal));
  }
  Seen means() const {
    Seen result = *this;
    for (double& share : result.shares) share /= count;
    for (double& value : result.light) value /= count;
    return result;
  }
};

/// In the viewer's frame: behind the surface, on the viewer's side, aside, low, and above.
const std::vector<Vec3>& lights() {
  static const std::vector<Vec3> lights{Vec3(-.6, .3, .7).normalized(), Vec3(.6, .3, .7).normalized(),
                                        Vec3(0, -.8, .6), Vec3(.9, 0, .35).normalized(), Vec3(0, 0, 1)};
  return lights;
}

/// What rays see of the displaced surface.
Seen seen_displaced(const Surface& surface, double view_angle, std::optional<double> azimuth = {}) {
  Seen seen(lights().size());
  test::for_seen_normals(
      surface.plane, view_angle, k_places,
      [&](const Vec3& normal, double, const DisplacedPlane::Hit&) { seen.add(normal, lights()); }, azimuth);
  return seen.means();
}

/// What a flat surface shows whose bump normals go through `move(normal, viewer)`, both in its own frame.
template <class Move>
Seen seen_flat(const Surface& surface, double view_angle, const Move& move,
               std::optional<double> fixed_azimuth = {}) {
  Seen seen(lights().size());
  test::for_places(surface.plane, k_places, [&](const Vec2& place, double azimuth) {
    if (fixed_azimuth) azimuth = *fixed_azimuth;
    const Vec3 normal = surface.plane.normal_at(place.cwiseQuotient(surface.sides));
    seen.add(test::turned(move(normal, test::direction_at(view_angle, azimuth)), -azimuth), lights());
  });
  return seen.means();
}

Seen seen_redistributed(const Surface& surface, const RedistributedBump& bump, double view_angle,
                        std::optional<double> azimuth = {}) {
  return seen_flat(
      surface, view_angle,
      [&](const Vec3& normal, const Vec3& viewer) { return bump.normal_for_view(normal, viewer); }, azimuth);
}

Seen seen_plain(const Surface& surface, double view_angle) {
  return seen_flat(surface, view_angle, [](const Vec3& normal, const Vec3&) { return normal; });
}

TEST(RedistributedBump, ShowsTheNormalsOfTheDisplacedSurfaceFromEveryAngle) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const Surface& surface = smooth_waves();
  const RedistributedBump searching(surface.normals, {.exact = true});
  for (const double degrees : {0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0}) {
    const Seen displaced = seen_displaced(surface, degrees * k_degree);
    for (const RedistributedBump* bump : {&surface.bump, &searching}) {
      const double distance =
          total_variation(seen_redistributed(surface, *bump, degrees * k_degree).shares, displaced.shares);
      // The bound of the claim. Chance alone puts a hundredth into wrong bins, so there is little room.
      EXPECT_LE(distance, 0.03) << degrees << (bump == &searching ? " by search" : " by grids");
    }
  }
}

void expect_equal_light(const Surface& surface, double degrees, std::optional<double> azimuth = {}) {
  const double angle = degrees * k_degree;
  const Seen displaced = seen_displaced(surface, angle, azimuth);
  const Seen redistributed = seen_redistributed(surface, surface.bump, angle, azimuth);
  for (std::size_t i = 0; i < lights().size(); ++i) {
    const Vec3& light = lights()[i];
    const double from_table = surface.table.value(angle, std::acos(light.z()),
                                                  std::atan2(light.y(), light.x()), azimuth.value_or(0));
    // Of the claim, half a per cent.
    const double tolerance = 0.005 * displaced.light[i];
    EXPECT_NEAR(redistributed.light[i], displaced.light[i], tolerance)
        << surface.name << ' ' << degrees << ' ' << i;
    EXPECT_NEAR(from_table, displaced.light[i], tolerance) << surface.name << ' ' << degrees << ' ' << i;
  }
}

TEST(RedistributedBump, AndTheTableAreAsBrightAsTheDisplacedSurface) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  for (const Surface* surface : {&smooth_waves(), &steep_waves(), &rough_ground()}) {
    for (const double degrees : {0.0, 15.0, 32.0, 45.0, 60.0, 70.0, 80.0})
      expect_equal_light(*surface, degrees);
  }
}

TEST(RedistributedBump, AndTheTableFollowTheDirectionOfRidges) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  for (const double azimuth : {0.0, 90.0, 120.0, 330.0}) {
    for (const double degrees : {30.0, 60.0, 80.0}) expect_equal_light(ridges(), degrees, azimuth * k_degree);
  }
}

TEST(RedistributedBump, CantSplitTheOneNormalOfFlatGroundButTheTableDoesNotMind) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  // From aside, flat ground is seen less. As a map of normals can't show one normal as two, its share goes to
  // another bin as a whole.
  for (const double degrees : {45.0, 70.0}) {
    const double angle = degrees * k_degree;
    const Seen displaced = seen_displaced(bumps(), angle);
    const Seen redistributed = seen_redistributed(bumps(), bumps().bump, angle);
    EXPECT_GT(total_variation(redistributed.shares, displaced.shares), 0.1) << degrees;
    for (std::size_t i = 0; i < lights().size(); ++i) {
      const Vec3& light = lights()[i];
      EXPECT_NEAR(redistributed.light[i], displaced.light[i], 0.04 * displaced.light[i])
          << degrees << ' ' << i;
      EXPECT_NEAR(bumps().table.value(angle, std::acos(light.z()), std::atan2(light.y(), light.x())),
                  displaced.light[i], 0.005 * displaced.light[i])
          << degrees << ' ' << i;
    }
  }
}

TEST(RedistributedBump, IsBetterThanPlainBumpsWhichAreBetterThanTheLiteralDirection) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const Surface& surface = smooth_waves();
  const RedistributedBump literal(surface.normals, {.literal = true});
  const RedistributedBump undivided(surface.normals, {.conditional = false});
  for (const double degrees : {30.0, 45.0, 60.0, 70.0, 80.0}) {
    const double angle = degrees * k_degree;
    const Seen displaced = seen_displaced(surface, angle);
    const auto distance = [&](const Seen& seen) { return total_variation(seen.shares, displaced.shares); };
    const Seen corrected_seen = seen_redistributed(surface, surface.bump, angle);
    const Seen plain_seen = seen_plain(surface, angle);
    const Seen literal_seen = seen_redistributed(surface, literal, angle);
    const double corrected = distance(corrected_seen), plain = distance(plain_seen);
    EXPECT_LT(2 * corrected, plain) << degrees;
    EXPECT_GT(distance(literal_seen), 1.5 * plain) << degrees;
    EXPECT_GT(distance(seen_redistributed(surface, undivided, angle)), 2 * corrected) << degrees;
    // The light on the back: the literal direction moves it away from the right value.
    EXPECT_GT(plain_seen.light[0], displaced.light[0]) << degrees;
    EXPECT_GT(literal_seen.light[0], plain_seen.light[0]) << degrees;
  }
}

TEST(RedistributedBump, KeepsLightAndNormalsWhileDisplacementGrows) {
  if (test::k_sanitized) GTEST_SKIP() << "millions of rays, and no other code than in the rest";
  const Surface& surface = smooth_waves();
  for (const double degrees : {45.0, 70.0}) {
    const double angle = degrees * k_degree;
    const Seen whole = seen_displaced(surface, angle);
    for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      // Heights times a part are sides over it; the bump's normals stay those of the whole heights.
      const DisplacedPlane partly(surface.map, surface.sides / std::max(part, 1e-6));
      Seen seen(lights().size()), raw(lights().size());
      test::for_seen_normals(
          partly, angle, k_places, [&](const Vec3&, double azimuth, const DisplacedPlane::Hit& hit) {
            const Vec3 normal = surface.plane.normal_at(hit.uv);
            const Vec3 viewer = test::direction_at(angle, azimuth);
            seen.add(test::turned(surface.bump.normal_for_view(normal, viewer, part), -azimuth), lights());
            raw.add(test::turned(normal, -azimuth), lights());
          });
      for (std::size_t i = 0; i < lights().size(); ++i)
        EXPECT_NEAR(seen.means().light[i], whole.light[i], 0.005 * whole.light[i])
            << degrees << ' ' << part << ' ' << i;
      EXPECT_LE(total_variation(seen.means().shares, whole.shares), 0.03) << degrees << ' ' << part;
      // The heights scaled show the normals that the whole ones show from the equivalent angle.
      const std::vector<double> equivalent =
          normals_for_view(surface.normals, equivalent_view_angle(angle, part));
      EXPECT_LE(total_variation(raw.means().shares, equivalent), 0.03) << degrees << ' ' << part;
    }
  }
}

TEST(RedistributedBump, LeavesTheNormalsOfTheWholeDisplacementAsTheyAre) {
  const Surface& surface = smooth_waves();
  for (const double degrees : {20.0, 45.0, 70.0, 80.0}) {
    test::for_seen_normals(surface.plane, degrees * k_degree, 2000,
                           [&](const Vec3&, double azimuth, const DisplacedPlane::Hit& hit) {
                             const Vec3 viewer = test::direction_at(degrees * k_degree, azimuth);
                             const Vec3 same = surface.bump.normal_for_view(hit.normal, viewer, 1);
                             // Bins with few normals magnify the rounding of sums.
                             EXPECT_LT((same - hit.normal).norm(), 1e-6);
                           });
  }
}

TEST(RedistributedBump, LeadsThereAndBack) {
  const Surface& surface = smooth_waves();
  test::for_places(surface.plane, 5000, [&](const Vec2& place, double) {
    const Vec3 normal = surface.plane.normal_at(place.cwiseQuotient(surface.sides));
    for (const double angle : {0.0, 0.4, 1.0, 1.5}) {
      const Vec3 there = surface.bump.redistribute(normal, angle);
      EXPECT_NEAR(there.norm(), 1, 1e-12);
      EXPECT_LT((surface.bump.restore(there, angle) - normal).norm(), 1e-6) << angle;
    }
    EXPECT_LT((surface.bump.redistribute(normal, 0) - normal).norm(), 1e-9);
  });
}

TEST(RedistributedBump, TurnsWithTheViewer) {
  // Isotropic tables don't know where u points: turning normal and viewer turns the result. Steps of the
  // grids are rounded to floats.
  const RedistributedBump searching(smooth_waves().normals, {.exact = true});
  const Vec3 normal = Vec3(0.2, -0.1, 1).normalized();
  for (const auto& [bump, tolerance] : {std::pair(&searching, 1e-9), std::pair(&smooth_waves().bump, 1e-6)}) {
    const Vec3 expected = bump->normal_for_view(normal, test::direction_at(1.2, 0));
    for (const double azimuth : {0.3, 2.0, 5.0}) {
      const Vec3 result =
          bump->normal_for_view(test::turned(normal, azimuth), test::direction_at(1.2, azimuth));
      EXPECT_LT((result - test::turned(expected, azimuth)).norm(), tolerance) << azimuth;
    }
  }
}

TEST(RedistributedBump, SearchesInShadingWhatItRedistributes) {
  const Surface& surface = smooth_waves();
  const RedistributedBump searching(surface.normals, {.exact = true});
  test::for_seen_normals(
      surface.plane, 0.5, 2000, [&](const Vec3& normal, double, const DisplacedPlane::Hit&) {
        for (const double angle : {0.0, 0.02, 0.7, 1.3, 1.57}) {
          const Vec3 searched = searching.normal_for_view(normal, test::direction_at(angle, 0));
          // The ninth digit of places on the square, which bins with few normals magnify.
          ASSERT_LT((searched - searching.redistribute(normal, angle)).norm(), 1e-6) << angle;
        }
      });
}

TEST(RedistributedBump, LooksUpInGridsAboutWhatItSearches) {
  const Surface& surface = smooth_waves();
  for (const double angle : {0.0, 0.4, 0.8, 1.2, 1.4}) {
    double squares = 0;
    constexpr int k_count = 5000;
    test::for_places(surface.plane, k_count, [&](const Vec2& place, double azimuth) {
      const Vec3 normal = surface.plane.normal_at(place.cwiseQuotient(surface.sides));
      const Vec3 found = surface.bump.normal_for_view(normal, test::direction_at(angle, azimuth));
      const Vec3 searched = surface.bump.redistribute(test::turned(normal, -azimuth), angle);
      squares += (test::turned(found, -azimuth) - searched).squaredNorm();
    });
    // A bin is 0.08 wide, and a normal may jump by one between rows, where grids go across.
    EXPECT_LT(std::sqrt(squares / k_count), 0.012) << angle;
  }
}

TEST(RedistributedBump, MovesBetweenTwoHandMadeDistributions) {
  // Two bins a side. From above all four have a quarter; from view 1 the first row has 0.1 and 0.3, the
  // second 0.6 and nothing.
  const VisibleNormals normals{
      .bins = 2, .views = 1, .azimuths = 1, .shares = {.25, .25, .25, .25, .1, .3, .6, 0}, .noise = {0, 0}};
  const RedistributedBump bump(normals);
  const double view = k_pi / 4;  // that of view 1
  const auto move = [&](double a, double b) {
    return hemisphere_to_square(bump.redistribute(square_to_hemisphere({a, b}), view));
  };
  // First axis: cumulated 0.2 of a is 0.2 of a, which is half of the first row's 0.4. Second: half of the row
  // is 0.2 of 0.4, beyond the 0.1 of the first bin by a third of the second.
  EXPECT_LT((move(.2, .5) - Vec2(.25, .5 + .5 / 3)).norm(), 1e-12);
  // 0.7 of a is half of the second row's 0.6; all of it lies in its first bin.
  EXPECT_LT((move(.7, .5) - Vec2(.75, .25)).norm(), 1e-12);
  EXPECT_LT((move(.7, 1) - Vec2(.75, .5)).norm(), 1e-9);
  // A normal in the empty bin goes back evenly: nothing is beyond its row's end.
  const Vec2 back = hemisphere_to_square(bump.restore(square_to_hemisphere({.75, .9}), view));
  EXPECT_LT((back - Vec2(.7, 1)).norm(), 1e-9);
}

TEST(RedistributedBump, SpreadsNormalsOfAnEmptyRowEvenly) {
  const VisibleNormals normals{
      .bins = 2, .views = 1, .azimuths = 1, .shares = {.5, .5, 0, 0, .25, .25, .25, .25}, .noise = {0, 0}};
  const RedistributedBump bump(normals);
  for (const double b : {0.1, 0.4, 0.8}) {
    const Vec2 place = hemisphere_to_square(bump.redistribute(square_to_hemisphere({.9, b}), k_pi / 4));
    EXPECT_LT((place - Vec2(1, b)).norm(), 1e-9) << b;
  }
}

TEST(RedistributedBump, KeepsTheNormalsOfAFlatPlane) {
  const DisplacementMap map(1, 1, {0}, MapBorder::periodic);
  const RedistributedBump bump(sample_visible_normals(DisplacedPlane(map, {1, 1}), {.samples = 10}));
  for (const double angle : {0.0, 1.0, 1.57, 2.0})
    EXPECT_LT((bump.redistribute({0, 0, 1}, angle) - Vec3(0, 0, 1)).norm(), 1e-9) << angle;
}

TEST(RedistributedBump, GivesUnitNormalsAboveTheHorizonForAnyInput) {
  const RedistributedBump& bump = (test::k_sanitized ? smooth_waves() : ridges()).bump;
  std::mt19937 random(1);
  std::normal_distribution<double> number;
  for (int i = 0; i < 10'000; ++i) {
    const Vec3 normal = Vec3(number(random), number(random), number(random)).normalized();
    const Vec3 viewer = Vec3(number(random), number(random), number(random)).normalized();
    for (const double displaced : {0.0, 0.3, 1.0}) {
      const Vec3 result = bump.normal_for_view(normal, viewer, displaced);
      ASSERT_NEAR(result.norm(), 1, 1e-12);
      ASSERT_GE(result.z(), 0);
    }
  }
}

TEST(RedistributedBump, HasTheEquivalentAnglesOfTheSource) {
  // 60 degrees, from a flat to the whole surface.
  const std::pair<double, double> pairs[] = {{0, 0}, {.25, 23.413}, {.5, 40.893}, {.75, 52.411}, {1, 60}};
  for (const auto& [part, degrees] : pairs)
    EXPECT_NEAR(equivalent_view_angle(60 * k_degree, part) / k_degree, degrees, 5e-4) << part;
  EXPECT_NEAR(equivalent_view_angle(k_pi / 2, 0.5), k_pi / 2, 1e-12);
  EXPECT_EQ(equivalent_view_angle(0, 0.5), 0);
}

TEST(RedistributedBump, RefusesWhatArentDistributions) {
  EXPECT_THROW(RedistributedBump(VisibleNormals{}), InputError);
  VisibleNormals normals = smooth_waves().normals;
  normals.shares[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(RedistributedBump{normals}, InputError);
}

}  // namespace
}  // namespace recede
