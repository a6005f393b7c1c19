#include <recede/geometry/detail/bound_search.h>
#include <recede/lod/detail/error_proof.h>
#include <recede/lod/detail/linked_level.h>
#include <recede/lod/detail/progressive_error.h>
#include <recede/lod/detail/triangle_cover.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace recede::detail {
namespace {

/// Splits whose new faces are measured together: few at first, as what is no farther than the error so far
/// takes hardly any time.
constexpr std::size_t k_first_block = 256, k_largest_block = 8192;

class ErrorProver {
 public:
  ErrorProver(ProgressiveMesh& mesh, const SplitRows<Index>& touched);

  /// The largest distance that a proof found for each level, from `mesh.splits.size()` splits down.
  std::vector<double> run(Progress* progress);

 private:
  Triangle scaled(const Triangle& t) const { return {scaled(t.a), scaled(t.b), scaled(t.c)}; }
  Vec3 scaled(const Vec3& p) const {
    const Vec3 d = p - center_;
    return {std::ldexp(d.x(), exponent_), std::ldexp(d.y(), exponent_), std::ldexp(d.z(), exponent_)};
  }
  void start();
  void take_back(std::size_t split);
  void add_triangles(Index face, std::vector<FaceTriangle>& triangles) const;
  void collect_stale(std::size_t split);
  void cover_again(std::size_t split);
  void cover_dropped();
  void add_beside(std::vector<FaceTriangle>& targets);
  void set_uses(Index triangle, double bound);
  double measure_block(const std::vector<FaceTriangle>& made, std::vector<double>& of_split,
                       const std::vector<std::size_t>& splits, double largest) const;

