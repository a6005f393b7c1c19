#include <recede/lod/detail/map_surface.h>
#include <recede/render/detail/displaced_patches.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>

namespace recede::detail {
namespace {

constexpr Index k_none = k_no_index;

/// A side of a triangle: from its corner `k` to the next one. Sides with the same two points are neighbours.
struct Side {
  Index low = 0, high = 0;  // points
  Index triangle = 0;
  std::uint8_t k = 0;

  bool same_line(const Side& other) const { return low == other.low && high == other.high; }
};

std::size_t after(std::size_t k) { return (k + 1) % 3; }

/// The triangles of a base with their welded points and texel coordinates.
struct Triangles {
  Triangles(const PolygonSoup& base, int columns, int rows) : points(points_of_corners(base)) {
    triangulate(base, &faces, &corners);
    texels.reserve(base.n_corners());
    for (const Vec2& uv : base.corner_uvs) {
      texels.push_back(
          {static_cast<float>(uv.x() * columns + 0.5), static_cast<float>((1 - uv.y()) * rows + 0.5)});
    }
  }

  std::size_t size() const { return faces.size(); }
  Index corner(std::size_t triangle, std::size_t k) const { return corners[3 * triangle + k % 3]; }
  Index point(std::size_t triangle, std::size_t k) const { return points[corner(triangle, k)]; }
  const std::array<float, 2>& texel(std::size_t triangle, std::size_t k) const {
    return texels[corner(triangle, k)];
  }
  std::size_t corner_at(std::size_t triangle, Index wanted) const {
    std::size_t k = 0;
    while (k < 2 && point(triangle, k) != wanted) ++k;
    return k;
  }

  std::vector<Index> points;  // of each corner of the base
  std::vector<Index> faces, corners;
  std::vector<std::array<float, 2>> texels;  // of each corner of the base
};

/// All sides, those of one line together and in the order of their triangles.
class Sides {
 public:
  explicit Sides(const Triangles& triangles) : at_(3 * triangles.size()) {
    for (Index t = 0; t < triangles.size(); ++t) {
      for (std::uint8_t k = 0; k < 3; ++k) {
        const Index from = triangles.point(t, k), to = triangles.point(t, k + 1u);
        sides_.push_back({std::min(from, to), std::max(from, to), t, k});
      }
    }
    std::sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) {
      return std::tie(a.low, a.high, a.triangle, a.k) < std::tie(b.low, b.high, b.triangle, b.k);
    });
    std::size_t first = 0;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
      if (!sides_[s].same_line(sides_[first])) first = s;
      at_[3 * sides_[s].triangle + sides_[s].k] = static_cast<Index>(first);
    }
  }

  /// The sides along the line of one.
  std::span<const Side> along(std::size_t triangle, std::size_t k) const {
    const std::size_t first = at_[3 * triangle + k];
    std::size_t end = first + 1;
    while (end < sides_.size() && sides_[end].same_line(sides_[first])) ++end;
    return {sides_.data() + first, end - first};
  }

 private:
  std::vector<Side> sides_;
  std::vector<Index> at_;  // the first side of the line of each
};

/// Which triangle each is paired with, across which of its sides.
class Pairing {
 public:
  Pairing(const Triangles& triangles, const Sides& sides, const std::vector<std::uint8_t>& levels)
      : triangles_(triangles),
        sides_(sides),
        levels_(levels),
        side_(triangles.size(), k_alone),
        is_taken_(triangles.size(), 0) {
    for (Index t = 0; t < triangles.size(); ++t) pair(t, true);
    // Triangles with one free neighbour left come first, so that few stay alone.
    for (Index t = 0; t < triangles.size(); ++t) {
      if (free_neighbours(t) == 1) waiting_.push_back(t);
    }
    settle_waiting();
    for (Index t = 0; t < triangles.size(); ++t) {
      pair(t, false);
      settle_waiting();
    }
  }

