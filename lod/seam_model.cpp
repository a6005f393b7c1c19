#include <recede/geometry/error.h>
#include <recede/lod/seam_model.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

namespace recede {

namespace {

// Which patches run along each side, and whether as it does from the lower to the higher vertex.
using SidePatches = std::map<std::pair<Index, Index>, std::vector<std::pair<Index, bool>>>;

SidePatches sides_of(const SeamGraph& graph, const std::vector<unsigned char>& is_reversed) {
  SidePatches sides;
  for (std::size_t patch = 0; patch < graph.n_patches(); ++patch) {
    for (std::size_t l = graph.patch_loops[patch]; l < graph.patch_loops[patch + 1]; ++l) {
      const auto loop = graph.loop(l);
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const Index a = loop[i].vertex, b = loop[(i + 1) % loop.size()].vertex;
        if (a == b) continue;
        const bool runs_up = (a < b) != (is_reversed[patch] != 0);
        sides[{std::min(a, b), std::max(a, b)}].emplace_back(static_cast<Index>(patch), runs_up);
      }
    }
  }
  return sides;
}

// Neighbours of each patch, and whether both run the same way along a side: then one has to turn.
using Neighbours = std::vector<std::vector<std::pair<Index, bool>>>;

Neighbours neighbours_of(const SeamGraph& graph, const std::vector<unsigned char>& is_reversed) {
  Neighbours neighbours(graph.n_patches());
  for (const auto& [side, patches] : sides_of(graph, is_reversed)) {
    if (patches.size() != 2 || patches[0].first == patches[1].first) continue;
    const bool is_same = patches[0].second == patches[1].second;
    neighbours[patches[0].first].emplace_back(patches[1].first, is_same);
    neighbours[patches[1].first].emplace_back(patches[0].first, is_same);
  }
  return neighbours;
}

// Turns patches until neighbours agree, the fewer of each piece of the model.
std::size_t turn_patches(const SeamGraph& graph, std::vector<unsigned char>& is_reversed) {
  const Neighbours neighbours = neighbours_of(graph, is_reversed);
  std::vector<int> turn(graph.n_patches(), -1);
  std::size_t turned = 0;
  for (std::size_t start = 0; start < turn.size(); ++start) {
    if (turn[start] >= 0) continue;
    std::vector<Index> piece{static_cast<Index>(start)};
    turn[start] = 0;
    std::size_t n_turned = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      for (const auto& [other, is_same] : neighbours[piece[i]]) {
        if (turn[other] >= 0) continue;
        turn[other] = turn[piece[i]] ^ (is_same ? 1 : 0);
        n_turned += static_cast<std::size_t>(turn[other]);
        piece.push_back(other);
      }
    }
    const int minority = 2 * n_turned > piece.size() ? 0 : 1;
    for (const Index patch : piece) {
      if (turn[patch] != minority) continue;
      is_reversed[patch] ^= 1;
      ++turned;
    }
  }
  return turned;
}

}  // namespace

SeamModel build_seam_model(const CadPart& part, const SeamModelOptions& options, Progress* progress) {
  SeamModel model;
  model.surfaces = prepare_surfaces(part.patches, k_bounds_share * std::max(options.seams.tolerance, 0.0));
  model.graph = build_seam_graph(part.patches, model.surfaces, options.seams, progress);
  model.hierarchy = build_seam_hierarchy(model.graph, model.surfaces, options.hierarchy, progress);
  for (const TrimmedPatch& patch : part.patches) {
    model.names.push_back(patch.name);
    model.materials.push_back(patch.material);
    model.is_reversed.push_back(patch.is_reversed ? 1 : 0);
  }
  model.turned = turn_patches(model.graph, model.is_reversed);
  Box3 box;
  for (const Vec3& point : model.graph.positions) box.extend(point);
  model.size = model.graph.positions.empty() ? 0.0 : box.diagonal().norm();
  return model;
}

class SeamTessellation::Impl {
 public:
  explicit Impl(const SeamModel& model)
      : model_(model),
        front_(model.graph, model.hierarchy),
        triangles_(model.graph.n_patches()),
        made_for_(model.graph.n_patches(), 0.0),
        last_(model.graph.n_patches()) {
    Box3 box;
    for (const Vec3& point : model.graph.positions) box.extend(point);
    for (const PatchSurface& surface : model.surfaces) box.extend(surface.bounds.box(surface.shape.domain()));
    if (!box.isEmpty()) extent_ = box.diagonal().norm();
  }

