#include <recede/lod/detail/corner_table.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace recede::detail {
namespace {

/// The side between two points in one face: the corners at either end.
struct SharedSide {
  Index at_a, at_b;
};

/// Calls `visit(SharedSide)` for every face that has the edge a-b. `at_a` is the corner of a, whichever way
/// the side runs.
template <typename Visit>
void each_shared_side(const CornerTable& table, Index a, Index b, Visit&& visit) {
  table.each_corner(a, [&](Index corner) {
    const Index after = table.next[corner];
    if (table.point[after] == b) visit(SharedSide{corner, after});
    const Index before = table.previous(corner);
    if (table.point[before] == b) visit(SharedSide{corner, before});
  });
}

}  // namespace

unsigned CornerTable::edge_kind(Index a, Index b) const {
  unsigned kind = k_smooth_edge;
  std::size_t sides = 0, along = 0;
  SharedSide first{};
  each_shared_side(*this, a, b, [&](const SharedSide& side) {
    ++sides;
    const bool runs_along = next[side.at_a] == side.at_b;
    along += runs_along ? 1u : 0u;
    if (!feature.empty() && feature[runs_along ? side.at_a : side.at_b] != 0) kind |= k_feature_edge;
    if (sides == 1) {
      first = side;
      return;
    }
    if (!face_material.empty() && face_material[face[side.at_a]] != face_material[face[first.at_a]]) {
      kind |= k_material_edge;
    }
    if (wedge.empty()) return;
    for (const auto& [x, y] :
         {std::pair{wedge[side.at_a], wedge[first.at_a]}, {wedge[side.at_b], wedge[first.at_b]}}) {
      if (x == y) continue;
      if (wedges[x].uv != wedges[y].uv) kind |= k_uv_seam_edge;
      if (wedges[x].normal != wedges[y].normal) kind |= k_normal_seam_edge;
    }
  });
  if (sides == 1) kind |= k_border_edge;
  if (sides > 2 || (sides == 2 && along != 1)) kind |= k_many_faces_edge;
  return kind;
}

namespace {

/// Builds the table in the order of its parts: geometry, loops and rings, wedges, classes.
class TableBuilder {
 public:
  TableBuilder(const PolygonSoup& soup, const CornerTableOptions& options) : soup_(soup), options_(options) {}

  CornerTable build() {
    set_positions();
    link_faces();
    link_rings();
    set_attributes();
    classify_points();
    return std::move(table_);
  }

 private:
  void set_positions() {
    const Box3 box = bounding_box(soup_);
    if (!soup_.positions.empty()) {
      table_.origin = box.center();
      table_.scale = box.sizes().maxCoeff();
    }
    if (!(table_.scale > 0)) table_.scale = 1;
    table_.positions.reserve(soup_.positions.size());
    for (const Vec3& p : soup_.positions) table_.positions.push_back((p - table_.origin) / table_.scale);
    table_.colors = soup_.vertex_colors;
  }

  void link_faces() {
    const std::size_t n = soup_.n_corners();
    table_.point = soup_.corner_vertices;
    table_.face.resize(n);
    table_.next.resize(n);
    table_.face_corner.resize(soup_.n_faces());
    table_.face_size.resize(soup_.n_faces());
    for (Index f = 0; f < soup_.n_faces(); ++f) {
      const Index first = soup_.face_offsets[f], last = soup_.face_offsets[f + 1] - 1;
      for (Index c = first; c <= last; ++c) {
        table_.face[c] = f;
        table_.next[c] = c == last ? first : c + 1;
      }
      table_.face_corner[f] = first;
      table_.face_size[f] = last - first + 1;
    }
    table_.n_alive_faces = soup_.n_faces();
    table_.face_material = soup_.face_materials;
    table_.materials = soup_.materials;
  }

  void link_rings() {
    table_.point_corner.assign(soup_.positions.size(), k_no_index);
    table_.sibling.resize(soup_.n_corners());
    std::vector<Index> last(soup_.positions.size(), k_no_index);
    for (Index c = 0; c < soup_.n_corners(); ++c) {
      const Index p = table_.point[c];
      if (last[p] == k_no_index) {
        table_.point_corner[p] = c;
        ++table_.n_alive_points;
      } else {
        table_.sibling[last[p]] = c;
      }
      table_.sibling[c] = table_.point_corner[p];
      last[p] = c;
    }
  }

