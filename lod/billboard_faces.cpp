#include <recede/geometry/atlas_packing.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/billboard_faces.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {

namespace {

// Triangles of a face that crosses itself can cancel out: then it has no front, but still a plane.
Vec3 normal_of(const SurfaceMoments& face) {
  constexpr double k_cancelled = 1e-9;  // of the area
  return face.normal.norm() > k_cancelled * face.area ? Vec3(face.normal.normalized())
                                                      : Vec3(face.axes().col(0));
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
    faces.normals.push_back(normal_of(moments[face]));
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
  std::sort(result.faces.begin(), result.faces.end());
  const BoundingRectangle rectangle = smallest_rectangle(points);
  const Vec2 along = rectangle.axis, across(-along.y(), along.x());
  const Vec2 middle = rectangle.corner + (rectangle.sides.x() * along + rectangle.sides.y() * across) / 2;
  const bool is_upright = rectangle.sides.y() > rectangle.sides.x();  // u is its longer side
  const Vec2& longer = is_upright ? across : along;
  result.axis_u = (longer.x() * u + longer.y() * v).normalized();
  result.axis_v = front.cross(result.axis_u);
  result.half_sizes = faces.size / 2 * (is_upright ? Vec2(rectangle.sides.reverse()) : rectangle.sides);
  const Vec3 center = middle.x() * u + middle.y() * v + (low + high) / 2 * front;
  result.center = faces.center + faces.size * center;
  result.error = faces.size * (high - low) / 2;
  result.normal_deviation = std::acos(std::clamp(least_cosine, -1.0, 1.0));
  result.face_area = faces.size * faces.size * moments.area;
  return result;
}

}  // namespace recede::detail
