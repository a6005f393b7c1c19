#include <recede/lod/detail/error_proof.h>
#include <recede/lod/detail/patch_distance.h>
#include <recede/lod/detail/progressive_error.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
/// Distances below this share of the error of the measured level before aren't looked at closely.
constexpr double k_fine_enough = 0.02;
/// Splits whose patches are kept at once.
constexpr std::size_t k_block = 4096;

/// The polygons that a split touches, one list for each side of it.
struct PatchPolygons {
  std::vector<Vec3> points;
  std::vector<Index> sizes;            ///< of the polygons
  std::vector<Index> starts{0};        ///< by patch, in `sizes`
  std::vector<Index> point_starts{0};  ///< by patch, in `points`
  void clear() {
    points.clear();
    sizes.clear();
    starts.assign(1, 0);
    point_starts.assign(1, 0);
  }
  void close_patch() {
    starts.push_back(static_cast<Index>(sizes.size()));
    point_starts.push_back(static_cast<Index>(points.size()));
  }
};

class ErrorProver {
 public:
  ErrorProver(ProgressiveMesh& mesh, const PolygonSoup& input, const SplitRows<Index>& touched)
      : mesh_(mesh), touched_(touched), proof_(input), steps_(mesh.splits.size(), k_infinity) {}

  void run(std::size_t measured_levels, Progress* progress);

 private:
  struct Measured {
    std::size_t level;
    double error;
  };

  std::vector<std::size_t> choose_levels(std::size_t measured_levels) const;
  void measure_steps(ProgressiveCursor& cursor, std::size_t level, double floor);
  void take_patch(const ProgressiveCursor& cursor, std::size_t split, PatchPolygons& patches) const;
  static void read_patch(const PatchPolygons& patches, std::size_t patch, std::vector<Triangle>& triangles);
  void add_from_input();
  void add_between(const Measured& fine, const Measured& coarse);
  template <typename Rise>
  double advance(std::size_t split, std::vector<double>& sums, Rise&& rise) const;

  ProgressiveMesh& mesh_;
  const SplitRows<Index>& touched_;
  ErrorProof proof_;
  std::vector<double> steps_;   // by split: the distance between its two sides
  std::vector<double> errors_;  // by level
  PatchPolygons before_, after_;
};

/// Levels between which the number of faces grows by about the same factor, and those beside dropped parts.
std::vector<std::size_t> ErrorProver::choose_levels(std::size_t measured_levels) const {
  const std::size_t n = mesh_.splits.size();
  std::vector<std::size_t> levels{0};
  const double coarse = std::max(1.0, static_cast<double>(mesh_.level_faces.front()));
  const double ratio = std::max(1.0, static_cast<double>(mesh_.level_faces[n]) / coarse);
  for (std::size_t i = 1; i < measured_levels; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(measured_levels);
    levels.push_back(mesh_.level_for_faces(static_cast<std::size_t>(coarse * std::pow(ratio, share))));
  }
  if (!mesh_.mending.empty()) levels.push_back(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (mesh_.splits[i].kept == k_no_index) levels.insert(levels.end(), {i, i + 1});
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  std::erase_if(levels, [&](std::size_t level) { return level >= mesh_.n_splits(); });
  return levels;
}

void ErrorProver::take_patch(const ProgressiveCursor& cursor, std::size_t split,
                             PatchPolygons& patches) const {
  for (const Index face : touched_[split]) {
    if (!cursor.is_face_alive(face)) continue;
    Index size = 0;
    for (Index c = mesh_.face_offsets[face]; c < mesh_.face_offsets[face + 1]; ++c) {
      if (!cursor.is_corner_alive(c)) continue;
      patches.points.push_back(cursor.positions()[cursor.corner_vertices()[c]]);
      ++size;
    }
    patches.sizes.push_back(size);
  }
  patches.close_patch();
}

/// The triangles of the polygons, as `triangulate` cuts them.
void ErrorProver::read_patch(const PatchPolygons& patches, std::size_t patch,
                             std::vector<Triangle>& triangles) {
  triangles.clear();
  std::size_t at = patches.point_starts[patch];
  for (std::size_t i = patches.starts[patch]; i < patches.starts[patch + 1]; ++i) {
    const std::size_t size = patches.sizes[i];
    const Vec3* const points = patches.points.data() + at;
    at += size;
    if (size == 3) {
      triangles.push_back({points[0], points[1], points[2]});
      continue;
    }
    PolygonSoup polygon;
    polygon.positions.assign(points, points + size);
    for (Index v = 0; v < size; ++v) polygon.corner_vertices.push_back(v);
    polygon.face_offsets.push_back(static_cast<Index>(size));
    const std::vector<Index> corners = triangulate(polygon);
    for (std::size_t t = 0; t < corners.size(); t += 3) {
      triangles.push_back({points[corners[t]], points[corners[t + 1]], points[corners[t + 2]]});
    }
  }
}

/// Takes splits back down to `level` and bounds what each of them moved.
void ErrorProver::measure_steps(ProgressiveCursor& cursor, std::size_t level, double floor) {
  while (cursor.level() > level) {
    const std::size_t last = cursor.level(), first = last - std::min(k_block, last - level);
    before_.clear();
    after_.clear();
    for (std::size_t split = last; split-- > first;) {
      take_patch(cursor, split, before_);
      cursor.move_to(split);
      take_patch(cursor, split, after_);
    }
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, last - first, 64), [&](const auto& range) {
      PatchDistance distance;
      std::vector<Triangle> fine, coarse;
      for (std::size_t i = range.begin(); i < range.end(); ++i) {
        const std::size_t split = last - 1 - i;
        if (mesh_.splits[split].kept == k_no_index) continue;
        read_patch(before_, i, fine);
        read_patch(after_, i, coarse);
        steps_[split] = distance.bound(fine, coarse, floor);
      }
    });
  }
}