  SeamUpdate update(std::span<const double> tolerances) {
    if (tolerances.size() != triangles_.size()) throw OptionError("a tolerance is needed for each patch");
    for (const double tolerance : tolerances) {
      if (!(tolerance > 0)) throw OptionError("tolerances of patches are above 0");
    }
    SeamUpdate result;
    std::vector<double> seams(tolerances.begin(), tolerances.end());  // what seams may reach, by patch
    std::vector<double> inside = seams;                               // and triangles
    for (std::size_t patch = 0; patch < last_.size(); ++patch) {
      if (last_[patch].asked != tolerances[patch]) continue;
      seams[patch] = last_[patch].seams;
      inside[patch] = last_[patch].inside;
    }
    constexpr int k_most_rounds = 24;
    for (int round = 0; round < k_most_rounds; ++round) {
      add(front_.adapt(seams), result.moves);
      const std::vector<Index> anew = patches_to_make(inside);
      result.tessellated += anew.size();
      tbb::parallel_for(std::size_t{0}, anew.size(), [&](std::size_t i) { make(anew[i], inside[anew[i]]); });
      bool is_done = true;
      for (std::size_t patch = 0; patch < seams.size(); ++patch) {
        if (front_.has_vanished(patch) || is_good(patch)) continue;
        if (change_tolerances(patch, tolerances[patch], seams[patch], inside[patch])) is_done = false;
      }
      if (is_done) break;
    }
    for (std::size_t patch = 0; patch < seams.size(); ++patch) {
      last_[patch] = {tolerances[patch], seams[patch], inside[patch]};
      result.tightened += seams[patch] < tolerances[patch] || inside[patch] < tolerances[patch];
      count(patch, tolerances[patch], result);
    }
    for (std::size_t split = 0; split < model_.hierarchy.n_splits(); ++split) {
      if (front_.is_applied(split)) continue;
      // The first that isn't there has the largest error: what vanished is within it.
      result.error_bound = std::max(result.error_bound, static_cast<double>(model_.hierarchy.errors[split]));
      break;
    }
    return result;
  }

  SampledDeviation sampled_deviation() const;
  PolygonSoup soup() const;

  const SeamModel& model_;
  SeamFront front_;
  std::vector<PatchTriangles> triangles_;

 private:
  static void add(const FrontMoves& moves, FrontMoves& sum) {
    sum.splits += moves.splits;
    sum.forced += moves.forced;
    sum.merges += moves.merges;
  }

  // Below it no split is left to be made.
  double least_error() const {
    return model_.hierarchy.errors.empty() ? 0.0 : static_cast<double>(model_.hierarchy.errors.back());
  }

  // Whose loops changed, and whose triangles are too coarse, or much finer than they need to be.
  std::vector<Index> patches_to_make(std::span<const double> tolerances) {
    constexpr double k_much_finer = 0.5;
    std::vector<unsigned char> wanted(tolerances.size(), 0);
    for (const Index patch : front_.take_changed()) wanted[patch] = 1;
    std::vector<Index> result;
    for (std::size_t patch = 0; patch < tolerances.size(); ++patch) {
      const bool fits =
          made_for_[patch] <= tolerances[patch] && made_for_[patch] >= k_much_finer * tolerances[patch];
      if (wanted[patch] || !fits) result.push_back(static_cast<Index>(patch));
    }
    return result;
  }

  void make(Index patch, double tolerance) {
    made_for_[patch] = tolerance;
    triangles_[patch] = {};
    if (front_.has_vanished(patch)) return;
    PatchTessellationOptions options;
    options.tolerance = tolerance;
    try {
      triangles_[patch] = triangulate_patch(front_.loops_of(patch, model_.surfaces[patch]),
                                            model_.graph.positions, model_.surfaces[patch], options);
    } catch (const InputError&) {
      // Loops that cross; finer ones may not. What isn't there is within the model of what is.
      triangles_[patch].error_bound = extent_;
    }
  }

  // For a patch that isn't good: finer seams as long as there are, then somewhat finer triangles where some
  // are turned over. Where the border itself is coarser than what is asked for, triangles turn over that are
  // much finer than it: then the patch gets what its border can have. Whether there is anything left to try.
  bool change_tolerances(std::size_t patch, double asked, double& seams, double& inside) const {
    constexpr double k_finest_inside = 1.0 / 16;
    constexpr double k_coarser = 2.5;            // more than twice, or the triangles that are there would do
    constexpr double k_coarsest = 4;             // of the error of the finest seams
    constexpr double k_finest_seams = 1.0 / 64;  // of it: points nearer together are as good as one
    const bool is_coarser = inside > asked;
    if (!is_coarser && seams >= std::max(least_error(), k_finest_seams * model_.graph.tolerance)) {
      seams /= 2;
    } else if (!is_coarser && triangles_[patch].reached_tolerance && inside > k_finest_inside * asked) {
      inside /= 2;
    } else {
      const double coarser = k_coarser * std::max(inside, asked);
      if (triangles_[patch].inverted == 0 || coarser > k_coarsest * model_.graph.tolerance) return false;
      seams = inside = coarser;
    }
    return true;
  }

  bool is_good(std::size_t patch) const {
    return triangles_[patch].reached_tolerance && triangles_[patch].inverted == 0;
  }

