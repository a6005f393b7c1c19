#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/mtl_io.h>
#include <recede/geometry/detail/text_scanner.h>
#include <recede/geometry/detail/text_writer.h>

#include <cmath>

namespace recede::detail {

namespace {

// "map_Kd -s 2 2 1 wood.png": what stands behind options is the last word; without options, a name may hold
// blanks.
std::string texture_name(std::string_view rest) {
  if (rest.empty() || rest.front() != '-') return std::string(rest);
  const std::size_t blank = rest.find_last_of(" \t");
  return std::string(blank == std::string_view::npos ? rest : rest.substr(blank + 1));
}

double unit_number(TextScanner& scanner) {
  const double value = scanner.number();
  if (!std::isfinite(value)) scanner.fail("a colour isn't finite");
  return value;
}

void read_diffuse_colour(TextScanner& scanner, Material& material) {
  scanner.skip_blanks();
  const std::string_view first = TextScanner(scanner).word();
  if (first == "spectral" || first == "xyz") return;  // not red, green, blue: the default stays
  material.base_color[0] = unit_number(scanner);
  // One number stands for all three.
  if (scanner.at_line_end()) {
    material.base_color[1] = material.base_color[2] = material.base_color[0];
    return;
  }
  material.base_color[1] = unit_number(scanner);
  material.base_color[2] = unit_number(scanner);
}

}  // namespace

std::vector<Material> read_mtl(const std::filesystem::path& path) {
  const std::string content = read_whole_file(path);
  const InputFile file{path, path.string(), content};
  TextScanner scanner(file);
  std::vector<Material> materials;
  for (; !scanner.at_end(); scanner.next_line()) {
    if (scanner.at_line_end()) continue;
    const std::string_view statement = scanner.word();
    if (statement == "newmtl") {
      materials.emplace_back();
      materials.back().name = scanner.rest_of_line();
    } else if (materials.empty()) {
      continue;
    } else if (statement == "Kd") {
      read_diffuse_colour(scanner, materials.back());
    } else if (statement == "d" || statement == "Tr") {
      if (TextScanner(scanner).word() == "-halo") scanner.word();
      const double value = unit_number(scanner);
      materials.back().base_color[3] = statement == "d" ? value : 1.0 - value;
    } else if (statement == "map_Kd") {
      materials.back().base_color_texture = texture_name(scanner.rest_of_line());
    }
  }
  return materials;
}

std::string format_mtl(const std::vector<Material>& materials) {
  TextWriter out;
  out << "# Written by Recede\n";
  for (const Material& material : materials) {
    out << "\nnewmtl " << material.name << "\nKd ";
    out.list(material.base_color.head<3>()) << "\nd " << material.base_color[3] << '\n';
    if (!material.base_color_texture.empty()) out << "map_Kd " << material.base_color_texture << '\n';
  }
  return out.take();
}

}  // namespace recede::detail
