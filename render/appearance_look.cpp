#include <recede/render/detail/appearance_look.h>

#include <algorithm>
#include <array>
#include <utility>

namespace recede::detail {
namespace {

BakedMaps maps_over(const PolygonSoup& base, std::vector<Vec3> normals, const BakedMaps& maps) {
  BakedMaps over = maps;
  over.surface = base;
  over.surface.corner_normals = std::move(normals);
  if (over.corner_tangents.empty()) over.corner_tangents = tangents_of(over.surface);
  over.displacement = {};
  over.float_displacement = {};
  over.color = {};
  return over;
}

}  // namespace

MethodShares shares_of(const RenderingTransition& transition) {
  switch (transition.method) {
    case RenderingMethod::brdf:
      return {.table = 1, .displaced = 0};
    case RenderingMethod::brdf_to_bump:
      return {.table = 1 - transition.progress, .displaced = 0};
    case RenderingMethod::bump:
      return {.table = 0, .displaced = 0};
    case RenderingMethod::bump_to_displacement:
      return {.table = 0, .displaced = transition.progress};
    case RenderingMethod::displacement:
      break;
  }
  return {};
}

AppearanceLook::AppearanceLook(const PolygonSoup& base, std::vector<Vec3> normals, const BakedMaps& maps,
                               std::shared_ptr<const Appearance> appearance)
    : maps_(maps_over(base, std::move(normals), maps)),
      triangles_(maps_),
      appearance_(std::move(appearance)) {}

SurfaceFrame AppearanceLook::frame_at(std::uint32_t triangle, const Vec3& weights) const {
  const MapPlace place = triangles_.at(triangle, weights);
  SurfaceFrame frame;
  frame.normal = place.normal;
  frame.along_u = (place.tangent - place.normal.dot(place.tangent) * place.normal).stableNormalized();
  if (frame.along_u.isZero(0)) frame.along_u = place.normal.unitOrthogonal();
  frame.along_v = place.normal.cross(frame.along_u);
  // Charts may be mirrored.
  if (frame.along_v.dot(place.bitangent) < 0) frame.along_v = -frame.along_v;
  frame.uv = Vec2::Zero();
  for (std::size_t k = 0; k < 3; ++k)
    frame.uv += weights[static_cast<Eigen::Index>(k)] * triangles_.uv(triangle, k);
  return frame;
}

Vec3 AppearanceLook::bump_normal(const Vec2& uv, const DisplacementMap& heights) const {
  if (!maps_.normal.samples.empty()) return maps_.normal_at(uv);
  const Vec2 slope = heights.smooth_derivative_at(uv).cwiseQuotient(appearance_->stretch().sides);
  return Vec3(-slope.x(), -slope.y(), 1).normalized();
}

HeightSpan span_of(const DisplacementMap& heights) {
  double sum = 0;
  HeightSpan span{heights.texel(0, 0), 0, heights.texel(0, 0)};
  for (int y = 0; y < heights.rows(); ++y) {
    for (int x = 0; x < heights.columns(); ++x) {
      const double height = heights.texel(x, y);
      sum += height;
      span.least = std::min(span.least, height);
      span.largest = std::max(span.largest, height);
    }
  }
  span.mean = sum / (static_cast<double>(heights.columns()) * heights.rows());
  return span;
}

PolygonSoup raised_base(const PolygonSoup& base, double height) {
  const std::vector<Index> points = points_of_corners(base);
  const std::vector<Vec3> directions = point_directions(base, points);
  PolygonSoup raised = base;
  raised.corner_normals.resize(base.n_corners());
  for (std::size_t c = 0; c < base.n_corners(); ++c) {
    const Vec3& direction = directions[points[c]];
    const Index vertex = base.corner_vertices[c];
    raised.corner_normals[c] = direction;
    raised.positions[vertex] = base.positions[vertex] + height * direction;
  }
  return raised;
}

std::vector<BorderSide> border_sides(const PolygonSoup& base) {
  const std::vector<Index> points = points_of_corners(base);
  std::vector<Index> corners;
  triangulate(base, nullptr, &corners);
  struct Side {
    std::array<Index, 2> points;  // in order of their numbers
    BorderSide side;
  };
  std::vector<Side> sides;
  for (std::size_t c = 0; c < corners.size(); ++c) {
    const std::size_t triangle = c / 3, k = c % 3;
    const Index a = points[corners[c]], b = points[corners[3 * triangle + (k + 1) % 3]];
    sides.push_back({{std::min(a, b), std::max(a, b)},
                     {static_cast<std::uint32_t>(triangle), static_cast<std::uint32_t>(k)}});
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const Side& a, const Side& b) { return a.points < b.points; });
  std::vector<BorderSide> borders;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].points == sides[i].points) ++end;
    if (end == i + 1) borders.push_back(sides[i].side);
    i = end;
  }
  return borders;
}

}  // namespace recede::detail
