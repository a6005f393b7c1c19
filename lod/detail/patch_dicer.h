// The vertices and triangles of a view's patches.
#pragma once

#include <recede/lod/detail/footprint_heights.h>
#include <recede/lod/detail/grid_sweep.h>
#include <recede/lod/detail/view_patches.h>

#include <vector>

namespace recede::detail {

/// Where the parts of a patch lie in the mesh.
struct PatchPlace {
  std::size_t first_vertex = 0, n_inside = 0;  ///< inside
  std::size_t first_triangle = 0, n_triangles = 0;
  std::size_t first_border = 0, n_border = 0;  ///< in the list of border normals
};

/// A mesh in the making: numbers of vertices are known, and all parts can be written at once.
struct DicedMesh {
  std::vector<std::size_t> corner_vertices;  ///< of points; those without kept patches have `k_unused`
  static constexpr auto k_unused = static_cast<std::size_t>(-1);
  std::vector<PatchPlace> places;  ///< of patches; culled ones have none
  std::vector<Vec3> positions;
  std::vector<Vec3> vertex_normals, border_normals;  ///< sums over triangles by area; empty: not wanted
  std::vector<Index> corners;
  std::vector<Vec2> corner_uvs;
};

/// Evaluates vertices. Those on corners and edges come first, from the corner's or edge's data alone.
class PatchDicer {
 public:
  PatchDicer(const ViewPatches& patches, const GridSpace& space, const FootprintHeights& heights,
             const Vec2& map_size, DicedMesh& mesh)
      : patches_(patches), space_(space), heights_(heights), map_size_(map_size), mesh_(mesh) {}

  /// Memory of one thread.
  struct Workspace {
    GridSweep sweep;
    std::vector<Index> vertices;  // of the patch, numbers in the mesh
    std::vector<Vec2> uvs;
    std::vector<Vec3> positions, normals;
    double largest_move = 0;
  };

  void place_corner(std::size_t point, double& largest_move) const;
  void place_edge(std::size_t edge, double& largest_move) const;
  /// Needs the corners and edges around.
  void dice(std::size_t patch, Workspace& work) const;

  /// Voxels of a patch's corners.
  std::array<GridPoint, 3> voxels(const ViewPatch& patch) const {
    const auto& p = patch.points;
    return {patches_.views[p[0]].voxel, patches_.views[p[1]].voxel, patches_.views[p[2]].voxel};
  }

 private:
  struct EdgeWeights;
  Vec3 moved(const Vec3& position, const Vec3& unit, double height, double& largest_move) const;
  double facing(const Vec3& position, const Vec3& unit) const;
  double texels_at(std::size_t point) const;
  double longest_side(const ViewPatch& patch) const;
  void load_border(const ViewPatch& patch, Workspace& work) const;
  void place_inside(const ViewPatch& patch, const PatchPlace& place, Workspace& work) const;
  void write_triangles(const PatchPlace& place, Workspace& work) const;

  const ViewPatches& patches_;
  const GridSpace& space_;
  const FootprintHeights& heights_;
  Vec2 map_size_;
  DicedMesh& mesh_;
};

}  // namespace recede::detail
