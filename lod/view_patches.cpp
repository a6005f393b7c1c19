#include <recede/geometry/error.h>
#include <recede/lod/detail/grid_sweep.h>
#include <recede/lod/detail/view_patches.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>

namespace recede::detail {
namespace {

constexpr std::size_t k_next[] = {1, 2, 0};

/// Middles of edges, by their two ends.
class Middles {
 public:
  Middles(ViewPatches& patches, const GridSpace& space) : patches_(patches), space_(space) {}

  Index of(Index a, Index b) {
    const auto [low, high] = std::minmax(a, b);
    const auto key = static_cast<std::uint64_t>(low) << 32 | high;
    const auto [entry, is_new] = numbers_.try_emplace(key, static_cast<Index>(patches_.positions.size()));
    if (is_new) {
      const Vec3 position = 0.5 * (patches_.positions[low] + patches_.positions[high]);
      const Vec3 direction = 0.5 * (patches_.directions[low] + patches_.directions[high]);
      patches_.positions.push_back(position);
      patches_.directions.push_back(direction);
      patches_.views.push_back(space_.view(position));
    }
    return entry->second;
  }

 private:
  ViewPatches& patches_;
  const GridSpace& space_;
  std::unordered_map<std::uint64_t, Index> numbers_;
};

/// The pieces of a patch when some of its edges are halved.
class Cutter {
 public:
  Cutter(const ViewPatch& patch, const std::array<bool, 3>& cut, Middles& middles) : patch_(patch) {
    for (std::size_t k = 0; k < 3; ++k) {
      corners_[k] = {patch.points[k], patch.uvs[k]};
      if (!cut[k]) continue;
      const std::size_t next = k_next[k];
      const Vec2 uv = 0.5 * (patch.uvs[k] + patch.uvs[next]);
      corners_[3 + k] = {middles.of(patch.points[k], patch.points[next]), uv};
    }
  }

  void cut(const std::array<bool, 3>& cut, std::vector<ViewPatch>& pieces) const {
    const auto n = std::count(cut.begin(), cut.end(), true);
    const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
      ViewPatch piece = patch_;
      piece.points = {corners_[a].point, corners_[b].point, corners_[c].point};
      piece.uvs = {corners_[a].uv, corners_[b].uv, corners_[c].uv};
      pieces.push_back(piece);
    };
    if (n == 3) {
      for (std::size_t k = 0; k < 3; ++k) add(k, 3 + k, 3 + (k + 2) % 3);
      return add(3, 4, 5);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = k_next[k], q = k_next[p];
      if (n == 1 && cut[k]) {
        add(k, 3 + k, q);
        return add(3 + k, p, q);
      }
      if (n == 2 && !cut[k]) {  // the edges p q and q k are cut
        add(q, 3 + q, 3 + p);
        add(k, p, 3 + p);
        return add(k, 3 + p, 3 + q);
      }
    }
  }

 private:
  struct Corner {
    Index point = 0;
    Vec2 uv;
  };
  const ViewPatch& patch_;
  std::array<Corner, 6> corners_;
};

/// A side of a patch, to be found by its two ends.
struct Side {
  Index low, high;
  ViewPatches::Use use;
  bool operator<(const Side& other) const {
    return std::tie(low, high, use.patch, use.k) <
           std::tie(other.low, other.high, other.use.patch, other.use.k);
  }
};

bool comes_first(const Vec3& a, const Vec3& b) {
  return std::tie(a.x(), a.y(), a.z()) < std::tie(b.x(), b.y(), b.z());
}

}  // namespace

ViewPatches::ViewPatches(const DisplacedBase& base, const GridSpace& space, const RemeshOptions& options)
    : positions(base.positions()), directions(base.directions()), views(base.positions().size()) {
  tbb::parallel_for(std::size_t{0}, positions.size(),
                    [&](std::size_t p) { views[p] = space.view(positions[p]); });
  patches.reserve(base.triangles().size());
  for (const DisplacedBase::Triangle& triangle : base.triangles())
    patches.push_back({.points = triangle.points,
                       .uvs = triangle.uvs,
                       .reach = triangle.reach,
                       .material = triangle.material});
  halve_uneven_edges(space, options);
  connect();
  collect_point_uses();
}

