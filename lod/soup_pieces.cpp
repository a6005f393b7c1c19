#include <recede/lod/detail/list_bytes.h>
#include <recede/lod/detail/soup_pieces.h>

#include <algorithm>

namespace recede::detail {

PolygonSoup take_faces(const PolygonSoup& soup, std::span<const Index> faces) {
  PolygonSoup result;
  for (const Index f : faces) {
    for (Index c = soup.face_offsets[f]; c < soup.face_offsets[f + 1]; ++c) {
      result.corner_vertices.push_back(soup.corner_vertices[c]);
      if (!soup.corner_uvs.empty()) result.corner_uvs.push_back(soup.corner_uvs[c]);
      if (!soup.corner_normals.empty()) result.corner_normals.push_back(soup.corner_normals[c]);
    }
    result.face_offsets.push_back(static_cast<Index>(result.corner_vertices.size()));
    if (!soup.face_materials.empty()) result.face_materials.push_back(soup.face_materials[f]);
  }
  return result;
}

PolygonSoup cut_out(const PolygonSoup& soup, std::span<const Index> faces, std::vector<Index>& vertices) {
  PolygonSoup result = take_faces(soup, faces);
  vertices = result.corner_vertices;
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (Index& v : result.corner_vertices)
    v = static_cast<Index>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
  for (const VertexScalar& scalar : soup.vertex_scalars) result.vertex_scalars.push_back({scalar.name, {}});
  for (const Index v : vertices) {
    result.positions.push_back(soup.positions[v]);
    if (!soup.vertex_colors.empty()) result.vertex_colors.push_back(soup.vertex_colors[v]);
    for (std::size_t i = 0; i < soup.vertex_scalars.size(); ++i)
      result.vertex_scalars[i].values.push_back(soup.vertex_scalars[i].values[v]);
  }
  return result;
}

namespace {

/// `before` and `added` elements; lists that are empty have none of them.
template <typename Value>
void append_list(std::vector<Value>& list, const std::vector<Value>& more, std::size_t before,
                 std::size_t added, const Value& missing) {
  if (list.empty() && more.empty()) return;
  list.resize(before, missing);
  list.insert(list.end(), more.begin(), more.end());
  list.resize(before + added, missing);
}

}  // namespace

void append(PolygonSoup& soup, const PolygonSoup& more) {
  const std::size_t n_vertices = soup.positions.size(), n_corners = soup.n_corners(),
                    n_faces = soup.n_faces();
  const auto first_vertex = static_cast<Index>(n_vertices), first_corner = static_cast<Index>(n_corners);
  append_list(soup.vertex_colors, more.vertex_colors, n_vertices, more.positions.size(), Vec4(Vec4::Ones()));
  for (const VertexScalar& scalar : more.vertex_scalars) {
    const auto same = [&](const VertexScalar& known) { return known.name == scalar.name; };
    auto known = std::find_if(soup.vertex_scalars.begin(), soup.vertex_scalars.end(), same);
    if (known == soup.vertex_scalars.end())
      known = soup.vertex_scalars.insert(known, {scalar.name, std::vector<double>(n_vertices)});
    known->values.insert(known->values.end(), scalar.values.begin(), scalar.values.end());
  }
  for (VertexScalar& scalar : soup.vertex_scalars) scalar.values.resize(n_vertices + more.positions.size());
  append_list(soup.corner_uvs, more.corner_uvs, n_corners, more.n_corners(), Vec2(Vec2::Zero()));
  append_list(soup.corner_normals, more.corner_normals, n_corners, more.n_corners(), Vec3(Vec3::Zero()));
  append_list(soup.face_materials, more.face_materials, n_faces, more.n_faces(), k_no_index);
  soup.positions.insert(soup.positions.end(), more.positions.begin(), more.positions.end());
  for (const Index v : more.corner_vertices) soup.corner_vertices.push_back(first_vertex + v);
  for (std::size_t f = 1; f < more.face_offsets.size(); ++f)
    soup.face_offsets.push_back(first_corner + more.face_offsets[f]);
  if (soup.materials.size() < more.materials.size()) soup.materials = more.materials;
}

std::string to_bytes(const PolygonSoup& soup) {
  std::string bytes;
  put_list(bytes, soup.positions);
  put_list(bytes, soup.face_offsets);
  put_list(bytes, soup.corner_vertices);
  put_list(bytes, soup.corner_uvs);
  put_list(bytes, soup.corner_normals);
  put_list(bytes, soup.vertex_colors);
  put_list(bytes, soup.face_materials);
  for (const VertexScalar& scalar : soup.vertex_scalars) {
    put_list(bytes, scalar.name);
    put_list(bytes, scalar.values);
  }
  return bytes;
}

PolygonSoup soup_from_bytes(std::string_view bytes) {
  PolygonSoup soup;
  soup.positions = take_list<Vec3>(bytes);
  soup.face_offsets = take_list<Index>(bytes);
  soup.corner_vertices = take_list<Index>(bytes);
  soup.corner_uvs = take_list<Vec2>(bytes);
  soup.corner_normals = take_list<Vec3>(bytes);
  soup.vertex_colors = take_list<Vec4>(bytes);
  soup.face_materials = take_list<Index>(bytes);
  while (!bytes.empty()) {
    const auto name = take_list<char>(bytes);
    soup.vertex_scalars.push_back({std::string(name.begin(), name.end()), take_list<double>(bytes)});
  }
  return soup;
}

}  // namespace recede::detail
