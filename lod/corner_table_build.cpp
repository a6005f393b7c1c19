// From a soup to the flat table: points along a space-filling curve, faces by their points, attributes,
// classes.
#include <recede/lod/detail/corner_table.h>
#include <recede/lod/detail/point_classifier.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <numeric>

namespace recede::detail {
namespace {

/// Places on each axis of the curve's grid: 21 bits, so that three axes fit in 64.
constexpr double k_curve_cells = 2097151;

/// Every third bit of the result is one of `value`, which has 21.
std::uint64_t spread_bits(std::uint64_t value) {
  value = (value | value << 32) & 0x001f00000000ffffu;
  value = (value | value << 16) & 0x001f0000ff0000ffu;
  value = (value | value << 8) & 0x100f00f00f00f00fu;
  value = (value | value << 4) & 0x10c30c30c30c30c3u;
  return (value | value << 2) & 0x1249249249249249u;
}

/// Place on the Z-order curve of a position in the unit box around 0.
std::uint64_t place_on_curve(const Vec3& position) {
  std::uint64_t place = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double cell = std::clamp(position[axis] + 0.5, 0.0, 1.0) * k_curve_cells;
    place |= spread_bits(static_cast<std::uint64_t>(cell)) << axis;
  }
  return place;
}

struct PlacedVertex {
  std::uint64_t place;
  Index vertex;
};

/// Builds the table in the order of its parts: points, faces, rings, attributes, classes.
class TableBuilder {
 public:
  TableBuilder(const PolygonSoup& soup, const CornerTableOptions& options) : soup_(soup), options_(options) {
    set_points();
  }

  /// True when a face has two corners at one point; then there is no table.
  bool visits_a_point_twice() const;
  /// The lowest of the vertices at each vertex's place, `k_no_index` where no face uses it.
  std::vector<Index> representatives() const;

  CornerTable build() {
    set_faces();
    table_.n_alive_points = table_.n_points();
    table_.n_alive_faces = table_.n_faces();
    for (const unsigned char twice : table_.double_sided) table_.n_alive_faces += twice;
    if (!soup_.feature_edges.empty()) mark_features();
    // Lists that are done with lend their memory to those that come.
    table_.merged = std::move(vertex_point_);
    table_.ring = std::move(turned_);
    link_rings(table_);
    if (table_.has_uvs || table_.has_normals) make_wedges();
    classify_points();
    table_.deviation.assign(table_.n_points(), 0);
    return std::move(table_);
  }

 private:
  void set_points();
  void turn_faces();
  void merge_reverses();
  LargeList<Index> order_of_faces();
  void set_faces();
  void set_loops();
  Wedge corner_wedge(Index source_corner) const;
  bool differ(const Wedge& x, const Wedge& y) const;
  void make_wedges();
  void mark_features();
  void classify_points();

