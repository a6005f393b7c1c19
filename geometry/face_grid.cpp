#include <recede/geometry/detail/face_grid.h>

#include <opensubdiv/bfr/parameterization.h>

namespace recede::detail {
namespace {

/// Numbers the points of a face with so many sides, and names its facets. `parts` are those of a corner's
/// square along one side.
class QuadLattice {
 public:
  QuadLattice(std::size_t sides, int level)
      : sides_(sides), parts_(level == 0 ? 0 : std::size_t{1} << (level - 1)), steps_(side_steps(level)) {}

  std::size_t parts() const { return parts_; }
  std::size_t n_points() const { return first_inside() + n_inside(); }
  std::size_t n_inside() const {
    return parts_ == 0 ? 0 : 1 + sides_ * (parts_ - 1) + sides_ * (parts_ - 1) * (parts_ - 1);
  }

  /// The point of a corner's square that is `i` steps towards the next corner and `j` towards the one
  /// before. Points on common sides of two squares have one number.
  std::size_t number(std::size_t corner, std::size_t i, std::size_t j) const {
    const std::size_t before = (corner + sides_ - 1) % sides_, inner = parts_ - 1;
    if (i == 0 && j == 0) return corner;
    if (j == 0) return sides_ + corner * steps_ + i - 1;
    if (i == 0) return sides_ + before * steps_ + 2 * parts_ - j - 1;
    if (i == parts_ && j == parts_) return first_inside();
    if (i == parts_) return first_inside() + 1 + corner * inner + j - 1;
    if (j == parts_) return first_inside() + 1 + before * inner + i - 1;
    return first_inside() + 1 + sides_ * inner + (corner * inner + j - 1) * inner + i - 1;
  }
  std::size_t cell(std::size_t corner, std::size_t i, std::size_t j) const {
    return (corner * parts_ + j) * parts_ + i;
  }

  /// Calls `visit(number, corner, i, j)` for all points of all squares, those on common sides twice.
  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t corner = 0; corner < sides_; ++corner) {
      for (std::size_t j = 0; j <= parts_; ++j) {
        for (std::size_t i = 0; i <= parts_; ++i) visit(number(corner, i, j), corner, i, j);
      }
    }
  }

 private:
  std::size_t first_inside() const { return sides_ + sides_ * steps_; }

  std::size_t sides_, parts_, steps_;
};

/// The same for a triangle, whose points are `i` steps towards its second corner and `j` towards the third.
class TriangleLattice {
 public:
  explicit TriangleLattice(int level) : parts_(std::size_t{1} << level), steps_(parts_ - 1) {}

  std::size_t parts() const { return parts_; }
  std::size_t n_points() const { return (parts_ + 1) * (parts_ + 2) / 2; }
  std::size_t n_inside() const { return n_points() - 3 * parts_; }

  std::size_t number(std::size_t i, std::size_t j) const {
    if (i + j == 0) return 0;
    if (i == parts_) return 1;
    if (j == parts_) return 2;
    if (j == 0) return 3 + i - 1;
    if (i + j == parts_) return 3 + steps_ + j - 1;
    if (i == 0) return 3 + 2 * steps_ + (parts_ - j) - 1;
    // Row j has parts - 1 - j points inside, i from 1 on.
    return 3 + 3 * steps_ + (j - 1) * (parts_ - 1) - j * (j - 1) / 2 + i - 1;
  }
  /// Facets that stand as the face does, row by row; then those that are turned by half a turn.
  std::size_t upright_cell(std::size_t i, std::size_t j) const { return j * parts_ - j * (j - 1) / 2 + i; }
  std::size_t turned_cell(std::size_t i, std::size_t j) const {
    return parts_ * (parts_ + 1) / 2 + j * (parts_ - 1) - j * (j - 1) / 2 + i;
  }

  template <typename Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t j = 0; j <= parts_; ++j) {
      for (std::size_t i = 0; i + j <= parts_; ++i) visit(number(i, j), i, j);
    }
  }

 private:
  std::size_t parts_, steps_;
};

