#include <recede/geometry/detail/base64.h>
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>
#include <recede/render/detail/surface_look.h>
#include <recede/render/detail/viewer_mesh.h>
#include <recede/render/scene.h>

#include <tbb/parallel_for.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace recede::detail {

namespace {

template <typename Number>
Number share_of(double value, double whole) {
  constexpr double k_full = std::numeric_limits<Number>::max();
  return whole > 0 ? static_cast<Number>(std::lround(std::clamp(value / whole, 0.0, 1.0) * k_full))
                   : Number{0};
}

// What a vertex looks like.
struct Look {
  std::array<std::uint16_t, 2> normal;
  std::array<std::uint8_t, 3> color;
  std::array<std::uint16_t, 2> uv{};
  bool operator==(const Look&) const = default;
};

// Meyer et al. 2010, "On floating-point normal vectors": the octahedron unfolded into a square.
std::array<std::uint16_t, 2> octahedral(const Vec3& normal) {
  constexpr int k_middle = 511;
  const double sum = normal.lpNorm<1>();
  if (!(sum > 0)) return {k_middle, k_middle};
  Vec2 place = normal.head<2>() / sum;
  if (normal.z() < 0) {
    const Vec2 folded(1 - std::abs(place.y()), 1 - std::abs(place.x()));
    place = {std::copysign(folded.x(), place.x()), std::copysign(folded.y(), place.y())};
  }
  const auto step = [](double x) { return static_cast<std::uint16_t>(std::lround(k_middle * (x + 1))); };
  return {step(place.x()), step(place.y())};
}

std::array<std::uint8_t, 3> bytes_of(const Rgb& linear) {
  std::array<std::uint8_t, 3> bytes{};
  for (int k = 0; k < 3; ++k) {
    const double encoded = encode_srgb(std::clamp(linear[k], 0.0f, 1.0f));
    bytes[static_cast<std::size_t>(k)] = share_of<std::uint8_t>(encoded, 1);
  }
  return bytes;
}

// One vertex for each look that a point has, in the order in which triangles need them.
class Vertices {
 public:
  explicit Vertices(std::size_t n_points) : first_(n_points, k_no_index) {}

  Index find_or_add(Index point, const Look& look) {
    Index vertex = first_[point];
    while (vertex != k_no_index && looks[vertex] != look) vertex = next_[vertex];
    if (vertex != k_no_index) return vertex;
    vertex = static_cast<Index>(looks.size());
    points.push_back(point);
    looks.push_back(look);
    next_.push_back(first_[point]);
    first_[point] = vertex;
    return vertex;
  }

  std::vector<Index> points;
  std::vector<Look> looks;

 private:
  std::vector<Index> first_, next_;
};

std::vector<double> distances_to(const ClosestPointTree& input, const std::vector<Vec3>& positions) {
  std::vector<double> distances(positions.size());
  tbb::parallel_for(std::size_t{0}, positions.size(), [&](std::size_t i) {
    distances[i] = std::sqrt(input.closest(positions[i]).squared_distance);
  });
  return distances;
}

template <typename Number>
void append(const std::vector<Number>& values, std::string& bytes) {
  for (unsigned shift = 0; shift < 8 * sizeof(Number); shift += 8) {
    std::uint32_t last = 0;
    for (const Number value : values) {
      bytes += static_cast<char>((value - last) >> shift & 0xff);
      last = value;
    }
  }
}

std::string compressed(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string result(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(result.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                bytes.size(), Z_BEST_COMPRESSION) != Z_OK) {
    throw Error("zlib can't compress the report's geometry");
  }
  result.resize(size);
  return result;
}

/// Colours at corners: textures are blurred as the space between vertices is wide.
class CornerColors {
 public:
  CornerColors(const PolygonSoup& level, std::span<const Index> corners)
      : level_(level), textures_(level.corner_uvs.empty() ? std::vector<Material>{} : level.materials) {
    if (textures_.empty()) return;
    double area = 0;
    for (std::size_t c = 0; c + 2 < corners.size(); c += 3) {
      const Vec2 a = level.corner_uvs[corners[c + 1]] - level.corner_uvs[corners[c]],
                 b = level.corner_uvs[corners[c + 2]] - level.corner_uvs[corners[c]];
      area += std::abs(a.x() * b.y() - a.y() * b.x());
    }
    width_ = std::sqrt(area / static_cast<double>(corners.size() / 3));
  }

  Rgb at(Index face, Index corner) const {
    Rgb color = face_color(level_, face);
    const Index material = level_.face_materials.empty() ? k_no_index : level_.face_materials[face];
    if (const Texture* texture = textures_.of(material))
      color = color.cwiseProduct(texture->color_at(level_.corner_uvs[corner], width_).cast<float>());
    if (!level_.vertex_colors.empty()) {
      const Vec4& factor = level_.vertex_colors[level_.corner_vertices[corner]];
      color = color.cwiseProduct(factor.head<3>().cast<float>());
    }
    return color;
  }

 private:
  const PolygonSoup& level_;
  BaseColorTextures textures_;
  double width_ = 0;  // in texture coordinates
};

}  // namespace

ViewerMesh viewer_mesh(const PolygonSoup& level, const Box3& box, const ClosestPointTree& input,
                       bool with_uvs) {
  ViewerMesh mesh;
  std::vector<Index> faces, corners;
  triangulate(level, &faces, &corners);
  const std::vector<Vec3> normals = drawn_normals(level, SceneOptions{}.crease_angle);
  const CornerColors colors(level, corners);
  Vertices vertices(level.positions.size());
  mesh.indices.reserve(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Index point = level.corner_vertices[corners[i]];
    Look look{octahedral(normals[corners[i]]), bytes_of(colors.at(faces[i / 3], corners[i]))};
    if (with_uvs) {
      for (std::size_t k = 0; k < 2; ++k)
        look.uv[k] = share_of<std::uint16_t>(level.corner_uvs[corners[i]][static_cast<Eigen::Index>(k)], 1);
    }
    mesh.indices.push_back(vertices.find_or_add(point, look));
  }

  std::vector<Vec3> places;
  for (const Index point : vertices.points) places.push_back(level.positions[point]);
  const std::vector<double> distances = distances_to(input, places);
  mesh.largest_distance = *std::max_element(distances.begin(), distances.end());
  const Vec3 sides = box.sizes();
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vec3 place = places[i] - box.min();
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = static_cast<Eigen::Index>(k);
      mesh.positions[k].push_back(share_of<std::uint16_t>(place[axis], sides[axis]));
      mesh.colors[k].push_back(vertices.looks[i].color[k]);
    }
    for (std::size_t k = 0; k < 2; ++k) {
      mesh.normals[k].push_back(vertices.looks[i].normal[k]);
      if (with_uvs) mesh.uvs[k].push_back(vertices.looks[i].uv[k]);
    }
    mesh.distances.push_back(share_of<std::uint16_t>(distances[i], mesh.largest_distance));
  }
  return mesh;
}

std::string pack(const ViewerMesh& mesh) {
  std::string bytes;
  for (const auto& list : mesh.positions) append(list, bytes);
  append(mesh.distances, bytes);
  for (const auto& list : mesh.normals) append(list, bytes);
  for (const auto& list : mesh.colors) append(list, bytes);
  for (const auto& list : mesh.uvs) append(list, bytes);
  append(mesh.indices, bytes);
  return encode_base64(compressed(bytes));
}

}  // namespace recede::detail
