// Material files of Wavefront OBJ: names, base colours and base colour textures.
#pragma once

#include <recede/geometry/material.h>

#include <filesystem>
#include <string>
#include <vector>

namespace recede::detail {

/// The materials of a file. `Kd` and `d` (or `Tr`) make the base colour, `map_Kd` the texture; the rest isn't
/// kept. Throws `InputError` with the file's line.
std::vector<Material> read_mtl(const std::filesystem::path& path);

std::string format_mtl(const std::vector<Material>& materials);

}  // namespace recede::detail
