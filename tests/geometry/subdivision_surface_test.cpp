#include "control_meshes.h"
#include "input_errors.h"
#include "meshes.h"
#include "subdivided.h"
#include <recede/geometry/subdivision_surface.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>

namespace recede {
namespace {

using test::charted_cube;
using test::control_cube;
using test::control_icosahedron;
using test::error_text;
using test::expect_one_unit_normal_per_point;
using test::grid;
using test::k_rounding;
using test::nearest_point;
using test::shaken;
using test::soup_of;
using test::vertex_normals;
using test::with_level;
using testing::HasSubstr;

bool has_point(const PolygonSoup& soup, const Vec3& at) {
  return (soup.positions[nearest_point(soup.positions, at)] - at).norm() < k_rounding;
}

// Values of the four uniform cubic B-splines that count between knots 0 and 1.
std::array<double, 4> spline_values(double t) {
  return {(1 - t) * (1 - t) * (1 - t) / 6, (3 * t * t * t - 6 * t * t + 4) / 6,
          (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6, t * t * t / 6};
}
std::array<double, 4> spline_slopes(double t) {
  return {-(1 - t) * (1 - t) / 2, (3 * t * t - 4 * t) / 2, (-3 * t * t + 2 * t + 1) / 2, t * t / 2};
}

TEST(Subdivision, ACubesVerticesAreWhereTheLimitMasksPutThem) {
  for (const int level : {0, 1, 3}) {
    const PolygonSoup soup = subdivide(control_cube(), with_level(level)).soup;
    // Valence 3: (9 v + 4 times its edges' ends + the faces' opposite corners) / 24, with sums v and -v.
    for (std::size_t v = 0; v < 8; ++v)
      EXPECT_LT((soup.positions[v] - 0.5 * control_cube().positions[v]).norm(), k_rounding);
    if (level == 0) continue;
    // One refinement by hand gives face points (0,0,1), edge points (3/4,0,3/4) and vertices 5/9 (1,1,1);
    // valence 4: (16 v + 4 edges + faces) / 36.
    EXPECT_TRUE(has_point(soup, {0, 0, (16 + 4 * 3 + 4 * 5.0 / 9) / 36}));
    const double middle = (16 * 0.75 + 4 * (10.0 / 9 + 1) + 1.5) / 36;
    EXPECT_TRUE(has_point(soup, {middle, 0, middle}));
  }
}

TEST(Subdivision, LevelsHaveTheFacesAndPointsOfRefinement) {
  for (const auto& [level, faces, points] : {std::tuple(0, 6u, 8u), {1, 24u, 26u}, {2, 96u, 98u}}) {
    const SubdivisionResult result = subdivide(control_cube(), with_level(level));
    EXPECT_EQ(result.level, level);
    EXPECT_EQ(result.soup.n_faces(), faces);
    EXPECT_EQ(result.soup.positions.size(), points);
  }
  // A pyramid: 4 triangles become 3 quads each, its base 4.
  const PolygonSoup pyramid = soup_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}},
                                      {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
  EXPECT_EQ(subdivide(pyramid, with_level(1)).soup.n_faces(), 16u);
  EXPECT_EQ(subdivide(pyramid, with_level(3)).soup.n_faces(), 256u);
  const SubdivisionResult loop = subdivide(pyramid, with_level(2, SubdivisionScheme::loop));
  EXPECT_EQ(loop.triangulated, 1u);
  EXPECT_EQ(loop.soup.n_faces(), 6u * 16);
  EXPECT_EQ(loop.soup.positions.size(), 6u * 16 / 2 + 2) << "Euler: V = F / 2 + 2";
}

TEST(Subdivision, ARegularGridIsABicubicSpline) {
  // Along x and y the grid is uniform, where the splines give back the place: points tell their parameters.
  constexpr Index k_size = 6;
  PolygonSoup control = grid(k_size);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> height(-1, 1);
  for (Vec3& position : control.positions)
    position = {position.x() * k_size, position.y() * k_size, height(random)};
  const PolygonSoup soup = subdivide(control, with_level(3)).soup;
  const std::vector<Vec3> normals = vertex_normals(soup);
  int inside = 0;
  for (std::size_t k = 0; k < soup.positions.size(); ++k) {
    const Vec3& at = soup.positions[k];
    if (at.head<2>().minCoeff() < 1 - 1e-9 || at.head<2>().maxCoeff() > k_size - 1 + 1e-9)
      continue;  // the border bends
    ++inside;
    const int i = std::min(static_cast<int>(at.x() + 1e-9), static_cast<int>(k_size) - 2),
              j = std::min(static_cast<int>(at.y() + 1e-9), static_cast<int>(k_size) - 2);
    const auto u = spline_values(at.x() - i), v = spline_values(at.y() - j);
    const auto du = spline_slopes(at.x() - i), dv = spline_slopes(at.y() - j);
    double z = 0, slope_x = 0, slope_y = 0;
    for (int a = 0; a < 4; ++a) {
      for (int b = 0; b < 4; ++b) {
        const double c =
            control.positions[static_cast<std::size_t>((i + a - 1) * int(k_size + 1) + j + b - 1)].z();
        z += u[std::size_t(a)] * v[std::size_t(b)] * c;
        slope_x += du[std::size_t(a)] * v[std::size_t(b)] * c;
        slope_y += u[std::size_t(a)] * dv[std::size_t(b)] * c;
      }
    }
    ASSERT_NEAR(at.z(), z, k_rounding);
    ASSERT_LT((normals[k] - Vec3(-slope_x, -slope_y, 1).normalized()).norm(), k_rounding * 10);
  }
  EXPECT_EQ(inside, 33 * 33);
}

TEST(Subdivision, ARegularTriangularGridIsABoxSpline) {
  // On the lattice the refinement is linear in the heights: by hand, twice, and then the limit mask.
  constexpr int k_size = 8;
  PolygonSoup control = grid(k_size, true);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  std::map<std::pair<int, int>, double> heights;  // by x and y in quarters of a step
  for (Vec3& position : control.positions) {
    position = {position.x() * k_size, position.y() * k_size, any(random)};
    heights[{int(std::lround(4 * position.x())), int(std::lround(4 * position.y()))}] = position.z();
  }
  // Edges run along x, y and the diagonal (1, 1).
  constexpr std::pair<int, int> k_ways[] = {{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}};
  for (const int step : {4, 2}) {
    std::map<std::pair<int, int>, double> next;
    for (const auto& [at, h] : heights) {
      const auto look = [&, place = at](int x, int y) {
        const auto found = heights.find({place.first + x, place.second + y});
        return found == heights.end() ? std::nan("") : found->second;
      };
      double ring = 0;
      for (const auto& [x, y] : k_ways) ring += look(step * x, step * y);
      next[at] = 5.0 / 8 * h + ring / 16;
      for (std::size_t way = 0; way < 3; ++way) {
        const auto [x, y] = k_ways[way];
        const auto [left_x, left_y] = k_ways[way + 1];
        const auto [right_x, right_y] = k_ways[(way + 5) % 6];
        next[{at.first + step / 2 * x, at.second + step / 2 * y}] =
            3.0 / 8 * (h + look(step * x, step * y)) +
            (look(step * left_x, step * left_y) + look(step * right_x, step * right_y)) / 8;
      }
    }
    heights = std::move(next);
  }
  const PolygonSoup soup = subdivide(control, with_level(2, SubdivisionScheme::loop)).soup;
  int inside = 0;
  for (const Vec3& at : soup.positions) {
    const int x = int(std::lround(4 * at.x())), y = int(std::lround(4 * at.y()));
    double ring = 0;
    for (const auto& [i, j] : k_ways) ring += heights[{x + i, y + j}];
    const double limit = heights[{x, y}] / 2 + ring / 12;
    if (std::min(x, y) < 8 || std::max(x, y) > 4 * k_size - 8) continue;  // the border reaches in
    ++inside;
    ASSERT_NEAR(at.z(), limit, k_rounding);
    ASSERT_NEAR(at.x(), x / 4.0, k_rounding);
  }
  EXPECT_EQ(inside, 17 * 17);
}

TEST(Subdivision, LoopsLimitMaskGivesTheVerticesOfTetrahedronAndIcosahedron) {
  const PolygonSoup tetrahedron = soup_of({{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}},
                                          {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}});
  const auto check = [](const PolygonSoup& control, double n) {
    const double center = 3.0 / 8 + std::cos(2 * std::numbers::pi / n) / 4;
    const double beta = (5.0 / 8 - center * center) / n, weight = 1 / (3 / (8 * beta) + n);
    const PolygonSoup soup = subdivide(control, with_level(2, SubdivisionScheme::loop)).soup;
    const std::vector<Vec3> normals = vertex_normals(soup);
    for (std::size_t v = 0; v < control.positions.size(); ++v) {
      std::set<Index> ring;
      for (std::size_t f = 0; f < control.n_faces(); ++f) {
        const auto face = control.face(f);
        if (std::find(face.begin(), face.end(), v) != face.end()) ring.insert(face.begin(), face.end());
      }
      Vec3 limit = (1 - n * weight) * control.positions[v];
      for (const Index w : ring) limit += w == v ? Vec3(0, 0, 0) : Vec3(weight * control.positions[w]);
      EXPECT_LT((soup.positions[v] - limit).norm(), k_rounding);
      EXPECT_LT((normals[v] - control.positions[v].normalized()).norm(), k_rounding) << "by symmetry";
    }
  };
  check(tetrahedron, 3);
  check(control_icosahedron(), 5);
}

TEST(Subdivision, ACubeOfSharpEdgesStaysACube) {
  SubdivisionOptions options = with_level(3);
  options.crease_angle = 1;
  const SubdivisionResult result = subdivide(control_cube(), options);
  EXPECT_EQ(result.crease_edges, 12u);
  EXPECT_LT(result.error_estimate, k_rounding);
  for (const Vec3& at : result.soup.positions) EXPECT_NEAR(at.cwiseAbs().maxCoeff(), 1, k_rounding);
  EXPECT_EQ(result.soup.feature_edges.size(), 12u * 8);
  const std::vector<Vec3> normals = vertex_normals(result.soup);
  for (std::size_t v = 0; v < 8; ++v)
    EXPECT_LT((normals[v] - control_cube().positions[v].normalized()).norm(), 1e-12) << "mean of three sides";
  for (const auto& [a, b] : result.soup.feature_edges) {
    const Vec3 middle = (result.soup.positions[a] + result.soup.positions[b]) / 2;
    for (const Index end : {a, b}) {
      if (end < 8) continue;
      const Vec3 across = middle.unaryExpr([](double x) { return std::abs(x) > 1 - 1e-9 ? x : 0.0; });
      EXPECT_LT((normals[end] - across.normalized()).norm(), 1e-12) << "mean of two sides";
    }
  }
  // Edges whose faces meet at a right angle aren't sharper than 91 degrees.
  options.crease_angle = 91 * std::numbers::pi / 180;
  EXPECT_EQ(subdivide(control_cube(), options).crease_edges, 0u);
}

TEST(Subdivision, AnEndlessCreaseIsTheSplineOfItsVertices) {
  SubdivisionOptions options = with_level(3);
  const Index ring[] = {4, 5, 7, 6};
  for (int k = 0; k < 4; ++k) options.creases.push_back({ring[k], ring[(k + 1) % 4], k_infinite_sharpness});
  const PolygonSoup control = shaken(control_cube(), 0.2, 8);
  const PolygonSoup soup = subdivide(control, options).soup;
  EXPECT_EQ(soup.feature_edges.size(), 4u * 8);
  for (std::size_t k = 0; k < 4; ++k) {
    for (int step = 0; step < 8; ++step) {
      const auto weights = spline_values(step / 8.0);
      Vec3 at(0, 0, 0);
      for (std::size_t i = 0; i < 4; ++i) at += weights[i] * control.positions[ring[(k + i + 3) % 4]];
      EXPECT_TRUE(has_point(soup, at)) << k << " " << step;
    }
  }
}

TEST(Subdivision, BordersAreSplinesAndCornersFollowTheRule) {
  const PolygonSoup square = grid(1);
  const SubdivisionResult kept = subdivide(square, with_level(2));
  for (std::size_t v = 0; v < 4; ++v)
    EXPECT_LT((kept.soup.positions[v] - square.positions[v]).norm(), k_rounding);
  SubdivisionOptions options = with_level(2);
  options.boundary = SubdivisionBoundary::edge_only;
  const SubdivisionResult rounded = subdivide(square, options);
  // (a + 4 b + c) / 6 of the corners 0 1 / 2 3.
  EXPECT_LT((rounded.soup.positions[0] - Vec3(1, 1, 0) / 6).norm(), k_rounding);
  for (const PolygonSoup& soup : {kept.soup, rounded.soup}) {
    expect_one_unit_normal_per_point(soup);
    for (const Vec3& normal : soup.corner_normals) EXPECT_LT((normal - Vec3(0, 0, 1)).norm(), 1e-9);
  }
}

TEST(Subdivision, NormalsOfRoundedCornersAreThoseNearBy) {
  // A single quad, bent: at its rounded corners both sides have one direction, so there is no cross product.
  PolygonSoup control = grid(1);
  control.positions[3].z() = 0.5;
  SubdivisionOptions options = with_level(7);
  options.boundary = SubdivisionBoundary::edge_only;
  const PolygonSoup soup = subdivide(control, options).soup;
  const std::vector<Vec3> normals = vertex_normals(soup);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    for (const Index v : soup.face(f)) {
      if (v >= 4) continue;
      // Facets of 1/128 turn by about as much.
      EXPECT_LT(angle_between(normals[v], vector_area(soup, f)), 0.02) << v;
    }
  }
}

