#include <recede/geometry/detail/plane_predicates.h>
#include <recede/geometry/detail/space_predicates.h>
#include <recede/shells/detail/layer_boundary.h>

#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace recede::detail {
namespace {

/// The ray leaves every line that it would meet: its origin counts as moved by an infinitesimal step along
/// the second axis and an infinitely smaller one along the third.
int turn_towards_ray(const Vec2& a, const Vec2& b, const Vec2& origin) {
  const int turn = orientation(a, b, origin);
  if (turn != 0) return turn;
  if (a.y() != b.y()) return a.y() > b.y() ? 1 : -1;
  return a.x() == b.x() ? 0 : a.x() < b.x() ? 1 : -1;
}

/// 1 when the ray along the first axis leaves through the front of the triangle, -1 when it enters there, 0
/// when it misses it.
int crossing(const Vec3& origin, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto flat = [](const Vec3& p) { return Vec2(p.y(), p.z()); };
  const int turn = turn_towards_ray(flat(a), flat(b), flat(origin));
  if (turn == 0 || turn_towards_ray(flat(b), flat(c), flat(origin)) != turn ||
      turn_towards_ray(flat(c), flat(a), flat(origin)) != turn) {
    return 0;
  }
  return side_of_plane(a, b, c, origin) == -turn ? turn : 0;
}

/// How the ray crosses the part, as a boundary with its front outward: two triangles stand for a wall.
int crossing(const LayerBoundary& layer, Index part, const Vec3& origin) {
  const auto corners = layer.simplex(part).corners;
  const auto point = [&](std::size_t k) -> const Vec3& { return layer.points[corners[k]]; };
  if (layer.is_wall(part)) {
    return crossing(origin, point(0), point(1), point(3)) + crossing(origin, point(0), point(3), point(2));
  }
  const int front = crossing(origin, point(0), point(1), point(2));
  return part < layer.n_triangles() ? -front : front;
}

/// For each piece a vertex that no other piece has, or `k_no_index`.
std::vector<Index> own_vertices(const LayerBoundary& layer) {
  constexpr Index k_several = k_no_index - 1;
  std::vector<Index> piece_of_vertex(layer.n_vertices(), k_no_index);
  for (std::size_t c = 0; c < layer.triangles.size(); ++c) {
    const Index piece = layer.pieces.piece_of_triangle[c / 3];
    if (piece == k_no_index) continue;
    Index& known = piece_of_vertex[layer.triangles[c]];
    known = known == k_no_index || known == piece ? piece : k_several;
  }
  std::vector<Index> vertices(layer.pieces.n_pieces(), k_no_index);
  for (std::size_t v = piece_of_vertex.size(); v-- > 0;) {
    if (piece_of_vertex[v] < k_several) vertices[piece_of_vertex[v]] = static_cast<Index>(v);
  }
  return vertices;
}

using Pairs = std::vector<std::pair<Index, Index>>;
using Crossings = std::vector<std::pair<Index, int>>;  // of pieces

/// Adds the other pieces in whose layer a point of `piece` lies.
void add_layers_around(const LayerBoundary& layer, const BoxTree& tree, Index piece, const Vec3& point,
                       Crossings& crossings, Pairs& nested) {
  const auto& pieces = layer.pieces;
  crossings.clear();
  tree.visit_ray(point, [&](Index part) {
    const Index other = pieces.piece_of_triangle[layer.triangle(part)];
    if (other == piece || other == k_no_index) return;
    const int sign = crossing(layer, part, point);
    if (sign != 0) crossings.emplace_back(other, sign);
  });
  std::sort(crossings.begin(), crossings.end());
  for (std::size_t i = 0; i < crossings.size();) {
    const Index other = crossings[i].first;
    int winding = 0;
    for (; i < crossings.size() && crossings[i].first == other; ++i) winding += crossings[i].second;
    if (winding != 0) nested.emplace_back(pieces.first_triangle[piece], pieces.first_triangle[other]);
  }
}

}  // namespace

Simplex LayerBoundary::simplex(Index part) const {
  if (!is_wall(part)) {
    const Index first = 3 * triangle(part), shift = part < n_triangles() ? 0 : n_vertices();
    return {{triangles[first] + shift, triangles[first + 1] + shift, triangles[first + 2] + shift}, 3};
  }
  const Index corner = wall_corner(part);
  const Index a = triangles[corner], b = triangles[next_in_triangle(corner)];
  return {{a, b, a + n_vertices(), b + n_vertices()}, 4};
}

BoxTree::Box box_of_part(const LayerBoundary& layer, Index part) {
  const Simplex simplex = layer.simplex(part);
  const auto at = [&](int i) {
    const Vec3& p = layer.points[simplex.corners[static_cast<std::size_t>(i)]];
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  BoxTree::Box box{at(0), at(0)};
  for (int i = 1; i < simplex.size; ++i) box.extend({at(i), at(i)});
  return box;
}

std::vector<BoxTree::Box> boxes_of_parts(const LayerBoundary& layer) {
  std::vector<BoxTree::Box> boxes(layer.n_parts());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, boxes.size()), [&](const auto& range) {
    for (std::size_t part = range.begin(); part < range.end(); ++part)
      boxes[part] = box_of_part(layer, static_cast<Index>(part));
  });
  return boxes;
}

std::vector<std::pair<Index, Index>> find_nested_pieces(const LayerBoundary& layer, const BoxTree& tree) {
  const std::size_t n = layer.pieces.n_pieces();
  const std::vector<Index> vertices = own_vertices(layer);
  struct Workspace {
    Crossings crossings;
    Pairs nested;
  };
  tbb::enumerable_thread_specific<Workspace> workspaces;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n), [&](const auto& range) {
    Workspace& work = workspaces.local();
    for (std::size_t p = range.begin(); p < range.end(); ++p) {
      if (vertices[p] == k_no_index) continue;
      for (const Index shift : {Index{0}, layer.n_vertices()}) {
        add_layers_around(layer, tree, static_cast<Index>(p), layer.points[vertices[p] + shift],
                          work.crossings, work.nested);
      }
    }
  });
  Pairs nested;
  for (const Workspace& work : workspaces)
    nested.insert(nested.end(), work.nested.begin(), work.nested.end());
  std::sort(nested.begin(), nested.end());
  nested.erase(std::unique(nested.begin(), nested.end()), nested.end());
  return nested;
}

}  // namespace recede::detail
