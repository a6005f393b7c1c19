// Numbers for the points into which all faces of a control mesh are divided.
#pragma once

#include <recede/geometry/detail/control_mesh.h>
#include <recede/geometry/detail/face_grid.h>

#include <map>

namespace recede::detail {

/// By the number of a face's sides.
using FaceGrids = std::map<std::size_t, FaceGrid>;
FaceGrids make_face_grids(const ControlMesh& control, SubdivisionScheme scheme, int level);

/// Numbers for the points of all faces' grids. Those that faces share belong to the lowest corner that
/// touches them, and are evaluated in its face only: the same bits on all sides.
struct GridNumbers {
  std::vector<Index> corner_points, corner_lines;  // C: what a corner and its side stand on
  std::vector<bool> is_against;                    // C: the side runs against its line
  std::vector<Index> point_owners, line_owners;    // corners
  std::vector<std::size_t> first_inside;           // F + 1
  std::size_t steps = 0;                           // points inside of a line

  std::size_t first_on_lines() const { return point_owners.size(); }
  std::size_t count() const { return first_inside.back(); }
  std::size_t of(std::size_t face, Index first_corner, const GridPoint& point) const {
    if (point.place == GridPlace::inside) return first_inside[face] + point.step;
    const std::size_t corner = first_corner + point.element;
    if (point.place == GridPlace::corner) return corner_points[corner];
    const std::size_t step = is_against[corner] ? steps - point.step : point.step - 1;
    return first_on_lines() + corner_lines[corner] * steps + step;
  }
  bool is_owner(Index first_corner, const GridPoint& point) const {
    if (point.place == GridPlace::inside) return true;
    const Index corner = first_corner + point.element;
    return point.place == GridPlace::corner ? point_owners[corner_points[corner]] == corner
                                            : line_owners[corner_lines[corner]] == corner;
  }
};

/// Of positions: vertices, then points on edges, then those inside of faces.
GridNumbers number_positions(const ControlMesh& control, const FaceGrids& grids, int level);
/// Of texture coordinates, of which a seam has a line for each of its sides. The control mesh has some.
GridNumbers number_uvs(const ControlMesh& control, const FaceGrids& grids, int level);

}  // namespace recede::detail
