#include <recede/geometry/detail/same_positions.h>
#include <recede/lod/detail/progressive_source.h>
#include <recede/lod/detail/soup_pieces.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <numeric>

namespace recede::detail {
namespace {

/// `scratch` keeps its memory between faces.
bool visits_vertex_twice(std::span<const Index> face, std::vector<Index>& scratch) {
  if (face.size() == 3) return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
  scratch.assign(face.begin(), face.end());
  std::sort(scratch.begin(), scratch.end());
  return std::adjacent_find(scratch.begin(), scratch.end()) != scratch.end();
}

void append_faces(PolygonSoup& soup, const PolygonSoup& more) {
  const auto append = [](auto& list, const auto& values) {
    list.insert(list.end(), values.begin(), values.end());
  };
  for (std::size_t f = 0; f < more.n_faces(); ++f) soup.add_face(more.face(f));
  append(soup.corner_uvs, more.corner_uvs);
  append(soup.corner_normals, more.corner_normals);
  append(soup.face_materials, more.face_materials);
}

template <typename Vector>
bool same_bits(const Vector& a, const Vector& b) {
  return std::memcmp(a.data(), b.data(), sizeof(a)) == 0;
}

}  // namespace

ProgressiveSource::ProgressiveSource(const PolygonSoup& input, ProgressiveMesh& mesh) : input_(input) {
  is_input_ = !weld();
  std::vector<Index> good, bad, scratch;
  for (Index f = 0; f < soup().n_faces(); ++f) {
    (visits_vertex_twice(soup().face(f), scratch) ? bad : good).push_back(f);
  }
  mesh.positions = input.positions;
  mesh.colors = input.vertex_colors;
  mesh.scalars = input.vertex_scalars;
  mesh.materials = input.materials;
  mesh.feature_edges = input.feature_edges;
  mesh.face_offsets = input.face_offsets;
  mesh.face_materials = input.face_materials;
  mesh.corner_vertices = soup().corner_vertices;
  mesh.face_alive.assign(input.n_faces(), 1);
  for (Index c = 0; c < input.n_corners(); ++c) {
    const Index fine = input.corner_vertices[c], coarse = mesh.corner_vertices[c];
    if (fine != coarse) mesh.mending.vertices.push_back({c, fine, coarse});
  }
  if (!bad.empty()) {
    add_mended_faces(bad, mesh);
    face_number_ = good;
    for (auto f = static_cast<Index>(input.n_faces()); f < mesh.n_faces(); ++f) face_number_.push_back(f);
  }
  for (Index f = 0; f < mesh.n_faces(); ++f) {
    corner_face_.insert(corner_face_.end(), mesh.face_offsets[f + 1] - mesh.face_offsets[f], f);
  }
}

/// Gives vertices of faces at one place the lowest of their numbers. False when there is nothing to do.
bool ProgressiveSource::weld() {
  const std::vector<Index> lowest = lowest_at_same_position(input_.positions);
  std::vector<Index> target(lowest.size(),
                            k_no_index);  // by the lowest vertex of all: the lowest that is used
  for (const Index v : input_.corner_vertices) target[lowest[v]] = std::min(target[lowest[v]], v);
  const auto welds = [&](Index v) { return target[lowest[v]] != v; };
  if (std::none_of(input_.corner_vertices.begin(), input_.corner_vertices.end(), welds)) return false;
  mended_ = input_;
  for (Index& v : mended_.corner_vertices) v = target[lowest[v]];
  std::vector<bool> used(lowest.size(), false);
  for (const Index v : input_.corner_vertices) used[v] = true;
  for (auto& [a, b] : mended_.feature_edges) {
    if (used[a]) a = target[lowest[a]];
    if (used[b]) b = target[lowest[b]];
  }
  return true;
}

/// Takes these faces out of the soup and appends what is left of them.
void ProgressiveSource::add_mended_faces(const std::vector<Index>& faces, ProgressiveMesh& mesh) {
  PolygonSoup loops = take_faces(soup(), faces);
  loops.positions = input_.positions;
  remove_degenerate_faces(loops);
  std::vector<Index> others(soup().n_faces());
  std::iota(others.begin(), others.end(), Index{0});
  std::erase_if(others, [&](Index f) { return std::binary_search(faces.begin(), faces.end(), f); });
  PolygonSoup mended = take_faces(soup(), others);
  append_faces(mended, loops);
  mended.positions = input_.positions;
  mended.vertex_colors = input_.vertex_colors;
  mended.vertex_scalars = input_.vertex_scalars;
  mended.materials = input_.materials;
  mended.feature_edges = soup().feature_edges;
  for (const Index f : faces) {
    mesh.mending.fine_faces.push_back(f);
    mesh.face_alive[f] = 0;
  }
  for (std::size_t f = 0; f < loops.n_faces(); ++f) {
    mesh.mending.coarse_faces.push_back(static_cast<Index>(mesh.n_faces()));
    const auto face = loops.face(f);
    mesh.corner_vertices.insert(mesh.corner_vertices.end(), face.begin(), face.end());
    mesh.face_offsets.push_back(static_cast<Index>(mesh.corner_vertices.size()));
    mesh.face_alive.push_back(1);
    if (!loops.face_materials.empty()) mesh.face_materials.push_back(loops.face_materials[f]);
  }
  mended_ = std::move(mended);
  is_input_ = false;
}

void ProgressiveSource::match(const CornerTable& table, ProgressiveMesh& mesh) {
  corner_number_.resize(table.n_corners());
  for (Index f = 0; f < table.n_faces(); ++f) {
    const Index source = table.source_face[f], first = table.face_corner(f);
    const auto face = soup().face(source);
    const Index start = mesh.face_offsets[this->face(source)];
    const Index vertex = table.source_vertex[table.point[first]];
    const auto at = static_cast<std::size_t>(std::find(face.begin(), face.end(), vertex) - face.begin());
    for (std::size_t i = 0; i < face.size(); ++i) {
      corner_number_[first + i] = start + static_cast<Index>((at + i) % face.size());
    }
  }
  if (!table.double_sided.empty()) find_twins(table, mesh.face_offsets);
  if (!table.wedge.empty()) set_wedges(table, mesh);
  if (table.feature.empty()) return;
  mesh.corner_features.assign(mesh.corner_vertices.size(), 0);
  for (Index c = 0; c < table.n_corners(); ++c) mesh.corner_features[corner(c)] = table.feature[c];
}

/// The faces that the table hasn't got are reverses of double-sided ones.
void ProgressiveSource::find_twins(const CornerTable& table, const std::vector<Index>& offsets) {
  twin_corner_.assign(table.n_corners(), k_no_index);
  twin_face_.assign(soup().n_faces(), k_no_index);
  std::vector<bool> has(soup().n_faces(), false);
  for (const Index f : table.source_face) has[f] = true;
  // The material, and the vertices from the lowest on around.
  const auto key = [&](Index f, bool reversed) {
    std::vector<Index> vertices(soup().face(f).begin(), soup().face(f).end());
    if (reversed) std::reverse(vertices.begin(), vertices.end());
    const auto lowest = std::min_element(vertices.begin(), vertices.end()) - vertices.begin();
    std::vector<Index> result{soup().face_materials.empty() ? 0 : soup().face_materials[f]};
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      result.push_back(vertices[(static_cast<std::size_t>(lowest) + i) % vertices.size()]);
    }
    return result;
  };
  std::multimap<std::vector<Index>, Index> reverses;
  for (Index f = 0; f < has.size(); ++f) {
    if (!has[f]) reverses.emplace(key(f, true), f);
  }
  for (Index f = 0; f < table.n_faces(); ++f) {
    if (table.sides(f) == 1) continue;
    const Index source = table.source_face[f];
    const auto found = reverses.find(key(source, false));
    const Index twin = found->second, start = offsets[face(twin)];
    reverses.erase(found);
    twin_face_[source] = face(twin);
    table.each_corner_of_face(f, [&](Index c) {
      const auto corners = soup().face(twin);
      const Index vertex = table.source_vertex[table.point[c]];
      const auto at = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
      twin_corner_[c] = start + static_cast<Index>(at);
    });
  }
}

