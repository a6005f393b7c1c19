#include "meshes.h"
#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/detail/attribute_cost.h>
#include <recede/lod/simplify.h>

#include <gtest/gtest.h>

#include <random>

namespace recede {
namespace {

SimplifyOptions to_ratio(double ratio, const AttributeWeights& weights) {
  SimplifyOptions options;
  options.target.ratio = ratio;
  options.weights = weights;
  options.prove_error = false;
  return options;
}

VertexScalar& add_scalar(PolygonSoup& soup, const std::string& name) {
  return soup.vertex_scalars.emplace_back(VertexScalar{name, {}});
}

/// Weights of one triangle's corners at a point of it.
Vec3 barycentric(const Triangle& t, const Vec3& p) {
  const Vec3 normal = (t.b - t.a).cross(t.c - t.a);
  const double area = normal.squaredNorm();
  const double b = (p - t.a).cross(t.c - t.a).dot(normal) / area,
               c = (t.b - t.a).cross(p - t.a).dot(normal) / area;
  return {1 - b - c, b, c};
}

/// Root mean square of the difference between a scalar of `result` and its values at the vertices of `input`,
/// which are looked up at the nearest point.
double scalar_error(const PolygonSoup& input, const PolygonSoup& result, std::size_t scalar = 0) {
  const std::vector<Index> triangles = triangulate(result);
  const ClosestPointTree tree(result.positions, triangles);
  double sum = 0;
  for (std::size_t v = 0; v < input.positions.size(); ++v) {
    const auto hit = tree.closest(input.positions[v]);
    const Vec3 weights = barycentric(tree.triangle(hit.triangle), hit.point);
    double value = 0;
    for (int k = 0; k < 3; ++k) {
      value += weights[k] *
               result.vertex_scalars[scalar].values[triangles[3 * hit.triangle + static_cast<Index>(k)]];
    }
    const double off = value - input.vertex_scalars[scalar].values[v];
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(input.positions.size()));
}

/// Stripes with soft rims around a bumpy ball.
PolygonSoup striped_ball() {
  PolygonSoup soup = make_displaced_sphere(20000, true);
  VertexScalar& stripes = add_scalar(soup, "stripes");
  for (const Vec3& p : soup.positions) {
    const Vec3 d = p.normalized();
    stripes.values.push_back(0.5 + 0.5 * std::tanh(15 * std::sin(6 * d.x() + 3 * d.y())));
  }
  return soup;
}

TEST(Attributes, LinearOnesStayExactDownToTheCorners) {
  PolygonSoup soup = test::grid(16, true);
  VertexScalar& ramp = add_scalar(soup, "ramp");
  for (const Vec3& p : soup.positions) {
    ramp.values.push_back(3 * p.x() - 2 * p.y() + 1);
    soup.vertex_colors.emplace_back(p.x(), p.y(), 0.5, 1);
  }
  const AttributeWeights weights{.scalars = {{"ramp", 1.0}}};
  const SimplifySoupResult result = simplify(soup, to_ratio(0.004, weights));
  EXPECT_EQ(result.faces_after, 2u);
  for (std::size_t v = 0; v < result.soup.positions.size(); ++v) {
    const Vec3& p = result.soup.positions[v];
    // As for the shape: the square of the regularisation for each of some hundred collapses.
    EXPECT_NEAR(result.soup.vertex_scalars[0].values[v], 3 * p.x() - 2 * p.y() + 1, 1e-11);
    EXPECT_NEAR(result.soup.vertex_colors[v].x(), p.x(), 1e-11);
  }
}

TEST(Attributes, AStepOnAFlatSheetIsKeptWhereItCounts) {
  PolygonSoup soup = test::grid(40, true);
  VertexScalar& step = add_scalar(soup, "step");
  for (const Vec3& p : soup.positions) step.values.push_back((p - Vec3(0.5, 0.5, 0)).norm() < 0.3 ? 1 : 0);
  const double blind = scalar_error(soup, simplify(soup, to_ratio(0.1, {})).soup);
  const double seen = scalar_error(soup, simplify(soup, to_ratio(0.1, {.scalars = {{"step", 0.1}}})).soup);
  EXPECT_GT(blind, 0.1);
  EXPECT_LT(seen, 0.25 * blind);
}

TEST(Attributes, CountingKeepsThemAtLittleCostToTheShape) {
  const PolygonSoup ball = striped_ball();
  const auto blind = simplify(ball, to_ratio(0.1, {})).soup;
  const auto seen = simplify(ball, to_ratio(0.1, {.scalars = {{"stripes", 0.01}}})).soup;
  EXPECT_LT(scalar_error(ball, seen), 0.4 * scalar_error(ball, blind));
  EXPECT_LT(measure_distance(ball, seen).rms, 1.25 * measure_distance(ball, blind).rms);
}

TEST(Attributes, ValuesStayWithinThoseOfTheInput) {
  for (const double weight : {0.0, 0.01, 1.0, 100.0}) {
    const auto result = simplify(striped_ball(), to_ratio(0.02, {.scalars = {{"stripes", weight}}}));
    for (const double value : result.soup.vertex_scalars[0].values) {
      EXPECT_GE(value, 0) << weight;
      EXPECT_LE(value, 1) << weight;
    }
  }
}

TEST(Attributes, WithoutWeightTheShapeIsTheSameAsWithoutAttributes) {
  PolygonSoup coloured = striped_ball();
  for (const Vec3& p : coloured.positions) coloured.vertex_colors.emplace_back(p.x() > 0, p.y() > 0, 0, 1);
  for (const Index v : coloured.corner_vertices)
    coloured.corner_uvs.push_back(coloured.positions[v].head<2>());
  PolygonSoup plain = coloured;
  plain.vertex_scalars.clear();
  plain.vertex_colors.clear();
  plain.corner_uvs.clear();
  const AttributeWeights none{.uv = 0, .normal = 0, .color = 0};
  EXPECT_EQ(simplify(coloured, to_ratio(0.1, none)).soup.positions,
            simplify(plain, to_ratio(0.1, none)).soup.positions);
}

TEST(Attributes, BothSidesOfASeamFollowTheirOwnChart) {
  // A bent sheet with two charts that meet at x = 0.5, both curved in the texture.
  PolygonSoup soup = test::grid(30, true);
  const auto uv_of = [](const Vec3& p, bool right) {
    return right ? Vec2(5 + p.x() * p.x(), p.y()) : Vec2(p.x(), p.y() + 0.2 * std::sin(6 * p.x()));
  };
  for (Vec3& p : soup.positions) p.z() = 0.1 * p.x() * p.x();
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    double x = 0;
    for (const Index v : soup.face(f)) x += soup.positions[v].x() / 3;
    for (const Index v : soup.face(f)) soup.corner_uvs.push_back(uv_of(soup.positions[v], x > 0.5));
  }
  const auto error = [&](double weight) {
    const PolygonSoup coarse = simplify(soup, to_ratio(0.08, {.uv = weight})).soup;
    double sum = 0;
    for (std::size_t c = 0; c < coarse.n_corners(); ++c) {
      const bool right = coarse.corner_uvs[c].x() > 3;
      sum += (coarse.corner_uvs[c] - uv_of(coarse.positions[coarse.corner_vertices[c]], right)).squaredNorm();
    }
    return std::sqrt(sum / static_cast<double>(coarse.n_corners()));
  };
  EXPECT_LT(error(0.1), 2e-4);
  EXPECT_LT(error(0.1), error(0));
}

TEST(Attributes, ScalarsThatCannotCountAreRefusedByName) {
  PolygonSoup ball = striped_ball();
  EXPECT_THROW(simplify(ball, to_ratio(0.1, {.scalars = {{"dots", 1.0}}})), OptionError);
  EXPECT_THROW(simplify(ball, to_ratio(0.1, {.uv = -1})), OptionError);
  ball.vertex_scalars[0].values[7] = std::nan("");
  EXPECT_THROW(simplify(ball, to_ratio(0.1, {.scalars = {{"stripes", 1.0}}})), InputError);
  EXPECT_EQ(simplify(ball, to_ratio(0.1, {})).soup.vertex_scalars[0].name, "stripes");
}

TEST(Attributes, PolygonsAndHalfEdgesCarryThemToo) {
  PolygonSoup quads = make_displaced_sphere(3000, false);
  VertexScalar& height = add_scalar(quads, "height");
  for (const Vec3& p : quads.positions) height.values.push_back(p.z());
  for (const auto placement :
       {VertexPlacement::optimal, VertexPlacement::half_edge, VertexPlacement::midpoint}) {
    SimplifyOptions options = to_ratio(0.2, {.scalars = {{"height", 0.1}}});
    options.placement = placement;
    const PolygonSoup coarse = simplify(quads, options).soup;
    for (std::size_t v = 0; v < coarse.positions.size(); ++v) {
      // Half-edges keep the very value of their vertex; others follow the surface as it bends.
      const double most = placement == VertexPlacement::half_edge ? 0 : 0.05;
      EXPECT_NEAR(coarse.vertex_scalars[0].values[v], coarse.positions[v].z(), most);
    }
  }
}

// The quadratic form against its definition: extrapolated values of every triangle, and their weighted mean.
TEST(AttributeCost, EqualsTheSumOfSquaredDifferencesFromTheBestValue) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int round = 0; round < 50; ++round) {
    PolygonSoup soup = test::grid(3, true);
    for (Vec3& p : soup.positions) p += 0.1 * Vec3(unit(random), unit(random), unit(random));
    VertexScalar& scalar = add_scalar(soup, "s");
    for (std::size_t v = 0; v < soup.positions.size(); ++v) scalar.values.push_back(unit(random));
    const detail::CornerTable table = detail::build_corner_table(soup, {});
    const detail::AttributeChannels channels(table, {.scalars = {{"s", 0.7}}});
    detail::AttributeCost cost(table, channels);
    detail::EdgeRings rings;
    // The inner edge from the vertex at (1, 1) to the one at (2, 2).
    Index first = k_no_index, second = k_no_index;
    for (Index p = 0; p < table.n_points(); ++p) {
      if (table.source_vertex[p] == 5) first = p;
      if (table.source_vertex[p] == 10) second = p;
    }
    rings.gather(table, first, second);
    const Vec3 center = 0.5 * (table.positions[first] + table.positions[second]);
    cost.start(rings, first, second, center);
    struct Prediction {
      Triangle triangle;
      Vec3 values;
      double weight;
    };
    std::vector<Prediction> predictions;
    for (const auto* ring : {&rings.removed, &rings.kept}) {
      for (const detail::RingCorner& c : *ring) {
        if (ring == &rings.kept && c.on_edge) continue;
        const Index before = table.previous(c.corner), after = table.next(c.corner);
        cost.add_triangle(c.corner, before, after);
        Prediction& prediction = predictions.emplace_back();
        const Index points[] = {table.point[c.corner], table.point[before], table.point[after]};
        prediction.triangle = {table.positions[points[0]], table.positions[points[1]],
                               table.positions[points[2]]};
        for (int k = 0; k < 3; ++k) prediction.values[k] = 0.7 * table.point_scalars(points[k])[0];
        const Triangle& t = prediction.triangle;
        prediction.weight = (t.b - t.a).cross(t.c - t.a).squaredNorm();
      }
    }
    const detail::QuadraticForm form = cost.form();
    for (int place = 0; place < 5; ++place) {
      const Vec3 x = 0.2 * Vec3(unit(random), unit(random), unit(random));
      double weights = 0, mean = 0, expected = 0;
      const auto value = [&](const Prediction& p) {
        // Over the plane of the triangle, wherever x is.
        return barycentric(p.triangle, x + center).dot(p.values);
      };
      for (const Prediction& p : predictions) {
        weights += p.weight;
        mean += p.weight * value(p);
      }
      mean /= weights;
      for (const Prediction& p : predictions) expected += p.weight * std::pow(value(p) - mean, 2);
      EXPECT_NEAR(form.at(x), expected, 1e-12 + 1e-9 * expected);
    }
  }
}

}  // namespace
}  // namespace recede
