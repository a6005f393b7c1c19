#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

namespace recede::detail {

void InputFile::fail(const std::string& reason) const { throw InputError::in_file(name, reason); }

void InputFile::fail_at_line(std::size_t line, const std::string& reason) const {
  throw InputError::at_line(name, line, reason);
}

void InputFile::fail_at_byte(std::size_t offset, const std::string& reason) const {
  throw InputError::at_byte(name, offset, reason);
}

void ReadProgress::report(std::size_t offset) {
  constexpr std::size_t k_bytes_between_reports = std::size_t{4} << 20;
  next_ = offset + k_bytes_between_reports;
  const double size = static_cast<double>(std::max<std::size_t>(file_.content.size(), 1));
  report_progress(file_.progress, "read", std::min(1.0, static_cast<double>(offset) / size));
}

void check_place(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) throw InputError::in_file(path.string(), "is a folder");
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder))
    throw InputError::in_file(path.string(), "there is no folder " + folder.string());
}

std::string lower_case_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t k_longest = 40;
  std::string result = "'";
  for (const char c : text.substr(0, k_longest)) result += c >= ' ' && c <= '~' ? c : '?';
  return result + (text.size() > k_longest ? "...'" : "'");
}

void check_countable(const InputFile& file, std::size_t size, std::string_view elements) {
  if (size >= k_no_index)
    file.fail(fmt::format("more than {} {} can't be numbered", k_no_index - 1, elements));
}

namespace {

std::size_t count_isolated_vertices(const PolygonSoup& soup) {
  std::vector<bool> used(soup.positions.size(), false);
  for (const Index vertex : soup.corner_vertices) used[vertex] = true;
  return static_cast<std::size_t>(std::count(used.begin(), used.end(), false));
}

std::size_t count_polygons(const PolygonSoup& soup) {
  std::size_t polygons = 0;
  for (std::size_t face = 0; face < soup.n_faces(); ++face)
    if (soup.face_size(face) > 3) ++polygons;
  return polygons;
}

}  // namespace

std::vector<std::string> left_out(const PolygonSoup& soup, const FormatAbility& ability) {
  std::vector<std::string> result;
  const auto add = [&result](std::size_t count, const char* one, const char* many) {
    if (count > 0) result.push_back(fmt::format("{} {}", count, count == 1 ? one : many));
  };
  if (!ability.polygons) {
    add(count_polygons(soup), "polygon with more than three corners (cut into triangles)",
        "polygons with more than three corners (cut into triangles)");
  }
  if (!ability.isolated_vertices) {
    add(count_isolated_vertices(soup), "vertex that no face uses", "vertices that no face uses");
  }
  if (!ability.corner_uvs && !soup.corner_uvs.empty()) result.emplace_back("texture coordinates");
  if (!ability.corner_normals && !soup.corner_normals.empty()) result.emplace_back("normals");
  if (!ability.vertex_colors && !soup.vertex_colors.empty()) result.emplace_back("vertex colours");
  if (!ability.vertex_scalars) {
    for (const VertexScalar& scalar : soup.vertex_scalars) {
      result.push_back(fmt::format("the scalar {} of the vertices", in_quotes(scalar.name)));
    }
  }
  if (!ability.materials) add(soup.materials.size(), "material", "materials");
  if (!ability.feature_edges) add(soup.feature_edges.size(), "feature edge", "feature edges");
  return result;
}

namespace {

namespace fs = std::filesystem;

/// Puts pictures beside a file.
class PicturePlacer {
 public:
  PicturePlacer(const fs::path& file, OutputFile& output) : file_(file), output_(output) {}

  std::string name_of(const std::string& texture, const std::string& picture) {
    const fs::path named = picture_path(file_.parent_path(), texture);
    if (holds(named, picture)) return texture;
    const std::string own = named.filename().string(), stem = file_.stem().string();
    std::string name = own;
    for (int k = 1; is_taken(name, picture); ++k)
      name = k == 1 ? fmt::format("{}_{}", stem, own) : fmt::format("{}_{}_{}", stem, k, own);
    output_.beside.emplace_back(file_.parent_path() / name, picture);
    return name;
  }

 private:
  static bool holds(const fs::path& file, const std::string& content) {
    std::error_code failed;
    return fs::is_regular_file(file, failed) && fs::file_size(file, failed) == content.size() &&
           read_whole_file(file) == content;
  }
  bool is_taken(const std::string& name, const std::string& picture) const {
    const fs::path path = file_.parent_path() / name;
    for (const auto& [beside, content] : output_.beside) {
      if (beside == path) return true;
    }
    std::error_code ignored;
    return fs::exists(path, ignored) && !holds(path, picture);
  }

  const fs::path& file_;
  OutputFile& output_;
};

}  // namespace

std::vector<Material> with_pictures_beside(const fs::path& path, std::vector<Material> materials,
                                           OutputFile& output) {
  PicturePlacer placer(path, output);
  std::map<const std::string*, std::string> names;
  for (Material& material : materials) {
    const PictureBytes& picture = material.base_color_picture;
    if (!picture) continue;
    const auto [name, is_new] = names.try_emplace(picture.get());
    if (is_new) name->second = placer.name_of(material.base_color_texture, *picture);
    material.base_color_texture = name->second;
  }
  return materials;
}

float to_float(double value) {
  if (std::abs(value) > static_cast<double>(std::numeric_limits<float>::max())) {
    throw InputError(fmt::format("{} exceeds the range of 32-bit floats", value));
  }
  return static_cast<float>(value);
}

double rounded_to_float(double value) { return static_cast<double>(static_cast<float>(value)); }

bool loses_digits_as_float(const PolygonSoup& soup) {
  return std::any_of(soup.positions.begin(), soup.positions.end(), [](const Vec3& position) {
    return std::any_of(position.begin(), position.end(), [](double x) { return rounded_to_float(x) != x; });
  });
}

}  // namespace recede::detail
