// The triangles of a glTF scene, in world coordinates. Texture coordinates are turned from glTF's (v down
// from the top) to those of OBJ and PLY (v up from the bottom). Skins, animations and morph targets are left
// aside: what is read is the model at rest.
#include <recede/geometry/detail/gltf_document.h>
#include <recede/geometry/raster.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

namespace recede::detail {

namespace {

using Transform = Eigen::Matrix4d;

enum class Mode : std::size_t { triangles = 4, strip = 5, fan = 6 };

Transform local_transform(const GltfValue& node) {
  if (node["matrix"])
    return node["matrix"]
        .vector_or(Eigen::Matrix<double, 16, 1>::Zero().eval())
        .reshaped(4, 4);  // by columns
  const Vec3 translation = node["translation"].vector_or(Vec3(0, 0, 0));
  const Vec4 rotation = node["rotation"].vector_or(Vec4(0, 0, 0, 1));
  const Vec3 scale = node["scale"].vector_or(Vec3(1, 1, 1));
  const Eigen::Quaterniond quaternion(rotation[3], rotation[0], rotation[1], rotation[2]);
  Transform transform = Transform::Identity();
  transform.topLeftCorner<3, 3>() = quaternion.normalized().toRotationMatrix() * scale.asDiagonal();
  transform.topRightCorner<3, 1>() = translation;
  return transform;
}

// The corners of all triangles of a primitive, as positions among its vertices.
std::vector<Index> triangle_corners(Mode mode, const std::vector<std::uint32_t>& indices) {
  std::vector<Index> corners;
  if (mode == Mode::triangles) {
    corners.assign(indices.begin(), indices.end());
    return corners;
  }
  for (std::size_t i = 0; i + 2 < indices.size(); ++i) {
    std::array<Index, 3> triangle{indices[i], indices[i + 1], indices[i + 2]};
    if (mode == Mode::fan) triangle[0] = indices[0];
    if (mode == Mode::strip && i % 2 == 1) std::swap(triangle[1], triangle[2]);
    // Repeated indices only lead a strip to another place.
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  }
  return corners;
}

class GltfReader {
 public:
  explicit GltfReader(const InputFile& file) : file_(file), document_(file), root_(document_.root()) {}

  PolygonSoup read() {
    report_progress(file_.progress, "read", 0.1);
    read_materials();
    find_coarser_levels();
    visited_.resize(root_["nodes"].size(), false);
    const GltfValue scenes = root_["scenes"];
    for (std::size_t scene = scenes.size(); scene-- > 0;) {
      visit_children(scenes.at(scene)["nodes"], Transform::Identity());
    }
    if (scenes.size() == 0) visit_roots();
    walk();
    if (soup_.n_faces() == 0) file_.fail("holds no triangles");
    if (soup_.face_materials.empty()) soup_.materials.clear();
    return std::move(soup_);
  }

  /// After `read`.
  std::vector<std::string> left_aside() const {
    std::vector<std::string> result;
    const auto add = [&](std::size_t count, const char* one, const char* many) {
      if (count > 0) result.push_back(fmt::format("{} {}", count, count == 1 ? one : many));
    };
    const auto levels = std::count(coarser_level_.begin(), coarser_level_.end(), true);
    add(static_cast<std::size_t>(levels), "coarser level of detail", "coarser levels of detail");
    add(root_["animations"].size(), "animation", "animations");
    add(root_["skins"].size(), "skin", "skins");
    add(n_with_targets_, "surface's morph targets", "surfaces' morph targets");
    add(n_other_textures_, "texture that is neither PNG nor JPEG", "textures that are neither PNG nor JPEG");
    add(n_points_and_lines_, "list of points or lines", "lists of points or lines");
    return result;
  }

 private:
  struct Visit {
    std::size_t node;
    Transform transform;  // of its parent
  };

