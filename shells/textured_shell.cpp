#include <recede/geometry/error.h>
#include <recede/shells/textured_shell.h>

namespace recede {

const ShellLayer& TexturedShell::layer() const {
  if (!shell) throw InputError("a texture needs a shell");
  if (!texture || texture->surfaces.empty()) throw InputError("a textured shell needs a texture");
  if (shell->base.corner_uvs.empty()) throw InputError("a textured shell needs texture coordinates");
  if (!coordinates.repeat.allFinite() || !coordinates.offset.allFinite() || coordinates.repeat.x() == 0 ||
      coordinates.repeat.y() == 0)
    throw InputError("a texture's periods must be finite and not 0");
  const std::optional<ShellLayer>& layer = side == ShellSide::interior ? shell->interior : shell->exterior;
  if (side == ShellSide::envelope || !layer) throw InputError("the shell has no layer on the texture's side");
  return *layer;
}

}  // namespace recede
