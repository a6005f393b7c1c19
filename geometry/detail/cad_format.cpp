#include <recede/geometry/cad_import.h>
#include <recede/geometry/detail/cad_format.h>
#include <recede/geometry/detail/format_io.h>

#include <array>
#include <string_view>
#include <utility>

namespace recede {

std::optional<detail::CadFormat> detail::cad_format_of(const std::filesystem::path& path) {
  constexpr std::array<std::pair<std::string_view, CadFormat>, 6> k_extensions{{{".step", CadFormat::step},
                                                                                {".stp", CadFormat::step},
                                                                                {".iges", CadFormat::iges},
                                                                                {".igs", CadFormat::iges},
                                                                                {".brep", CadFormat::brep},
                                                                                {".brp", CadFormat::brep}}};
  const std::string extension = lower_case_extension(path);
  for (const auto& [known, format] : k_extensions) {
    if (extension == known) return format;
  }
  return {};
}

bool is_cad_path(const std::filesystem::path& path) { return detail::cad_format_of(path).has_value(); }

}  // namespace recede
