#include <recede/geometry/detail/base64.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/detail/gltf_document.h>
#include <recede/geometry/error.h>
#include <recede/geometry/gltf_writer.h>
#include <recede/geometry/raster.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <unordered_set>

namespace recede {

using nlohmann::json;

namespace {

constexpr int k_float = 5126;
constexpr int k_vertex_data = 34962;
constexpr int k_index_data = 34963;

struct Attribute {
  const char* name;
  const char* type;
  std::size_t size;  // floats
};
constexpr Attribute k_position{"POSITION", "VEC3", 3};
constexpr Attribute k_normal{"NORMAL", "VEC3", 3};
constexpr Attribute k_uv{"TEXCOORD_0", "VEC2", 2};
constexpr Attribute k_color{"COLOR_0", "VEC4", 4};
constexpr Attribute k_tangent{"TANGENT", "VEC4", 4};
constexpr Attribute k_parent{"_PARENT", "SCALAR", 1};

// An attribute of a mesh, or what a morph target adds to it.
struct Placed {
  Attribute attribute;
  std::size_t first;  // among the floats of a vertex
  bool in_target;
};

// The floats of a vertex: those of its attributes, one after the other.
struct Layout {
  std::vector<Placed> attributes;
  std::size_t size = 0;

  Layout(const PolygonSoup& soup, const GltfMeshExtras& extras) {
    const auto add = [this](bool is_there, const Attribute& attribute, bool in_target) {
      if (!is_there) return;
      attributes.push_back({attribute, size, in_target});
      size += attribute.size;
    };
    for (const bool in_target : {false, true}) {
      if (in_target && extras.morph_target == nullptr) break;
      add(true, k_position, in_target);
      add(!soup.corner_normals.empty(), k_normal, in_target);
      add(!soup.corner_uvs.empty(), k_uv, in_target);
      add(!soup.vertex_colors.empty(), k_color, in_target);
      add(!in_target && !extras.corner_tangents.empty(), k_tangent, in_target);
      add(!in_target && !extras.parents.empty(), k_parent, in_target);
    }
  }
};

// Vertices as the file has them; two corners with the same floats share one.
class Primitive {
 public:
  explicit Primitive(std::size_t vertex_size) : size_(vertex_size), numbers_(0, Hash{this}, Equal{this}) {}
  Primitive(const Primitive&) = delete;
  Primitive& operator=(const Primitive&) = delete;

  // The floats are those of a whole vertex.
  void add_corner(const std::vector<float>& vertex) {
    const auto number = static_cast<std::uint32_t>(n_vertices());
    values_.insert(values_.end(), vertex.begin(), vertex.end());
    const auto [found, is_new] = numbers_.insert(number);
    if (!is_new) values_.resize(values_.size() - size_);
    indices_.push_back(*found);
  }

  std::size_t n_vertices() const { return values_.size() / size_; }
  const float* vertex(std::size_t number) const { return values_.data() + number * size_; }
  const std::vector<std::uint32_t>& indices() const { return indices_; }

 private:
  struct Hash {
    const Primitive* of;
    std::size_t operator()(std::uint32_t number) const {
      const float* const values = of->vertex(number);
      std::uint64_t hash = 0;
      for (std::size_t i = 0; i < of->size_; ++i) {
        hash = (hash ^ std::bit_cast<std::uint32_t>(values[i])) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
      }
      return hash;
    }
  };
  struct Equal {
    const Primitive* of;
    bool operator()(std::uint32_t a, std::uint32_t b) const {
      return std::memcmp(of->vertex(a), of->vertex(b), of->size_ * sizeof(float)) == 0;
    }
  };

  std::size_t size_;
  std::vector<float> values_;
  std::vector<std::uint32_t> indices_;
  std::unordered_set<std::uint32_t, Hash, Equal> numbers_;
};

// Floats keep 24 bits of a coordinate: a model further from the origin than a thousand times its size would
// lose ten of them, and is stored around its centre. The offset is a float itself, so that every reader adds
// the same number.
Vec3 offset_of(const PolygonSoup& soup) {
  constexpr double k_far = 1e3;
  const Box3 box = bounding_box(soup);
  if (box.isEmpty() || !(box.center().norm() > k_far * box.diagonal().norm())) return Vec3::Zero();
  return box.center().unaryExpr(&detail::rounded_to_float);
}

Vec3 unit_face_normal(const PolygonSoup& soup, std::size_t face) {
  const Vec3 area = vector_area(soup, face);
  const double length = area.stableNorm();
  return length > 0.0 && std::isfinite(length) ? Vec3(area / length)
                                               : Vec3::UnitZ();  // glTF has no zero normals
}

class VertexMaker {
 public:
  VertexMaker(const PolygonSoup& soup, const GltfMeshExtras& extras, const Vec3& offset)
      : soup_(soup), extras_(extras), offset_(offset) {}