  static constexpr std::uint8_t k_alone = 3;
  /// The side of a triangle that it shares with its partner.
  std::uint8_t side(Index triangle) const { return side_[triangle]; }
  /// The triangle and its side across a side, if the two can be paired; else k_none.
  Side partner(Index triangle, std::size_t k) const {
    const std::span<const Side> line = sides_.along(triangle, k);
    constexpr Side k_nobody{0, 0, k_none, 0};
    if (line.size() != 2) return k_nobody;
    const Side other = line[0].triangle == triangle ? line[1] : line[0];
    const bool fits = other.triangle != triangle && levels_[other.triangle] == levels_[triangle] &&
                      triangles_.point(triangle, k) == triangles_.point(other.triangle, other.k + 1u) &&
                      triangles_.texel(triangle, k) == triangles_.texel(other.triangle, other.k + 1u) &&
                      triangles_.texel(triangle, k + 1) == triangles_.texel(other.triangle, other.k);
    return fits ? other : k_nobody;
  }

 private:
  bool is_free(const Side& side) const { return side.triangle != k_none && !is_taken_[side.triangle]; }
  int free_neighbours(Index triangle) const {
    int count = 0;
    for (std::size_t k = 0; k < 3; ++k) count += is_free(partner(triangle, k)) ? 1 : 0;
    return count;
  }

  /// Takes the free neighbour that has the fewest others; `within`: of the same polygon only.
  void pair(Index triangle, bool within) {
    if (is_taken_[triangle]) return;
    Side best{0, 0, k_none, 0};
    std::uint8_t best_side = 0;
    int fewest = 4;
    for (std::uint8_t k = 0; k < 3; ++k) {
      const Side other = partner(triangle, k);
      if (!is_free(other)) continue;
      if (within && triangles_.faces[other.triangle] != triangles_.faces[triangle]) continue;
      const int others = free_neighbours(other.triangle);
      if (others >= fewest) continue;
      fewest = others;
      best = other;
      best_side = k;
    }
    if (best.triangle == k_none) return;
    side_[triangle] = best_side;
    side_[best.triangle] = best.k;
    is_taken_[triangle] = is_taken_[best.triangle] = 1;
    if (within) return;
    for (const Index taken : {triangle, best.triangle}) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Side other = partner(taken, k);
        if (is_free(other) && free_neighbours(other.triangle) == 1) waiting_.push_back(other.triangle);
      }
    }
  }
  void settle_waiting() {
    while (!waiting_.empty()) {
      const Index triangle = waiting_.back();
      waiting_.pop_back();
      pair(triangle, false);
    }
  }

  const Triangles& triangles_;
  const Sides& sides_;
  const std::vector<std::uint8_t>& levels_;
  std::vector<std::uint8_t> side_;
  std::vector<std::uint8_t> is_taken_;
  std::vector<Index> waiting_;
};

class PatchMaker {
 public:
  PatchMaker(const PolygonSoup& base, const SceneFrame& frame, int columns, int rows,
             const std::vector<std::uint8_t>& levels)
      : base_(base),
        frame_(frame),
        levels_(levels),
        triangles_(base, columns, rows),
        sides_(triangles_),
        corner_owners_(base.positions.size(), k_none) {
    for (std::size_t c = triangles_.corners.size(); c-- > 0;) {
      const Index corner = triangles_.corners[c];
      corner_owners_[triangles_.points[corner]] = corner;
    }
  }

  DisplacedPatches run() {
    make_vertices();
    const Pairing pairing(triangles_, sides_, levels_);
    for (Index t = 0; t < triangles_.size(); ++t) {
      const std::uint8_t side = pairing.side(t);
      if (side == Pairing::k_alone) {
        add_patch(t, 0, k_none, 0);
      } else if (const Side other = pairing.partner(t, side); other.triangle > t) {
        add_patch(t, after(after(side)), other.triangle, after(after(other.k)));
      }
    }
    result_.faces = std::move(triangles_.faces);
    result_.patches.shrink_to_fit();
    return std::move(result_);
  }

