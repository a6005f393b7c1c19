#include <recede/geometry/detail/ply_header.h>
#include <recede/geometry/detail/text_scanner.h>
#include <recede/geometry/detail/text_writer.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace recede::detail {

namespace {

PlyType type_named(const TextScanner& scanner, std::string_view name) {
  constexpr std::array<std::array<std::string_view, 2>, 8> k_names{{{"char", "int8"},
                                                                    {"uchar", "uint8"},
                                                                    {"short", "int16"},
                                                                    {"ushort", "uint16"},
                                                                    {"int", "int32"},
                                                                    {"uint", "uint32"},
                                                                    {"float", "float32"},
                                                                    {"double", "float64"}}};
  for (std::size_t i = 0; i < k_names.size(); ++i) {
    if (name == k_names[i][0] || name == k_names[i][1]) return static_cast<PlyType>(i);
  }
  scanner.fail("unknown property type " + in_quotes(name));
}

void read_property(TextScanner& scanner, PlyHeader& header) {
  if (header.elements.empty()) scanner.fail("property before the first element");
  PlyProperty property;
  std::string_view type = scanner.word();
  if (type == "list") {
    property.is_list = true;
    property.count_type = type_named(scanner, scanner.word());
    type = scanner.word();
  }
  property.type = type_named(scanner, type);
  property.name = scanner.word();
  if (property.name.empty()) scanner.fail("property without a name");
  header.elements.back().properties.push_back(std::move(property));
}

void read_element(TextScanner& scanner, PlyHeader& header) {
  PlyElement element;
  element.name = scanner.word();
  if (element.name.empty()) scanner.fail("element without a name");
  if (header.find(element.name) != nullptr) scanner.fail("second element " + in_quotes(element.name));
  element.count = scanner.count("the number of elements");
  header.elements.push_back(std::move(element));
}

// A quoted text and the blanks before it. False when there is none.
bool take_quoted(std::string_view& text, std::string& result) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  if (text.empty() || text.front() != '"') return false;
  result.clear();
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '"') {
      text.remove_prefix(i + 1);
      return true;
    }
    if (text[i] == '\\' && i + 1 < text.size()) ++i;
    result += text[i];
  }
  return false;
}

bool take_number(std::string_view& text, double& value) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const auto parsed = fast_float::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc() || !std::isfinite(value)) return false;
  text.remove_prefix(static_cast<std::size_t>(parsed.ptr - text.data()));
  return true;
}

// Comments are free text: what doesn't follow the form to its end, or comes out of order, isn't about our
// materials.
void read_material_comment(std::string_view text, PlyHeader& header) {
  double index = 0.0;
  Material material;
  if (!take_number(text, index) || index != static_cast<double>(header.materials.size())) return;
  if (!take_quoted(text, material.name)) {
    material.name = text;
    if (!text.empty()) header.materials.push_back(std::move(material));
    return;
  }
  for (double& component : material.base_color) {
    if (!take_number(text, component)) return;
  }
  if (!take_quoted(text, material.base_color_texture)) return;
  header.materials.push_back(std::move(material));
}

void read_comment(TextScanner& scanner, PlyHeader& header) {
  std::string_view text = scanner.rest_of_line();
  for (const std::string_view keyword : {"material ", "TextureFile "}) {
    if (!text.starts_with(keyword)) continue;
    text.remove_prefix(keyword.size());
    if (keyword == "material ") return read_material_comment(text, header);
    header.texture_files.emplace_back(text);
  }
}

PlyHeader::Encoding read_encoding(TextScanner& scanner) {
  const std::string_view name = scanner.word();
  const std::string_view version = scanner.word();
  if (version != "1.0") scanner.fail("unknown PLY version " + in_quotes(version));
  if (name == "ascii") return PlyHeader::Encoding::ascii;
  if (name == "binary_little_endian") return PlyHeader::Encoding::little_endian;
  if (name == "binary_big_endian") return PlyHeader::Encoding::big_endian;
  scanner.fail("unknown PLY encoding " + in_quotes(name));
}

}  // namespace

bool PlyElement::has(std::string_view property) const {
  return std::any_of(properties.begin(), properties.end(),
                     [&](const PlyProperty& p) { return p.name == property; });
}

const PlyElement* PlyHeader::find(std::string_view element) const {
  const auto found =
      std::find_if(elements.begin(), elements.end(), [&](const PlyElement& e) { return e.name == element; });
  return found == elements.end() ? nullptr : &*found;
}

PlyHeader read_ply_header(const InputFile& file) {
  TextScanner scanner(file);
  PlyHeader header;
  if (scanner.word() != "ply") scanner.fail("isn't a PLY file (it doesn't start with 'ply')");
  bool has_encoding = false;
  for (;;) {
    scanner.next_line();
    if (scanner.at_end()) scanner.fail("the header has no end_header");
    const std::string_view keyword = scanner.word();
    if (keyword == "end_header") break;
    if (keyword == "format") {
      header.encoding = read_encoding(scanner);
      has_encoding = true;
    } else if (keyword == "element") {
      read_element(scanner, header);
    } else if (keyword == "property") {
      read_property(scanner, header);
    } else if (keyword == "comment") {
      read_comment(scanner, header);
    } else if (keyword != "obj_info" && !keyword.empty()) {
      scanner.fail("unknown header line " + in_quotes(keyword));
    }
  }
  if (!has_encoding) scanner.fail("the header has no format line");
  scanner.next_line();
  header.body_offset = scanner.offset();
  header.body_line = scanner.line();
  return header;
}

std::string format_material_comment(std::size_t index, const Material& material) {
  const auto escaped = [](const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
      if (c == '"' || c == '\\') result += '\\';
      result += c == '\n' || c == '\r' ? ' ' : c;
    }
    return result + '"';
  };
  TextWriter out;
  out << "material " << index << ' ' << escaped(material.name) << ' ';
  out.list(material.base_color) << ' ' << escaped(material.base_color_texture);
  return out.take();
}

}  // namespace recede::detail