  /// Writes the floats of a corner in the order of `Layout`.
  void make(Index corner, std::size_t face, std::vector<float>& vertex) const {
    const Index v = soup_.corner_vertices[corner];
    vertex.clear();
    put(vertex, soup_.positions[v] - offset_);
    if (!soup_.corner_normals.empty()) put(vertex, normal(soup_, corner, face));
    if (!soup_.corner_uvs.empty()) put(vertex, uv(soup_, corner));
    if (!soup_.vertex_colors.empty()) put(vertex, color(soup_, v));
    if (!extras_.corner_tangents.empty()) put(vertex, extras_.corner_tangents[corner]);
    if (!extras_.parents.empty()) {
      const Index parent = extras_.parents[v];
      vertex.push_back(parent == k_no_index ? -1.0f : static_cast<float>(parent));
    }
    if (extras_.morph_target != nullptr) put_target(vertex, *extras_.morph_target, corner, face);
  }

 private:
  static Vec3 normal(const PolygonSoup& soup, Index corner, std::size_t face) {
    const double length = soup.corner_normals[corner].stableNorm();
    if (!(length > 0.0) || !std::isfinite(length)) return unit_face_normal(soup, face);
    return soup.corner_normals[corner] / length;
  }
  static Vec2 uv(const PolygonSoup& soup, Index corner) {
    return {soup.corner_uvs[corner][0], 1.0 - soup.corner_uvs[corner][1]};
  }
  static Vec4 color(const PolygonSoup& soup, Index vertex) {
    return soup.vertex_colors[vertex].cwiseMax(0.0).cwiseMin(1.0);
  }

  void put_target(std::vector<float>& vertex, const PolygonSoup& target, Index corner,
                  std::size_t face) const {
    const Index v = soup_.corner_vertices[corner];
    put(vertex, target.positions[v] - soup_.positions[v]);
    if (!soup_.corner_normals.empty())
      put(vertex, normal(target, corner, face) - normal(soup_, corner, face));
    if (!soup_.corner_uvs.empty()) put(vertex, uv(target, corner) - uv(soup_, corner));
    if (!soup_.vertex_colors.empty()) put(vertex, color(target, v) - color(soup_, v));
  }

  template <class Derived>
  static void put(std::vector<float>& vertex, const Eigen::MatrixBase<Derived>& values) {
    // Adding zero turns -0 into 0: the two would split a vertex.
    for (Eigen::Index i = 0; i < values.size(); ++i) vertex.push_back(detail::to_float(values[i] + 0.0));
  }

  const PolygonSoup& soup_;
  const GltfMeshExtras& extras_;
  Vec3 offset_;
};

json clamped_color(const Vec4& color) {
  json result = json::array();
  for (const double component : color) result.push_back(std::clamp(component, 0.0, 1.0));
  return result;
}

}  // namespace

struct GltfBuilder::Impl {
  json document;
  std::string buffer;
  std::vector<Material> materials;
  std::vector<Vec3> offsets;                   // one per mesh
  std::map<std::string, int> images;           // by path
  std::map<const std::string*, int> pictures;  // images by their bytes, which materials hold

  int append(const char* list, json value) {
    json& array = document[list];
    array.push_back(std::move(value));
    return static_cast<int>(array.size()) - 1;
  }

  int add_view(std::string_view bytes, std::optional<int> target) {
    buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
    json view{{"buffer", 0}, {"byteOffset", buffer.size()}, {"byteLength", bytes.size()}};
    if (target) view["target"] = *target;
    buffer += bytes;
    return append("bufferViews", std::move(view));
  }

  template <class Value>
  int add_values(const std::vector<Value>& values, int target) {
    return add_view({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)}, target);
  }

