// A displaced base as a view has it: triangles cut until voxels fit them, and the edges between them.
#pragma once

#include <recede/lod/detail/grid_space.h>

#include <span>
#include <vector>

namespace recede::detail {

struct ViewPatch {
  std::array<Index, 3> points;
  std::array<Vec2, 3> uvs;
  std::array<Index, 3> edges{};  ///< from corner k to the next
  double reach = 0;              ///< see `DisplacedBase::Triangle`
  Index material = k_no_index;
  bool culled = false;
};

/// An edge of the patches, in the direction from the smaller of its two positions, x first: neighbours that
/// know nothing of each other agree.
struct ViewEdge {
  Index from = 0, to = 0;
  std::uint32_t first_use = 0, n_uses = 0;
  std::uint32_t pieces = 1;
  bool kept = false;             ///< by a patch that isn't culled
  std::size_t first_vertex = 0;  ///< in the mesh
};

class ViewPatches {
 public:
  ViewPatches(const DisplacedBase& base, const GridSpace& space, const RemeshOptions& options);

  // Of points: those of the base first, then middles of edges. Directions are combinations of the base's, so
  // that they vary linearly over its triangles; not unit.
  std::vector<Vec3> positions, directions;
  std::vector<ViewPoint> views;

  std::vector<ViewPatch> patches;
  std::vector<ViewEdge> edges;

  /// Side k of a patch, for edges; corner k of a patch, for points.
  struct Use {
    Index patch;
    std::uint32_t k;
  };
  std::span<const Use> uses_of_edge(std::size_t edge) const {
    return {edge_uses_.data() + edges[edge].first_use, edges[edge].n_uses};
  }
  std::span<const Use> uses_of_point(std::size_t point) const {
    return {point_uses_.data() + point_offsets_[point], point_offsets_[point + 1] - point_offsets_[point]};
  }

 private:
  void halve_uneven_edges(const GridSpace& space, const RemeshOptions& options);
  double about_triangles(const ViewPatch& patch) const;
  void connect();
  void collect_point_uses();

  std::vector<Use> edge_uses_, point_uses_;
  std::vector<std::size_t> point_offsets_;
};

}  // namespace recede::detail