TEST(Subdivision, ASharpnessOfOneIsOneSharpStep) {
  SubdivisionOptions options = with_level(2);
  options.crease_angle = 1;
  options.crease_sharpness = 1;
  const SubdivisionResult result = subdivide(control_cube(), options);
  // The sharp step leaves the corner (1,1,1) with edge points (0,1,1) and face points (0,0,1): then
  // (9 + 4 * 2 + 1) / 24.
  EXPECT_LT((result.soup.positions[7] - 0.75 * Vec3(1, 1, 1)).norm(), k_rounding);
  EXPECT_TRUE(result.soup.feature_edges.empty()) << "the limit surface is smooth";
}

TEST(Subdivision, SeamsOfTextureCoordinatesStaySeamsAndAllElseIsOne) {
  const PolygonSoup control = charted_cube();
  const PolygonSoup soup = subdivide(control, with_level(3)).soup;
  ASSERT_EQ(soup.corner_uvs.size(), soup.n_corners());
  EXPECT_EQ(soup.positions.size(), 6u * 64 + 2) << "points are welded across seams";
  std::map<Index, std::set<std::pair<double, double>>> uvs_at;
  for (std::size_t c = 0; c < soup.n_corners(); ++c)
    uvs_at[soup.corner_vertices[c]].insert({soup.corner_uvs[c].x(), soup.corner_uvs[c].y()});
  std::map<std::size_t, int> counts;
  for (const auto& [vertex, uvs] : uvs_at) ++counts[uvs.size()];
  EXPECT_EQ(counts, (std::map<std::size_t, int>{{1, 6 * 49}, {2, 12 * 7}, {3, 8}}));
  // The border of a chart is as straight as it was, with points at equal steps.
  for (std::size_t f = 0; f < 64; ++f) {
    for (std::size_t k = soup.face_offsets[f]; k < soup.face_offsets[f + 1]; ++k) {
      if (uvs_at[soup.corner_vertices[k]].size() < 2) continue;
      const Vec2 within = (soup.corner_uvs[k] - control.corner_uvs[0])
                              .cwiseQuotient(control.corner_uvs[2] - control.corner_uvs[0]);
      EXPECT_NEAR(std::min(within.cwiseAbs().minCoeff(), (within - Vec2(1, 1)).cwiseAbs().minCoeff()), 0,
                  k_rounding);
      for (const double share : {8 * within.x(), 8 * within.y()})
        EXPECT_NEAR(share, std::round(share), 10 * k_rounding);
    }
  }
}

