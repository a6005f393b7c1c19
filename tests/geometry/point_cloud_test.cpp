#include "error_text.h"
#include "temp_folder.h"
#include <recede/geometry/error.h>
#include <recede/geometry/point_cloud.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace recede {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// A lattice of squares of side 1 in the plane of x and y.
PointCloud lattice(int n) {
  PointCloud cloud;
  for (int x = 0; x < n; ++x) {
    for (int y = 0; y < n; ++y) cloud.positions.emplace_back(x, y, 0);
  }
  return cloud;
}

// Points on a unit sphere, at random.
PointCloud ball(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> number;
  PointCloud cloud;
  while (cloud.positions.size() < n)
    cloud.positions.push_back(Vec3(number(random), number(random), number(random)).normalized());
  return cloud;
}

std::string complaint_about(const PointCloud& cloud) {
  return test::error_text([&] { splats_of(cloud); });
}

TEST(PointCloud, ReadsNormalsAndColoursOfPlyVerticesWithoutFaces) {
  const test::TempFolder folder;
  folder.write(
      "scan.ply",
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
      "property float nx\nproperty float ny\nproperty float nz\nproperty uchar red\nproperty uchar green\n"
      "property uchar blue\nend_header\n1 2 3 0 0 1 255 0 51\n4 5 6 1 0 0 0 255 0\n");
  const PointCloud cloud = read_point_cloud(folder / "scan.ply");
  EXPECT_THAT(cloud.positions, ElementsAre(Vec3(1, 2, 3), Vec3(4, 5, 6)));
  EXPECT_THAT(cloud.normals, ElementsAre(Vec3(0, 0, 1), Vec3(1, 0, 0)));
  EXPECT_THAT(cloud.colors, ElementsAre(Vec4(1, 0, 0.2, 1), Vec4(0, 1, 0, 1)));
}

TEST(PointCloud, ReadsBarePointsOfPlyAndObj) {
  const test::TempFolder folder;
  folder.write("scan.obj", "v 1 2 3\nv 4 5 6\nv 7 8 9\n");
  folder.write("scan.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
               "float z\nend_header\n1 2 3\n");
  EXPECT_EQ(read_point_cloud(folder / "scan.obj").positions.size(), 3u);
  const PointCloud ply = read_point_cloud(folder / "scan.ply");
  EXPECT_THAT(ply.positions, ElementsAre(Vec3(1, 2, 3)));
  EXPECT_TRUE(ply.normals.empty());
  EXPECT_TRUE(ply.colors.empty());
}

TEST(PointCloud, HasTheNormalOfThePlaneThatItsPointsAreIn) {
  PointCloud cloud;
  const Vec3 normal = Vec3(1, 2, -2) / 3, u = normal.unitOrthogonal(), v = normal.cross(u);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  // Far from the origin, where coordinates have few digits to spare: 1e6 times the rounding of doubles.
  for (int i = 0; i < 200; ++i)
    cloud.positions.push_back(Vec3(1e6, -1e6, 1e6) + number(random) * u + number(random) * v);
  for (const Vec3& estimated : estimate_normals(cloud)) {
    EXPECT_NEAR(estimated.norm(), 1, 1e-12);
    EXPECT_NEAR(std::abs(estimated.dot(normal)), 1, 1e-8);
  }
}

// 16 neighbours of 5 000 points on a sphere reach 0.11 of its radius, 7 degrees. Points at random are off by
// less than that.
TEST(PointCloud, HasTheNormalsOfASphere) {
  const PointCloud cloud = ball(5000, 1);
  const std::vector<Vec3> normals = estimate_normals(cloud);
  for (std::size_t i = 0; i < normals.size(); ++i)
    ASSERT_GT(std::abs(normals[i].dot(cloud.positions[i])), std::cos(7 * std::numbers::pi / 180)) << i;
}

TEST(PointCloud, IsSpacedAsLookingAtAllPairsSays) {
  const PointCloud cloud = ball(300, 2);
  const std::vector<double> spacings = spacings_of(cloud, 5);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    std::vector<double> distances;
    for (const Vec3& other : cloud.positions) distances.push_back((other - cloud.positions[i]).norm());
    std::sort(distances.begin(), distances.end());
    double sum = 0;
    for (std::size_t k = 1; k <= 5; ++k) sum += distances[k];
    EXPECT_NEAR(spacings[i], sum / 5, 1e-12);
  }
}

