// Wavefront OBJ with its material file beside it.
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/detail/mtl_io.h>
#include <recede/geometry/detail/text_writer.h>

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

namespace recede::detail {

namespace {

// Numbers from 1, in order of first use, for the distinct values of a list.
template <class Vector>
class DistinctValues {
 public:
  Index number(const Vector& value) {
    const auto [found, inserted] = numbers_.try_emplace(value, static_cast<Index>(values_.size() + 1));
    if (inserted) values_.push_back(value);
    return found->second;
  }
  const std::vector<Vector>& values() const { return values_; }

 private:
  // By bits: 0 and -0 are two values, so that what is read is what was written.
  struct SameBits {
    bool operator()(const Vector& a, const Vector& b) const {
      for (int i = 0; i < static_cast<int>(a.size()); ++i) {
        if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
      }
      return true;
    }
  };
  struct Hash {
    std::size_t operator()(const Vector& value) const {
      std::uint64_t hash = 0;
      for (const double coordinate : value) {
        hash = (hash ^ std::bit_cast<std::uint64_t>(coordinate)) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 32;
      }
      return hash;
    }
  };
  std::unordered_map<Vector, Index, Hash, SameBits> numbers_;
  std::vector<Vector> values_;
};

template <class Vector>
std::vector<Index> number_corners(const std::vector<Vector>& corners, DistinctValues<Vector>& distinct) {
  std::vector<Index> numbers;
  numbers.reserve(corners.size());
  for (const Vector& value : corners) numbers.push_back(distinct.number(value));
  return numbers;
}

// A corner normal of zero means that there is none; number 0 says so.
std::vector<Index> number_normals(const std::vector<Vec3>& corners, DistinctValues<Vec3>& distinct) {
  std::vector<Index> numbers;
  numbers.reserve(corners.size());
  for (const Vec3& value : corners) numbers.push_back(value.isZero(0.0) ? 0 : distinct.number(value));
  return numbers;
}

// OBJ finds materials by name, one to a line: names lose line ends and outer blanks, empty and repeated ones
// get a number. The changed names are counted.
std::vector<Material> with_distinct_names(std::vector<Material> materials, std::size_t& renamed) {
  std::unordered_set<std::string> taken{"(null)"};
  for (Material& material : materials) {
    std::string name = material.name;
    std::replace_if(
        name.begin(), name.end(), [](unsigned char c) { return c < ' '; }, ' ');
    name.erase(0, std::min(name.find_first_not_of(' '), name.size()));
    name.erase(name.find_last_not_of(' ') + 1);
    if (name.empty()) name = "material";
    const std::string stem = name;
    for (int k = 2; !taken.insert(name).second; ++k) name = fmt::format("{}_{}", stem, k);
    if (name != material.name) ++renamed;
    material.name = name;
    std::replace_if(
        material.base_color_texture.begin(), material.base_color_texture.end(),
        [](unsigned char c) { return c < ' '; }, ' ');
  }
  return materials;
}

void write_vertices(TextWriter& out, const PolygonSoup& soup) {
  const bool opaque = std::all_of(soup.vertex_colors.begin(), soup.vertex_colors.end(),
                                  [](const Vec4& color) { return color[3] == 1.0; });
  for (std::size_t v = 0; v < soup.positions.size(); ++v) {
    (out << "v ").list(soup.positions[v]);
    if (!soup.vertex_colors.empty()) {
      (out << ' ').list(soup.vertex_colors[v].head<3>());
      if (!opaque) out << ' ' << soup.vertex_colors[v][3];
    }
    out << '\n';
  }
}

struct CornerNumbers {
  std::vector<Index> uvs;
  std::vector<Index> normals;
};

void write_faces(TextWriter& out, const PolygonSoup& soup, const CornerNumbers& numbers,
                 const std::vector<Material>& materials) {
  Index material = k_no_index;
  for (std::size_t face = 0; face < soup.n_faces(); ++face) {
    if (!soup.face_materials.empty() && soup.face_materials[face] != material) {
      material = soup.face_materials[face];
      out << "usemtl " << (material == k_no_index ? std::string_view("(null)") : materials[material].name)
          << '\n';
    }
    out << 'f';
    for (Index corner = soup.face_offsets[face]; corner < soup.face_offsets[face + 1]; ++corner) {
      out << ' ' << soup.corner_vertices[corner] + std::size_t{1};
      const bool has_normal = !numbers.normals.empty() && numbers.normals[corner] != 0;
      if (!numbers.uvs.empty()) out << '/' << numbers.uvs[corner];
      if (has_normal) out << (numbers.uvs.empty() ? "//" : "/") << numbers.normals[corner];
    }
    out << '\n';
  }
}

}  // namespace

OutputFile format_obj(const std::filesystem::path& path, const PolygonSoup& soup, const WriteOptions&) {
  OutputFile output;
  output.written_without = left_out(soup, {});
  TextWriter out;
  out << "# Written by Recede\n";
  std::size_t renamed = 0;
  const std::vector<Material> materials =
      with_distinct_names(with_pictures_beside(path, soup.materials, output), renamed);
  if (!materials.empty()) {
    const std::filesystem::path library = std::filesystem::path(path).replace_extension(".mtl");
    out << "mtllib " << library.filename().string() << '\n';
    output.beside.emplace_back(library, format_mtl(materials));
  }
  if (renamed > 0) {
    output.written_without.push_back(fmt::format("{} material {} (changed to be distinct words on a line)",
                                                 renamed, renamed == 1 ? "name" : "names"));
  }
  write_vertices(out, soup);
  DistinctValues<Vec2> uvs;
  DistinctValues<Vec3> normals;
  const CornerNumbers numbers{number_corners(soup.corner_uvs, uvs),
                              number_normals(soup.corner_normals, normals)};
  for (const Vec2& uv : uvs.values()) (out << "vt ").list(uv) << '\n';
  for (const Vec3& normal : normals.values()) (out << "vn ").list(normal) << '\n';
  write_faces(out, soup, numbers, materials);
  for (const auto& [from, to] : soup.feature_edges) {
    out << "l " << from + std::size_t{1} << ' ' << to + std::size_t{1} << '\n';
  }
  output.content = out.take();
  return output;
}

}  // namespace recede::detail
