// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <string_view>

namespace recede {

/// Writes `content` beside `path` and renames it into place. Throws `InputError` with the system's reason and
/// leaves nothing behind when the file can't be written.
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// The whole file. Throws `InputError` when it is missing, unreadable or a folder.
std::string read_whole_file(const std::filesystem::path& path);

}  // namespace recede