  void set_attributes() {
    table_.has_uvs = !soup_.corner_uvs.empty();
    table_.has_normals = !soup_.corner_normals.empty();
    if (table_.has_uvs || table_.has_normals) make_wedges();
    if (!soup_.feature_edges.empty()) mark_features();
  }

  Wedge corner_wedge(Index corner) const {
    Wedge w;
    if (table_.has_uvs) w.uv = soup_.corner_uvs[corner];
    if (table_.has_normals) w.normal = soup_.corner_normals[corner];
    return w;
  }

  /// True when a seam between the two would have to be kept.
  bool differ(const Wedge& x, const Wedge& y) const {
    return (options_.keep_uv_seams && x.uv != y.uv) || (options_.keep_normal_seams && x.normal != y.normal);
  }

  /// Corners of one point share a wedge when they agree in all that has to be kept.
  void make_wedges() {
    table_.wedge.assign(soup_.n_corners(), k_no_index);
    std::vector<Index> of_point;
    for (Index p = 0; p < soup_.positions.size(); ++p) {
      of_point.clear();
      table_.each_corner(p, [&](Index corner) {
        const Wedge w = corner_wedge(corner);
        const auto same = std::find_if(of_point.begin(), of_point.end(),
                                       [&](Index known) { return !differ(table_.wedges[known], w); });
        if (same != of_point.end()) {
          table_.wedge[corner] = *same;
          return;
        }
        table_.wedge[corner] = static_cast<Index>(table_.wedges.size());
        of_point.push_back(table_.wedge[corner]);
        table_.wedges.push_back(w);
      });
    }
  }

  void mark_features() {
    table_.feature.assign(soup_.n_corners(), 0);
    std::vector<std::pair<Index, Index>> marked = soup_.feature_edges;
    for (auto& [a, b] : marked) {
      if (a > b) std::swap(a, b);
    }
    std::sort(marked.begin(), marked.end());
    for (Index c = 0; c < soup_.n_corners(); ++c) {
      const std::pair<Index, Index> ends = std::minmax(table_.point[c], table_.point[table_.next[c]]);
      table_.feature[c] = std::binary_search(marked.begin(), marked.end(), ends) ? 1 : 0;
    }
  }

  /// Number of fans of faces around a point: its neighbours fall into that many sets when each corner joins
  /// the two beside it.
  std::size_t count_fans(const std::vector<Index>& neighbours, const std::vector<Index>& corners) {
    parents_.resize(neighbours.size());
    std::iota(parents_.begin(), parents_.end(), Index{0});
    const auto root_of = [&](Index q) {
      auto i =
          static_cast<Index>(std::lower_bound(neighbours.begin(), neighbours.end(), q) - neighbours.begin());
      while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
      return i;
    };
    std::size_t fans = neighbours.size();
    for (const Index corner : corners) {
      const Index x = root_of(table_.point[table_.next[corner]]),
                  y = root_of(table_.point[table_.previous(corner)]);
      if (x == y) continue;
      parents_[x] = y;
      --fans;
    }
    return fans;
  }

  void classify_points() {
    table_.classes.assign(soup_.positions.size(), PointClass::smooth);
    std::vector<Index> neighbours, corners;
    for (Index p = 0; p < soup_.positions.size(); ++p) {
      neighbours.clear();
      corners.clear();
      table_.each_corner(p, [&](Index corner) {
        corners.push_back(corner);
        neighbours.push_back(table_.point[table_.next[corner]]);
        neighbours.push_back(table_.point[table_.previous(corner)]);
      });
      if (corners.empty()) continue;
      std::sort(neighbours.begin(), neighbours.end());
      neighbours.erase(std::unique(neighbours.begin(), neighbours.end()), neighbours.end());
      table_.classes[p] = classify(p, neighbours, corners);
    }
  }

