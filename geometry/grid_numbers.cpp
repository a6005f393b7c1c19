#include <recede/geometry/detail/grid_numbers.h>

#include <algorithm>

namespace recede::detail {
namespace {

void claim(std::vector<Index>& owners, Index owned, Index corner) {
  if (owned >= owners.size()) owners.resize(owned + 1, k_no_index);
  owners[owned] = std::min(owners[owned], corner);
}

// Of numbers whose corners have points and lines.
void finish(GridNumbers& numbers, const ControlMesh& control, const FaceGrids& grids, int level) {
  for (Index c = 0; c < control.soup.n_corners(); ++c) {
    numbers.is_against.push_back(control.from(c) > control.to(c));
    claim(numbers.point_owners, numbers.corner_points[c], c);
    claim(numbers.line_owners, numbers.corner_lines[c], c);
  }
  numbers.steps = side_steps(level);
  numbers.first_inside.push_back(numbers.point_owners.size() + numbers.line_owners.size() * numbers.steps);
  for (std::size_t f = 0; f < control.soup.n_faces(); ++f)
    numbers.first_inside.push_back(numbers.first_inside.back() +
                                   grids.at(control.soup.face_size(f)).n_inside);
}

}  // namespace

FaceGrids make_face_grids(const ControlMesh& control, SubdivisionScheme scheme, int level) {
  FaceGrids grids;
  for (std::size_t f = 0; f < control.soup.n_faces(); ++f) {
    const std::size_t sides = control.soup.face_size(f);
    if (!grids.contains(sides)) grids[sides] = make_face_grid(scheme, sides, level);
  }
  return grids;
}

GridNumbers number_positions(const ControlMesh& control, const FaceGrids& grids, int level) {
  GridNumbers numbers;
  numbers.corner_points = control.soup.corner_vertices;
  numbers.corner_lines = control.edges.edge_of_corner;
  finish(numbers, control, grids, level);
  return numbers;
}

GridNumbers number_uvs(const ControlMesh& control, const FaceGrids& grids, int level) {
  const std::vector<Index>& points = control.corner_uv_numbers;
  GridNumbers numbers;
  numbers.corner_points = points;
  numbers.corner_lines.resize(points.size());
  Index n_lines = 0;
  for (std::size_t e = 0; e < control.edges.n_edges(); ++e) {
    const auto sides = control.edges.sides(e);
    numbers.corner_lines[sides[0]] = n_lines++;
    if (sides.size() < 2) continue;
    const bool is_seam = points[sides[0]] != points[control.after(sides[1])] ||
                         points[control.after(sides[0])] != points[sides[1]];
    numbers.corner_lines[sides[1]] = is_seam ? n_lines++ : n_lines - 1;
  }
  finish(numbers, control, grids, level);
  return numbers;
}

}  // namespace recede::detail
