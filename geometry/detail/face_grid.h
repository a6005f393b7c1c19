// The points and facets into which one face of a control mesh is divided.
#pragma once

#include <recede/geometry/subdivision_surface.h>

#include <array>

namespace recede::detail {

/// What of the face a point lies on.
enum class GridPlace : unsigned char { corner, side, inside };

struct GridPoint {
  Vec2 at{0, 0};  ///< coordinates of the face's limit surface, as `FaceLimit` takes them
  GridPlace place = GridPlace::inside;
  Index element = 0;  ///< corner or side of the face; side k runs from corner k to the next one
  Index step = 0;     ///< on a side: from 1 on, counted from its first corner. Inside: a number from 0 on
};

/// Catmull-Clark: every corner of a face has a square of 4^(level - 1) quads between it, the middles of both
/// sides, and the face's centre; at level 0 the face is one facet. Loop: 4^level triangles.
/// The same for all faces with so many sides.
struct FaceGrid {
  std::vector<GridPoint>
      points;  ///< corners, then sides, then inside, where Catmull-Clark has the centre first
  std::vector<Index> cell_points;  ///< places in `points`, counter-clockwise, `cell_sides` for each facet
  std::size_t cell_sides = 0;
  std::size_t n_inside = 0;

  std::size_t n_cells() const { return cell_points.size() / cell_sides; }
};

/// Points inside of a side.
inline std::size_t side_steps(int level) { return (std::size_t{1} << level) - 1; }

FaceGrid make_face_grid(SubdivisionScheme scheme, std::size_t sides, int level);

/// A point of a finer grid that is none of this one, and the facets of this one that it stands for: one, or
/// the two on both sides of an edge. On the sides of the face, the second one is another face's.
struct GridSample {
  GridPoint point;
  std::array<Index, 2> cells{k_no_index, k_no_index};
};
std::vector<GridSample> make_grid_samples(SubdivisionScheme scheme, std::size_t sides, int level,
                                          int sample_level);

/// A point of a grid as a mean of points of a coarser one, which are some of its own.
struct GridMean {
  std::vector<Index> points;    ///< places in the finer grid's points, those of positive weight
  std::vector<double> weights;  ///< add up to 1
};
/// Of each point of the grid of `level`: bilinear in the quads of `coarse_level`, linear in triangles. A face
/// that isn't divided has the means of its sides and its corners in their middles.
std::vector<GridMean> make_grid_means(SubdivisionScheme scheme, std::size_t sides, int level,
                                      int coarse_level);

/// Catmull-Clark: the point of the corner's square that is so far along both sides from the corner, 1 being
/// their middles. Loop: 1 is all the way.
Vec2 grid_coordinate(SubdivisionScheme scheme, std::size_t sides, std::size_t corner, double along_next,
                     double along_previous);

}  // namespace recede::detail