  PointClass classify(Index p, const std::vector<Index>& neighbours, const std::vector<Index>& corners) {
    std::array<unsigned, 2> kinds{};
    std::size_t n_creases = 0;
    for (const Index q : neighbours) {
      const unsigned kind = table_.edge_kind(p, q);
      if (kind == k_smooth_edge) continue;
      if (n_creases < 2) kinds[n_creases] = kind;
      ++n_creases;
    }
    if (count_fans(neighbours, corners) > 1) return PointClass::fixed;
    if (n_creases == 0) return PointClass::smooth;
    if (n_creases != 2 || kinds[0] != kinds[1]) return PointClass::fixed;
    if (options_.lock_borders && (kinds[0] & k_border_edge) != 0) return PointClass::fixed;
    return PointClass::crease;
  }

  const PolygonSoup& soup_;
  const CornerTableOptions& options_;
  CornerTable table_;
  std::vector<Index> parents_;
};

}  // namespace

CornerTable build_corner_table(const PolygonSoup& soup, const CornerTableOptions& options) {
  return TableBuilder(soup, options).build();
}

namespace {

Wedge interpolate(const Wedge& at_zero, const Wedge& at_one, double share) {
  Wedge result;
  result.uv = (1 - share) * at_zero.uv + share * at_one.uv;
  result.normal = (1 - share) * at_zero.normal + share * at_one.normal;
  const double length = result.normal.norm();
  if (length > 0) result.normal /= length;
  return result;
}

/// Wedges of the removed point and those of the kept one that they become.
class WedgeMap {
 public:
  WedgeMap(CornerTable& table, const Collapse& collapse) {
    if (table.wedge.empty()) return;
    each_shared_side(table, collapse.removed, collapse.kept, [&](const SharedSide& side) {
      const Index from = table.wedge[side.at_a], to = table.wedge[side.at_b];
      if (size_ == pairs_.size() || find(from) != k_no_index) return;
      pairs_[size_++] = {from, to};
      // At the kept point nothing changes: the bits of its attributes stay.
      if (collapse.share < 1)
        table.wedges[to] = interpolate(table.wedges[from], table.wedges[to], collapse.share);
    });
  }

  /// The kept point's wedge, or k_no_index when no face of the edge has this one.
  Index find(Index from) const {
    for (std::size_t i = 0; i < size_; ++i) {
      if (pairs_[i].first == from) return pairs_[i].second;
    }
    return k_no_index;
  }

 private:
  std::array<std::pair<Index, Index>, 16> pairs_{};  // a wedge for each face of the edge; seams have two
  std::size_t size_ = 0;
};

void kill_corner(CornerTable& table, Index corner) { table.face[corner] = k_no_index; }

/// Marks the sides between `p` and `q` in all faces when one of them is marked.
void spread_feature(CornerTable& table, Index p, Index q) {
  if (table.feature.empty() || (table.edge_kind(p, q) & k_feature_edge) == 0) return;
  each_shared_side(table, p, q, [&](const SharedSide& side) {
    table.feature[table.next[side.at_a] == side.at_b ? side.at_a : side.at_b] = 1;
  });
}

/// Takes the removed point's corner out of a face that has the edge; a triangle goes as a whole.
void shorten_face(CornerTable& table, Index corner, CollapseEffect& effect) {
  const Index f = table.face[corner];
  const Index before = table.previous(corner), after = table.next[corner];
  ++effect.edge_faces;
  if (table.face_size[f] == 3) {
    for (const Index c : {before, corner, after}) kill_corner(table, c);
    table.face_corner[f] = k_no_index;
    --table.n_alive_faces;
    ++effect.removed_faces;
    return;
  }
  table.next[before] = after;
  kill_corner(table, corner);
  table.face_corner[f] = after;
  --table.face_size[f];
  ++effect.lost_sides;
}

}  // namespace

