#include <recede/lod/detail/linked_level.h>
#include <recede/lod/detail/refinement_bounds.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {
namespace {

/// Grows spheres and cones by more than rounding to single precision takes away.
constexpr double k_rounding = 1e-5;

struct Sphere {
  Vec3 center = Vec3::Zero();
  double radius = -1;  // empty
  /// Becomes the smallest sphere around both.
  void add(const Sphere& other) {
    if (other.radius < 0) return;
    const Vec3 between = other.center - center;
    const double distance = between.norm();
    if (radius >= distance + other.radius) return;
    if (radius < 0 || other.radius >= distance + radius) {
      *this = other;
      return;
    }
    const double both = (distance + radius + other.radius) / 2;
    center += (both - radius) / distance * between;
    radius = both;
  }
};

struct Cone {
  Vec3 axis = Vec3::Zero();
  double angle = -1;  // empty; pi: all directions
  static constexpr double k_all = std::numbers::pi;
  void add(const Cone& other) {
    if (other.angle < 0 || angle >= k_all) return;
    if (angle < 0) {
      *this = other;
      return;
    }
    const double between = std::atan2(axis.cross(other.axis).norm(), axis.dot(other.axis));
    if (angle >= between + other.angle) return;
    if (other.angle >= between + angle) {
      *this = other;
      return;
    }
    const double both = (between + angle + other.angle) / 2;
    const Vec3 across = other.axis - axis.dot(other.axis) * axis;
    constexpr double k_opposite = 1e-6;  // sine: below it rounding says which way the axis turns
    if (both >= k_all || (axis.dot(other.axis) < 0 && across.norm() < k_opposite)) {
      angle = k_all;
      return;
    }
    const double turn = both - angle;
    axis = (std::cos(turn) * axis + std::sin(turn) * across.normalized()).normalized();
    angle = both;
  }
};

class HierarchyBounder {
 public:
  explicit HierarchyBounder(const ProgressiveMesh& mesh);
  HierarchyBounds run();

 private:
  void take_back(Index split);
  void gather_faces(Index vertex);
  void add_gathered();
  void add_below(Index vertex);
  Vec3 normal_of(Index face) const;