TEST(Subdivision, TextureCoordinatesFollowTheirRule) {
  const PolygonSoup control = charted_cube();
  const auto corner_uv = [&](UvInterpolation rule) {
    SubdivisionOptions options = with_level(1);
    options.uv_interpolation = rule;
    return subdivide(control, options).soup.corner_uvs[0];
  };
  // The border of a chart of one quad is a spline: (a + 4 b + c) / 6. All other rules keep its corners.
  const Vec2 corner = control.corner_uvs[0], size = control.corner_uvs[2] - corner;
  EXPECT_LT((corner_uv(UvInterpolation::smooth) - (corner + size / 6)).norm(), k_rounding);
  for (const UvInterpolation rule :
       {UvInterpolation::corners_only, UvInterpolation::corners_plus_1, UvInterpolation::corners_plus_2,
        UvInterpolation::boundaries, UvInterpolation::linear}) {
    EXPECT_LT((corner_uv(rule) - corner).norm(), k_rounding);
  }
}

TEST(Subdivision, CarriesMaterialsColorsScalarsAndFeatureEdges) {
  PolygonSoup control = control_cube();
  control.materials = {{"side", {1, 0, 0, 1}, ""}, {"lid", {0, 1, 0, 1}, ""}};
  control.face_materials = {0, 0, 0, 0, k_no_index, 1};
  control.vertex_scalars = {{"height", {}}, {"gap", std::vector<double>(8, 1)}};
  control.vertex_scalars[1].values[0] = std::nan("");
  for (const Vec3& p : control.positions) {
    const Vec3 c = (p + Vec3(1, 1, 1)) / 2;
    control.vertex_colors.emplace_back(c.x(), c.y(), c.z(), 1);
    control.vertex_scalars[0].values.push_back(p.z());
  }
  control.feature_edges = {{0, 1}, {5, 4}};
  control.positions.emplace_back(9, 9, 9);  // no face has it
  control.vertex_colors.emplace_back(0, 0, 0, 0);
  for (VertexScalar& scalar : control.vertex_scalars) scalar.values.push_back(0);
  const PolygonSoup soup = subdivide(control, with_level(2)).soup;
  EXPECT_NO_THROW(validate(soup, "result"));
  EXPECT_EQ(soup.positions.size(), 98u) << "without the one that no face has";
  EXPECT_TRUE(soup.materials == control.materials);
  for (std::size_t f = 0; f < soup.n_faces(); ++f)
    EXPECT_EQ(soup.face_materials[f], control.face_materials[f / 16]);
  for (std::size_t v = 0; v < soup.positions.size(); ++v) {
    // Colours and heights are linear in the positions, and so stay.
    EXPECT_LT((soup.vertex_colors[v].head<3>() - (soup.positions[v] + Vec3(1, 1, 1)) / 2).norm(), k_rounding);
    EXPECT_NEAR(soup.vertex_colors[v][3], 1, k_rounding);
    EXPECT_NEAR(soup.vertex_scalars[0].values[v], soup.positions[v].z(), k_rounding);
  }
  EXPECT_TRUE(std::isnan(soup.vertex_scalars[1].values[0]));
  EXPECT_EQ(soup.feature_edges.size(), 2u * 4);
  const auto edges = test::edge_counts(soup);
  for (const auto& [a, b] : soup.feature_edges) EXPECT_TRUE(edges.contains(std::minmax(a, b)));

  SubdivisionOptions sharp = with_level(2);
  sharp.feature_sharpness = k_infinite_sharpness;
  EXPECT_EQ(subdivide(control, sharp).crease_edges, 2u);
}