  ProgressiveMesh& mesh_;
  const SplitRows<Index>& touched_;
  LinkedLevel level_;
  Vec3 center_ = Vec3::Zero();
  int exponent_ = 0;
  double floor_ = 0;
  std::optional<Surface> fine_;            // the finest level of splits
  std::vector<Triangle> triangles_;        // of the finest level
  std::vector<std::vector<Index>> uses_;   // by triangle: the faces that its bound needs
  std::vector<std::vector<Index>> users_;  // by face: triangles that need it, and some that did
  std::vector<unsigned char> is_touched_;  // by face: by the split at hand
  TriangleCover cover_;
  double largest_ = 0;        // bound so far
  std::vector<Index> stale_;  // triangles whose faces change
  std::vector<FaceTriangle> patch_, targets_;
  std::vector<Index> beside_;
};

ErrorProver::ErrorProver(ProgressiveMesh& mesh, const SplitRows<Index>& touched)
    : mesh_(mesh), touched_(touched), level_(mesh, level_of_all_splits(mesh)) {
  Box3 box;
  for (const Vec3& p : mesh.positions) box.extend(p);
  if (box.isEmpty()) return;
  center_ = 0.5 * box.min() + 0.5 * box.max();
  const double largest = (0.5 * box.max() - 0.5 * box.min()).maxCoeff();
  if (largest > 0) exponent_ = -std::ilogb(largest);
  floor_ = k_proof_rounding * (largest > 0 ? std::ldexp(largest, exponent_) : 1);
}

/// The triangles of a face as `triangulate` cuts it.
void ErrorProver::add_triangles(Index face, std::vector<FaceTriangle>& triangles) const {
  std::array<Vec3, 3> corners;
  Index n = 0;
  level_.each_corner_of(face, [&](Index c) {
    if (n < 3) corners[n] = level_.position(c);
    ++n;
  });
  if (n == 3) {
    triangles.push_back({scaled({corners[0], corners[1], corners[2]}), face});
    return;
  }
  PolygonSoup polygon;
  level_.each_corner_of(face, [&](Index c) { polygon.positions.push_back(level_.position(c)); });
  for (Index v = 0; v < n; ++v) polygon.corner_vertices.push_back(v);
  polygon.face_offsets.push_back(n);
  const std::vector<Index> cut = triangulate(polygon);
  const std::vector<Vec3>& p = polygon.positions;
  for (std::size_t t = 0; t < cut.size(); t += 3) {
    triangles.push_back({scaled({p[cut[t]], p[cut[t + 1]], p[cut[t + 2]]}), face});
  }
}

/// A soup of triangles that share no vertices.
PolygonSoup loose_triangles(std::span<const FaceTriangle> triangles) {
  PolygonSoup soup;
  for (const FaceTriangle& t : triangles) {
    const auto first = static_cast<Index>(soup.positions.size());
    soup.positions.insert(soup.positions.end(), {t.corners.a, t.corners.b, t.corners.c});
    soup.add_face(std::array<Index, 3>{first, first + 1, first + 2});
  }
  return soup;
}

void ErrorProver::start() {
  std::vector<FaceTriangle> all;
  for (Index f = 0; f < mesh_.n_faces(); ++f) {
    if (level_.state().is_face_alive(f)) add_triangles(f, all);
  }
  PolygonSoup soup = triangulated(level_.state().soup(false));
  for (Vec3& p : soup.positions) p = scaled(p);
  fine_.emplace(std::move(soup));
  users_.resize(mesh_.n_faces());
  is_touched_.assign(mesh_.n_faces(), 0);
  for (const FaceTriangle& t : all) {
    users_[t.face].push_back(static_cast<Index>(triangles_.size()));
    uses_.push_back({t.face});
    triangles_.push_back(t.corners);
  }
}

/// The triangles that need a face that the split touches.
void ErrorProver::collect_stale(std::size_t split) {
  stale_.clear();
  for (const Index face : touched_[split]) {
    for (const Index t : users_[face]) {
      if (std::find(uses_[t].begin(), uses_[t].end(), face) != uses_[t].end()) stale_.push_back(t);
    }
    users_[face].clear();
  }
  for (const Index face : touched_[split]) is_touched_[face] = 1;
  std::sort(stale_.begin(), stale_.end());
  stale_.erase(std::unique(stale_.begin(), stale_.end()), stale_.end());
}

void ErrorProver::set_uses(Index triangle, double bound) {
  largest_ = std::max(largest_, bound);
  for (const Index face : cover_.used()) {
    // Lists of faces that stay have it already; those of touched ones are new.
    std::vector<Index>& users = users_[face];
    const auto& before = uses_[triangle];
    if (std::find(before.begin(), before.end(), face) == before.end() || is_touched_[face] != 0) {
      users.push_back(triangle);
    }
  }
  uses_[triangle].assign(cover_.used().begin(), cover_.used().end());
}

/// Adds the faces that share a vertex with those of the targets.
void ErrorProver::add_beside(std::vector<FaceTriangle>& targets) {
  beside_.clear();
  for (const FaceTriangle& t : targets) {
    if (std::find(beside_.begin(), beside_.end(), t.face) == beside_.end()) beside_.push_back(t.face);
  }
  const std::size_t n_known = beside_.size();
  for (std::size_t i = 0; i < n_known; ++i) {
    level_.each_corner_of(beside_[i], [&](Index c) {
      level_.each_corner_at(level_.state().corner_vertices()[c],
                            [&](Index other) { beside_.push_back(level_.face(other)); });
    });
  }
  const auto known = beside_.begin() + static_cast<std::ptrdiff_t>(n_known);
  std::sort(known, beside_.end());
  const auto end = std::unique(known, beside_.end());
  for (auto face = known; face != end; ++face) {
    if (std::find(beside_.begin(), known, *face) == known) add_triangles(*face, targets);
  }
}

/// Bounds for what needed faces that have changed: by the faces that came, and by those that it needs beside
/// them; where that isn't enough, by their neighbours too.
void ErrorProver::cover_again(std::size_t split) {
  patch_.clear();
  for (const Index face : touched_[split]) {
    if (level_.state().is_face_alive(face)) add_triangles(face, patch_);
  }
  for (const Index t : stale_) {
    targets_.assign(patch_.begin(), patch_.end());
    for (const Index face : uses_[t]) {
      if (is_touched_[face] == 0) add_triangles(face, targets_);
    }
    // An ear of a border goes without changing other faces: those around the end that stays are near.
    if (targets_.empty()) {
      level_.each_corner_at(mesh_.splits[split].kept,
                            [&](Index corner) { add_triangles(level_.face(corner), targets_); });
    }
    const double enough = std::max(largest_, floor_);
    if (targets_.empty()) {  // nothing is left; no bound from here on
      largest_ = std::numeric_limits<double>::infinity();
      continue;
    }
    double bound = cover_.bound(triangles_[t], targets_, enough);
    if (bound > enough) {
      add_beside(targets_);
      bound = cover_.bound(triangles_[t], targets_, enough);
    }
    set_uses(t, bound);
  }
}

/// After parts are gone, what stood for them is looked for everywhere.
void ErrorProver::cover_dropped() {
  std::vector<FaceTriangle> all;
  for (Index f = 0; f < mesh_.n_faces(); ++f) {
    if (level_.state().is_face_alive(f)) add_triangles(f, all);
  }
  const Surface level(loose_triangles(all));
  for (const Index t : stale_) {
    const Triangle& triangle = triangles_[t];
    targets_.clear();
    for (const Vec3& p :
         {triangle.a, triangle.b, triangle.c, Vec3((triangle.a + triangle.b + triangle.c) / 3)}) {
      targets_.push_back(all[level.tree.closest(p).triangle]);
    }
    const double enough = std::max(largest_, floor_);
    double bound = cover_.bound(triangle, targets_, enough);
    if (bound > enough) {
      add_beside(targets_);
      bound = cover_.bound(triangle, targets_, enough);
    }
    set_uses(t, bound);
  }
}

void ErrorProver::take_back(std::size_t split) {
  collect_stale(split);
  level_.apply<false>(split);
  if (mesh_.splits[split].kept == k_no_index)
    cover_dropped();
  else
    cover_again(split);
  for (const Index face : touched_[split]) is_touched_[face] = 0;
}

/// How far the faces that a block of splits makes are from the finest level, by split.
double ErrorProver::measure_block(const std::vector<FaceTriangle>& made, std::vector<double>& of_split,
                                  const std::vector<std::size_t>& splits, double largest) const {
  if (made.empty()) return largest;
  const Surface surface(loose_triangles(made));
  std::vector<Index> nearest(surface.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, nearest.size(), 256), [&](const auto& range) {
    Index hint = k_no_index;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      nearest[i] = hint = fine_->tree.closest(surface.positions[i], hint).triangle;
    }
  });
  // So that what is no farther than the bound so far is settled at once.
  const BoundGoal goal{largest * (1 - k_proof_tolerance), k_proof_tolerance, floor_};
  const std::vector<Interval> intervals = certified_intervals(surface, *fine_, nearest, goal);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    of_split[splits[i]] = std::max(of_split[splits[i]], intervals[i].upper);
    largest = std::max(largest, intervals[i].upper);
  }
  return largest;
}

