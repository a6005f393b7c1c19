#include "hough_billboards.h"

#include <recede/geometry/atlas_packing.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/billboard_faces.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace recede::bench {
namespace {

using detail::BillboardFaces;
using detail::SurfaceMoments;

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr double k_pi = std::numbers::pi;

struct Plane {
  Vec3 normal = Vec3::UnitZ();
  double offset = 0;
};

struct Interval {
  double low = k_infinity, high = -k_infinity;

  bool overlaps(double from, double to) const { return low < high && low <= to && from <= high; }
};

Vec3 direction_of(double around, double upwards) {
  return {std::cos(around) * std::cos(upwards), std::sin(around) * std::cos(upwards), std::sin(upwards)};
}

/// Angles and offsets of planes.
struct Cell {
  Vec3 low = Vec3::Zero(), sides = Vec3::Zero();

  Plane middle() const {
    const Vec3 at = low + sides / 2;
    return {direction_of(at.x(), at.y()), at.z()};
  }
  /// One of its 8 parts, or of those that continue them beyond it: parts have numbers from -2 to 3 along each
  /// axis.
  Cell part(int x, int y, int z) const { return {low + sides.cwiseProduct(Vec3(x, y, z)) / 2, sides / 2}; }
  bool is_within_domain() const {
    const double middle = low.y() + sides.y() / 2;
    return std::abs(middle) < k_pi / 2 && low.z() + sides.z() > 0;
  }
};

/// Directions that all cells of one after the other offset share.
struct Column {
  std::array<Vec3, 4> corners;
  Vec3 middle;
};

Column column_of(const Cell& cell) {
  const Vec3 &a = cell.low, b = cell.low + cell.sides;
  return {{direction_of(a.x(), a.y()), direction_of(b.x(), a.y()), direction_of(a.x(), b.y()),
           direction_of(b.x(), b.y())},
          cell.middle().normal};
}

/// Along each axis: of a cell and its neighbours.
constexpr int k_first_part = -2;
constexpr std::size_t k_parts = 6;
using Densities = std::array<double, k_parts>;

class HoughPlanes {
 public:
  HoughPlanes(const BillboardFaces& faces, double error, const HoughOptions& options)
      : faces_(faces), options_(options), error_(error), is_covered_(faces.count(), 0) {
    double farthest = 0;
    for (const Index corner : faces.corners) farthest = std::max(farthest, faces.points[corner].norm());
    n_offsets_ = static_cast<std::size_t>(std::ceil((farthest + error) / error));
    for (std::size_t column = 0; column < options.around * options.upwards; ++column)
      columns_.push_back(column_of(cell_at(column, 0)));
    density_.assign(columns_.size() * n_offsets_, 0.0);
    valid_.assign(density_.size(), 0);
    for (Index face = 0; face < faces.count(); ++face) add(face, 1);
  }

  /// Planes, and for each the faces that it was the first to take.
  std::vector<std::pair<Plane, std::vector<Index>>> run() {
    std::vector<std::pair<Plane, std::vector<Index>>> planes;
    for (std::size_t n_left = faces_.count(); n_left > 0;) {
      const Cell cell = densest();
      const std::vector<Index> members = valid_for(cell, uncovered());
      Plane plane = refined(cell, members);
      std::vector<Index> taken = near_faces(plane);
      if (taken.empty()) {
        plane = plane_of_one(members.empty() ? uncovered().front() : members.front());
        taken = near_faces(plane);
        if (taken.empty()) throw InputError("a face isn't flat within the error");
      }
      for (const Index face : taken) {
        is_covered_[face] = 1;
        add(face, -1);
      }
      n_left -= taken.size();
      planes.emplace_back(plane, std::move(taken));
    }
    return planes;
  }

 private:
  // Offsets of planes with some direction of a cell that are near to all points of a face.
  Interval offsets_near(Index face, const Column& column) const {
    Interval offsets{-k_infinity, k_infinity};
    for (const Index corner : faces_.corners_of(face)) {
      Interval at;
      for (const Vec3& direction : column.corners) {
        at.low = std::min(at.low, faces_.points[corner].dot(direction));
        at.high = std::max(at.high, faces_.points[corner].dot(direction));
      }
      offsets.low = std::max(offsets.low, at.low - error_);
      offsets.high = std::min(offsets.high, at.high + error_);
    }
    return offsets;
  }

  double area_along(Index face, const Vec3& normal) const {
    return faces_.moments[face].area * std::abs(faces_.normals[face].dot(normal));
  }