 private:
  void make_vertices() {
    const std::vector<Vec3> directions = point_directions(base_, triangles_.points);
    numbers_.assign(base_.positions.size(), k_none);
    for (const Index corner : triangles_.corners) {
      const Index point = triangles_.points[corner];
      if (numbers_[point] != k_none) continue;
      numbers_[point] = static_cast<Index>(result_.vertices.size());
      DisplacedVertex& vertex = result_.vertices.emplace_back();
      const Vec3 place = frame_.to_scene(base_.positions[base_.corner_vertices[corner]]);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        vertex.position[axis] = static_cast<float>(place[axis]);
        vertex.direction[axis] = static_cast<float>(directions[point][axis]);
      }
    }
  }

  /// `first_corner` and `second_corner` lie opposite to the common side.
  void add_patch(Index first, std::size_t first_corner, Index second, std::size_t second_corner) {
    DisplacedPatch patch{};
    patch.level = levels_[first];
    patch.is_single = second == k_none;
    patch.first_corner[0] = static_cast<std::uint8_t>(first_corner % 3);
    patch.first_corner[1] = static_cast<std::uint8_t>(second_corner % 3);
    const Index a = triangles_.corner(first, first_corner), b = triangles_.corner(first, first_corner + 1),
                d = triangles_.corner(first, first_corner + 2);
    const Index c = second == k_none ? b : triangles_.corner(second, second_corner);
    const std::array<Index, 4> corners{a, b, c, d};
    for (std::size_t k = 0; k < 4; ++k) {
      patch.vertices[k] = numbers_[triangles_.points[corners[k]]];
      patch.x[k] = triangles_.texels[corners[k]][0];
      patch.y[k] = triangles_.texels[corners[k]][1];
    }
    set_stretch(patch);
    exception_ = {};
    has_exception_ = false;
    look_along(k_line_ab, patch, first, first_corner, 0, 1);
    look_along(k_line_ad, patch, first, first_corner + 2, 0, 3);
    if (second == k_none) {
      look_along(k_line_bd, patch, first, first_corner + 1, 1, 3);
    } else {
      look_along(k_line_dc, patch, second, second_corner, 3, 2);
      look_along(k_line_bc, patch, second, second_corner + 2, 1, 2);
    }
    for (std::size_t k = 0; k < 4; ++k) look_at_corner(k, corners[k]);
    patch.exception = k_no_exception;
    if (has_exception_) {
      patch.exception = static_cast<std::uint32_t>(result_.exceptions.size());
      result_.exceptions.push_back(exception_);
    }
    result_.patches.push_back(patch);
    result_.triangles.push_back({first, second});
  }

  /// Within a triangle of unit directions the squared length is 1 minus the sum of w_i w_j |n_i - n_j|^2, at
  /// most a third of the largest side's square.
  void set_stretch(DisplacedPatch& patch) const {
    constexpr double k_parallel = 0.0001;  // more costs more than bounds of every square
    constexpr double k_float_room = 1e-6;
    const auto side = [&](std::size_t a, std::size_t b) {
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double step = static_cast<double>(result_.vertices[patch.vertices[a]].direction[axis]) -
                            static_cast<double>(result_.vertices[patch.vertices[b]].direction[axis]);
        square += step * step;
      }
      return square;
    };
    const double most = std::max({side(0, 1), side(0, 3), side(1, 3), side(1, 2), side(2, 3)});
    const double least_square = 1 - most / 3;
    if (1 - least_square > k_parallel) return;
    patch.least_stretch = static_cast<float>(1 - k_float_room);
    patch.most_stretch = static_cast<float>((1 + k_float_room) / std::sqrt(least_square));
  }

  /// The line is the triangle's side `k`, and runs between two corners of the patch.
  void look_along(PatchLine line, const DisplacedPatch& patch, Index triangle, std::size_t k,
                  std::size_t from, std::size_t to) {
    const std::span<const Side> neighbours = sides_.along(triangle, k % 3);
    std::uint8_t level = patch.level;
    for (const Side& side : neighbours) level = std::min(level, levels_[side.triangle]);
    exception_.coarsening[line] = static_cast<std::uint8_t>(patch.level - level);
    has_exception_ = has_exception_ || level < patch.level;
    const Index owner = neighbours.front().triangle;
    const auto texel_of_owner = [&](std::size_t corner) {
      const Index point = point_of_vertex(triangle, patch.vertices[corner]);
      return triangles_.texel(owner, triangles_.corner_at(owner, point));
    };
    const std::array<float, 2> start = texel_of_owner(from), end = texel_of_owner(to);
    exception_.line_x[line][0] = start[0];
    exception_.line_y[line][0] = start[1];
    exception_.line_x[line][1] = end[0];
    exception_.line_y[line][1] = end[1];
    const bool is_own = start[0] == patch.x[from] && start[1] == patch.y[from] && end[0] == patch.x[to] &&
                        end[1] == patch.y[to];
    if (is_own) return;
    exception_.foreign_lines = static_cast<std::uint8_t>(exception_.foreign_lines | 1u << line);
    has_exception_ = true;
  }
  Index point_of_vertex(Index triangle, std::uint32_t vertex) const {
    for (std::size_t k = 0; k < 2; ++k) {
      if (numbers_[triangles_.point(triangle, k)] == vertex) return triangles_.point(triangle, k);
    }
    return triangles_.point(triangle, 2);
  }

  void look_at_corner(std::size_t k, Index corner) {
    const Index owner = corner_owners_[triangles_.points[corner]];
    const std::array<float, 2>&own = triangles_.texels[corner], &theirs = triangles_.texels[owner];
    exception_.corner_x[k] = theirs[0];
    exception_.corner_y[k] = theirs[1];
    if (own == theirs) return;
    exception_.foreign_corners = static_cast<std::uint8_t>(exception_.foreign_corners | 1u << k);
    has_exception_ = true;
  }

  const PolygonSoup& base_;
  const SceneFrame& frame_;
  const std::vector<std::uint8_t>& levels_;
  Triangles triangles_;
  Sides sides_;
  std::vector<Index> corner_owners_;  // the first corner at each point
  std::vector<Index> numbers_;        // of the vertex at each point
  DisplacedPatches result_;
  PatchException exception_{};
  bool has_exception_ = false;
};

}  // namespace