std::vector<double> ErrorProver::run(Progress* progress) {
  start();
  const std::size_t n = mesh_.splits.size();
  std::vector<double> of_split(n, 0), errors(n + 1, 0);
  std::vector<FaceTriangle> made;
  std::vector<std::size_t> splits;  // of the triangles made
  double largest_made = 0, at_block_start = 0;
  // One block's faces are measured while the next block is taken back.
  tbb::task_group measuring;
  std::size_t block = k_first_block, block_end = n - std::min(block, n);
  for (std::size_t split = n; split-- > 0;) {
    take_back(split);
    errors[split] = largest_;
    if (mesh_.splits[split].kept != k_no_index) {
      made.insert(made.end(), patch_.begin(), patch_.end());
      splits.resize(made.size(), split);
    }
    if (split > block_end) continue;
    report_progress(progress, "prove", 1 - static_cast<double>(split) / static_cast<double>(n));
    measuring.wait();
    const double known = std::max(largest_made, at_block_start);
    measuring.run([this, known, &of_split, &largest_made, faces = std::exchange(made, {}),
                   numbers = std::exchange(splits, {})] {
      largest_made = measure_block(faces, of_split, numbers, known);
    });
    at_block_start = largest_;
    block = std::min(2 * block, k_largest_block);
    block_end = split - std::min(block, split);
  }
  measuring.wait();
  for (std::size_t split = n; split-- > 0;) {
    errors[split] = std::max({errors[split], errors[split + 1], of_split[split]});
  }
  for (double& error : errors) error = std::ldexp(error, -exponent_);
  return errors;
}

}  // namespace

void prove_level_errors(ProgressiveMesh& mesh, const PolygonSoup& input, const SplitRows<Index>& touched,
                        Progress* progress) {
  mesh.errors_are_proved = true;
  if (input.n_faces() == 0 || mesh.n_splits() == 0) return;
  ErrorProof proof(input);
  double mended = 0;
  ProgressiveCursor cursor(mesh);
  if (!mesh.mending.empty()) {
    cursor.move_to(mesh.splits.size());
    const auto error = proof.prove(cursor.soup(), progress);
    mended = error ? error->upper : std::numeric_limits<double>::infinity();
  }
  std::vector<double> errors =
      mesh.splits.empty() ? std::vector<double>{0} : ErrorProver(mesh, touched).run(progress);
  for (double& error : errors) error += mended;
  if (!mesh.mending.empty()) errors.push_back(0);
  cursor.move_to(0);
  if (const auto error = proof.prove(cursor.soup(), progress)) mesh.report.error_lower = error->lower;
  mesh.report.error_bound = errors.front();
  mesh.level_errors = std::move(errors);
}

}  // namespace recede::detail
