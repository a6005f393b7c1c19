#include <recede/geometry/closest_point.h>
#include <recede/geometry/detail/face_grid.h>
#include <recede/geometry/detail/limit_error.h>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace recede::detail {
namespace {

constexpr std::size_t k_faces_of_a_task = 8;
constexpr std::size_t k_blocks = 32;  // between two of them progress is reported

class ErrorSearch {
 public:
  ErrorSearch(const ControlMesh& control, const LimitSurface& surface, SubdivisionScheme scheme, int level,
              const PolygonSoup& facets)
      : control_(control), surface_(surface), facets_(facets), triangles_(triangulate(facets)) {
    const std::size_t n_faces = control.soup.n_faces();
    const int sample_level = limit_sample_level(scheme, level);
    steps_ = side_steps(sample_level);
    first_cells_.push_back(0);
    for (std::size_t f = 0; f < n_faces; ++f) {
      const std::size_t sides = control.soup.face_size(f);
      if (!samples_.contains(sides)) {
        samples_[sides] = make_grid_samples(scheme, sides, level, sample_level);
        cells_[sides] = make_face_grid(scheme, sides, level).n_cells();
      }
      first_cells_.push_back(first_cells_.back() + cells_[sides]);
    }
    side_errors_.resize(control.soup.n_corners() * steps_);
    face_errors_.resize(n_faces);
  }

  double run(Progress* progress) {
    const std::size_t n_faces = face_errors_.size();
    tbb::enumerable_thread_specific<FaceLimit> limits([&] { return FaceLimit(surface_); });
    for (std::size_t block = 0; block < k_blocks; ++block) {
      report_progress(progress, "measuring facets", static_cast<double>(block) / k_blocks);
      const tbb::blocked_range<std::size_t> faces(n_faces * block / k_blocks,
                                                  n_faces * (block + 1) / k_blocks, k_faces_of_a_task);
      tbb::parallel_for(faces, [&](const auto& range) {
        FaceLimit& limit = limits.local();
        for (std::size_t f = range.begin(); f != range.end(); ++f) measure_face(f, limit);
      });
    }
    double largest = 0;
    for (const double squared : face_errors_) largest = std::max(largest, squared);
    return std::sqrt(std::max(largest, largest_on_sides()));
  }

 private:
  double squared_distance(const Vec3& point, std::size_t cell) const {
    const std::size_t first = facets_.face_offsets[cell] - 2 * cell;
    const std::size_t end = facets_.face_offsets[cell + 1] - 2 * (cell + 1);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t t = first; t < end; ++t) {
      const Triangle triangle{facets_.positions[triangles_[3 * t]], facets_.positions[triangles_[3 * t + 1]],
                              facets_.positions[triangles_[3 * t + 2]]};
      nearest = std::min(nearest, (point - closest_point_on_triangle(point, triangle)).squaredNorm());
    }
    return nearest;
  }

  void measure_face(std::size_t face, FaceLimit& limit) {
    limit.set_face(face, false);
    double largest = 0;
    for (const GridSample& sample : samples_.at(control_.soup.face_size(face))) {
      const Vec3 point = limit.position(sample.point.at);
      double nearest = squared_distance(point, first_cells_[face] + sample.cells[0]);
      if (sample.cells[1] != k_no_index)
        nearest = std::min(nearest, squared_distance(point, first_cells_[face] + sample.cells[1]));
      if (sample.point.place == GridPlace::side) {
        const std::size_t corner = control_.soup.face_offsets[face] + sample.point.element;
        side_errors_[corner * steps_ + sample.point.step - 1] = nearest;
      } else {
        largest = std::max(largest, nearest);
      }
    }
    face_errors_[face] = largest;
  }

  /// The nearer of both faces' facets counts: between facets the surface may bend sideways.
  double largest_on_sides() const {
    double largest = 0;
    for (std::size_t e = 0; e < control_.edges.n_edges(); ++e) {
      const auto sides = control_.edges.sides(e);
      for (std::size_t step = 0; step < steps_; ++step) {
        double nearest = side_errors_[sides[0] * steps_ + step];
        // The other face runs along the edge the other way.
        if (sides.size() == 2)
          nearest = std::min(nearest, side_errors_[sides[1] * steps_ + steps_ - 1 - step]);
        largest = std::max(largest, nearest);
      }
    }
    return largest;
  }

  const ControlMesh& control_;
  const LimitSurface& surface_;
  const PolygonSoup& facets_;
  std::vector<Index> triangles_;
  std::map<std::size_t, std::vector<GridSample>> samples_;  // by sides of a face
  std::map<std::size_t, std::size_t> cells_;
  std::vector<std::size_t> first_cells_;  // of each face
  std::size_t steps_ = 0;                 // samples inside of a side
  std::vector<double> side_errors_;       // squared, by corner and step
  std::vector<double> face_errors_;       // squared
};

}  // namespace

int limit_sample_level(SubdivisionScheme scheme, int level) {
  // Facets of coarse levels have more than one bend, and triangles are farthest off in their middle, which
  // the next level doesn't have.
  if (level == 0) return 3;
  constexpr int k_fine_enough = 4;
  return level < k_fine_enough || scheme == SubdivisionScheme::loop ? level + 2 : level + 1;
}

double estimate_limit_error(const ControlMesh& control, const LimitSurface& surface, SubdivisionScheme scheme,
                            int level, const PolygonSoup& facets, Progress* progress) {
  return ErrorSearch(control, surface, scheme, level, facets).run(progress);
}

}  // namespace recede::detail
