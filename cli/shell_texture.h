// Textures for shells, by name.
#pragma once

#include "common.h"
#include <recede/shells/textured_shell.h>

namespace recede::cli {

struct ShellTextureOptions {
  std::string name;  ///< empty: none
  std::optional<double> periods;
  std::optional<int> texels;
  int layers = 16;  ///< of `empty` and `solid`, texels along r
  std::uint32_t seed = 1;
  double time = 0;
  double growth = 1;
};
/// Adds `--texture` and what belongs to it.
void add_shell_texture_options(CLI::App& command, ShellTextureOptions& options);

/// With the charts of an atlas where the surface has no texture coordinates.
PolygonSoup with_coordinates(PolygonSoup surface, Progress* progress);

/// In the layer on `side`, without smaller versions of the texture.
TexturedShell textured_shell(std::shared_ptr<const Shell> shell, ShellSide side,
                             const ShellTextureOptions& options, Progress* progress);

}  // namespace recede::cli
