#include <recede/shells/detail/box_tree.h>
#include <recede/shells/detail/director_cuts.h>

#include <tbb/parallel_for.h>

#include <algorithm>

namespace recede::detail {

namespace {

BoxTree::Box box_of(std::span<const Vec3> points) {
  const auto at = [](const Vec3& p) { return std::array<double, 3>{p.x(), p.y(), p.z()}; };
  BoxTree::Box box{at(points[0]), at(points[0])};
  for (const Vec3& p : points) box.extend({at(p), at(p)});
  return box;
}

// Where the segment meets the triangle, from 0 to 1; above 1 where it doesn't. Moeller and Trumbore 1997.
double meeting(const Vec3& from, const Vec3& along, std::span<const Vec3, 3> corners) {
  constexpr double k_never = 2;
  const Vec3 one = corners[1] - corners[0], other = corners[2] - corners[0], across = along.cross(other);
  const double volume = one.dot(across);
  if (volume == 0) return k_never;
  const Vec3 start = from - corners[0], turned = start.cross(one);
  const double u = start.dot(across) / volume, v = along.dot(turned) / volume, t = other.dot(turned) / volume;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : k_never;
}

}  // namespace

std::vector<double> shares_before_surface(const ShellSurface& surface, std::span<const Vec3> ends) {
  const auto corners_of = [&](std::size_t t) {
    const Index* const corners = &surface.triangles[3 * t];
    return std::array<Vec3, 3>{surface.positions[corners[0]], surface.positions[corners[1]],
                               surface.positions[corners[2]]};
  };
  std::vector<BoxTree::Box> boxes;
  boxes.reserve(surface.triangles.size() / 3);
  for (std::size_t t = 0; 3 * t < surface.triangles.size(); ++t) boxes.push_back(box_of(corners_of(t)));
  const BoxTree tree(boxes);
  std::vector<double> shares(ends.size(), 1);
  tbb::parallel_for(std::size_t{0}, ends.size(), [&](std::size_t v) {
    const std::array<Vec3, 2> director{surface.positions[v], ends[v]};
    const Vec3 along = ends[v] - surface.positions[v];
    tree.visit_overlaps(box_of(director), [&](Index t) {
      const std::span<const Index> corners = surface.triangles.subspan(3 * std::size_t{t}, 3);
      if (std::find(corners.begin(), corners.end(), static_cast<Index>(v)) != corners.end()) return;
      shares[v] = std::min(shares[v], meeting(director[0], along, corners_of(t)));
    });
  });
  return shares;
}

}  // namespace recede::detail