TEST(Subdivision, AMissingScalarIsMissingAroundItOnly) {
  PolygonSoup control = grid(6);
  control.vertex_scalars = {{"gap", std::vector<double>(49, 1)}};
  control.vertex_scalars[0].values[0] = std::nan("");
  const PolygonSoup soup = subdivide(control, with_level(0)).soup;
  EXPECT_TRUE(std::isnan(soup.vertex_scalars[0].values[0]));
  EXPECT_NEAR(soup.vertex_scalars[0].values[48], 1, k_rounding);
}

TEST(Subdivision, AToleranceTakesTheLeastLevelWithinIt) {
  for (const SubdivisionScheme scheme : {SubdivisionScheme::catmull_clark, SubdivisionScheme::loop}) {
    std::vector<double> errors;
    for (const int level : {0, 1, 2, 3, 4})
      errors.push_back(subdivide(control_cube(), with_level(level, scheme)).error_estimate);
    for (const int level : {0, 2, 4}) {
      SubdivisionOptions options = with_level(0, scheme);
      options.error = 1.01 * errors[std::size_t(level)];
      const SubdivisionResult result = subdivide(control_cube(), options);
      EXPECT_EQ(result.level, level);
      EXPECT_EQ(result.error_estimate, errors[std::size_t(level)]);
    }
    // Facets four times smaller are four times nearer.
    EXPECT_NEAR(errors[3] / errors[4], 4, 0.6);
  }
}

