#include <recede/geometry/error.h>
#include <recede/lod/detail/billboard_faces.h>
#include <recede/lod/detail/plane_hulls.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {

namespace {

struct Rectangle {
  Vec2 center = Vec2::Zero(), axis = Vec2::UnitX();  // along its longer side
  Vec2 half_sizes = Vec2::Zero();
};

// The least one around points has a side along one of their hull's.
Rectangle least_rectangle(std::vector<Vec2> points) {
  const std::vector<Vec2> hull = convex_hull(std::move(points));
  Rectangle best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 side = hull[(i + 1) % hull.size()] - hull[i];
    if (!(side.norm() > 0)) continue;
    const Vec2 along = side.normalized(), across(-along.y(), along.x());
    Eigen::AlignedBox2d box;
    for (const Vec2& point : hull) box.extend(Vec2(point.dot(along), point.dot(across)));
    const Vec2 sizes = box.sizes();
    if (!(sizes.prod() < least)) continue;
    least = sizes.prod();
    const bool is_long = sizes.x() >= sizes.y();
    best = {box.center().x() * along + box.center().y() * across, is_long ? along : across,
            is_long ? Vec2(sizes / 2) : Vec2(sizes.reverse() / 2)};
  }
  return best;
}

}  // namespace

BillboardFaces billboard_faces_of(const PolygonSoup& model) {
  validate(model, "billboard cloud");
  BillboardFaces faces;
  Box3 box;
  for (const Index corner : model.corner_vertices) box.extend(model.positions[corner]);
  if (!box.isEmpty()) {
    faces.center = box.center();
    faces.size = box.sizes().maxCoeff();
  }
  if (!(faces.size > 0)) throw InputError("a billboard cloud needs faces with an area");
  for (const Vec3& point : model.positions) faces.points.push_back((point - faces.center) / faces.size);
  std::vector<Index> of_triangles;
  const std::vector<Index> triangles = triangulate(model, &of_triangles);
  std::vector<SurfaceMoments> moments(model.n_faces());
  for (std::size_t t = 0; t < of_triangles.size(); ++t) {
    moments[of_triangles[t]].add(faces.points[triangles[3 * t]], faces.points[triangles[3 * t + 1]],
                                 faces.points[triangles[3 * t + 2]]);
  }
  for (std::size_t face = 0; face < model.n_faces(); ++face) {
    if (!(moments[face].area > 0)) {
      ++faces.left_out;
      continue;
    }
    faces.numbers.push_back(static_cast<Index>(face));
    for (const Index corner : model.face(face)) faces.corners.push_back(corner);
    faces.offsets.push_back(static_cast<Index>(faces.corners.size()));
    faces.normals.push_back(moments[face].normal.normalized());
    faces.moments.push_back(moments[face]);
  }
  if (faces.count() == 0) throw InputError("a billboard cloud needs faces with an area");
  return faces;
}

Billboard billboard_facing(const BillboardFaces& faces, std::span<const Index> members, const Vec3& normal,
                           bool is_two_sided) {
  Billboard result;
  SurfaceMoments moments;
  for (const Index face : members) moments += faces.moments[face];
  const Vec3 front = moments.normal.dot(normal) < 0 ? Vec3(-normal) : normal;
  const Vec3 u = front.unitOrthogonal(), v = front.cross(u);
  double low = std::numeric_limits<double>::infinity(), high = -low, least_cosine = 1;
  std::vector<Vec2> points;
  for (const Index face : members) {
    for (const Index corner : faces.corners_of(face)) {
      const Vec3& point = faces.points[corner];
      low = std::min(low, point.dot(front));
      high = std::max(high, point.dot(front));
      points.emplace_back(point.dot(u), point.dot(v));
    }
    const double cosine = faces.normals[face].dot(front);
    least_cosine = std::min(least_cosine, is_two_sided ? std::abs(cosine) : cosine);
    result.faces.push_back(faces.numbers[face]);
  }
  const Rectangle rectangle = least_rectangle(std::move(points));
  result.axis_u = (rectangle.axis.x() * u + rectangle.axis.y() * v).normalized();
  result.axis_v = front.cross(result.axis_u);
  result.half_sizes = faces.size * rectangle.half_sizes;
  const Vec3 center = rectangle.center.x() * u + rectangle.center.y() * v + (low + high) / 2 * front;
  result.center = faces.center + faces.size * center;
  result.error = faces.size * (high - low) / 2;
  result.normal_deviation = std::acos(std::clamp(least_cosine, -1.0, 1.0));
  result.face_area = faces.size * faces.size * moments.area;
  return result;
}

}  // namespace recede::detail
