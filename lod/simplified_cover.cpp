#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/simplified_cover.h>
#include <recede/lod/simplify.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

namespace recede::detail {

namespace {

PolygonSoup soup_of(const BillboardFaces& faces) {
  PolygonSoup soup;
  soup.positions = faces.points;
  soup.face_offsets = faces.offsets;
  soup.corner_vertices = faces.corners;
  return soup;
}

// Where a coordinate is at least as large as 1/sqrt(3), which one has for each unit vector: 6 bins.
std::size_t bin_of(const Vec3& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return 2 * static_cast<std::size_t>(axis) + (normal[axis] < 0 ? 1 : 0);
}
constexpr std::size_t k_bins = 6;

class FaceAssignment {
 public:
  FaceAssignment(const BillboardFaces& faces, const PolygonSoup& simplified, double error,
                 const BillboardOptions& options)
      : faces_(faces),
        positions_(simplified.positions),
        error_(error),
        least_cosine_(std::cos(options.largest_deviation)),
        is_two_sided_(options.is_two_sided) {
    const std::vector<Index> triangles = triangulate(simplified);
    std::array<std::vector<Index>, k_bins> in_bins;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      const Vec3& a = positions_[triangles[t]];
      const Vec3 normal = (positions_[triangles[t + 1]] - a).cross(positions_[triangles[t + 2]] - a);
      if (!(normal.norm() > 0)) continue;  // has no side to be seen from
      normals_.push_back(normal.normalized());
      const std::size_t bin = bin_of(normals_.back());
      numbers_[bin].push_back(static_cast<Index>(corners_.size() / 3));
      for (std::size_t i = t; i < t + 3; ++i) {
        corners_.push_back(triangles[i]);
        in_bins[bin].push_back(triangles[i]);
      }
    }
    if (!corners_.empty()) tree_ = std::make_unique<ClosestPointTree>(positions_, corners_);
    for (std::size_t bin = 0; bin < k_bins; ++bin) {
      if (!in_bins[bin].empty()) trees_[bin] = std::make_unique<ClosestPointTree>(positions_, in_bins[bin]);
    }
  }

  SimplifiedCover run() const {
    std::vector<Index> triangle_of(faces_.count());
    tbb::parallel_for(std::size_t{0}, faces_.count(),
                      [&](std::size_t face) { triangle_of[face] = find(static_cast<Index>(face)); });
    std::vector<CoveringPlane> all(normals_.size());
    SimplifiedCover result;
    for (Index face = 0; face < faces_.count(); ++face) {
      if (triangle_of[face] == k_no_index) {
        result.left_over.push_back(face);
      } else {
        all[triangle_of[face]].faces.push_back(face);
      }
    }
    for (std::size_t t = 0; t < all.size(); ++t) {
      if (all[t].faces.empty()) continue;
      all[t].normal = normals_[t];
      result.triangles.push_back(std::move(all[t]));
    }
    return result;
  }

 private:
  // The nearest triangle that may take the face, of those nearest to its middle and its corners, and of those
  // nearest to its middle that face about to one side.
  Index find(Index face) const {
    if (!tree_) return k_no_index;
    const Vec3 middle = faces_.moments[face].first / faces_.moments[face].area;
    const ClosestPointTree::Hit nearest = tree_->closest(middle);
    if (may_take(nearest.triangle, face)) return nearest.triangle;
    Index best = k_no_index;
    double least = std::numeric_limits<double>::infinity();
    const auto offer = [&](Index triangle) {
      if (!may_take(triangle, face)) return;
      const double square =
          (closest_point_on_triangle(middle, tree_->triangle(triangle)) - middle).squaredNorm();
      if (square < least || (square == least && triangle < best)) {
        least = square;
        best = triangle;
      }
    };
    for (const Index corner : faces_.corners_of(face))
      offer(tree_->closest(faces_.points[corner], nearest.triangle).triangle);
    for (std::size_t bin = 0; bin < k_bins; ++bin) {
      if (trees_[bin]) offer(numbers_[bin][trees_[bin]->closest(middle).triangle]);
    }
    return best;
  }

  bool may_take(Index triangle, Index face) const {
    const Vec3& normal = normals_[triangle];
    const double cosine = faces_.normals[face].dot(normal);
    if ((is_two_sided_ ? std::abs(cosine) : cosine) < least_cosine_) return false;
    const Vec3& at = positions_[corners_[3 * std::size_t{triangle}]];
    const std::span<const Index> corners = faces_.corners_of(face);
    return std::all_of(corners.begin(), corners.end(), [&](Index corner) {
      return std::abs((faces_.points[corner] - at).dot(normal)) <= error_;
    });
  }

  const BillboardFaces& faces_;
  const std::vector<Vec3>& positions_;
  double error_, least_cosine_;
  bool is_two_sided_;
  std::vector<Vec3> normals_;   // of triangles
  std::vector<Index> corners_;  // the same
  std::unique_ptr<ClosestPointTree> tree_;
  std::array<std::unique_ptr<ClosestPointTree>, k_bins> trees_;  // of those that face about to one side
  std::array<std::vector<Index>, k_bins> numbers_;
};

}  // namespace

std::vector<SimplifiedCover> cover_by_simplification(const BillboardFaces& faces,
                                                     std::span<const double> errors,
                                                     const BillboardOptions& options, Progress* progress) {
  // A share of each is kept free for rounding.
  constexpr double k_rounding = 1e-12;
  std::vector<SimplifyTarget> targets;
  for (const double error : errors) targets.push_back({.error = error});
  SimplifyOptions simplification;
  simplification.join_distance = errors.empty() ? 0 : errors.front();
  simplification.drop_parts = true;
  simplification.keep_polygons = false;
  const std::vector<SimplifySoupResult> levels =
      simplify_levels(soup_of(faces), targets, simplification, progress);
  std::vector<SimplifiedCover> covers;
  for (std::size_t i = 0; i < levels.size(); ++i)
    covers.push_back(FaceAssignment(faces, levels[i].soup, errors[i] * (1 - k_rounding), options).run());
  return covers;
}

}  // namespace recede::detail