  const PolygonSoup& soup_;
  const CornerTableOptions& options_;
  CornerTable table_;
  LargeList<Index> vertex_point_;    // by vertex; k_no_index: no face uses it
  LargeList<Index> source_corner_;   // by corner; only with attributes
  LargeList<Index> turned_;          // points of the faces from the lowest on around, in the input's order
  std::vector<Index> turned_start_;  // by face of the input: where the lowest stands; only with attributes
};

void TableBuilder::set_points() {
  Box3 box;
  for (const Index v : soup_.corner_vertices) box.extend(soup_.positions[v]);
  if (!box.isEmpty()) {
    table_.origin = box.center();
    table_.scale = box.sizes().maxCoeff();
  }
  if (!(table_.scale > 0)) table_.scale = 1;
  const auto unit = [&](Index v) -> Vec3 { return (soup_.positions[v] - table_.origin) / table_.scale; };
  vertex_point_.assign(soup_.positions.size(), k_no_index);
  for (const Index v : soup_.corner_vertices) vertex_point_[v] = 0;
  LargeList<PlacedVertex> order;
  order.reserve(soup_.positions.size());
  for (Index v = 0; v < vertex_point_.size(); ++v) {
    if (vertex_point_[v] == 0) order.push_back({0, v});
  }
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), 4096), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      order[i].place = place_on_curve(unit(order[i].vertex));
    }
  });
  const auto position = [&](const PlacedVertex& x) -> const Vec3& { return soup_.positions[x.vertex]; };
  tbb::parallel_sort(order.begin(), order.end(), [&](const PlacedVertex& x, const PlacedVertex& y) {
    if (x.place != y.place) return x.place < y.place;
    const Vec3 &p = position(x), &q = position(y);
    if (p != q) return std::lexicographical_compare(p.data(), p.data() + 3, q.data(), q.data() + 3);
    return x.vertex < y.vertex;
  });
  table_.source_vertex.reserve(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new =
        i == 0 || order[i].place != order[i - 1].place || position(order[i]) != position(order[i - 1]);
    if (is_new) table_.source_vertex.push_back(order[i].vertex);
    vertex_point_[order[i].vertex] = static_cast<Index>(table_.source_vertex.size() - 1);
  }
  table_.positions.resize(table_.source_vertex.size());
  if (!soup_.vertex_colors.empty()) table_.colors.resize(table_.positions.size());
  for (const VertexScalar& scalar : soup_.vertex_scalars) table_.scalar_names.push_back(scalar.name);
  table_.scalars.resize(table_.positions.size() * table_.scalar_names.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, table_.n_points(), 4096), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p) {
      table_.positions[p] = unit(table_.source_vertex[p]);
      if (!table_.colors.empty()) table_.colors[p] = soup_.vertex_colors[table_.source_vertex[p]];
      for (std::size_t i = 0; i < table_.scalar_names.size(); ++i) {
        table_.point_scalars(static_cast<Index>(p))[i] =
            soup_.vertex_scalars[i].values[table_.source_vertex[p]];
      }
    }
  });
}

bool TableBuilder::visits_a_point_twice() const {
  std::vector<Index> points;
  for (std::size_t f = 0; f < soup_.n_faces(); ++f) {
    const auto face = soup_.face(f);
    if (face.size() == 3) {
      const Index a = vertex_point_[face[0]], b = vertex_point_[face[1]], c = vertex_point_[face[2]];
      if (a == b || b == c || c == a) return true;
      continue;
    }
    points.clear();
    for (const Index v : face) points.push_back(vertex_point_[v]);
    std::sort(points.begin(), points.end());
    if (std::adjacent_find(points.begin(), points.end()) != points.end()) return true;
  }
  return false;
}

std::vector<Index> TableBuilder::representatives() const {
  std::vector<Index> result(vertex_point_.size(), k_no_index);
  for (std::size_t v = 0; v < result.size(); ++v) {
    if (vertex_point_[v] != k_no_index) result[v] = table_.source_vertex[vertex_point_[v]];
  }
  return result;
}

/// The points of every face, from the lowest on around, in the order of the input; and that start.
void TableBuilder::turn_faces() {
  turned_.resize(soup_.n_corners());
  if (table_.has_uvs || table_.has_normals) turned_start_.resize(soup_.n_faces());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, soup_.n_faces(), 4096), [&](const auto& range) {
    for (std::size_t f = range.begin(); f < range.end(); ++f) {
      const auto face = soup_.face(f);
      std::size_t at = 0;
      for (std::size_t i = 1; i < face.size(); ++i) {
        if (vertex_point_[face[i]] < vertex_point_[face[at]]) at = i;
      }
      if (!turned_start_.empty()) turned_start_[f] = static_cast<Index>(at);
      Index* to = turned_.data() + soup_.face_offsets[f];
      for (std::size_t i = at; i < face.size(); ++i) *to++ = vertex_point_[face[i]];
      for (std::size_t i = 0; i < at; ++i) *to++ = vertex_point_[face[i]];
    }
  });
}

