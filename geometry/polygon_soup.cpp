#include <recede/geometry/error.h>
#include <recede/geometry/polygon_soup.h>

#include <fmt/format.h>

namespace recede {

void PolygonSoup::add_face(std::span<const Index> vertices) {
  corner_vertices.insert(corner_vertices.end(), vertices.begin(), vertices.end());
  face_offsets.push_back(static_cast<Index>(corner_vertices.size()));
}

std::size_t RepairReport::total_changed() const {
  std::size_t total = 0;
  for (const RepairStep& step : steps) total += step.changed;
  return total;
}

namespace {

void check_length(const std::string& source, const char* what, std::size_t length, std::size_t expected) {
  if (length == 0 || length == expected) return;
  throw InputError::in_file(source, fmt::format("{} {} for {} elements", length, what, expected));
}

void check_faces(const PolygonSoup& soup, const std::string& source) {
  if (soup.face_offsets.empty() || soup.face_offsets.front() != 0 ||
      soup.face_offsets.back() != soup.n_corners()) {
    throw InputError::in_file(source, "face offsets don't span the corners");
  }
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    if (soup.face_offsets[f + 1] < soup.face_offsets[f] + 3) {
      throw InputError::in_file(source, fmt::format("face {} has fewer than 3 corners", f));
    }
  }
  for (std::size_t c = 0; c < soup.n_corners(); ++c) {
    if (soup.corner_vertices[c] >= soup.positions.size()) {
      throw InputError::in_file(source, fmt::format("corner {} names vertex {}, but there are {}", c,
                                                    soup.corner_vertices[c], soup.positions.size()));
    }
  }
}

template <typename Vector>
void check_finite(const std::vector<Vector>& values, const std::string& source, const char* what) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].allFinite()) throw InputError::in_file(source, fmt::format("{} {} isn't finite", what, i));
  }
}

void check_scalar(const PolygonSoup& soup, std::size_t number, const std::string& source) {
  const VertexScalar& scalar = soup.vertex_scalars[number];
  if (scalar.name.empty()) throw InputError::in_file(source, "a scalar of the vertices has no name");
  for (std::size_t i = 0; i < number; ++i) {
    if (soup.vertex_scalars[i].name != scalar.name) continue;
    throw InputError::in_file(source, fmt::format("two scalars of the vertices are named {}", scalar.name));
  }
  if (scalar.values.size() != soup.positions.size()) {
    throw InputError::in_file(source, fmt::format("{} values of {} for {} vertices", scalar.values.size(),
                                                  scalar.name, soup.positions.size()));
  }
}

}  // namespace

void validate(const PolygonSoup& soup, const std::string& source) {
  constexpr std::size_t k_most = k_no_index - 1;
  if (soup.positions.size() > k_most || soup.n_corners() > k_most) {
    throw InputError::in_file(source, "more than 4 294 967 294 vertices or corners");
  }
  check_faces(soup, source);
  check_length(source, "corner texture coordinates", soup.corner_uvs.size(), soup.n_corners());
  check_length(source, "corner normals", soup.corner_normals.size(), soup.n_corners());
  check_length(source, "vertex colours", soup.vertex_colors.size(), soup.positions.size());
  for (std::size_t i = 0; i < soup.vertex_scalars.size(); ++i) check_scalar(soup, i, source);
  check_length(source, "face materials", soup.face_materials.size(), soup.n_faces());
  check_finite(soup.positions, source, "the position of vertex");
  check_finite(soup.corner_uvs, source, "the texture coordinate of corner");
  check_finite(soup.corner_normals, source, "the normal of corner");
  check_finite(soup.vertex_colors, source, "the colour of vertex");
  for (const Index material : soup.face_materials) {
    if (material != k_no_index && material >= soup.materials.size()) {
      throw InputError::in_file(
          source, fmt::format("a face names material {}, but there are {}", material, soup.materials.size()));
    }
  }
  for (const auto& [a, b] : soup.feature_edges) {
    if (a >= soup.positions.size() || b >= soup.positions.size()) {
      throw InputError::in_file(source, fmt::format("a feature edge names vertex {}, but there are {}",
                                                    std::max(a, b), soup.positions.size()));
    }
  }
}

Vec3 vector_area(const PolygonSoup& soup, std::size_t face) {
  const auto corners = soup.face(face);
  // Relative to the first corner, so that models far from the origin keep their digits.
  const Vec3 origin = soup.positions[corners[0]];
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    const Vec3 a = soup.positions[corners[i]] - origin;
    const Vec3 b = soup.positions[corners[i + 1]] - origin;
    sum += a.cross(b);
  }
  return 0.5 * sum;
}

Box3 bounding_box(const PolygonSoup& soup) {
  Box3 box;
  for (const Vec3& p : soup.positions) box.extend(p);
  return box;
}

}  // namespace recede
