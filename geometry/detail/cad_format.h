// Kinds of CAD files, told by the ends of their names.
#pragma once

#include <filesystem>
#include <optional>

namespace recede::detail {

enum class CadFormat { step, iges, brep };

std::optional<CadFormat> cad_format_of(const std::filesystem::path& path);

}  // namespace recede::detail