  void read_materials() {
    const GltfValue materials = root_["materials"];
    for (std::size_t i = 0; i < materials.size(); ++i) {
      if (materials.at(i)["extras"][k_no_material]) {
        material_numbers_.push_back(k_no_index);
        continue;
      }
      material_numbers_.push_back(static_cast<Index>(soup_.materials.size()));
      const GltfValue surface = materials.at(i)["pbrMetallicRoughness"];
      Material material;
      material.name = materials.at(i)["name"].text_or("");
      material.base_color = surface["baseColorFactor"].vector_or(Vec4(1, 1, 1, 1));
      const GltfValue texture = surface["baseColorTexture"]["index"];
      if (texture) read_texture(texture, material.base_color_texture, material.base_color_picture);
      const GltfValue normals = materials.at(i)["normalTexture"]["index"];
      if (normals) read_texture(normals, material.normal_texture, material.normal_picture);
      if (materials.at(i)["alphaMode"].text_or("OPAQUE") == "MASK") {
        const GltfValue cutoff = materials.at(i)["alphaCutoff"];
        material.alpha_cutoff = cutoff ? cutoff.number() : 0.5;
      }
      soup_.materials.push_back(std::move(material));
    }
  }

  // Images inside the file have a number for a name, but for those that our writer put there.
  void read_texture(const GltfValue& number, std::string& name, PictureBytes& picture) {
    const GltfValue source = document_.element("textures", number.integer())["source"];
    if (!source) {
      ++n_other_textures_;
      return;
    }
    const std::size_t index = source.integer();
    const GltfValue image = document_.element("images", index);
    const auto [known, is_new] = pictures_.try_emplace(index);
    if (is_new) {
      if (std::optional<std::string> bytes = document_.read_picture(image))
        known->second = std::make_shared<const std::string>(std::move(*bytes));
    }
    picture = known->second;
    if (!picture) {
      name = decode_percent(image["uri"].text_or(""));
      return;
    }
    const bool is_jpeg = picture_format(*picture) == PictureFormat::jpeg;
    name =
        image["extras"][k_picture_file].text_or(fmt::format("image_{}.{}", index, is_jpeg ? "jpg" : "png"));
  }

  // MSFT_lod: the node that has the extension is the finest level; those that it lists stand for it further
  // away.
  void find_coarser_levels() {
    const GltfValue nodes = root_["nodes"];
    coarser_level_.resize(nodes.size(), false);
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const GltfValue ids = nodes.at(node)["extensions"]["MSFT_lod"]["ids"];
      for (std::size_t i = 0; i < ids.size(); ++i) {
        const std::size_t id = ids.at(i).integer();
        if (id >= nodes.size()) ids.fail(fmt::format("names node {} (there are {})", id, nodes.size()));
        coarser_level_[id] = true;
      }
    }
  }

  void visit_children(const GltfValue& ids, const Transform& transform) {
    for (std::size_t i = 0; i < ids.size(); ++i) to_visit_.push_back({ids.at(i).integer(), transform});
    // The stack gives back the last first; the order of the file is the order of the soup.
    std::reverse(to_visit_.end() - static_cast<std::ptrdiff_t>(ids.size()), to_visit_.end());
  }

  // Without scenes, every node is there that is no child of another one.
  void visit_roots() {
    const GltfValue nodes = root_["nodes"];
    std::vector<bool> is_child(nodes.size(), false);
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const GltfValue children = nodes.at(node)["children"];
      for (std::size_t i = 0; i < children.size(); ++i) {
        const std::size_t child = children.at(i).integer();
        if (child < nodes.size()) is_child[child] = true;
      }
    }
    for (std::size_t node = nodes.size(); node-- > 0;) {
      if (!is_child[node]) to_visit_.push_back({node, Transform::Identity()});
    }
  }

  // Depth first without recursion: a damaged file may nest nodes as deep as it is long. A node has one
  // parent, so one that comes again is shared by scenes or bites its tail.
  void walk() {
    while (!to_visit_.empty()) {
      const Visit visit = to_visit_.back();
      to_visit_.pop_back();
      const GltfValue node = document_.element("nodes", visit.node);
      if (visited_[visit.node] || coarser_level_[visit.node]) continue;
      visited_[visit.node] = true;
      const Transform transform = visit.transform * local_transform(node);
      if (node["mesh"]) read_mesh(document_.element("meshes", node["mesh"].integer()), transform);
      visit_children(node["children"], transform);
    }
  }

