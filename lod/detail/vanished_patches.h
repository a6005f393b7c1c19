// How far patches that have vanished are from the seams that stand for them.
#pragma once

#include <recede/lod/seam_graph.h>

#include <array>
#include <optional>
#include <span>
#include <vector>

namespace recede::detail {

using Segment = std::array<Vec3, 2>;

class VanishedPatches {
 public:
  VanishedPatches(const SeamGraph& graph, std::span<const PatchSurface> surfaces)
      : graph_(graph), surfaces_(surfaces), distances_(graph.n_patches(), 0.0), samples_(graph.n_patches()) {}

  /// Of any point of a patch from the nearest of some segments, at most.
  double distance(Index patch, std::span<const Segment> segments);

  /// What is remembered of a patch.
  double at(Index patch) const { return distances_[patch]; }
  void set(Index patch, double distance) { distances_[patch] = distance; }

 private:
  struct Sample {
    std::vector<Vec3> corners;  // of triangles, three each
    double tolerance = 0;       // of these
  };
  void sample(Index patch);

  const SeamGraph& graph_;
  std::span<const PatchSurface> surfaces_;
  std::vector<double> distances_;
  std::vector<std::optional<Sample>> samples_;
};

}  // namespace recede::detail