/// Where a number stands among corners, sides and the inside.
GridPoint grid_point(std::size_t number, std::size_t sides, std::size_t steps) {
  GridPoint point;
  if (number < sides) {
    point.place = GridPlace::corner;
    point.element = static_cast<Index>(number);
  } else if (number < sides + sides * steps) {
    point.place = GridPlace::side;
    point.element = static_cast<Index>((number - sides) / steps);
    point.step = static_cast<Index>((number - sides) % steps + 1);
  } else {
    point.step = static_cast<Index>(number - sides - sides * steps);
  }
  return point;
}

std::vector<GridPoint> numbered_points(std::size_t n_points, std::size_t sides, int level) {
  std::vector<GridPoint> points;
  points.reserve(n_points);
  for (std::size_t k = 0; k < n_points; ++k) points.push_back(grid_point(k, sides, side_steps(level)));
  return points;
}

FaceGrid single_cell(std::size_t sides) {
  FaceGrid grid;
  grid.cell_sides = sides;
  grid.points = numbered_points(sides, sides, 0);
  for (std::size_t k = 0; k < sides; ++k) {
    grid.points[k].at = grid_coordinate(SubdivisionScheme::catmull_clark, sides, k, 0, 0);
    grid.cell_points.push_back(static_cast<Index>(k));
  }
  return grid;
}

FaceGrid quad_grid(std::size_t sides, int level) {
  if (level == 0) return single_cell(sides);
  const QuadLattice lattice(sides, level);
  FaceGrid grid;
  grid.cell_sides = 4;
  grid.n_inside = lattice.n_inside();
  grid.points = numbered_points(lattice.n_points(), sides, level);
  const std::size_t parts = lattice.parts();
  grid.cell_points.resize(4 * sides * parts * parts);
  const auto share = [&](std::size_t i) { return static_cast<double>(i) / static_cast<double>(parts); };
  lattice.for_each([&](std::size_t number, std::size_t corner, std::size_t i, std::size_t j) {
    grid.points[number].at =
        grid_coordinate(SubdivisionScheme::catmull_clark, sides, corner, share(i), share(j));
    if (i == parts || j == parts) return;
    Index* cell = grid.cell_points.data() + 4 * lattice.cell(corner, i, j);
    cell[0] = static_cast<Index>(number);
    cell[1] = static_cast<Index>(lattice.number(corner, i + 1, j));
    cell[2] = static_cast<Index>(lattice.number(corner, i + 1, j + 1));
    cell[3] = static_cast<Index>(lattice.number(corner, i, j + 1));
  });
  return grid;
}

FaceGrid triangle_grid(int level) {
  const TriangleLattice lattice(level);
  FaceGrid grid;
  grid.cell_sides = 3;
  grid.n_inside = lattice.n_inside();
  grid.points = numbered_points(lattice.n_points(), 3, level);
  const std::size_t parts = lattice.parts();
  grid.cell_points.resize(3 * parts * parts);
  const auto set = [&](std::size_t cell, std::size_t a, std::size_t b, std::size_t c) {
    grid.cell_points[3 * cell] = static_cast<Index>(a);
    grid.cell_points[3 * cell + 1] = static_cast<Index>(b);
    grid.cell_points[3 * cell + 2] = static_cast<Index>(c);
  };
  lattice.for_each([&](std::size_t number, std::size_t i, std::size_t j) {
    grid.points[number].at =
        Vec2(static_cast<double>(i), static_cast<double>(j)) / static_cast<double>(parts);
    if (i + j >= parts) return;
    set(lattice.upright_cell(i, j), number, lattice.number(i + 1, j), lattice.number(i, j + 1));
    if (i + j + 1 >= parts) return;
    set(lattice.turned_cell(i, j), lattice.number(i + 1, j), lattice.number(i + 1, j + 1),
        lattice.number(i, j + 1));
  });
  return grid;
}