  void count(std::size_t patch, double tolerance, SeamUpdate& result) const {
    if (front_.has_vanished(patch)) return;
    const PatchTriangles& triangles = triangles_[patch];
    ++result.patches;
    result.triangles += triangles.triangles.size();
    result.inverted += triangles.inverted;
    result.error_bound = std::max(result.error_bound, triangles.error_bound);
    if (!(triangles.error_bound <= tolerance)) result.refused.push_back(static_cast<Index>(patch));
  }

  // What a patch was made for. While it tolerates the same it needn't be found again what that takes.
  struct Reached {
    double asked = 0, seams = 0, inside = 0;
  };

  std::vector<double> made_for_;  // by patch: the tolerance of its triangles
  std::vector<Reached> last_;     // by patch
  double extent_ = 0;             // of all that the model could reach
};

SampledDeviation SeamTessellation::Impl::sampled_deviation() const {
  static const std::array<Vec3, 4> k_places{Vec3(0.5, 0.5, 0), Vec3(0, 0.5, 0.5), Vec3(0.5, 0, 0.5),
                                            Vec3::Constant(1.0 / 3)};
  SampledDeviation result;
  double squares = 0;
  for (std::size_t patch = 0; patch < triangles_.size(); ++patch) {
    const PatchTriangles& of_patch = triangles_[patch];
    for (const auto& [a, b, c] : of_patch.triangles) {
      const Vec3 &pa = of_patch.positions[a], &pb = of_patch.positions[b], &pc = of_patch.positions[c];
      const double area = 0.5 * (pb - pa).cross(pc - pa).norm();
      result.area += area;
      for (const Vec3& at : k_places) {
        const Vec2 uv = at[0] * of_patch.uvs[a] + at[1] * of_patch.uvs[b] + at[2] * of_patch.uvs[c];
        const double distance =
            (model_.surfaces[patch].shape.evaluate(uv) - (at[0] * pa + at[1] * pb + at[2] * pc)).norm();
        result.max = std::max(result.max, distance);
        squares += area * distance * distance / k_places.size();
      }
    }
  }
  result.rms = result.area > 0 ? std::sqrt(squares / result.area) : 0;
  return result;
}

PolygonSoup SeamTessellation::Impl::soup() const {
  PolygonSoup soup;
  std::unordered_map<Index, Index> numbers;  // of the graph's vertices
  for (std::size_t patch = 0; patch < triangles_.size(); ++patch) {
    if (triangles_[patch].triangles.empty()) continue;
    const PatchTriangles& of_patch = triangles_[patch];
    std::vector<Index> points;
    for (const SeamLoop& loop : front_.loops_of(patch, model_.surfaces[patch])) {
      for (const SeamSlot& slot : loop) {
        const auto [at, is_new] = numbers.try_emplace(slot.vertex, static_cast<Index>(soup.positions.size()));
        if (is_new) soup.positions.push_back(model_.graph.positions[slot.vertex]);
        points.push_back(at->second);
      }
    }
    for (std::size_t i = points.size(); i < of_patch.positions.size(); ++i) {
      points.push_back(static_cast<Index>(soup.positions.size()));
      soup.positions.push_back(of_patch.positions[i]);
    }
    std::vector<Vec3> normals;
    const double side = model_.is_reversed[patch] ? -1 : 1;
    for (const Vec2& uv : of_patch.uvs) normals.push_back(side * model_.surfaces[patch].shape.normal(uv));
    for (std::array<Index, 3> triangle : of_patch.triangles) {
      if (model_.is_reversed[patch]) std::swap(triangle[1], triangle[2]);
      soup.add_face(std::array<Index, 3>{points[triangle[0]], points[triangle[1]], points[triangle[2]]});
      for (const Index corner : triangle) soup.corner_normals.push_back(normals[corner]);
      soup.face_materials.push_back(model_.materials[patch]);
    }
  }
  return soup;
}

SeamTessellation::SeamTessellation(const SeamModel& model) : impl_(std::make_unique<Impl>(model)) {}
SeamTessellation::SeamTessellation(SeamTessellation&&) noexcept = default;
SeamTessellation& SeamTessellation::operator=(SeamTessellation&&) noexcept = default;
SeamTessellation::~SeamTessellation() = default;

SeamUpdate SeamTessellation::update(std::span<const double> tolerance_of_patch) {
  return impl_->update(tolerance_of_patch);
}

SeamUpdate SeamTessellation::update(double tolerance) {
  return impl_->update(std::vector<double>(impl_->triangles_.size(), tolerance));
}

const SeamModel& SeamTessellation::model() const { return impl_->model_; }
const SeamFront& SeamTessellation::front() const { return impl_->front_; }
const PatchTriangles& SeamTessellation::triangles_of(std::size_t patch) const {
  return impl_->triangles_[patch];
}
SampledDeviation SeamTessellation::sampled_deviation() const { return impl_->sampled_deviation(); }
PolygonSoup SeamTessellation::soup() const { return impl_->soup(); }

}  // namespace recede