  int add_attribute(const Primitive& primitive, const Placed& placed) {
    const std::size_t size = placed.attribute.size, n = primitive.n_vertices();
    std::vector<float> values;
    values.reserve(n * size);
    constexpr float k_infinite = std::numeric_limits<float>::infinity();
    std::vector<float> low(size, k_infinite), high(size, -k_infinite);
    for (std::size_t vertex = 0; vertex < n; ++vertex) {
      const float* const of_vertex = primitive.vertex(vertex) + placed.first;
      for (std::size_t i = 0; i < size; ++i) {
        low[i] = std::min(low[i], of_vertex[i]);
        high[i] = std::max(high[i], of_vertex[i]);
        values.push_back(of_vertex[i]);
      }
    }
    json accessor{{"bufferView", add_values(values, k_vertex_data)},
                  {"componentType", k_float},
                  {"count", n},
                  {"type", placed.attribute.type}};
    if (std::string_view(placed.attribute.name) == k_position.name) {
      accessor["min"] = low;
      accessor["max"] = high;
    }
    return append("accessors", std::move(accessor));
  }

  // The highest 16-bit index is kept free: it restarts primitives.
  int add_indices(const std::vector<std::uint32_t>& indices, std::size_t n_vertices) {
    const bool narrow = n_vertices <= std::numeric_limits<std::uint16_t>::max();
    const std::vector<std::uint16_t> narrowed(narrow ? indices.begin() : indices.end(), indices.end());
    const int view = narrow ? add_values(narrowed, k_index_data) : add_values(indices, k_index_data);
    return append("accessors", {{"bufferView", view},
                                {"componentType", narrow ? 5123 : 5125},
                                {"count", indices.size()},
                                {"type", "SCALAR"}});
  }

  int add_image(const std::string& path, std::string_view picture) {
    const char* const kind = picture_format(picture) == PictureFormat::jpeg ? "image/jpeg" : "image/png";
    const int view = add_view(picture, {});
    return append("images",
                  {{"bufferView", view}, {"mimeType", kind}, {"extras", {{detail::k_picture_file, path}}}});
  }

  /// Its position in `images`: inside of the document where its bytes are known.
  int image_number(const std::string& path, const PictureBytes& picture) {
    if (picture && picture_format(*picture) != PictureFormat::unknown) {
      const auto [image, is_new] = pictures.try_emplace(picture.get());
      if (is_new) image->second = add_image(path, *picture);
      return image->second;
    }
    const auto [image, is_new] = images.try_emplace(path);
    if (is_new) image->second = append("images", {{"uri", detail::encode_percent(path)}});
    return image->second;
  }

  int texture_number(const std::string& path, const PictureBytes& picture) {
    return append("textures", {{"source", image_number(path, picture)}});
  }

  int material_number(Material material, bool has_uvs) {
    if (!has_uvs) {  // a texture needs coordinates
      material.base_color_texture.clear();
      material.normal_texture.clear();
    }
    const auto found = std::find(materials.begin(), materials.end(), material);
    if (found != materials.end()) return static_cast<int>(found - materials.begin());
    json surface{{"baseColorFactor", clamped_color(material.base_color)}, {"metallicFactor", 0.0}};
    if (!material.base_color_texture.empty())
      surface["baseColorTexture"] = {
          {"index", texture_number(material.base_color_texture, material.base_color_picture)}};
    json entry{{"pbrMetallicRoughness", std::move(surface)}, {"doubleSided", true}};
    if (!material.normal_texture.empty())
      entry["normalTexture"] = {{"index", texture_number(material.normal_texture, material.normal_picture)}};
    if (!material.name.empty()) entry["name"] = material.name;
    if (material.alpha_cutoff) {
      entry["alphaMode"] = "MASK";
      entry["alphaCutoff"] = *material.alpha_cutoff;
    } else if (material.base_color[3] < 1.0) {
      entry["alphaMode"] = "BLEND";
    }
    materials.push_back(std::move(material));
    return append("materials", std::move(entry));
  }

  json primitive_json(const Primitive& primitive, const Layout& layout) {
    json attributes, target;
    for (const Placed& placed : layout.attributes)
      (placed.in_target ? target : attributes)[placed.attribute.name] = add_attribute(primitive, placed);
    json result{{"attributes", std::move(attributes)},
                {"indices", add_indices(primitive.indices(), primitive.n_vertices())},
                {"mode", 4}};
    if (!target.is_null()) result["targets"] = json::array({std::move(target)});
    return result;
  }