  const ProgressiveMesh& mesh_;
  LinkedLevel level_;
  std::vector<Sphere> spheres_;  // by split
  std::vector<Cone> cones_;
  std::vector<Index> next_;  // by vertex: its next split
  std::vector<Index> faces_;
  std::vector<Vec3> points_;
  Sphere sphere_;
  Cone cone_;
};

HierarchyBounder::HierarchyBounder(const ProgressiveMesh& mesh)
    : mesh_(mesh),
      level_(mesh, level_of_all_splits(mesh)),
      spheres_(mesh.splits.size()),
      cones_(mesh.splits.size()),
      next_(mesh.positions.size(), k_no_index) {}

Vec3 HierarchyBounder::normal_of(Index face) const {
  Vec3 normal = Vec3::Zero(), first = Vec3::Zero(), previous = Vec3::Zero();
  int n = 0;
  level_.each_corner_of(face, [&](Index c) {
    const Vec3& p = level_.position(c);
    if (n == 0) first = p;
    const Vec3 arm = p - first;
    if (n > 1) normal += previous.cross(arm);
    previous = arm;
    ++n;
  });
  return normal;
}

void HierarchyBounder::gather_faces(Index vertex) {
  level_.each_corner_at(vertex, [&](Index corner) { faces_.push_back(level_.face(corner)); });
}

/// Adds the gathered faces and what is below their vertices.
void HierarchyBounder::add_gathered() {
  std::sort(faces_.begin(), faces_.end());
  faces_.erase(std::unique(faces_.begin(), faces_.end()), faces_.end());
  points_.clear();
  Vec3 sum = Vec3::Zero();
  double widest = -1;  // no face has a normal
  for (const Index face : faces_) {
    level_.each_corner_of(face, [&](Index c) { points_.push_back(level_.position(c)); });
    const Vec3 normal = normal_of(face);
    const double length = normal.norm();
    if (length > 0) sum += normal / length;
  }
  if (points_.empty()) return;
  Box3 box;
  for (const Vec3& p : points_) box.extend(p);
  Sphere star{box.center(), 0};
  for (const Vec3& p : points_) star.radius = std::max(star.radius, (p - star.center).norm());
  sphere_.add(star);
  sum.normalize();
  for (const Index face : faces_) {
    const Vec3 normal = normal_of(face);
    const double angle = std::atan2(sum.cross(normal).norm(), sum.dot(normal));
    if (normal.squaredNorm() > 0) widest = std::max(widest, angle);
  }
  const bool cancel_out = widest >= 0 && sum.isZero(0);
  cone_.add({sum, cancel_out ? Cone::k_all : widest});
  faces_.clear();
}

void HierarchyBounder::add_below(Index vertex) {
  const Index split = next_[vertex];
  if (split == k_no_index) return;
  sphere_.add(spheres_[split]);
  cone_.add(cones_[split]);
}

void HierarchyBounder::take_back(Index number) {
  const VertexSplit& split = mesh_.splits[number];
  sphere_ = {};
  cone_ = {};
  const auto returning = level_.faces_of(number);
  faces_.assign(returning.begin(), returning.end());
  if (split.kept == k_no_index) {
    for (const Index face : returning) {
      level_.each_corner_of(face, [&](Index c) { add_below(level_.state().corner_vertices()[c]); });
    }
    cone_.add({Vec3::UnitX(), Cone::k_all});
    add_gathered();
  } else {
    gather_faces(split.kept);
    gather_faces(split.removed);
    add_gathered();
    add_below(split.kept);
    add_below(split.removed);
  }
  level_.apply<false>(number);
  if (split.kept != k_no_index) {
    gather_faces(split.kept);
    add_gathered();
    next_[split.kept] = number;
  }
  spheres_[number] = sphere_;
  cones_[number] = cone_;
}

HierarchyBounds HierarchyBounder::run() {
  HierarchyBounds bounds;
  const std::size_t n = mesh_.splits.size();
  bounds.starts.assign(n, 0);
  for (std::size_t s = n; s-- > 0;) {
    take_back(static_cast<Index>(s));
    const Index kept = mesh_.splits[s].kept;
    bounds.starts[s] = kept == k_no_index || !level_.has_faces(kept) ? 1 : 0;
  }
  Box3 box;
  for (const Vec3& position : level_.state().positions()) box.extend(position);
  if (!box.isEmpty()) bounds.origin = 0.5 * box.min() + 0.5 * box.max();
  bounds.splits.reserve(n);
  for (std::size_t s = 0; s < n; ++s) {
    const Sphere& sphere = spheres_[s];
    const Cone& cone = cones_[s];
    RefinementBounds& b = bounds.splits.emplace_back();
    const Vec3 center = sphere.center - bounds.origin;
    for (int axis = 0; axis < 3; ++axis) {
      b.center[axis] = static_cast<float>(center[axis]);
      b.axis[axis] = static_cast<float>(cone.axis[axis]);
    }
    const double moved = (center - Vec3(b.center[0], b.center[1], b.center[2])).norm();
    b.radius = static_cast<float>((std::max(sphere.radius, 0.0) + moved) * (1 + k_rounding));
    b.angle = static_cast<float>(cone.angle < 0 ? Cone::k_all : cone.angle + k_rounding);
    b.error = static_cast<float>(mesh_.level_errors[s]);
    if (static_cast<double>(b.error) < mesh_.level_errors[s]) b.error = std::nextafter(b.error, HUGE_VALF);
  }
  return bounds;
}

}  // namespace

HierarchyBounds bound_hierarchy(const ProgressiveMesh& mesh) { return HierarchyBounder(mesh).run(); }

}  // namespace recede::detail