std::string complaint_about(const PolygonSoup& control, const SubdivisionOptions& options = {}) {
  return error_text([&] { subdivide(control, options); });
}

TEST(Subdivision, ControlMeshesThatAreNoneAreNamed) {
  EXPECT_THAT(complaint_about({}), HasSubstr("no faces"));
  PolygonSoup bad = control_cube();
  bad.positions[3].y() = std::nan("");
  EXPECT_THAT(complaint_about(bad), HasSubstr("position"));
  EXPECT_THAT(complaint_about(soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 1}})),
              HasSubstr("face 0 visits vertex 1 twice"));
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0},  {0, 1, 0}, {0, 0, 1},
                                 {1, 1, 1}, {0, -1, 0}, {2, 2, 2}};
  EXPECT_THAT(complaint_about(soup_of(points, {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})),
              HasSubstr("edge 0-1 has 3 faces"));
  EXPECT_THAT(complaint_about(soup_of(points, {{0, 1, 2}, {0, 1, 3}})),
              HasSubstr("edge 0-1 disagree in orientation"));
  EXPECT_THAT(complaint_about(soup_of(points, {{0, 1, 2}, {0, 3, 4}})), HasSubstr("touch at vertex 0"));
  std::vector<Index> many(600);
  PolygonSoup disk;
  for (Index k = 0; k < many.size(); ++k) {
    many[k] = k;
    disk.positions.emplace_back(std::cos(k / 100.0), std::sin(k / 100.0), 0);
  }
  disk.add_face(many);
  EXPECT_THAT(complaint_about(disk), HasSubstr("more than 500 sides"));
  PolygonSoup huge = control_cube();
  for (Vec3& position : huge.positions) position *= 1e71;
  EXPECT_THAT(complaint_about(huge), HasSubstr("positions beyond 1e+70"));
  // Faces without area carry connectivity, and are welcome.
  PolygonSoup flat = control_cube();
  flat.positions[7] = flat.positions[5];
  expect_one_unit_normal_per_point(subdivide(flat, with_level(2)).soup);
  PolygonSoup point = control_cube();
  for (Vec3& position : point.positions) position = {1, 2, 3};
  expect_one_unit_normal_per_point(subdivide(point, with_level(1)).soup);
}