DisplacedPatches make_displaced_patches(const PolygonSoup& base, const SceneFrame& frame, int columns,
                                        int rows, const std::vector<std::uint8_t>& levels) {
  return PatchMaker(base, frame, columns, rows, levels).run();
}

namespace {

constexpr int k_least_level_of_part = 4;  // unless its patch has less

}  // namespace

void divide_into_parts(DisplacedPatches& patches) {
  constexpr std::size_t k_most_parts = 1 << 16;  // some 5 MB of boxes
  const auto level_of_part = [](const DisplacedPatch& patch, int divisions) {
    return std::max(patch.level - divisions, std::min<int>(patch.level, k_least_level_of_part));
  };
  const auto count = [&](int divisions) {
    std::size_t sum = 0;
    for (const DisplacedPatch& patch : patches.patches)
      sum += std::size_t{1} << (2 * (patch.level - level_of_part(patch, divisions)));
    return sum;
  };
  int divisions = 0;
  while (count(divisions + 1) <= k_most_parts && count(divisions + 1) > count(divisions)) ++divisions;
  patches.parts.clear();
  if (divisions == 0) return;
  for (std::uint32_t p = 0; p < patches.patches.size(); ++p) {
    const DisplacedPatch& patch = patches.patches[p];
    const int level = level_of_part(patch, divisions);
    const std::uint32_t side = 1u << patch.level, step = 1u << level;
    for (std::uint32_t j = 0; j < side; j += step) {
      for (std::uint32_t i = 0; i < (patch.is_single ? side - j : side); i += step) {
        patches.parts.push_back({p, static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(j),
                                 static_cast<std::uint8_t>(level)});
      }
    }
  }
}

}  // namespace recede::detail