/// Faces sorted by their points, from the lowest on around; equal ones by number.
LargeList<Index> TableBuilder::order_of_faces() {
  const auto points = [&](Index f) {
    return std::span(turned_.data() + soup_.face_offsets[f], soup_.face_size(f));
  };
  LargeList<Index>& start = table_.ring_start;  // whose content comes later
  start.assign(table_.n_points() + 1, 0);
  for (Index f = 0; f < soup_.n_faces(); ++f) ++start[points(f)[0] + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  LargeList<Index> order(soup_.n_faces());
  for (Index f = 0; f < soup_.n_faces(); ++f)
    order[start[points(f)[0]]++] = f;  // now start[p] is the end of p
  const auto comes_first = [&](Index f, Index g) {
    const auto a = points(f), b = points(g);
    const auto [x, y] = std::mismatch(a.begin(), a.end(), b.begin(), b.end());
    if (x != a.end() && y != b.end()) return *x < *y;
    return a.size() != b.size() ? a.size() < b.size() : f < g;
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, table_.n_points(), 4096), [&](const auto& range) {
    for (std::size_t p = range.begin(); p < range.end(); ++p) {
      const auto first = order.begin() + (p == 0 ? 0 : start[p - 1]);
      std::sort(first, order.begin() + start[p], comes_first);
    }
  });
  return order;
}

/// A face and its reverse become one face with two sides, so that a sheet is a surface with a border and not
/// a flat bag without an inside.
void TableBuilder::merge_reverses() {
  LargeList<Index>& order = table_.source_face;
  const auto points = [&](Index f) {
    return std::span(turned_.data() + soup_.face_offsets[f], soup_.face_size(f));
  };
  const auto material = [&](Index f) {
    return soup_.face_materials.empty() ? k_no_index : soup_.face_materials[f];
  };
  const auto are_reverse = [&](Index f, Index g) {
    const auto a = points(f), b = points(g);
    return a.size() == b.size() && material(f) == material(g) &&
           std::equal(a.begin() + 1, a.end(), b.rbegin());
  };
  // The faces with one lowest point stand together; those with one pair of neighbours of it can be reverses.
  struct Key {
    Index low, high, at;
    auto operator<=>(const Key&) const = default;
  };
  std::vector<Key> keys;
  const auto visit_pairs = [&](Index first, Index last, auto&& visit) {
    keys.clear();
    for (Index i = first; i < last; ++i) {
      const auto face = points(order[i]);
      const auto [low, high] = std::minmax(face[1], face.back());
      keys.push_back({low, high, i});
    }
    std::sort(keys.begin(), keys.end());
    for (std::size_t k = 0; k < keys.size(); ++k) {
      for (std::size_t l = k + 1; l < keys.size(); ++l) {
        if (keys[l].low != keys[k].low || keys[l].high != keys[k].high) break;
        visit(keys[k].at, keys[l].at);
      }
    }
  };
  LargeList<unsigned char> sides;  // 0: gone, 1, 2
  for (std::size_t p = 0; p < table_.n_points(); ++p) {
    const Index first = p == 0 ? 0 : table_.ring_start[p - 1], last = table_.ring_start[p];
    if (last - first < 2) continue;
    visit_pairs(first, last, [&](Index i, Index j) {
      if (!are_reverse(order[i], order[j])) return;
      if (sides.empty()) sides.assign(order.size(), 1);
      if (sides[i] != 1 || sides[j] != 1) return;
      // The earlier one of the input stays: its neighbours are oriented like it.
      const bool first_is_earlier = order[i] < order[j];
      sides[first_is_earlier ? i : j] = 2;
      sides[first_is_earlier ? j : i] = 0;
    });
  }
  if (sides.empty()) return;
  std::size_t n = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (sides[i] == 0) continue;
    order[n] = order[i];
    sides[n++] = sides[i];
  }
  order.resize(n);
  for (unsigned char& count : sides) count = count == 2 ? 1 : 0;
  sides.resize(n);
  table_.double_sided = std::move(sides);
}

void TableBuilder::set_faces() {
  table_.has_uvs = !soup_.corner_uvs.empty();
  table_.has_normals = !soup_.corner_normals.empty();
  turn_faces();
  table_.source_face = order_of_faces();
  const bool with_attributes = table_.has_uvs || table_.has_normals;
  if (!with_attributes) merge_reverses();
  std::size_t n_corners = 0;
  for (const Index f : table_.source_face) n_corners += soup_.face_size(f);
  table_.point.resize(n_corners);
  table_.has_polygons = soup_.n_corners() != 3 * soup_.n_faces();
  if (table_.has_polygons) set_loops();
  if (with_attributes) source_corner_.resize(soup_.n_corners());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, table_.n_faces(), 4096), [&](const auto& range) {
    for (std::size_t f = range.begin(); f < range.end(); ++f) {
      const Index source = table_.source_face[f], first = soup_.face_offsets[source];
      const auto size = static_cast<Index>(soup_.face_size(source));
      const Index corner = table_.face_corner(static_cast<Index>(f));
      std::copy_n(turned_.begin() + first, size, table_.point.begin() + corner);
      if (!with_attributes) continue;
      for (Index i = 0; i < size; ++i) {
        source_corner_[corner + i] = first + (turned_start_[source] + i) % size;
      }
    }
  });
  if (!soup_.face_materials.empty()) {
    for (const Index f : table_.source_face) table_.face_material.push_back(soup_.face_materials[f]);
  }
  table_.materials = soup_.materials;
}

