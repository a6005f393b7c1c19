#include "shapes.h"
#include <recede/geometry/detail/base64.h>
#include <recede/render/detail/viewer_mesh.h>

#include <gmock/gmock.h>
#include <zlib.h>

#include <limits>

namespace recede {
namespace {

using detail::viewer_mesh;
using detail::ViewerMesh;

// Reads lists as `pack` says that it wrote them.
class Unpacked {
 public:
  explicit Unpacked(const std::string& text) {
    const std::string packed = detail::decode_base64(text).value();
    uLongf size = 1 << 24;  // more than any shape here takes
    bytes_.resize(size);
    EXPECT_EQ(uncompress(bytes_.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
              Z_OK);
    bytes_.resize(size);
  }

  template <typename Number>
  std::vector<Number> read(std::size_t count) {
    std::vector<Number> list(count);
    for (unsigned shift = 0; shift < 8 * sizeof(Number); shift += 8) {
      for (Number& value : list)
        value = static_cast<Number>(value | static_cast<Number>(bytes_.at(at_++)) << shift);
    }
    for (std::size_t i = 1; i < count; ++i) list[i] = static_cast<Number>(list[i] + list[i - 1]);
    return list;
  }

  bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::vector<Bytef> bytes_;
  std::size_t at_ = 0;
};

ClosestPointTree tree_of(const PolygonSoup& soup) { return {soup.positions, triangulate(soup)}; }

Vec3 place(const ViewerMesh& mesh, Index vertex, const Box3& box) {
  const Vec3 steps(mesh.positions[0][vertex], mesh.positions[1][vertex], mesh.positions[2][vertex]);
  return box.min() + steps.cwiseProduct(box.sizes()) / 65535;
}

Vec3 normal_of(const ViewerMesh& mesh, Index vertex) {
  const double x = mesh.normals[0][vertex] / 511.0 - 1, y = mesh.normals[1][vertex] / 511.0 - 1;
  const double z = 1 - std::abs(x) - std::abs(y), fold = std::max(-z, 0.0);
  return Vec3(x - std::copysign(fold, x), y - std::copysign(fold, y), z).normalized();
}

TEST(ViewerMesh, DecodedAgainIsWithinHalfAStep) {
  const PolygonSoup input = make_sphere(Vec3(100, -20, 3), 7, 40, 20, 0.1);
  const PolygonSoup level = make_sphere(Vec3(100, -20, 3), 7, 24, 12, 0.1);
  Box3 box = bounding_box(input);
  box.extend(bounding_box(level));
  const ClosestPointTree tree = tree_of(input);
  const ViewerMesh made = viewer_mesh(level, box, tree);

  Unpacked unpacked(detail::pack(made));
  ViewerMesh mesh;
  const std::size_t vertices = made.distances.size();
  for (auto& list : mesh.positions) list = unpacked.read<std::uint16_t>(vertices);
  mesh.distances = unpacked.read<std::uint16_t>(vertices);
  for (auto& list : mesh.normals) list = unpacked.read<std::uint16_t>(vertices);
  for (auto& list : mesh.colors) list = unpacked.read<std::uint8_t>(vertices);
  mesh.indices = unpacked.read<Index>(made.indices.size());
  EXPECT_TRUE(unpacked.at_end());

  const std::vector<Index> triangles = triangulate(level);
  ASSERT_EQ(mesh.indices.size(), triangles.size());
  // Rounding in double precision is nothing beside a step of 16 bits.
  const Vec3 half_step = box.sizes() / 65535 / 2 * (1 + 1e-9);
  const double half_distance = made.largest_distance / 65535 / 2 * (1 + 1e-9);
  double largest = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Vec3& wanted = level.positions[triangles[i]];
    const Vec3 off = (place(mesh, mesh.indices[i], box) - wanted).cwiseAbs();
    EXPECT_TRUE((off.array() <= half_step.array()).all()) << off.transpose();
    double distance = std::numeric_limits<double>::infinity();
    for (Index t = 0; t < tree.size(); ++t)
      distance = std::min(distance, (closest_point_on_triangle(wanted, tree.triangle(t)) - wanted).norm());
    EXPECT_NEAR(mesh.distances[mesh.indices[i]] * made.largest_distance / 65535, distance, half_distance);
    largest = std::max(largest, distance);
  }
  EXPECT_NEAR(made.largest_distance, largest, 1e-12);
  EXPECT_GT(largest, 0.01);
}

TEST(ViewerMesh, CornersWithOtherNormalsHaveVerticesOfTheirOwn) {
  const PolygonSoup cube = make_cube(Vec3::Zero(), 2);
  const ViewerMesh mesh = viewer_mesh(cube, bounding_box(cube), tree_of(cube));
  EXPECT_EQ(mesh.distances.size(), 24u);
  EXPECT_EQ(mesh.indices.size(), 36u);
  EXPECT_EQ(mesh.largest_distance, 0);
  for (std::size_t t = 0; t < 36; t += 3) {
    const Index* triangle = &mesh.indices[t];
    const Box3 box = bounding_box(cube);
    const Vec3 a = place(mesh, triangle[0], box);
    const Vec3 normal =
        (place(mesh, triangle[1], box) - a).cross(place(mesh, triangle[2], box) - a).normalized();
    // Axes are exact in the octahedron.
    for (int k = 0; k < 3; ++k) EXPECT_NEAR((normal_of(mesh, triangle[k]) - normal).norm(), 0, 1e-12);
  }
}

TEST(ViewerMesh, NormalsOfAllDirectionsAreKeptToAQuarterOfADegree) {
  const PolygonSoup sphere = make_sphere(Vec3::Zero(), 1, 64, 32);
  PolygonSoup with_normals = sphere;
  for (const Index vertex : sphere.corner_vertices)
    with_normals.corner_normals.push_back(sphere.positions[vertex]);
  const Box3 box = bounding_box(sphere);
  const ViewerMesh mesh = viewer_mesh(with_normals, box, tree_of(sphere));
  EXPECT_EQ(mesh.distances.size(), sphere.positions.size());
  for (Index i = 0; i < mesh.distances.size(); ++i) {
    // Steps of the square are 1/511: half of one off along x and y, so one along z, on a plane sqrt(1/3) from
    // the center.
    const double bound = std::sqrt(0.25 + 0.25 + 1) / 511 * std::sqrt(3.0);
    EXPECT_LT((normal_of(mesh, i) - place(mesh, i, box).normalized()).norm(), bound);
  }
}

TEST(ViewerMesh, ColoursAreThoseOfMaterialsTimesThoseOfVertices) {
  PolygonSoup cube = make_cube(Vec3::Zero(), 2);
  cube.materials.resize(2);
  cube.materials[0].base_color = {1, 0.5, 0, 1};
  cube.materials[1].base_color = {1, 1, 1, 1};
  cube.face_materials = {0, 0, 0, 1, 1, 1};
  cube.vertex_colors.assign(8, Vec4(0.5, 0.5, 0.5, 1));
  const ViewerMesh mesh = viewer_mesh(cube, bounding_box(cube), tree_of(cube));
  const auto color = [&](std::size_t corner) {
    const Index vertex = mesh.indices[corner];
    return std::array<int, 3>{mesh.colors[0][vertex], mesh.colors[1][vertex], mesh.colors[2][vertex]};
  };
  // 0.5 and 0.25 in sRGB.
  EXPECT_THAT(color(0), testing::ElementsAre(188, 137, 0));
  EXPECT_THAT(color(35), testing::ElementsAre(188, 188, 188));
}

TEST(ViewerMesh, TextureCoordinatesAreKeptWhereTheyAreWanted) {
  PolygonSoup square;
  square.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  square.add_face(std::array<Index, 4>{0, 1, 2, 3});
  square.corner_uvs = {{0, 0.25}, {1, 0.25}, {1, 0.75}, {0, 0.75}};
  EXPECT_TRUE(viewer_mesh(square, bounding_box(square), tree_of(square)).uvs[0].empty());
  const ViewerMesh made = viewer_mesh(square, bounding_box(square), tree_of(square), true);
  Unpacked unpacked(detail::pack(made));
  const std::size_t vertices = made.distances.size();
  for (int list = 0; list < 6; ++list) unpacked.read<std::uint16_t>(vertices);
  for (int list = 0; list < 3; ++list) unpacked.read<std::uint8_t>(vertices);
  const auto u = unpacked.read<std::uint16_t>(vertices), v = unpacked.read<std::uint16_t>(vertices);
  const auto indices = unpacked.read<Index>(made.indices.size());
  EXPECT_TRUE(unpacked.at_end());
  std::vector<Index> corners;
  triangulate(square, nullptr, &corners);
  ASSERT_EQ(indices.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    // 0.25 isn't a step of 16 bits.
    EXPECT_NEAR(u[indices[i]] / 65535.0, square.corner_uvs[corners[i]].x(), 0.5 / 65535);
    EXPECT_NEAR(v[indices[i]] / 65535.0, square.corner_uvs[corners[i]].y(), 0.5 / 65535);
  }
}

TEST(ViewerMesh, AFlatModelHasNoStepsAlongItsNormal) {
  PolygonSoup square;
  square.positions = {{0, 0, 5}, {1, 0, 5}, {1, 1, 5}, {0, 1, 5}};
  square.add_face(std::array<Index, 4>{0, 1, 2, 3});
  const ViewerMesh mesh = viewer_mesh(square, bounding_box(square), tree_of(square));
  EXPECT_THAT(mesh.positions[2], testing::Each(0));
  EXPECT_EQ(place(mesh, mesh.indices[0], bounding_box(square)).z(), 5);
}

}  // namespace
}  // namespace recede