  // What has no material would be dark metal, as viewers draw what glTF says of it: it is painted plainly,
  // grey unless it has colours, and marked, so that readers who know the mark find none.
  static void paint_plainly(json& result) {
    if (!result.contains("meshes")) return;
    std::array<std::optional<std::size_t>, 2> plain;  // grey, white
    for (json& mesh : result["meshes"]) {
      for (json& primitive : mesh["primitives"]) {
        if (primitive.contains("material")) continue;
        const bool is_white = primitive["attributes"].contains("COLOR_0");
        std::optional<std::size_t>& number = plain[is_white ? 1 : 0];
        if (!number) {
          json& materials = result["materials"];
          number = materials.size();
          const Vec4 color = is_white ? Vec4(Vec4::Ones()) : Material{}.base_color;
          materials.push_back(
              {{"pbrMetallicRoughness", {{"baseColorFactor", clamped_color(color)}, {"metallicFactor", 0.0}}},
               {"doubleSided", true},
               {"extras", {{detail::k_no_material, true}}}});
        }
        primitive["material"] = *number;
      }
    }
  }

  json complete_document(bool with_data) const {
    json result = document;
    paint_plainly(result);
    if (buffer.empty()) return result;
    json entry{{"byteLength", buffer.size()}};
    if (with_data) entry["uri"] = "data:application/octet-stream;base64," + detail::encode_base64(buffer);
    result["buffers"] = json::array({std::move(entry)});
    return result;
  }

  static std::string dump(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
  }
};

GltfBuilder::GltfBuilder() : impl_(std::make_unique<Impl>()) {
  impl_->document = {{"asset", {{"version", "2.0"}, {"generator", "Recede"}}},
                     {"scene", 0},
                     {"scenes", json::array({json::object()})}};
}
GltfBuilder::GltfBuilder(GltfBuilder&&) noexcept = default;
GltfBuilder& GltfBuilder::operator=(GltfBuilder&&) noexcept = default;
GltfBuilder::~GltfBuilder() = default;

nlohmann::json& GltfBuilder::document() { return impl_->document; }

int GltfBuilder::add_mesh(const PolygonSoup& soup, const std::string& name, const GltfMeshExtras& extras) {
  std::vector<Index> faces, corners;
  triangulate(soup, &faces, &corners);
  if (corners.empty()) throw InputError("glTF can't hold a mesh without triangles");
  const Vec3 offset = offset_of(soup);
  const VertexMaker maker(soup, extras, offset);
  // One primitive for each material, the faces without one last.
  const Layout layout(soup, extras);
  std::deque<Primitive> primitives;
  for (std::size_t i = 0; i <= soup.materials.size(); ++i) primitives.emplace_back(layout.size);
  std::vector<float> vertex;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Index face = faces[i / 3];
    const std::size_t material = soup.face_materials.empty() ? k_no_index : soup.face_materials[face];
    maker.make(corners[i], face, vertex);
    primitives[std::min(material, soup.materials.size())].add_corner(vertex);
  }
  json list = json::array();
  for (std::size_t material = 0; material < primitives.size(); ++material) {
    if (primitives[material].indices().empty()) continue;
    json entry = impl_->primitive_json(primitives[material], layout);
    if (material < soup.materials.size()) {
      entry["material"] = impl_->material_number(soup.materials[material], !soup.corner_uvs.empty());
    }
    list.push_back(std::move(entry));
  }
  impl_->offsets.push_back(offset);
  json mesh{{"name", name}, {"primitives", std::move(list)}};
  if (extras.morph_target != nullptr) {
    mesh["weights"] = {0.0};
    mesh["extras"]["targetNames"] = {extras.morph_name};
  }
  return impl_->append("meshes", std::move(mesh));
}

int GltfBuilder::copy_mesh(int mesh) {
  const auto from = static_cast<std::size_t>(mesh);
  const Vec3 offset = impl_->offsets.at(from);
  impl_->offsets.push_back(offset);
  json copy = impl_->document["meshes"].at(from);
  return impl_->append("meshes", std::move(copy));
}

void GltfBuilder::paint_mesh(int mesh, const Material& material) {
  for (json& primitive : impl_->document["meshes"].at(static_cast<std::size_t>(mesh))["primitives"]) {
    if (primitive.contains("material")) continue;
    const bool has_uvs = primitive["attributes"].contains(k_uv.name);
    primitive["material"] = impl_->material_number(material, has_uvs);
  }
}

