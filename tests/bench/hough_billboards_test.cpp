#include "hough_billboards.h"

#include "cloud_check.h"
#include "simple_soups.h"
#include "uv_ball.h"
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace recede::bench {
namespace {

using test::soup_of;

PolygonSoup cube() {
  return triangulated(
      soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
              {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}));
}

TEST(HoughBillboards, OfACubeAreItsSixSides) {
  constexpr double k_error = 0.01;
  const BillboardCloud cloud = hough_billboards(cube(), k_error);
  ASSERT_EQ(cloud.billboards.size(), 6u);
  for (const Billboard& billboard : cloud.billboards) {
    EXPECT_EQ(billboard.faces.size(), 2u);
    // Strips of its neighbours within the error are on the plane, too, but it sees them from their side.
    EXPECT_NEAR(2 * billboard.half_sizes.x(), 1, 1e-12);
    EXPECT_NEAR(2 * billboard.half_sizes.y(), 1, 1e-12);
    EXPECT_NEAR(billboard.normal().cwiseAbs().maxCoeff(), 1, 1e-12);
  }
}

TEST(HoughBillboards, OfSquaresApartOnOnePlaneAreOneRectangleAroundAll) {
  const PolygonSoup two =
      soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {9, 0, 0}, {10, 0, 0}, {10, 1, 0}, {9, 1, 0}},
              {{0, 1, 2, 3}, {4, 5, 6, 7}});
  const BillboardCloud cloud = hough_billboards(two, 0.1);
  ASSERT_EQ(cloud.billboards.size(), 1u);
  // 10 x 1; a plane that leans by the error sees it smaller by less than a thousandth.
  EXPECT_NEAR(cloud.billboards[0].area(), 10, 0.01);
}

TEST(HoughBillboards, TakeInWhatOtherPlanesCover) {
  // A square across the middle of a large one is on a plane of its own, which also sees a strip of the large
  // one, four times as long.
  const PolygonSoup cross = soup_of(
      {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0}, {-2, 2, 0}, {-0.5, 0, 0}, {0.5, 0, 0}, {0.5, 0, 1}, {-0.5, 0, 1}},
      {{0, 1, 2, 3}, {4, 5, 6, 7}});
  const BillboardCloud cloud = hough_billboards(cross, 0.05);
  ASSERT_EQ(cloud.billboards.size(), 2u);
  const auto upright = std::find_if(cloud.billboards.begin(), cloud.billboards.end(),
                                    [](const Billboard& b) { return b.faces == std::vector<Index>{1}; });
  ASSERT_NE(upright, cloud.billboards.end());
  // The plane leans by at most 0.1 over the square's side of 1: the strip is 4 over the cosine of that, and
  // its ends are aslant by a tenth of its width of 0.1.
  EXPECT_NEAR(2 * upright->half_sizes.maxCoeff(), 4, 0.03);
}

TEST(HoughBillboards, CoverEveryFaceOnceWithinTheError) {
  const PolygonSoup models[] = {test::uv_ball(24), make_tree({.leaves = 200})};
  for (const PolygonSoup& model : models) {
    const double size = bounding_box(model).sizes().maxCoeff();
    for (const double share : {0.04, 0.02}) {
      const BillboardCloud cloud = hough_billboards(model, share * size);
      const CloudCheck check = check_cloud(model, cloud, true);
      EXPECT_TRUE(check.is_sound(std::numbers::pi)) << check.distance << " of the error, " << check.uncovered
                                                    << " uncovered, " << check.repeated << " repeated";
    }
  }
}

TEST(HoughBillboards, RefuseFacesThatNoPlaneIsNearTo) {
  const PolygonSoup bent = soup_of({{0, 0, 0}, {1, 0, 1}, {1, 1, 0}, {0, 1, 1}}, {{0, 1, 2, 3}});
  EXPECT_THROW(hough_billboards(bent, 0.01), InputError);
}

TEST(CloudCheck, SeesFacesThatAreFarOffTurnedLeftOutOrRepeated) {
  const PolygonSoup model = cube();
  BillboardCloud cloud = hough_billboards(model, 0.01);
  EXPECT_TRUE(check_cloud(model, cloud, true).is_sound(0));
  const auto aside = std::find_if(
      cloud.billboards.begin() + 1, cloud.billboards.end(),
      [&](const Billboard& b) { return std::abs(b.normal().dot(cloud.billboards[0].normal())) < 0.5; });
  cloud.billboards[0].faces.push_back(aside->faces[0]);
  const CloudCheck check = check_cloud(model, cloud, true);
  EXPECT_EQ(check.repeated, 1u);
  EXPECT_NEAR(check.distance, 100, 1e-9)
      << "the far end of a side at a right angle: its length over the error";
  EXPECT_NEAR(check.deviation, std::numbers::pi / 2, 1e-9);
  cloud.billboards.erase(aside);
  EXPECT_EQ(check_cloud(model, cloud, true).uncovered, 1u) << "the other of its faces was added to the first";
  cloud.left_out = 2;
  EXPECT_EQ(check_cloud(model, cloud, true).uncovered, 1u) << "a face with an area can't be left out";
}

}  // namespace
}  // namespace recede::bench
