#include <recede/lod/detail/corner_table.h>

#include <oneapi/tbb/parallel_invoke.h>

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
    const Index after = table.next(corner);
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
    const bool runs_along = next(side.at_a) == side.at_b;
    along += runs_along ? 1u : 0u;
    if (!feature.empty() && feature[runs_along ? side.at_a : side.at_b] != 0) kind |= k_feature_edge;
    if (sides == 1) {
      first = side;
      return;
    }
    if (!face_material.empty() && face_material[face(side.at_a)] != face_material[face(first.at_a)]) {
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

/// Marks the sides between `p` and `q` in all faces when one of them is marked.
void spread_feature(CornerTable& table, Index p, Index q) {
  if (table.feature.empty() || (table.edge_kind(p, q) & k_feature_edge) == 0) return;
  each_shared_side(table, p, q, [&](const SharedSide& side) {
    table.feature[table.next(side.at_a) == side.at_b ? side.at_a : side.at_b] = 1;
  });
}

/// Takes the removed point's corner out of a face that has the edge; a triangle goes as a whole.
void shorten_face(CornerTable& table, Index corner, CollapseEffect& effect) {
  const Index f = table.face(corner);
  const Index before = table.previous(corner), after = table.next(corner);
  ++effect.edge_faces;
  if (table.face_size(f) == 3) {
    for (const Index c : {before, corner, after}) table.point[c] = k_no_index;
    if (table.has_polygons) table.loop_size[f] = 0;
    effect.removed_faces += table.sides(f);
    return;
  }
  table.loop_next[before] = after;
  table.point[corner] = k_no_index;
  table.loop_start[f] = after;
  --table.loop_size[f];
  effect.lost_sides += table.sides(f);
}

/// Shortens the faces that have the edge, and gives the removed point's other corners to the kept one.
class RingMerge {
 public:
  RingMerge(CornerTable& table, const Collapse& collapse) : table_(table), collapse_(collapse) {}

  CollapseEffect carry_out() {
    const WedgeMap wedges(table_, collapse_);
    table_.each_corner(collapse_.removed, [&](Index corner) {
      if (!shorten(corner)) give(corner, wedges);
    });
    // Two rings become one by exchanging a link.
    std::swap(table_.merged[collapse_.removed], table_.merged[collapse_.kept]);
    for (std::size_t i = 0; i < n_thirds_; ++i) spread_feature(table_, collapse_.kept, thirds_[i]);
    return effect_;
  }

 private:
  bool shorten(Index corner) {
    const Index before = table_.previous(corner), after = table_.next(corner);
    const bool before_is_kept = table_.point[before] == collapse_.kept,
               after_is_kept = table_.point[after] == collapse_.kept;
    if (!before_is_kept && !after_is_kept) return false;
    if (table_.face_size(table_.face(corner)) == 3) {
      if (n_thirds_ < thirds_.size()) thirds_[n_thirds_++] = table_.point[before_is_kept ? after : before];
    } else if (!table_.feature.empty() && before_is_kept) {
      table_.feature[before] = table_.feature[corner];  // the side kept-removed goes, removed-after stays
    }
    shorten_face(table_, corner, effect_);
    return true;
  }

  void give(Index corner, const WedgeMap& wedges) {
    table_.point[corner] = collapse_.kept;
    if (table_.wedge.empty()) return;
    const Index to = wedges.find(table_.wedge[corner]);
    if (to != k_no_index) table_.wedge[corner] = to;
  }

  CornerTable& table_;
  const Collapse& collapse_;
  CollapseEffect effect_;
  std::array<Index, 16> thirds_{};
  std::size_t n_thirds_ = 0;
};

}  // namespace

CollapseEffect apply_collapse(CornerTable& table, const Collapse& collapse) {
  const auto [removed, kept, position, share] = collapse;
  const CollapseEffect effect = RingMerge(table, collapse).carry_out();
  table.positions[kept] = position;
  if (!table.colors.empty() && share < 1) {
    table.colors[kept] = (1 - share) * table.colors[removed] + share * table.colors[kept];
  }
  for (std::size_t i = 0; i < table.scalar_names.size() && share < 1; ++i) {
    double& value = table.point_scalars(kept)[i];
    value = (1 - share) * table.point_scalars(removed)[i] + share * value;
  }
  table.classes[kept] = std::max(table.classes[kept], table.classes[removed]);
  return effect;
}

