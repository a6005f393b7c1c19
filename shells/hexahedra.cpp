#include <recede/shells/detail/box_tree.h>
#include <recede/shells/detail/hexahedra.h>
#include <recede/shells/detail/shell_cell.h>
#include <recede/shells/detail/shell_pieces.h>
#include <recede/shells/detail/simplex_contact.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <limits>

namespace recede::detail {
namespace {

/// A sum of determinants, and how large the products in it are.
struct DeterminantSum {
  double value = 0, size = 0;

  void add(const Vec3& u, const Vec3& v, const Vec3& w) {
    value += u.cross(v).dot(w);
    const Vec3 a = u.cwiseAbs(), b = v.cwiseAbs(), c = w.cwiseAbs();
    size += (a.y() * b.z() + a.z() * b.y()) * c.x() + (a.z() * b.x() + a.x() * b.z()) * c.y() +
            (a.x() * b.y() + a.y() * b.x()) * c.z();
  }
  bool is_surely_above_zero(double orientation) const {
    // Three roundings of differences, five of a determinant and those of a sum of eight, and a little more,
    // for the bound is rounded as well.
    constexpr double k_error = 20 * (0.5 * std::numeric_limits<double>::epsilon());
    // Products too small for a double are lost only below this.
    constexpr double k_least = 1e30 * std::numeric_limits<double>::min();
    return orientation * value > k_error * size + k_least;
  }
};

/// What a layer's boundary is of when some quads are hulls of their corners instead of two triangles.
struct HullBoundary {
  std::vector<Vec3> points;
  std::vector<Simplex> parts;
  std::vector<Index> quads;  ///< of each part the quad's first triangle, or none

  void add(const Simplex& simplex, Index quad) {
    parts.push_back(simplex);
    quads.push_back(quad);
  }
  void add_at_both_ends(Simplex simplex, Index quad) {
    add(simplex, quad);
    for (int k = 0; k < simplex.size; ++k)
      simplex.corners[static_cast<std::size_t>(k)] += static_cast<Index>(points.size() / 2);
    add(simplex, quad);
  }
};

HullBoundary boundary_with(const Shell& shell, const ShellLayer& layer, std::span<const Index> quads) {
  const std::vector<Index>& triangles = shell.base.corner_vertices;
  const auto n_vertices = static_cast<Index>(shell.base.positions.size());
  HullBoundary boundary;
  boundary.points = shell.base.positions;
  boundary.points.insert(boundary.points.end(), layer.tops.begin(), layer.tops.end());
  auto quad = quads.begin();
  for (Index t = 0; t < shell.base.n_faces(); ++t) {
    Simplex simplex{{triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]}, 3};
    const bool is_quad = quad != quads.end() && *quad == t;
    if (is_quad) {
      const std::array<Index, 4> corners = quad_corners(triangles, t);
      for (std::size_t k = 0; k < 4; ++k) simplex.corners[k] = triangles[corners[k]];
      simplex.size = 4;
      ++quad;
    }
    boundary.add_at_both_ends(simplex, is_quad ? t : k_no_index);
    if (is_quad) ++t;
  }
  for (const Index corner : find_open_sides(n_vertices, triangles)) {
    const Index a = triangles[corner], b = triangles[next_in_triangle(corner)];
    boundary.add({{a, b, a + n_vertices, b + n_vertices}, 4}, k_no_index);
  }
  return boundary;
}

BoxTree tree_over(const HullBoundary& boundary) {
  std::vector<BoxTree::Box> boxes(boundary.parts.size());
  for (std::size_t part = 0; part < boxes.size(); ++part) {
    const Simplex& simplex = boundary.parts[part];
    const auto at = [&](std::size_t k) {
      const Vec3& p = boundary.points[simplex.corners[k]];
      return std::array<double, 3>{p.x(), p.y(), p.z()};
    };
    boxes[part] = {at(0), at(0)};
    for (std::size_t k = 1; k < static_cast<std::size_t>(simplex.size); ++k)
      boxes[part].extend({at(k), at(k)});
  }
  return BoxTree(boxes);
}

}  // namespace

std::array<Index, 4> quad_corners(std::span<const Index> triangles, Index first) {
  const Index a = 3 * first, b = a + 3;
  const auto has = [&](Index triangle, Index vertex) {
    return triangles[triangle] == vertex || triangles[triangle + 1] == vertex ||
           triangles[triangle + 2] == vertex;
  };
  // From the corner that the other triangle hasn't got, past its next one, across the diagonal, and back.
  Index k = 0, other = 0;
  while (k < 2 && has(b, triangles[a + k])) ++k;
  while (other < 2 && has(a, triangles[b + other])) ++other;
  return {a + k, a + (k + 1) % 3, b + other, a + (k + 2) % 3};
}