CollapseEffect apply_collapse(CornerTable& table, const Collapse& collapse) {
  const auto [removed, kept, position, share] = collapse;
  CollapseEffect effect;
  const WedgeMap wedges(table, collapse);
  std::array<Index, 16> thirds{};
  std::size_t n_thirds = 0;
  // A face that has the edge is shortened; in every other one the kept point takes the removed one's place.
  const Index start = table.point_corner[removed];
  Index corner = start;
  do {
    const Index following = table.sibling[corner];
    if (table.is_alive(corner)) {
      const Index before = table.previous(corner), after = table.next[corner];
      const bool before_is_kept = table.point[before] == kept, after_is_kept = table.point[after] == kept;
      if (before_is_kept || after_is_kept) {
        if (table.face_size[table.face[corner]] == 3 && n_thirds < thirds.size()) {
          thirds[n_thirds++] = table.point[before_is_kept ? after : before];
        } else if (!table.feature.empty() && before_is_kept) {
          table.feature[before] = table.feature[corner];  // the side kept-removed goes, removed-after stays
        }
        shorten_face(table, corner, effect);
      }
    }
    corner = following;
  } while (corner != start);
  do {
    table.point[corner] = kept;
    if (table.is_alive(corner) && !table.wedge.empty()) {
      const Index to = wedges.find(table.wedge[corner]);
      if (to != k_no_index) table.wedge[corner] = to;
    }
    corner = table.sibling[corner];
  } while (corner != start);
  // Two rings become one by exchanging a link.
  std::swap(table.sibling[start], table.sibling[table.point_corner[kept]]);
  table.point_corner[removed] = k_no_index;
  --table.n_alive_points;
  table.positions[kept] = position;
  if (!table.colors.empty() && share < 1) {
    table.colors[kept] = (1 - share) * table.colors[removed] + share * table.colors[kept];
  }
  table.classes[kept] = std::max(table.classes[kept], table.classes[removed]);
  for (std::size_t i = 0; i < n_thirds; ++i) spread_feature(table, kept, thirds[i]);
  return effect;
}

void unlink_dead_corners(CornerTable& table) {
  for (Index& head : table.point_corner) {
    if (head == k_no_index) continue;
    const Index start = head;
    Index first = k_no_index, last = k_no_index, corner = start;
    do {
      const Index following = table.sibling[corner];
      if (table.is_alive(corner)) {
        if (first == k_no_index) first = corner;
        if (last != k_no_index) table.sibling[last] = corner;
        last = corner;
      }
      corner = following;
    } while (corner != start);
    head = first;
    if (last != k_no_index) table.sibling[last] = first;
    if (first == k_no_index) --table.n_alive_points;
  }
}

PolygonSoup to_soup(const CornerTable& table) {
  PolygonSoup soup;
  std::vector<Index> vertex(table.positions.size(), k_no_index);
  soup.positions.reserve(table.n_alive_points);
  soup.face_offsets.reserve(table.n_alive_faces + 1);
  for (Index f = 0; f < table.face_corner.size(); ++f) {
    if (table.face_corner[f] == k_no_index) continue;
    for (Index c = table.face_corner[f], i = 0; i < table.face_size[f]; ++i, c = table.next[c]) {
      vertex[table.point[c]] = 0;
    }
  }
  for (Index p = 0; p < vertex.size(); ++p) {
    if (vertex[p] == k_no_index) continue;
    vertex[p] = static_cast<Index>(soup.positions.size());
    soup.positions.push_back(table.origin + table.scale * table.positions[p]);
    if (!table.colors.empty()) soup.vertex_colors.push_back(table.colors[p]);
  }
  for (Index f = 0; f < table.face_corner.size(); ++f) {
    if (table.face_corner[f] == k_no_index) continue;
    for (Index c = table.face_corner[f], i = 0; i < table.face_size[f]; ++i, c = table.next[c]) {
      soup.corner_vertices.push_back(vertex[table.point[c]]);
      if (table.has_uvs) soup.corner_uvs.push_back(table.wedges[table.wedge[c]].uv);
      if (table.has_normals) soup.corner_normals.push_back(table.wedges[table.wedge[c]].normal);
      if (table.feature.empty() || table.feature[c] == 0) continue;
      soup.feature_edges.emplace_back(
          std::minmax(vertex[table.point[c]], vertex[table.point[table.next[c]]]));
    }
    soup.face_offsets.push_back(static_cast<Index>(soup.corner_vertices.size()));
    if (!table.face_material.empty()) soup.face_materials.push_back(table.face_material[f]);
  }
  std::sort(soup.feature_edges.begin(), soup.feature_edges.end());
  soup.feature_edges.erase(std::unique(soup.feature_edges.begin(), soup.feature_edges.end()),
                           soup.feature_edges.end());
  soup.materials = table.materials;
  return soup;
}

}  // namespace recede::detail