/// Carries the sums at the faces that a split touches over it: all get the largest, and what the split adds.
template <typename Rise>
double ErrorProver::advance(std::size_t split, std::vector<double>& sums, Rise&& rise) const {
  double most = 0;
  for (const Index face : touched_[split]) most = std::max(most, sums[face]);
  most = rise(most);
  for (const Index face : touched_[split]) sums[face] = most;
  return most;
}

void ErrorProver::add_from_input() {
  std::vector<double> sums(mesh_.n_faces(), 0);
  double most = mesh_.mending.empty() ? 0 : errors_[mesh_.splits.size()];
  const double start = most;
  for (std::size_t split = mesh_.splits.size(); split-- > 0;) {
    most = std::max(most, start + advance(split, sums, [&](double sum) { return sum + steps_[split]; }));
    errors_[split] = std::min(errors_[split], most);
  }
}

/// Levels between two measured ones, by the sums from either.
void ErrorProver::add_between(const Measured& fine, const Measured& coarse) {
  std::vector<double> sums(mesh_.n_faces(), 0);
  double most = 0;
  for (std::size_t split = fine.level; split-- > coarse.level + 1;) {
    most = std::max(most, advance(split, sums, [&](double sum) { return sum + steps_[split]; }));
    errors_[split] = std::min(errors_[split], fine.error + most);
  }
  std::fill(sums.begin(), sums.end(), 0);
  most = 0;
  for (std::size_t split = coarse.level; split + 1 < fine.level; ++split) {
    most = std::max(most, advance(split, sums, [&](double sum) { return sum + steps_[split]; }));
    errors_[split + 1] = std::min(errors_[split + 1], coarse.error + most);
  }
}

void ErrorProver::run(std::size_t measured_levels, Progress* progress) {
  const std::size_t n_levels = mesh_.n_levels();
  errors_.assign(n_levels, k_infinity);
  errors_.back() = 0;
  const std::vector<std::size_t> levels = choose_levels(measured_levels);
  ProgressiveCursor cursor(mesh_);
  cursor.move_to(mesh_.n_splits());
  std::vector<Measured> measured{{mesh_.n_splits(), 0}};
  for (std::size_t i = levels.size(); i-- > 0;) {
    report_progress(progress, "prove", 1 - static_cast<double>(i + 1) / static_cast<double>(levels.size()));
    if (cursor.level() > mesh_.splits.size()) cursor.move_to(mesh_.splits.size());
    measure_steps(cursor, levels[i], k_fine_enough * measured.back().error);
    const auto error = proof_.prove(cursor.soup(), nullptr);
    const double upper = error ? error->upper : k_infinity;
    errors_[levels[i]] = upper;
    measured.push_back({levels[i], upper});
    mesh_.report.error_lower = error ? error->lower : 0;
  }
  for (std::size_t i = 0; i + 1 < measured.size(); ++i) add_between(measured[i], measured[i + 1]);
  add_from_input();
  for (std::size_t level = n_levels - 1; level-- > 0;)
    errors_[level] = std::max(errors_[level], errors_[level + 1]);
  mesh_.report.error_bound = errors_.front();
  mesh_.level_errors = std::move(errors_);
  mesh_.errors_are_proved = true;
}

}  // namespace

void prove_level_errors(ProgressiveMesh& mesh, const PolygonSoup& input, const SplitRows<Index>& touched,
                        std::size_t measured_levels, Progress* progress) {
  if (input.n_faces() == 0 || mesh.n_splits() == 0) {
    mesh.errors_are_proved = true;
    return;
  }
  ErrorProver(mesh, input, touched).run(measured_levels, progress);
}

}  // namespace recede::detail