bool is_quad(std::span<const Index> triangles, Index first) {
  const std::array<Index, 4> corners = quad_corners(triangles, first);
  std::array<Index, 4> vertices{};
  for (std::size_t k = 0; k < 4; ++k) vertices[k] = triangles[corners[k]];
  const Index second = 3 * first + 3, last = corners[2];
  // The other triangle runs along the diagonal the other way.
  const Index next = second + (last - second + 1) % 3, then = second + (last - second + 2) % 3;
  std::array<Index, 4> sorted = vertices;
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end() && triangles[next] == vertices[3] &&
         triangles[then] == vertices[1];
}

bool surely_has_one_orientation(const Hexahedron& hexahedron, bool is_inward) {
  // At height 0 and 1: the sides along u at v = 0 and 1, along v at u = 0 and 1. Steps upwards by u and v.
  const auto& at = std::array{&hexahedron.bottom, &hexahedron.top};
  Vec3 along_u[2][2], along_v[2][2], up[2][2];
  for (std::size_t r = 0; r < 2; ++r) {
    const std::array<Vec3, 4>& p = *at[r];
    along_u[0][r] = p[1] - p[0];
    along_u[1][r] = p[2] - p[3];
    along_v[0][r] = p[3] - p[0];
    along_v[1][r] = p[2] - p[1];
  }
  const auto director = [&](std::size_t k) -> Vec3 { return hexahedron.top[k] - hexahedron.bottom[k]; };
  up[0][0] = director(0);
  up[1][0] = director(1);
  up[1][1] = director(2);
  up[0][1] = director(3);
  DeterminantSum sums[3][3][3];
  for (std::size_t bits = 0; bits < 64; ++bits) {
    const auto bit = [&](std::size_t k) { return (bits >> k) & 1; };
    const std::size_t v0 = bit(0), r0 = bit(1), u1 = bit(2), r1 = bit(3), u2 = bit(4), v2 = bit(5);
    sums[u1 + u2][v0 + v2][r0 + r1].add(along_u[v0][r0], along_v[u1][r1], up[u2][v2]);
  }
  const double orientation = is_inward ? -1 : 1;
  for (const auto& plane : sums) {
    for (const auto& row : plane) {
      for (const DeterminantSum& sum : row) {
        if (!sum.is_surely_above_zero(orientation)) return false;
      }
    }
  }
  return true;
}

std::vector<Index> find_hexahedra(const Shell& shell, const ShellLayer& layer, bool is_inward,
                                  Progress* progress) {
  std::vector<Index> turned;
  for (const Index quad : shell.quads) {
    Hexahedron hexahedron;
    const std::array<Index, 4> corners = quad_corners(shell.base.corner_vertices, quad);
    for (std::size_t k = 0; k < 4; ++k) {
      const Index v = shell.base.corner_vertices[corners[k]];
      hexahedron.bottom[k] = shell.base.positions[v];
      hexahedron.top[k] = layer.tops[v];
    }
    if (surely_has_one_orientation(hexahedron, is_inward)) turned.push_back(quad);
  }
  if (turned.empty()) return turned;
  report_progress(progress, "find hexahedra", 0);
  const HullBoundary boundary = boundary_with(shell, layer, turned);
  const BoxTree tree = tree_over(boundary);
  std::vector<std::atomic<bool>> meets(shell.base.n_faces());
  tbb::parallel_for(std::size_t{0}, tree.n_leaves(), [&](std::size_t leaf) {
    tree.visit_pairs(leaf, [&](Index a, Index b) {
      const Index first = boundary.quads[a], second = boundary.quads[b];
      if (first == k_no_index && second == k_no_index) return;
      if (!has_contact(boundary.points, boundary.parts[a], boundary.parts[b])) return;
      if (first != k_no_index) meets[first].store(true, std::memory_order_relaxed);
      if (second != k_no_index) meets[second].store(true, std::memory_order_relaxed);
    });
  });
  std::erase_if(turned, [&](Index quad) { return meets[quad].load(std::memory_order_relaxed); });
  report_progress(progress, "find hexahedra", 1);
  return turned;
}

}  // namespace recede::detail