  Cell cell_at(std::size_t column, std::size_t offset) const {
    const Vec3 sides(2 * k_pi / static_cast<double>(options_.around),
                     k_pi / static_cast<double>(options_.upwards), error_);
    const Vec3 at(static_cast<double>(column / options_.upwards),
                  static_cast<double>(column % options_.upwards), static_cast<double>(offset));
    return {Vec3(0, -k_pi / 2, 0) + at.cwiseProduct(sides), sides};
  }

  // To the cells that are valid for a face, and against those that miss it.
  void add(Index face, int sign) {
    for (std::size_t column = 0; column < columns_.size(); ++column) {
      const Interval near = offsets_near(face, columns_[column]);
      if (!(near.low < near.high)) continue;
      const double area = sign * area_along(face, columns_[column].middle);
      const double reach = options_.missed_reach * error_;
      const auto first = static_cast<std::size_t>(std::max(0.0, std::floor((near.low - reach) / error_)));
      for (std::size_t i = first; i < n_offsets_; ++i) {
        const double from = static_cast<double>(i) * error_, to = from + error_;
        if (from > near.high) break;
        const bool is_valid = near.overlaps(from, to);
        density_[column * n_offsets_ + i] += is_valid ? area : -options_.penalty * area;
        valid_[column * n_offsets_ + i] += is_valid ? sign : 0;
      }
    }
  }

  Cell densest() const {
    std::size_t best = 0;
    double most = -k_infinity;
    for (std::size_t i = 0; i < density_.size(); ++i) {
      if (valid_[i] <= 0 || density_[i] <= most) continue;
      most = density_[i];
      best = i;
    }
    return cell_at(best / n_offsets_, best % n_offsets_);
  }

  std::vector<Index> uncovered() const {
    std::vector<Index> result;
    for (Index face = 0; face < faces_.count(); ++face) {
      if (is_covered_[face] == 0) result.push_back(face);
    }
    return result;
  }

  std::vector<Index> valid_for(const Cell& cell, const std::vector<Index>& members) const {
    const Column column = column_of(cell);
    std::vector<Index> valid;
    for (const Index face : members) {
      if (offsets_near(face, column).overlaps(cell.low.z(), cell.low.z() + cell.sides.z()))
        valid.push_back(face);
    }
    return valid;
  }

  // Of parts of a cell with the same directions: minus infinity where no face is valid.
  Densities densities_of(const Cell& cell, int x, int y, const std::vector<Index>& members) const {
    const Column column = column_of(cell.part(x, y, 0));
    const double reach = options_.missed_reach * error_, side = cell.sides.z() / 2;
    Densities densities{};
    std::array<bool, k_parts> is_valid{};
    for (const Index face : members) {
      const Interval near = offsets_near(face, column);
      if (!(near.low < near.high)) continue;
      const double area = area_along(face, column.middle);
      for (std::size_t z = 0; z < k_parts; ++z) {
        const double from = cell.low.z() + (static_cast<double>(z) + k_first_part) * side, to = from + side;
        if (near.overlaps(from, to)) {
          densities[z] += area;
          is_valid[z] = true;
        } else if (to >= near.low - reach && from < near.low) {
          densities[z] -= options_.penalty * area;
        }
      }
    }
    for (std::size_t z = 0; z < k_parts; ++z) {
      if (!is_valid[z]) densities[z] = -k_infinity;
    }
    return densities;
  }

  std::optional<Cell> densest_part(const Cell& cell, const std::vector<Index>& members) const {
    std::optional<Cell> best;
    double most = -k_infinity;
    constexpr int k_end = k_first_part + static_cast<int>(k_parts);
    for (int x = k_first_part; x < k_end; ++x) {
      for (int y = k_first_part; y < k_end; ++y) {
        const Densities densities = densities_of(cell, x, y, members);
        for (int z = k_first_part; z < k_end; ++z) {
          const Cell part = cell.part(x, y, z);
          const double density = densities[static_cast<std::size_t>(z - k_first_part)];
          if (density <= most || !part.is_within_domain()) continue;
          most = density;
          best = part;
        }
      }
    }
    return best;
  }