/// Wedges are those of the table. Corners whose bits differ from theirs get their own in the input.
void ProgressiveSource::set_wedges(const CornerTable& table, ProgressiveMesh& mesh) const {
  const auto add = [&](const Vec2& uv, const Vec3& normal) {
    if (table.has_uvs) mesh.wedge_uvs.push_back(uv);
    if (table.has_normals) mesh.wedge_normals.push_back(normal);
    return static_cast<Index>(std::max(mesh.wedge_uvs.size(), mesh.wedge_normals.size()) - 1);
  };
  for (const Wedge& wedge : table.wedges) add(wedge.uv, wedge.normal);
  mesh.corner_wedges.assign(mesh.corner_vertices.size(), k_no_index);
  for (Index c = 0; c < table.n_corners(); ++c) mesh.corner_wedges[corner(c)] = table.wedge[c];
  for (Index c = 0; c < input_.n_corners(); ++c) {
    const Vec2 uv = table.has_uvs ? input_.corner_uvs[c] : Vec2::Zero();
    const Vec3 normal = table.has_normals ? input_.corner_normals[c] : Vec3::Zero();
    Index& wedge = mesh.corner_wedges[c];
    if (wedge == k_no_index) {  // of a face that was mended
      wedge = add(uv, normal);
      continue;
    }
    const bool same = (!table.has_uvs || same_bits(uv, mesh.wedge_uvs[wedge])) &&
                      (!table.has_normals || same_bits(normal, mesh.wedge_normals[wedge]));
    if (!same) mesh.mending.wedges.push_back({c, add(uv, normal), wedge});
  }
}

}  // namespace recede::detail
