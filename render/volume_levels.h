// The levels of a volume texture that a picture needs.
#pragma once

#include <recede/render/shell_volume.h>

namespace recede {

/// The coarsest level of its texture that rays of the view see of the shell, with what is finer than a pixel
/// in the place that is farthest away.
int coarsest_level_seen(const TexturedShell& textured, const VolumeView& view);

/// The shell with the levels that the view needs, made of the finest (`make_mipmap`): pictures are those of
/// all levels. Levels of volumes take seconds to minutes, most of them for matter that is seen from afar
/// only.
TexturedShell with_levels_for(const TexturedShell& textured, const VolumeView& view);

}  // namespace recede
