// Corrections of transparent levels by direction.
#pragma once

#include <recede/shells/volume_mipmap.h>

namespace recede::detail {

/// What rays of one direction meet of a whole layer.
struct SeenLayer {
  double opacity;             ///< share of them that is stopped
  Vec3 normal;                ///< mean of the unit normals there
  Vec3 color = Vec3::Ones();  ///< mean, linear light; white without colours
};

/// By `MatterDirections`.
std::vector<SeenLayer> measure_layer(const VolumeTexture& texture);

/// Sets `corrections`, so that the layer is seen as it was measured.
void calibrate(const VolumeTexture& finest, const std::vector<SeenLayer>& exact, TransparentVolume& matter);

}  // namespace recede::detail