int GltfBuilder::add_picture(const std::string& path, std::string_view picture) {
  return impl_->images[path] = impl_->add_image(path, picture);
}

int GltfBuilder::add_node(int mesh, const std::string& name, const Eigen::Affine3d& placement) {
  json node{{"name", name}};
  Eigen::Affine3d whole = placement;
  if (mesh >= 0) {
    node["mesh"] = mesh;
    whole.translate(impl_->offsets.at(static_cast<std::size_t>(mesh)));
  }
  if (!whole.linear().isIdentity(0.0)) {
    const std::span<const double> columns(whole.data(), 16);
    node["matrix"] = std::vector<double>(columns.begin(), columns.end());
  } else if (!whole.translation().isZero(0.0)) {
    node["translation"] = {whole.translation().x(), whole.translation().y(), whole.translation().z()};
  }
  return impl_->append("nodes", std::move(node));
}

void GltfBuilder::add_to_scene(int node) { impl_->document["scenes"][0]["nodes"].push_back(node); }

void GltfBuilder::add_child(int parent, int node) {
  impl_->document["nodes"].at(static_cast<std::size_t>(parent))["children"].push_back(node);
}

std::string GltfBuilder::to_gltf() const { return Impl::dump(impl_->complete_document(true)) + '\n'; }

std::string GltfBuilder::to_glb() const {
  const auto padded = [](std::size_t size) { return (size + 3) / 4 * 4; };
  std::string text = Impl::dump(impl_->complete_document(false));
  text.resize(padded(text.size()), ' ');
  const std::size_t n_binary = padded(impl_->buffer.size());
  const std::size_t size = 12 + 8 + text.size() + (n_binary > 0 ? 8 + n_binary : 0);
  if (size > std::numeric_limits<std::uint32_t>::max()) {
    throw InputError(fmt::format("a GLB file holds at most 4 GiB, not {} bytes", size));
  }
  std::string result;
  result.reserve(size);
  const auto put = [&result](std::size_t value) {
    const auto word = static_cast<std::uint32_t>(value);
    result.append(reinterpret_cast<const char*>(&word), sizeof word);
  };
  result += "glTF";
  put(2);
  put(size);
  put(text.size());
  put(detail::k_json_chunk);
  result += text;
  if (n_binary > 0) {
    put(n_binary);
    put(detail::k_binary_chunk);
    result += impl_->buffer;
    result.resize(size, '\0');
  }
  return result;
}

namespace detail {

namespace {

GltfBuilder single_mesh(const std::filesystem::path& path, const PolygonSoup& soup) {
  GltfBuilder builder;
  const std::string name = path.stem().string();
  builder.add_to_scene(builder.add_node(builder.add_mesh(soup, name), name));
  return builder;
}

}  // namespace

std::vector<std::string> left_out_of_gltf(const PolygonSoup& soup) {
  std::vector<std::string> result =
      left_out(soup, {.polygons = false, .isolated_vertices = false, .feature_edges = false});
  const bool textured =
      std::any_of(soup.materials.begin(), soup.materials.end(),
                  [](const Material& material) { return !material.base_color_texture.empty(); });
  if (textured && soup.corner_uvs.empty()) result.emplace_back("textures (there are no texture coordinates)");
  std::vector<bool> used(soup.materials.size(), false);
  for (const Index material : soup.face_materials) {
    if (material != k_no_index) used[material] = true;
  }
  const auto unused = std::count(used.begin(), used.end(), false);
  if (unused > 0)
    result.push_back(fmt::format("{} {} that no face uses", unused, unused == 1 ? "material" : "materials"));
  if (loses_digits_as_float(soup)) result.emplace_back(k_rounded_positions);
  return result;
}

OutputFile format_glb(const std::filesystem::path& path, const PolygonSoup& soup, const WriteOptions&) {
  return {single_mesh(path, soup).to_glb(), {}, left_out_of_gltf(soup)};
}

OutputFile format_gltf(const std::filesystem::path& path, const PolygonSoup& soup, const WriteOptions&) {
  return {single_mesh(path, soup).to_gltf(), {}, left_out_of_gltf(soup)};
}

}  // namespace detail

}  // namespace recede