// In a lattice four neighbours are 1 away and four sqrt(2), on average 1.207: hexagons with a radius of half
// of that have an area of 0.946 of the squares.
TEST(PointCloud, BecomesHexagonsWithAboutTheAreaOfItsSurface) {
  PointCloud cloud = lattice(9);
  cloud.colors.assign(81, Vec4(0.5, 0.25, 0, 1));
  cloud.colors[40] = Vec4(1, 1, 1, 1);
  const Splats splats = splats_of(cloud);
  EXPECT_TRUE(splats.are_normals_estimated);
  EXPECT_EQ(splats.repeated, 0u);
  validate(splats.soup, "discs");
  ASSERT_EQ(splats.soup.n_faces(), 81u);
  const double radius = (1 + std::numbers::sqrt2) / 4;
  Vec3 middle = Vec3::Zero();
  for (const Index corner : splats.soup.face(40)) {
    const Vec3& point = splats.soup.positions[corner];
    middle += point / 6;
    EXPECT_NEAR((point - Vec3(4, 4, 0)).norm(), radius, 1e-12);
    EXPECT_NEAR(point.z(), 0, 1e-12);
    EXPECT_EQ(splats.soup.vertex_colors[corner], Vec4(1, 1, 1, 1));
  }
  EXPECT_NEAR((middle - Vec3(4, 4, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR(vector_area(splats.soup, 40).norm(), 1.5 * std::sqrt(3) * radius * radius, 1e-12);
}

TEST(PointCloud, FacesAsItsNormalsDoAndEstimatesThoseThatAreMissing) {
  PointCloud cloud = lattice(4);
  cloud.normals.assign(16, Vec3(0, 0, -2));
  const Splats given = splats_of(cloud);
  EXPECT_FALSE(given.are_normals_estimated);
  for (std::size_t face = 0; face < 16; ++face) EXPECT_LT(vector_area(given.soup, face).z(), 0);
  cloud.normals[5] = Vec3::Zero();
  const Splats completed = splats_of(cloud);
  EXPECT_TRUE(completed.are_normals_estimated);
  EXPECT_GT(std::abs(vector_area(completed.soup, 5).z()), 0);
}

TEST(PointCloud, TakesPointsAtOnePlaceAsOne) {
  PointCloud cloud = lattice(3);
  const Splats once = splats_of(cloud);
  for (int i = 0; i < 30; ++i) cloud.positions.emplace_back(1, 1, 0);
  const Splats repeated = splats_of(cloud);
  EXPECT_EQ(repeated.repeated, 30u);
  EXPECT_EQ(repeated.soup.positions, once.soup.positions);
  // A point among more repeated ones than it has neighbours.
  EXPECT_EQ(spacings_of(cloud, 3)[4], 0);
  EXPECT_EQ(estimate_normals(cloud, 3)[4], Vec3(0, 0, 1));
}

TEST(PointCloud, TakesFewPointsAndPointsOnALine) {
  PointCloud two{{{0, 0, 0}, {2, 0, 0}}, {}, {}};
  EXPECT_THAT(spacings_of(two, 8), ElementsAre(2, 2));
  for (const Vec3& normal : estimate_normals(two)) EXPECT_NEAR(normal.x(), 0, 1e-12);
  EXPECT_EQ(splats_of(two).soup.n_faces(), 2u);
  PointCloud line;
  for (int i = 0; i < 20; ++i) line.positions.push_back(i * Vec3(1, 2, 3));
  for (const Vec3& normal : estimate_normals(line)) {
    EXPECT_NEAR(normal.norm(), 1, 1e-12);
    EXPECT_NEAR(normal.dot(Vec3(1, 2, 3)), 0, 1e-9);
  }
  EXPECT_EQ(splats_of(line).soup.n_faces(), 20u);
}

TEST(PointCloud, KeepsTheDiscOfALonelyPointSmall) {
  PointCloud cloud = lattice(9);
  cloud.positions.emplace_back(1000, 0, 0);
  const Splats splats = splats_of(cloud);
  const Vec3 corner = splats.soup.positions[splats.soup.face(81)[0]];
  EXPECT_NEAR((corner - Vec3(1000, 0, 0)).norm(), 3 * (1 + std::numbers::sqrt2) / 4, 1e-9);
}

TEST(PointCloud, SaysWhatCantBe) {
  PointCloud cloud = lattice(3);
  cloud.positions[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaint_about(cloud), HasSubstr("7"));
  cloud = lattice(3);
  cloud.normals.resize(4);
  EXPECT_THAT(complaint_about(cloud), HasSubstr("4 normals for 9 points"));
  EXPECT_THAT(complaint_about({}), HasSubstr("no points"));
  EXPECT_THAT(complaint_about({{{1, 1, 1}, {1, 1, 1}}, {}, {}}), HasSubstr("two places"));
  EXPECT_THROW(estimate_normals(lattice(3), 0), OptionError);
  EXPECT_THROW(splats_of(lattice(3), {.radius = 0}), OptionError);
}

TEST(PointCloud, IsTheSameForAnyNumberOfThreads) {
  const PointCloud cloud = ball(3000, 5);
  const PolygonSoup one = [&] {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
    return splats_of(cloud).soup;
  }();
  EXPECT_EQ(one.positions, splats_of(cloud).soup.positions);
}

}  // namespace
}  // namespace recede