void add_cell(GridSample& sample, std::size_t cell) {
  const auto index = static_cast<Index>(cell);
  if (sample.cells[0] == k_no_index) sample.cells[0] = index;
  if (sample.cells[0] != index) sample.cells[1] = index;
}

void find_quad_cells(std::vector<GridSample>& samples, std::size_t sides, int level, int sample_level) {
  const QuadLattice coarse(sides, level), fine(sides, sample_level);
  const std::size_t ratio = std::size_t{1} << (sample_level - level);
  fine.for_each([&](std::size_t number, std::size_t corner, std::size_t i, std::size_t j) {
    if (level == 0 && number >= sides) add_cell(samples[number], 0);
    if (level == 0 || (i % ratio == 0 && j % ratio == 0)) return;
    // On a line of the coarse grid, the cells of both sides.
    for (const std::size_t y : {j / ratio, (j + ratio - 1) / ratio - (j > 0 ? 1 : 0)}) {
      for (const std::size_t x : {i / ratio, (i + ratio - 1) / ratio - (i > 0 ? 1 : 0)}) {
        if (x < coarse.parts() && y < coarse.parts()) add_cell(samples[number], coarse.cell(corner, x, y));
      }
    }
  });
}

void find_triangle_cells(std::vector<GridSample>& samples, int level, int sample_level) {
  const TriangleLattice coarse(level), fine(sample_level);
  const std::size_t ratio = std::size_t{1} << (sample_level - level), parts = coarse.parts();
  fine.for_each([&](std::size_t number, std::size_t i, std::size_t j) {
    const std::size_t x = i / ratio, y = j / ratio, rest_x = i % ratio, rest_y = j % ratio;
    if (rest_x == 0 && rest_y == 0) return;
    GridSample& sample = samples[number];
    if (rest_x + rest_y <= ratio && x + y < parts) add_cell(sample, coarse.upright_cell(x, y));
    if (rest_x + rest_y >= ratio && x + y + 1 < parts) add_cell(sample, coarse.turned_cell(x, y));
    if (rest_x == 0 && x > 0 && x + y < parts) add_cell(sample, coarse.turned_cell(x - 1, y));
    if (rest_y == 0 && y > 0 && x + y < parts) add_cell(sample, coarse.turned_cell(x, y - 1));
  });
}

void add_to(GridMean& mean, std::size_t point, double weight) {
  if (!(weight > 0)) return;
  mean.points.push_back(static_cast<Index>(point));
  mean.weights.push_back(weight);
}

double share_of(std::size_t i, std::size_t n) { return static_cast<double>(i) / static_cast<double>(n); }

// Between the corners of a face that isn't divided. `u` and `v` are 0 at `corner` and 1 at the sides'
// middles.
GridMean mean_of_corners(std::size_t sides, std::size_t corner, double u, double v) {
  std::vector<double> weights(sides, u * v / static_cast<double>(sides));
  weights[corner] += (1 - u) * (1 - v) + (u * (1 - v) + v * (1 - u)) / 2;
  weights[(corner + 1) % sides] += u * (1 - v) / 2;
  weights[(corner + sides - 1) % sides] += v * (1 - u) / 2;
  GridMean mean;
  for (std::size_t k = 0; k < sides; ++k) add_to(mean, k, weights[k]);
  return mean;
}

void find_quad_means(std::vector<GridMean>& means, std::size_t sides, int level, int coarse_level) {
  const QuadLattice fine(sides, level);
  const std::size_t ratio = std::size_t{1} << (level - coarse_level);
  fine.for_each([&](std::size_t number, std::size_t corner, std::size_t i, std::size_t j) {
    if (coarse_level == 0) {
      means[number] = mean_of_corners(sides, corner, share_of(i, fine.parts()), share_of(j, fine.parts()));
      return;
    }
    // The quad's first point; of its last ones those are left out that lie beyond the square.
    const std::size_t x = i / ratio * ratio, y = j / ratio * ratio;
    const double u = share_of(i - x, ratio), v = share_of(j - y, ratio);
    GridMean mean;
    add_to(mean, fine.number(corner, x, y), (1 - u) * (1 - v));
    if (u > 0) add_to(mean, fine.number(corner, x + ratio, y), u * (1 - v));
    if (v > 0) add_to(mean, fine.number(corner, x, y + ratio), (1 - u) * v);
    if (u > 0 && v > 0) add_to(mean, fine.number(corner, x + ratio, y + ratio), u * v);
    means[number] = std::move(mean);
  });
}