/// Again and again, since halves may be uneven too. Whether an edge is cut follows from its ends.
void ViewPatches::halve_uneven_edges(const GridSpace& space, const RemeshOptions& options) {
  constexpr int k_most_rounds = 64;  // more than the bits of a length
  Middles middles(*this, space);
  std::vector<ViewPatch> even, pieces;
  even.reserve(patches.size());
  double triangles_of_even = 0;
  for (int round = 0; round < k_most_rounds && !patches.empty(); ++round) {
    pieces.clear();
    for (ViewPatch& patch : patches) {
      const auto& p = patch.points;
      patch.culled = options.cull && GridSpace::is_unseen(patch.reach, views[p[0]], views[p[1]], views[p[2]]);
      std::array<bool, 3> cut{};
      for (std::size_t k = 0; k < 3; ++k) {
        const ViewPoint &a = views[patch.points[k]], &b = views[patch.points[k_next[k]]];
        cut[k] = space.is_uneven(a, b, options.largest_depth_ratio);
      }
      if (cut == std::array<bool, 3>{}) {
        even.push_back(patch);
        triangles_of_even += about_triangles(patch);
      } else {
        Cutter(patch, cut, middles).cut(cut, pieces);
      }
    }
    patches.swap(pieces);
    // Before memory runs out.
    double triangles = triangles_of_even;
    for (const ViewPatch& patch : patches) triangles += about_triangles(patch);
    constexpr double k_sure = 2;  // beyond doubt
    if (triangles > k_sure * static_cast<double>(options.most_triangles))
      throw OptionError(fmt::format("the view needs more than {} triangles", options.most_triangles));
  }
  even.insert(even.end(), patches.begin(), patches.end());
  patches.swap(even);
}

/// Twice its area among the voxels, and itself.
double ViewPatches::about_triangles(const ViewPatch& patch) const {
  if (patch.culled) return 1;
  const auto& p = patch.points;
  const std::array<GridPoint, 3> corners{views[p[0]].voxel, views[p[1]].voxel, views[p[2]].voxel};
  const SweepPlan plan = plan_sweep(corners);
  return 1 + std::abs(static_cast<double>(twice_area(corners, plan.sweep, plan.side)));
}

void ViewPatches::connect() {
  std::vector<Side> sides(3 * patches.size());
  tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(patches[t].points[k], patches[t].points[k_next[k]]);
      sides[3 * t + k] = {low, high, {static_cast<Index>(t), static_cast<std::uint32_t>(k)}};
    }
  });
  tbb::parallel_sort(sides.begin(), sides.end());
  edge_uses_.reserve(sides.size());
  for (std::size_t i = 0; i < sides.size();) {
    ViewEdge edge{.from = sides[i].low, .to = sides[i].high, .first_use = static_cast<std::uint32_t>(i)};
    const std::int32_t length = main_direction(views[edge.from].voxel, views[edge.to].voxel).length;
    edge.pieces = static_cast<std::uint32_t>(std::max(length, 1));
    if (!comes_first(positions[edge.from], positions[edge.to])) std::swap(edge.from, edge.to);
    for (const Side& first = sides[i];
         i < sides.size() && sides[i].low == first.low && sides[i].high == first.high; ++i) {
      const Use use = sides[i].use;
      edge_uses_.push_back(use);
      ++edge.n_uses;
      patches[use.patch].edges[use.k] = static_cast<Index>(edges.size());
      edge.kept = edge.kept || !patches[use.patch].culled;
    }
    edges.push_back(edge);
  }
}

void ViewPatches::collect_point_uses() {
  point_offsets_.assign(positions.size() + 1, 0);
  for (const ViewPatch& patch : patches) {
    for (const Index p : patch.points) ++point_offsets_[p + 1];
  }
  for (std::size_t p = 0; p < positions.size(); ++p) point_offsets_[p + 1] += point_offsets_[p];
  point_uses_.resize(3 * patches.size());
  std::vector<std::size_t> next(point_offsets_.begin(), point_offsets_.end() - 1);
  for (std::size_t t = 0; t < patches.size(); ++t) {
    for (std::uint32_t k = 0; k < 3; ++k)
      point_uses_[next[patches[t].points[k]]++] = {static_cast<Index>(t), k};
  }
}

}  // namespace recede::detail