TEST(Subdivision, OptionsOutOfRangeAreNamed) {
  const auto complaint = [](auto&& change) {
    SubdivisionOptions options;
    change(options);
    try {
      subdivide(control_cube(), options);
    } catch (const OptionError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(complaint([](auto& o) { o.level = -1; }), HasSubstr("0 to 10"));
  EXPECT_THAT(complaint([](auto& o) { o.level = 11; }), HasSubstr("0 to 10"));
  EXPECT_THAT(complaint([](auto& o) { o.error = 0; }), HasSubstr("positive"));
  EXPECT_THAT(complaint([](auto& o) { o.error = std::nan(""); }), HasSubstr("positive"));
  EXPECT_THAT(complaint([](auto& o) { o.crease_angle = 4; }), HasSubstr("crease angle"));
  EXPECT_THAT(complaint([](auto& o) { o.crease_sharpness = -1; }), HasSubstr("sharpness"));
  EXPECT_THAT(complaint([](auto& o) { o.creases = {{0, 1, std::nan("")}}; }), HasSubstr("sharpness"));
  EXPECT_THAT(complaint([](auto& o) { o.creases = {{0, 3, 1}}; }), HasSubstr("0-3 is no edge"));
  EXPECT_THAT(complaint([](auto& o) { o.creases = {{0, 99, 1}}; }), HasSubstr("0-99 is no edge"));
  EXPECT_THAT(complaint([](auto& o) { o.corners = {{8, 1}}; }), HasSubstr("8 is no vertex"));
  EXPECT_THAT(complaint_about(test::grid(10), with_level(10)), HasSubstr("more than 50000000"));
  SubdivisionOptions fine;
  fine.error = 1e-12;
  fine.boundary = SubdivisionBoundary::edge_only;
  EXPECT_THAT(complaint_about(test::grid(1), fine), HasSubstr("needs more than 10 levels"));
}

TEST(Subdivision, CanBeCancelled) {
  struct Stop final : Progress {
    void update(std::string_view, double) override {}
    bool cancel_requested() const override { return true; }
  } stop;
  EXPECT_THROW(subdivide(control_cube(), {}, &stop), Cancelled);
}

}  // namespace
}  // namespace recede
