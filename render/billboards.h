// Billboard clouds in scenes.
#pragma once

#include <recede/lod/billboard_texture.h>

#include <memory>
#include <vector>

namespace recede {

/// A cloud with textures, at one or more places. Rays meet the surface that heights make over each billboard
/// where it isn't transparent, from both sides.
struct PlacedBillboards {
  std::shared_ptr<const BillboardTextures> textures;
  /// From the cloud's coordinates to the scene's; can be undone. None of them: nothing is drawn.
  std::vector<Eigen::Affine3d> placements{Eigen::Affine3d::Identity()};
};

}  // namespace recede