namespace {

/// Moves what stays to the front of a list, which then has only that.
template <typename List, typename Stays>
void keep(List& list, Stays&& stays) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (stays(static_cast<Index>(i))) {
      if (size != i) list[size] = list[i];
      ++size;
    }
  }
  list.resize(size);
}

/// New numbers of what stays, in order; k_no_index for what goes.
template <typename Stays>
std::vector<Index> number_what_stays(std::size_t n, Stays&& stays) {
  std::vector<Index> number(n, k_no_index);
  Index next = 0;
  for (Index i = 0; i < n; ++i) {
    if (stays(i)) number[i] = next++;
  }
  return number;
}

void pack_loops(CornerTable& table) {
  const auto corner_number = number_what_stays(table.n_corners(), [&](Index c) { return table.is_alive(c); });
  const auto face_number =
      number_what_stays(table.loop_size.size(), [&](Index f) { return table.loop_size[f] != 0; });
  const auto stays_in = [](const std::vector<Index>& number) {
    return [&number](Index i) { return number[i] != k_no_index; };
  };
  keep(table.loop_next, stays_in(corner_number));
  keep(table.corner_face, stays_in(corner_number));
  keep(table.loop_start, stays_in(face_number));
  keep(table.loop_size, stays_in(face_number));
  for (Index& c : table.loop_next) c = corner_number[c];
  for (Index& f : table.corner_face) f = face_number[f];
  for (Index& c : table.loop_start) c = corner_number[c];
}

/// Takes dead faces and corners out. What tells the dead from the living goes last.
void pack_faces(CornerTable& table) {
  const auto face_stays = [&](Index f) { return table.is_face_alive(f); };
  const auto corner_stays = [&](Index c) { return table.is_alive(c); };
  if (!table.face_material.empty()) keep(table.face_material, face_stays);
  if (!table.double_sided.empty()) keep(table.double_sided, face_stays);
  keep(table.source_face, face_stays);
  if (!table.wedge.empty()) keep(table.wedge, corner_stays);
  if (!table.feature.empty()) keep(table.feature, corner_stays);
  if (!table.source_corner.empty()) keep(table.source_corner, corner_stays);
  if (table.has_polygons) pack_loops(table);
  keep(table.point, corner_stays);
}

/// Names the points that the ends of joins have become; pairs that lost an end, or have become one, go.
void follow_joins(CornerTable& table) {
  const auto what_became_of = [&](Index p) {
    Index point = k_no_index;
    table.each_corner(p, [&](Index corner) { point = table.point[corner]; });
    return point;
  };
  for (PointPair& join : table.joins) {
    const std::pair<Index, Index> ends = std::minmax(what_became_of(join.first), what_became_of(join.second));
    join = {ends.first, ends.second};
  }
  std::erase_if(table.joins,
                [](const PointPair& join) { return join.second == k_no_index || join.first == join.second; });
  std::sort(table.joins.begin(), table.joins.end());
  table.joins.erase(std::unique(table.joins.begin(), table.joins.end()), table.joins.end());
}

/// Completes the rings: `ring_start[p + 1]` holds the number of p's corners.
void fill_rings(CornerTable& table) {
  std::partial_sum(table.ring_start.begin(), table.ring_start.end(), table.ring_start.begin());
  table.ring.resize(table.n_corners());
  // `merged` serves as the places to write to before it gets its own content.
  table.merged.assign(table.ring_start.begin(), table.ring_start.end() - 1);
  for (Index c = 0; c < table.n_corners(); ++c) table.ring[table.merged[table.point[c]]++] = c;
  std::iota(table.merged.begin(), table.merged.end(), Index{0});
}

}  // namespace

void link_rings(CornerTable& table) {
  table.ring_start.assign(table.n_points() + 1, 0);
  for (const Index p : table.point) ++table.ring_start[p + 1];
  fill_rings(table);
}