void TableBuilder::set_loops() {
  table_.loop_next.resize(table_.n_corners());
  table_.corner_face.resize(table_.n_corners());
  Index corner = 0;
  for (Index f = 0; f < table_.n_faces(); ++f) {
    const auto size = static_cast<Index>(soup_.face_size(table_.source_face[f]));
    table_.loop_start.push_back(corner);
    table_.loop_size.push_back(size);
    for (Index i = 0; i < size; ++i, ++corner) {
      table_.corner_face[corner] = f;
      table_.loop_next[corner] = i + 1 == size ? corner + 1 - size : corner + 1;
    }
  }
}

Wedge TableBuilder::corner_wedge(Index source_corner) const {
  Wedge w;
  if (table_.has_uvs) w.uv = soup_.corner_uvs[source_corner];
  if (table_.has_normals) w.normal = soup_.corner_normals[source_corner];
  return w;
}

/// True when a seam between the two would have to be kept.
bool TableBuilder::differ(const Wedge& x, const Wedge& y) const {
  return (options_.keep_uv_seams && x.uv != y.uv) || (options_.keep_normal_seams && x.normal != y.normal);
}

/// Corners of one point share a wedge when they agree in all that has to be kept.
void TableBuilder::make_wedges() {
  table_.wedge.assign(table_.n_corners(), k_no_index);
  std::vector<Index> of_point;
  for (Index p = 0; p < table_.n_points(); ++p) {
    of_point.clear();
    table_.each_corner(p, [&](Index corner) {
      const Wedge w = corner_wedge(source_corner_[corner]);
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

void TableBuilder::mark_features() {
  std::vector<std::pair<Index, Index>> marked;
  for (const auto& [v, w] : soup_.feature_edges) {
    const Index a = vertex_point_[v], b = vertex_point_[w];
    if (a != k_no_index && b != k_no_index) marked.emplace_back(std::minmax(a, b));
  }
  std::sort(marked.begin(), marked.end());
  table_.feature.assign(table_.n_corners(), 0);
  for (Index c = 0; c < table_.n_corners(); ++c) {
    const std::pair<Index, Index> ends = std::minmax(table_.point[c], table_.point_after(c));
    table_.feature[c] = std::binary_search(marked.begin(), marked.end(), ends) ? 1 : 0;
  }
}

void TableBuilder::classify_points() {
  table_.classes.assign(table_.n_points(), PointClass::smooth);
  tbb::parallel_for(tbb::blocked_range<Index>(0, static_cast<Index>(table_.n_points()), 4096),
                    [&](const auto& range) {
                      PointClassifier classifier(table_, options_.lock_borders);
                      for (Index p = range.begin(); p < range.end(); ++p) {
                        table_.classes[p] = classifier.classify(p);
                      }
                    });
}

}  // namespace

CornerTable build_corner_table(const PolygonSoup& soup, const CornerTableOptions& options) {
  TableBuilder builder(soup, options);
  if (!builder.visits_a_point_twice()) return builder.build();
  // Rare: the faces are mended on a copy, whose vertices keep their numbers.
  const std::vector<Index> representatives = builder.representatives();
  PolygonSoup mended = soup;
  for (Index& v : mended.corner_vertices) v = representatives[v];
  for (auto& [v, w] : mended.feature_edges) {
    if (representatives[v] != k_no_index) v = representatives[v];
    if (representatives[w] != k_no_index) w = representatives[w];
  }
  remove_degenerate_faces(mended);
  return TableBuilder(mended, options).build();
}

}  // namespace recede::detail