void find_triangle_means(std::vector<GridMean>& means, int level, int coarse_level) {
  const TriangleLattice fine(level);
  const std::size_t ratio = std::size_t{1} << (level - coarse_level);
  fine.for_each([&](std::size_t number, std::size_t i, std::size_t j) {
    const std::size_t x = i / ratio * ratio, y = j / ratio * ratio;
    const double u = share_of(i - x, ratio), v = share_of(j - y, ratio);
    GridMean mean;
    if (u + v <= 1) {
      add_to(mean, fine.number(x, y), 1 - u - v);
      if (u > 0) add_to(mean, fine.number(x + ratio, y), u);
      if (v > 0) add_to(mean, fine.number(x, y + ratio), v);
    } else {
      add_to(mean, fine.number(x + ratio, y + ratio), u + v - 1);
      add_to(mean, fine.number(x, y + ratio), 1 - u);
      add_to(mean, fine.number(x + ratio, y), 1 - v);
    }
    means[number] = std::move(mean);
  });
}

}  // namespace

Vec2 grid_coordinate(SubdivisionScheme scheme, std::size_t sides, std::size_t corner, double along_next,
                     double along_previous) {
  if (scheme == SubdivisionScheme::loop) {
    const Vec2 corners[3] = {{0, 0}, {1, 0}, {0, 1}};
    const Vec2 origin = corners[corner];
    return origin + along_next * (corners[(corner + 1) % 3] - origin) +
           along_previous * (corners[(corner + 2) % 3] - origin);
  }
  if (sides == 4) {
    const Vec2 corners[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const Vec2 origin = corners[corner];
    return origin + along_next / 2 * (corners[(corner + 1) % 4] - origin) +
           along_previous / 2 * (corners[(corner + 3) % 4] - origin);
  }
  const OpenSubdiv::Bfr::Parameterization faces(OpenSubdiv::Sdc::SCHEME_CATMARK, static_cast<int>(sides));
  const double within[2] = {along_next, along_previous};
  double at[2];
  faces.ConvertNormalizedSubFaceToCoord(static_cast<int>(corner), within, at);
  return {at[0], at[1]};
}

FaceGrid make_face_grid(SubdivisionScheme scheme, std::size_t sides, int level) {
  return scheme == SubdivisionScheme::loop ? triangle_grid(level) : quad_grid(sides, level);
}

std::vector<GridSample> make_grid_samples(SubdivisionScheme scheme, std::size_t sides, int level,
                                          int sample_level) {
  const FaceGrid fine = make_face_grid(scheme, sides, sample_level);
  std::vector<GridSample> samples(fine.points.size());
  for (std::size_t k = 0; k < samples.size(); ++k) samples[k].point = fine.points[k];
  if (scheme == SubdivisionScheme::loop) {
    find_triangle_cells(samples, level, sample_level);
  } else {
    find_quad_cells(samples, sides, level, sample_level);
  }
  std::erase_if(samples, [](const GridSample& sample) { return sample.cells[0] == k_no_index; });
  return samples;
}

std::vector<GridMean> make_grid_means(SubdivisionScheme scheme, std::size_t sides, int level,
                                      int coarse_level) {
  std::vector<GridMean> means(make_face_grid(scheme, sides, level).points.size());
  if (scheme == SubdivisionScheme::loop) {
    find_triangle_means(means, level, coarse_level);
  } else if (level == 0) {
    for (std::size_t k = 0; k < sides; ++k) add_to(means[k], k, 1);
  } else {
    find_quad_means(means, sides, level, coarse_level);
  }
  return means;
}

}  // namespace recede::detail