void pack(CornerTable& table) {
  if (table.n_alive_points == table.n_points()) return;
  follow_joins(table);
  pack_faces(table);
  LargeList<Index>& number = table.merged;  // which loses its content anyway
  std::fill(number.begin(), number.end(), k_no_index);
  for (const Index p : table.point) number[p] = 0;
  Index next = 0;
  for (Index& n : number) {
    if (n != k_no_index) n = next++;
  }
  for (PointPair& join : table.joins) join = {number[join.first], number[join.second]};
  const auto pack_points = [&] {
    const auto stays = [&](Index p) { return number[p] != k_no_index; };
    keep(table.positions, stays);
    keep(table.classes, stays);
    keep(table.deviation, stays);
    keep(table.source_vertex, stays);
    if (!table.held.empty()) keep(table.held, stays);
    if (!table.colors.empty()) keep(table.colors, stays);
    const std::size_t width = table.scalar_names.size();
    if (width > 0) keep(table.scalars, [&](Index i) { return stays(static_cast<Index>(i / width)); });
  };
  const auto pack_corners = [&] {
    table.ring_start.assign(next + 1, 0);
    for (Index& p : table.point) {
      p = number[p];
      ++table.ring_start[p + 1];
    }
  };
  tbb::parallel_invoke(pack_points, pack_corners);
  fill_rings(table);
}

std::vector<Index> fan_triangles(const CornerTable& table) {
  std::vector<Index> triangles;
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (!table.is_face_alive(f)) continue;
    const Index start = table.face_corner(f);
    for (Index c = table.next(start); table.next(c) != start; c = table.next(c)) {
      triangles.insert(triangles.end(), {table.point[start], table.point[c], table.point_after(c)});
    }
  }
  return triangles;
}

PolygonSoup to_soup(const CornerTable& table, const std::vector<Vec3>& source_positions) {
  PolygonSoup soup;
  for (const std::string& name : table.scalar_names) soup.vertex_scalars.push_back({name, {}});
  // In the order of the input.
  std::vector<Index> faces, points;
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (table.is_face_alive(f)) faces.push_back(f);
  }
  std::sort(faces.begin(), faces.end(), [&](Index f, Index g) {
    return std::pair(table.source_face[f], f) < std::pair(table.source_face[g], g);
  });
  std::vector<Index> vertex(table.n_points(), k_no_index);
  for (const Index f : faces) table.each_corner_of_face(f, [&](Index c) { vertex[table.point[c]] = 0; });
  for (Index p = 0; p < table.n_points(); ++p) {
    if (vertex[p] == 0) points.push_back(p);
  }
  std::sort(points.begin(), points.end(),
            [&](Index p, Index q) { return table.source_vertex[p] < table.source_vertex[q]; });
  soup.positions.reserve(points.size());
  for (const Index p : points) {
    vertex[p] = static_cast<Index>(soup.positions.size());
    const Vec3& source = source_positions[table.source_vertex[p]];
    const bool unmoved = (source - table.origin) / table.scale == table.positions[p];
    soup.positions.push_back(unmoved ? source : Vec3(table.origin + table.scale * table.positions[p]));
    if (!table.colors.empty()) soup.vertex_colors.push_back(table.colors[p]);
    for (std::size_t i = 0; i < table.scalar_names.size(); ++i) {
      soup.vertex_scalars[i].values.push_back(table.point_scalars(p)[i]);
    }
  }
  soup.face_offsets.reserve(faces.size() + 1);
  const auto close_face = [&](Index f) {
    soup.face_offsets.push_back(static_cast<Index>(soup.corner_vertices.size()));
    if (!table.face_material.empty()) soup.face_materials.push_back(table.face_material[f]);
  };
  for (const Index f : faces) {
    table.each_corner_of_face(f, [&](Index c) {
      soup.corner_vertices.push_back(vertex[table.point[c]]);
      if (table.has_uvs) soup.corner_uvs.push_back(table.wedges[table.wedge[c]].uv);
      if (table.has_normals) soup.corner_normals.push_back(table.wedges[table.wedge[c]].normal);
      if (table.feature.empty() || table.feature[c] == 0) return;
      soup.feature_edges.emplace_back(std::minmax(vertex[table.point[c]], vertex[table.point_after(c)]));
    });
    close_face(f);
    if (table.sides(f) == 1) continue;
    const std::size_t size = table.face_size(f), end = soup.corner_vertices.size();
    for (std::size_t i = 1; i <= size; ++i) soup.corner_vertices.push_back(soup.corner_vertices[end - i]);
    close_face(f);
  }
  std::sort(soup.feature_edges.begin(), soup.feature_edges.end());
  soup.feature_edges.erase(std::unique(soup.feature_edges.begin(), soup.feature_edges.end()),
                           soup.feature_edges.end());
  soup.materials = table.materials;
  return soup;
}

}  // namespace recede::detail
