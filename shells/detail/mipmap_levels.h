// Some of a mipmap's levels, for views that see no others.
#pragma once

#include <recede/shells/volume_mipmap.h>

namespace recede::detail {

/// `make_mipmap` without the levels that are coarser than `last_level`, 0 or more. Where all up to that keep
/// their shape there is one more of them, and none is transparent.
VolumeMipmap make_mipmap_to(int last_level, const VolumeTexture& texture, const MipmapOptions& options = {});

}  // namespace recede::detail