  void read_mesh(const GltfValue& mesh, const Transform& transform) {
    report_progress(file_.progress, "read", 0.5);
    const GltfValue primitives = mesh["primitives"];
    for (std::size_t i = 0; i < primitives.size(); ++i) {
      const std::size_t mode = primitives.at(i)["mode"].integer_or(4);
      if (mode > 6) primitives.at(i).fail(fmt::format("has the unknown mode {}", mode));
      // Points and lines aren't surfaces.
      if (mode < 4) ++n_points_and_lines_;
      if (mode >= 4 && primitives.at(i)["attributes"]["POSITION"]) {
        if (primitives.at(i)["targets"].size() > 0) ++n_with_targets_;
        read_primitive(primitives.at(i), static_cast<Mode>(mode), transform);
      }
    }
  }

  void read_primitive(const GltfValue& primitive, Mode mode, const Transform& transform) {
    if (primitive["extensions"]["KHR_draco_mesh_compression"]) {
      primitive.fail("needs the extension KHR_draco_mesh_compression, which isn't supported");
    }
    n_faces_before_ = soup_.n_faces();
    const std::size_t first_vertex = soup_.positions.size();
    const std::size_t n = read_positions(primitive, transform);
    std::vector<Index> corners = triangle_corners(mode, read_corner_indices(primitive, n));
    if (corners.size() % 3 != 0)
      primitive.fail(fmt::format("has {} indices, which make no triangles", corners.size()));
    const bool mirrored = transform.topLeftCorner<3, 3>().determinant() < 0.0;
    for (std::size_t i = 0; mirrored && i < corners.size(); i += 3) std::swap(corners[i + 1], corners[i + 2]);
    check_countable(file_, soup_.n_corners() + corners.size(), "corners");
    read_uvs(primitive, n, corners);
    read_normals(primitive, n, corners, transform);
    read_colors(primitive, n, first_vertex);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      soup_.corner_vertices.push_back(static_cast<Index>(first_vertex + corners[i]));
      if (i % 3 == 2) soup_.face_offsets.push_back(static_cast<Index>(soup_.n_corners()));
    }
    pad_attributes(primitive);
  }

  std::size_t read_positions(const GltfValue& primitive, const Transform& transform) {
    const GltfValue attribute = primitive["attributes"]["POSITION"];
    const GltfValues positions = document_.read_accessor(attribute.integer());
    if (positions.components != 3) attribute.fail("isn't a list of positions");
    check_countable(file_, soup_.positions.size() + positions.count, "vertices");
    const Eigen::Matrix3d linear = transform.topLeftCorner<3, 3>();
    const Vec3 translation = transform.topRightCorner<3, 1>();
    for (std::size_t v = 0; v < positions.count; ++v) {
      soup_.positions.emplace_back(linear * Eigen::Map<const Vec3>(positions.values.data() + 3 * v) +
                                   translation);
    }
    return positions.count;
  }

  std::vector<std::uint32_t> read_corner_indices(const GltfValue& primitive, std::size_t n_vertices) {
    std::vector<std::uint32_t> indices;
    if (!primitive["indices"]) {
      for (std::size_t v = 0; v < n_vertices; ++v) indices.push_back(static_cast<std::uint32_t>(v));
      return indices;
    }
    indices = document_.read_indices(primitive["indices"].integer());
    const auto wrong =
        std::find_if(indices.begin(), indices.end(), [&](std::uint32_t i) { return i >= n_vertices; });
    if (wrong != indices.end())
      primitive.fail(fmt::format("uses vertex {} (there are {})", *wrong, n_vertices));
    return indices;
  }

  // The values of an attribute that the primitive may lack; each vertex has at least `components` of them.
  GltfValues read_attribute(const GltfValue& primitive, const char* name, std::size_t n,
                            std::size_t components) {
    const GltfValue attribute = primitive["attributes"][name];
    if (!attribute) return {};
    GltfValues values = document_.read_accessor(attribute.integer());
    if (values.count != n) attribute.fail(fmt::format("has {} elements for {} vertices", values.count, n));
    if (values.components < components) attribute.fail("has too few components");
    return values;
  }

  void read_uvs(const GltfValue& primitive, std::size_t n, const std::vector<Index>& corners) {
    const GltfValues uvs = read_attribute(primitive, "TEXCOORD_0", n, 2);
    if (uvs.values.empty()) return;
    soup_.corner_uvs.resize(soup_.n_corners(), Vec2::Zero());
    for (const Index corner : corners) {
      const double* uv = uvs.values.data() + uvs.components * corner;
      soup_.corner_uvs.emplace_back(uv[0], 1.0 - uv[1]);
    }
  }

  void read_normals(const GltfValue& primitive, std::size_t n, const std::vector<Index>& corners,
                    const Transform& transform) {
    const GltfValues normals = read_attribute(primitive, "NORMAL", n, 3);
    if (normals.values.empty()) return;
    soup_.corner_normals.resize(soup_.n_corners(), Vec3::Zero());
    // The cofactor matrix is the inverse transpose up to a factor, and exists for flattening transforms as
    // well.
    Eigen::Matrix3d cofactors;
    const Eigen::Matrix3d linear = transform.topLeftCorner<3, 3>();
    for (int i = 0; i < 3; ++i) cofactors.col(i) = linear.col((i + 1) % 3).cross(linear.col((i + 2) % 3));
    if (linear.determinant() < 0.0) cofactors = -cofactors;
    const bool unchanged = linear.isIdentity(0.0);
    for (const Index corner : corners) {
      const Vec3 normal = Eigen::Map<const Vec3>(normals.values.data() + normals.components * corner);
      soup_.corner_normals.push_back(unchanged ? normal : Vec3((cofactors * normal).stableNormalized()));
    }
  }

  void read_colors(const GltfValue& primitive, std::size_t n, std::size_t first_vertex) {
    const GltfValues colors = read_attribute(primitive, "COLOR_0", n, 3);
    if (colors.values.empty()) return;
    soup_.vertex_colors.resize(first_vertex, Vec4::Ones());
    for (std::size_t v = 0; v < n; ++v) {
      const double* color = colors.values.data() + colors.components * v;
      soup_.vertex_colors.emplace_back(color[0], color[1], color[2], colors.components > 3 ? color[3] : 1.0);
    }
  }

  // What this or earlier primitives have, all have.
  void pad_attributes(const GltfValue& primitive) {
    if (!soup_.corner_uvs.empty()) soup_.corner_uvs.resize(soup_.n_corners(), Vec2::Zero());
    if (!soup_.corner_normals.empty()) soup_.corner_normals.resize(soup_.n_corners(), Vec3::Zero());
    if (!soup_.vertex_colors.empty()) soup_.vertex_colors.resize(soup_.positions.size(), Vec4::Ones());
    const Index material = material_of(primitive);
    if (material == k_no_index && soup_.face_materials.empty()) return;
    soup_.face_materials.resize(n_faces_before_, k_no_index);
    soup_.face_materials.resize(soup_.n_faces(), material);
  }

  Index material_of(const GltfValue& primitive) const {
    if (!primitive["material"]) return k_no_index;
    const std::size_t number = primitive["material"].integer();
    if (number >= material_numbers_.size())
      primitive["material"].fail(fmt::format("names material {}, which isn't there", number));
    return material_numbers_[number];
  }

  const InputFile& file_;
  GltfDocument document_;
  GltfValue root_;
  std::vector<Index> material_numbers_;           // of the file's materials
  std::map<std::size_t, PictureBytes> pictures_;  // of its images
  PolygonSoup soup_;
  std::vector<bool> coarser_level_;
  std::vector<bool> visited_;
  std::vector<Visit> to_visit_;
  std::size_t n_faces_before_ = 0;  // the present primitive
  std::size_t n_with_targets_ = 0, n_points_and_lines_ = 0, n_other_textures_ = 0;
};

}  // namespace

PolygonSoup read_gltf(const InputFile& file) {
  GltfReader reader(file);
  PolygonSoup soup = reader.read();
  if (file.left_aside != nullptr) *file.left_aside = reader.left_aside();
  return soup;
}

}  // namespace recede::detail
