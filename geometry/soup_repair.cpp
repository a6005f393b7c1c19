// The named repair steps. Each works on the whole soup, keeps attribute lists in step and reports what it
// changed.
#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/detail/same_positions.h>
#include <recede/geometry/polygon_soup.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

namespace recede {
namespace {

/// Keeps the listed corners and faces of every attribute list.
/// `corners` are old corner numbers in new order; `offsets` are the new face offsets; `faces` the old face of
/// each new one.
void keep_corners(PolygonSoup& soup, const std::vector<Index>& corners, std::vector<Index> offsets,
                  const std::vector<Index>& faces) {
  const auto gather = [](auto& list, const std::vector<Index>& from) {
    if (list.empty()) return;
    std::remove_reference_t<decltype(list)> kept;
    kept.reserve(from.size());
    for (const Index i : from) kept.push_back(list[i]);
    list = std::move(kept);
  };
  gather(soup.corner_vertices, corners);
  gather(soup.corner_uvs, corners);
  gather(soup.corner_normals, corners);
  gather(soup.face_materials, faces);
  soup.face_offsets = std::move(offsets);
}

/// Feature edges as sorted, unique pairs between different vertices.
void tidy_feature_edges(PolygonSoup& soup) {
  for (auto& [a, b] : soup.feature_edges) {
    if (a > b) std::swap(a, b);
  }
  std::erase_if(soup.feature_edges, [](const auto& edge) { return edge.first == edge.second; });
  std::sort(soup.feature_edges.begin(), soup.feature_edges.end());
  soup.feature_edges.erase(std::unique(soup.feature_edges.begin(), soup.feature_edges.end()),
                           soup.feature_edges.end());
}

/// Bits of a coordinate with -0 as 0, so that equal numbers have equal bits.
std::uint64_t coordinate_bits(double value) { return std::bit_cast<std::uint64_t>(value + 0.0); }

std::uint64_t hash_position(const Vec3& p) {
  std::uint64_t hash = 0x9e3779b97f4a7c15u;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= coordinate_bits(p[axis]);
    hash *= 0xff51afd7ed558ccdu;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace

std::vector<Index> detail::lowest_at_same_position(const std::vector<Vec3>& positions) {
  const std::size_t capacity = std::bit_ceil(2 * positions.size() + 1);
  std::vector<Index> slots(capacity, k_no_index);
  std::vector<Index> lowest(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    std::size_t slot = hash_position(positions[v]) & (capacity - 1);
    while (slots[slot] != k_no_index && positions[slots[slot]] != positions[v])
      slot = (slot + 1) & (capacity - 1);
    if (slots[slot] == k_no_index) slots[slot] = static_cast<Index>(v);
    lowest[v] = slots[slot];
  }
  return lowest;
}

namespace {

using detail::lowest_at_same_position;

/// Renumbers vertices: `kept[v]` says whether v stays, `target[v]` which kept vertex stands for v.
void renumber_vertices(PolygonSoup& soup, const std::vector<Index>& target, const std::vector<bool>& kept) {
  std::vector<Index> number(soup.positions.size(), k_no_index);
  Index next = 0;
  for (std::size_t v = 0; v < kept.size(); ++v) {
    if (!kept[v]) continue;
    soup.positions[next] = soup.positions[v];
    if (!soup.vertex_colors.empty()) soup.vertex_colors[next] = soup.vertex_colors[v];
    for (VertexScalar& scalar : soup.vertex_scalars) scalar.values[next] = scalar.values[v];
    number[v] = next++;
  }
  soup.positions.resize(next);
  if (!soup.vertex_colors.empty()) soup.vertex_colors.resize(next);
  for (VertexScalar& scalar : soup.vertex_scalars) scalar.values.resize(next);
  for (Index& v : soup.corner_vertices) v = number[target[v]];
  for (auto& [a, b] : soup.feature_edges) {
    a = number[target[a]];
    b = number[target[b]];
  }
  tidy_feature_edges(soup);
}

/// Splits a closed walk over vertices into loops that visit no vertex twice; repeated neighbours vanish.
/// Entries are corner numbers; loops shorter than three corners are left out.
void split_into_simple_loops(const PolygonSoup& soup, std::size_t face,
                             std::vector<std::vector<Index>>& loops) {
  std::vector<Index> walk;
  for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c) {
    const Index vertex = soup.corner_vertices[c];
    const auto seen = std::find_if(walk.begin(), walk.end(),
                                   [&](Index earlier) { return soup.corner_vertices[earlier] == vertex; });
    if (seen != walk.end()) {
      if (walk.end() - seen >= 3) loops.emplace_back(seen, walk.end());
      walk.erase(seen + 1, walk.end());
    } else {
      walk.push_back(c);
    }
  }
  if (walk.size() >= 3) loops.push_back(std::move(walk));
}

bool visits_vertex_twice(std::span<const Index> face) {
  for (std::size_t i = 0; i < face.size(); ++i) {
    for (std::size_t j = i + 1; j < face.size(); ++j) {
      if (face[i] == face[j]) return true;
    }
  }
  return false;
}

/// The vertices of a face from its lowest one on: equal for faces that are the same up to their starting
/// corner.
std::vector<Index> rotated_to_lowest(std::span<const Index> face) {
  std::vector<Index> vertices(face.begin(), face.end());
  std::rotate(vertices.begin(), std::min_element(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

}  // namespace

RepairStep merge_identical_vertices(PolygonSoup& soup) {
  RepairStep step{"merge_identical_vertices", 0, ""};
  const std::vector<Index> target = lowest_at_same_position(soup.positions);
  std::vector<bool> kept(target.size());
  std::size_t recoloured = 0, rescaled = 0;
  for (std::size_t v = 0; v < target.size(); ++v) {
    kept[v] = target[v] == v;
    if (kept[v]) continue;
    ++step.changed;
    if (!soup.vertex_colors.empty() && soup.vertex_colors[v] != soup.vertex_colors[target[v]]) ++recoloured;
    rescaled += std::any_of(soup.vertex_scalars.begin(), soup.vertex_scalars.end(),
                            [&](const VertexScalar& s) { return s.values[v] != s.values[target[v]]; })
                    ? 1u
                    : 0u;
  }
  if (step.changed == 0) return step;
  renumber_vertices(soup, target, kept);
  step.detail = fmt::format("merged {} vertices into others at the same position", step.changed);
  if (recoloured > 0)
    step.detail += fmt::format("; {} of them had another colour, which is lost", recoloured);
  if (rescaled > 0) step.detail += fmt::format("; {} of them had another scalar, which is lost", rescaled);
  return step;
}

RepairStep remove_degenerate_faces(PolygonSoup& soup) {
  RepairStep step{"remove_degenerate_faces", 0, ""};
  std::vector<Index> corners, offsets{0}, faces;
  corners.reserve(soup.n_corners());
  std::size_t removed = 0, split = 0, shortened = 0;
  std::vector<std::vector<Index>> loops;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    if (!visits_vertex_twice(soup.face(f))) {
      for (Index c = soup.face_offsets[f]; c < soup.face_offsets[f + 1]; ++c) corners.push_back(c);
      offsets.push_back(static_cast<Index>(corners.size()));
      faces.push_back(static_cast<Index>(f));
      continue;
    }
    loops.clear();
    split_into_simple_loops(soup, f, loops);
    removed += loops.empty() ? 1u : 0u;
    shortened += loops.size() == 1 ? 1u : 0u;
    split += loops.size() > 1 ? 1u : 0u;
    for (const auto& loop : loops) {
      corners.insert(corners.end(), loop.begin(), loop.end());
      offsets.push_back(static_cast<Index>(corners.size()));
      faces.push_back(static_cast<Index>(f));
    }
  }
  step.changed = removed + split + shortened;
  if (step.changed == 0) return step;
  keep_corners(soup, corners, std::move(offsets), faces);
  step.detail = fmt::format(
      "removed {} faces with fewer than 3 different vertices, shortened {}, split {} that "
      "visit a vertex twice",
      removed, shortened, split);
  return step;
}

RepairStep remove_duplicate_faces(PolygonSoup& soup) {
  RepairStep step{"remove_duplicate_faces", 0, ""};
  // Faces with equal keys are compared in full; the key is the sum of hashed vertices, whatever their order.
  const auto key_of = [&](std::size_t f) {
    std::uint64_t key = soup.face_size(f);
    for (const Index v : soup.face(f)) {
      std::uint64_t hash = (v + 1) * 0x9e3779b97f4a7c15u;
      hash ^= hash >> 29;
      key += hash * 0xbf58476d1ce4e5b9u;
    }
    return key;
  };
  std::vector<std::pair<std::uint64_t, Index>> keys(soup.n_faces());
  for (std::size_t f = 0; f < keys.size(); ++f) keys[f] = {key_of(f), static_cast<Index>(f)};
  std::sort(keys.begin(), keys.end());
  std::vector<bool> duplicate(soup.n_faces(), false);
  for (std::size_t i = 0; i < keys.size();) {
    std::size_t end = i + 1;
    while (end < keys.size() && keys[end].first == keys[i].first) ++end;
    for (std::size_t k = i + 1; k < end; ++k) {
      for (std::size_t j = i; j < k && !duplicate[keys[k].second]; ++j) {
        if (duplicate[keys[j].second]) continue;
        duplicate[keys[k].second] =
            rotated_to_lowest(soup.face(keys[k].second)) == rotated_to_lowest(soup.face(keys[j].second));
      }
      if (duplicate[keys[k].second]) ++step.changed;
    }
    i = end;
  }
  if (step.changed == 0) return step;
  std::vector<Index> corners, offsets{0}, faces;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    if (duplicate[f]) continue;
    for (Index c = soup.face_offsets[f]; c < soup.face_offsets[f + 1]; ++c) corners.push_back(c);
    offsets.push_back(static_cast<Index>(corners.size()));
    faces.push_back(static_cast<Index>(f));
  }
  keep_corners(soup, corners, std::move(offsets), faces);
  step.detail = fmt::format("removed {} faces that repeat an earlier one", step.changed);
  return step;
}

RepairStep remove_unreferenced_vertices(PolygonSoup& soup) {
  RepairStep step{"remove_unreferenced_vertices", 0, ""};
  std::vector<bool> kept(soup.positions.size(), false);
  for (const Index v : soup.corner_vertices) kept[v] = true;
  for (const auto& [a, b] : soup.feature_edges) kept[a] = kept[b] = true;
  step.changed = static_cast<std::size_t>(std::count(kept.begin(), kept.end(), false));
  if (step.changed == 0) return step;
  std::vector<Index> target(soup.positions.size());
  std::iota(target.begin(), target.end(), Index{0});
  renumber_vertices(soup, target, kept);
  step.detail = fmt::format("removed {} vertices that no face uses", step.changed);
  return step;
}

namespace {

/// Faces connected over two-sided edges, walked breadth-first; `flip` says relative to the first face of the
/// part.
struct OrientationWalk {
  const PolygonSoup& soup;
  const detail::EdgeTable& edges;
  std::vector<signed char> flip;  // -1: not visited

  /// True when both sides run the same way, that is, when the two faces disagree.
  bool sides_disagree(Index first, Index second) const {
    return soup.corner_vertices[first] == soup.corner_vertices[second];
  }

  /// Visits the part of `seed`; returns its faces.
  std::vector<Index> visit_part(Index seed) {
    std::vector<Index> part{seed};
    flip[seed] = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      const Index face = part[i];
      for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c) {
        const auto sides = edges.sides(edges.edge_of_corner[c]);
        if (sides.size() != 2) continue;
        const Index other = sides[0] == c ? sides[1] : sides[0];
        const Index neighbour = edges.corner_faces[other];
        if (flip[neighbour] >= 0) continue;
        flip[neighbour] = static_cast<signed char>(flip[face] ^ (sides_disagree(c, other) ? 1 : 0));
        part.push_back(neighbour);
      }
    }
    return part;
  }
};

/// Reverses a face but keeps its first corner first.
void reverse_face(PolygonSoup& soup, Index face) {
  const auto first = soup.face_offsets[face] + 1, last = soup.face_offsets[face + 1];
  const auto reverse = [&](auto& list) {
    if (!list.empty()) std::reverse(list.begin() + first, list.begin() + last);
  };
  reverse(soup.corner_vertices);
  reverse(soup.corner_uvs);
  reverse(soup.corner_normals);
}

}  // namespace

RepairStep orient_consistently(PolygonSoup& soup) {
  RepairStep step{"orient_consistently", 0, ""};
  const detail::EdgeTable edges = detail::build_edge_table(soup);
  OrientationWalk walk{soup, edges, std::vector<signed char>(soup.n_faces(), -1)};
  std::vector<Index> to_flip;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    if (walk.flip[f] >= 0) continue;
    const std::vector<Index> part = walk.visit_part(static_cast<Index>(f));
    const auto flipped = static_cast<std::size_t>(
        std::count_if(part.begin(), part.end(), [&](Index face) { return walk.flip[face] == 1; }));
    const signed char minority = 2 * flipped > part.size() ? 0 : 1;
    for (const Index face : part) {
      if (walk.flip[face] == minority) to_flip.push_back(face);
    }
  }
  for (const Index face : to_flip) reverse_face(soup, face);
  step.changed = to_flip.size();
  if (step.changed > 0)
    step.detail = fmt::format("turned over {} faces to agree with their neighbours", step.changed);
  return step;
}

}  // namespace recede