  Plane refined(Cell cell, std::vector<Index> members) const {
    constexpr int k_most_halvings = 12;  // a cell is then far below what the error can tell
    for (int halving = 0; halving < k_most_halvings; ++halving) {
      if (is_near_to_all(cell.middle(), members)) return cell.middle();
      const std::optional<Cell> best = densest_part(cell, members);
      std::vector<Index> valid;
      if (best) valid = valid_for(*best, members);
      if (valid.empty()) return least_squares(members);
      cell = *best;
      members = std::move(valid);
    }
    return cell.middle();
  }

  Plane least_squares(const std::vector<Index>& members) const {
    SurfaceMoments moments;
    for (const Index face : members) moments += faces_.moments[face];
    if (!(moments.area > 0)) return {};
    const Vec3 normal = moments.axes().col(0);
    return {normal, normal.dot(moments.first) / moments.area};
  }

  bool is_near(Index face, const Plane& plane) const {
    const detail::FaceReach reach = detail::reach_of(faces_, face, plane.normal);
    return reach.high - plane.offset <= error_ && plane.offset - reach.low <= error_;
  }
  bool is_near_to_all(const Plane& plane, const std::vector<Index>& members) const {
    return std::all_of(members.begin(), members.end(), [&](Index face) { return is_near(face, plane); });
  }
  Plane plane_of_one(Index face) const {
    const detail::FaceReach reach = detail::reach_of(faces_, face, faces_.normals[face]);
    return {faces_.normals[face], (reach.low + reach.high) / 2};
  }
  std::vector<Index> near_faces(const Plane& plane) const {
    std::vector<Index> near;
    for (Index face = 0; face < faces_.count(); ++face) {
      if (is_covered_[face] == 0 && is_near(face, plane)) near.push_back(face);
    }
    return near;
  }

  const BillboardFaces& faces_;
  HoughOptions options_;
  double error_;
  std::size_t n_offsets_ = 0;
  std::vector<Column> columns_;
  std::vector<double> density_;  // by column and offset
  std::vector<int> valid_;       // faces
  std::vector<unsigned char> is_covered_;
};

// What a polygon has in front of a plane's offset, or behind it.
std::vector<Vec3> clipped(const std::vector<Vec3>& polygon, const Vec3& normal, double offset) {
  std::vector<Vec3> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double at_a = a.dot(normal) - offset, at_b = b.dot(normal) - offset;
    if (at_a >= 0) result.push_back(a);
    if ((at_a >= 0) != (at_b >= 0)) result.push_back(a + at_a / (at_a - at_b) * (b - a));
  }
  return result;
}

// The rectangle around all of the model that is near to a plane.
Billboard billboard_on(const Plane& plane, const std::vector<Index>& taken, const BillboardFaces& faces,
                       double error) {
  Billboard billboard = detail::billboard_facing(faces, taken, plane.normal, true);
  const Vec3 u = plane.normal.unitOrthogonal(), v = plane.normal.cross(u);
  std::vector<Vec2> points;
  for (Index face = 0; face < faces.count(); ++face) {
    std::vector<Vec3> polygon;
    for (const Index corner : faces.corners_of(face)) polygon.push_back(faces.points[corner]);
    polygon = clipped(polygon, plane.normal, plane.offset - error);
    polygon = clipped(polygon, -plane.normal, -plane.offset - error);
    for (const Vec3& point : polygon) points.emplace_back(point.dot(u), point.dot(v));
  }
  const BoundingRectangle rectangle = smallest_rectangle(points);
  const Vec2 along = rectangle.axis, across(-along.y(), along.x());
  const Vec2 middle = rectangle.corner + (rectangle.sides.x() * along + rectangle.sides.y() * across) / 2;
  billboard.axis_u = along.x() * u + along.y() * v;
  billboard.axis_v = plane.normal.cross(billboard.axis_u);
  billboard.half_sizes = faces.size / 2 * rectangle.sides;
  billboard.center =
      faces.center + faces.size * (middle.x() * u + middle.y() * v + plane.offset * plane.normal);
  billboard.error = faces.size * error;
  return billboard;
}

}  // namespace

BillboardCloud hough_billboards(const PolygonSoup& model, double error, const HoughOptions& options) {
  const BillboardFaces faces = detail::billboard_faces_of(model);
  const double relative = error / faces.size;
  BillboardCloud cloud;
  cloud.error = error;
  cloud.left_out = faces.left_out;
  cloud.is_two_sided = true;
  for (const auto& [plane, taken] : HoughPlanes(faces, relative, options).run())
    cloud.billboards.push_back(billboard_on(plane, taken, faces, relative));
  return cloud;
}

}  // namespace recede::bench
