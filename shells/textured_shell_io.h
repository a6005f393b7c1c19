// Files of textured shells.
#pragma once

#include <recede/shells/textured_shell.h>

#include <filesystem>

namespace recede {

/// The base's triangles, which of them are halves of quads, with texture coordinates and vertex colours, the
/// layer's tops, and the finest texture with its coordinates, compressed (Zstandard). Materials, scalars and
/// another layer of the shell aren't kept. The same bytes for the same shell. Throws `InputError` for what
/// `TexturedShell::layer` refuses and files that can't be written.
void write_textured_shell(const std::filesystem::path& path, const TexturedShell& textured);

struct ReadShellOptions {
  /// Makes the smaller versions of the texture (`make_mipmap`), which pictures from afar need; else there is
  /// the finest alone.
  bool make_mipmap = true;
};

/// Checks the layer (`check_shell`). Throws `InputError` for files that can't be read, are damaged, or hold
/// what has no meaning, and `Cancelled`.
TexturedShell read_textured_shell(const std::filesystem::path& path, const ReadShellOptions& options = {},
                                  Progress* progress = nullptr);

/// Ends in `.shell`.
bool is_textured_shell(const std::filesystem::path& path);

}  // namespace recede
