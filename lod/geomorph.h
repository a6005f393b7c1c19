// Two levels of a progressive mesh that blend into each other without a jump.
//
// H. Hoppe: Progressive Meshes. SIGGRAPH 1996, section 3.
#pragma once

#include <recede/geometry/mesh_io.h>
#include <recede/lod/progressive_mesh.h>

namespace recede {

/// A fine level, and the same polygons in the shape of a coarse one: those that the coarse level doesn't have
/// are shrunk to edges and points.
struct Geomorph {
  /// The levels, as `ProgressiveCursor` counts and gives them.
  std::size_t coarse_level = 0, fine_level = 0;
  PolygonSoup fine;
  /// Differs from `fine` in positions and attributes only. Corners of polygons without area have the
  /// attributes of the fine level. Parts that only the fine level has are shrunk to their middles.
  PolygonSoup coarse;
  /// By vertex of `fine`: the vertex of the coarse level that it becomes, in that level's own numbers;
  /// k_no_index in parts that the coarse level doesn't have, and for vertices without faces.
  std::vector<Index> parents;

  /// The blend of both: exactly `coarse` at 0, `fine` at 1, and a straight line between for positions,
  /// texture coordinates, colours and scalars; normals are made unit length. Throws `OptionError` outside 0
  /// to 1.
  PolygonSoup at(double share) const;
};

/// Throws `OptionError` when there are no such levels or `coarse_level` is the finer one.
Geomorph make_geomorph(const ProgressiveMesh& mesh, std::size_t coarse_level, std::size_t fine_level);

/// Writes a geomorph. `.glb` and `.gltf`: the fine level with the coarse one as a morph target, and the
/// parents as the attribute `_PARENT` (-1: none). `.ply`: the fine level with the scalars `parent` (missing:
/// none), `coarse_x`, `coarse_y` and `coarse_z` at its vertices. Throws `InputError` for other files.
WriteResult write_geomorph(const std::filesystem::path& path, const Geomorph& morph);

}  // namespace recede
