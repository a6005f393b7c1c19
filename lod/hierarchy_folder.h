// Where a hierarchy is, from what a person names.
#pragma once

#include <filesystem>

namespace recede {

/// The folder `NAME.recede` that `read_hierarchy` takes: of itself, of its `hierarchy.json`, or of the folder
/// that `write_hierarchy` wrote it into, when there is one. Empty for anything that is no folder and no
/// `hierarchy.json`, such as a mesh. Throws `InputError` for folders with no hierarchy in them, or several.
std::filesystem::path hierarchy_folder(const std::filesystem::path& path);

}  // namespace recede
