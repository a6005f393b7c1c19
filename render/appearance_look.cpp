#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/map_surface.h>
#include <recede/render/detail/appearance_look.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace recede::detail {
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
    : appearance_(std::move(appearance)) {
  std::vector<Vec4> tangents = maps.corner_tangents;
  if (tangents.empty()) {
    PolygonSoup shaded = base;
    shaded.corner_normals = normals;
    tangents = tangents_of(shaded);
  }
  std::vector<Index> corners;
  triangulate(base, nullptr, &corners);
  triangles_.resize(corners.size() / 3);
  for (std::size_t c = 0; c < corners.size(); ++c) {
    Triangle& triangle = triangles_[c / 3];
    const Index corner = corners[c];
    triangle.normals[c % 3] = normals[corner].cast<float>();
    triangle.tangents[c % 3] = tangents[corner].head<3>().cast<float>();
    triangle.uvs[c % 3] = base.corner_uvs[corner].cast<float>();
    triangle.side = tangents[corner].w() < 0 ? -1.0f : 1.0f;
  }
  normal_map_.size = maps.size;
  normal_map_.normal = maps.normal;
  normal_map_.float_normal = maps.float_normal;
}

Vec3 AppearanceLook::normal_at(std::uint32_t triangle, const Vec3& weights) const {
  const Triangle& at = triangles_[triangle];
  const Eigen::Vector3f w = weights.cast<float>();
  const Eigen::Vector3f sum = w.x() * at.normals[0] + w.y() * at.normals[1] + w.z() * at.normals[2];
  const float squared = sum.squaredNorm();
  return squared > 1e-12f ? Vec3((sum / std::sqrt(squared)).cast<double>())
                          : Vec3(at.normals[0].cast<double>());
}

SurfaceFrame AppearanceLook::frame_at(std::uint32_t triangle, const Vec3& weights) const {
  const Triangle& at = triangles_[triangle];
  const Eigen::Vector3f w = weights.cast<float>();
  SurfaceFrame frame;
  frame.normal = normal_at(triangle, weights);
  const Vec3 tangent =
      (w.x() * at.tangents[0] + w.y() * at.tangents[1] + w.z() * at.tangents[2]).cast<double>();
  const Vec3 across = tangent - frame.normal.dot(tangent) * frame.normal;
  const double squared = across.squaredNorm();
  frame.along_u = squared > 1e-12 ? Vec3(across / std::sqrt(squared)) : Vec3(frame.normal.unitOrthogonal());
  frame.along_v = static_cast<double>(at.side) * frame.normal.cross(frame.along_u);
  frame.uv = (w.x() * at.uvs[0] + w.y() * at.uvs[1] + w.z() * at.uvs[2]).cast<double>();
  return frame;
}

Vec3 AppearanceLook::bump_normal(const Vec2& uv, const DisplacementMap& heights) const {
  if (!normal_map_.normal.samples.empty()) return normal_map_.normal_at(uv);
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

double least_direction(const PolygonSoup& base) {
  const std::vector<Index> points = points_of_corners(base);
  const std::vector<Vec3> directions = point_directions(base, points);
  std::vector<Index> corners;
  triangulate(base, nullptr, &corners);
  double least = 1;
  for (std::size_t c = 0; c + 2 < corners.size(); c += 3) {
    const Triangle triangle{directions[points[corners[c]]], directions[points[corners[c + 1]]],
                            directions[points[corners[c + 2]]]};
    least = std::min(least, closest_point_on_triangle(Vec3::Zero(), triangle).norm());
  }
  constexpr double k_least = 0.05;
  return std::max(least, k_least);
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
