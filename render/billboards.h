// Billboard clouds in scenes.
#pragma once

#include <recede/lod/billboard_texture.h>
#include <recede/render/billboard_reflectance.h>

#include <memory>
#include <vector>

namespace recede {

/// A cloud with textures, at one or more places. Rays meet the surface that heights make over each billboard
/// where it isn't transparent, from both sides.
struct PlacedBillboards {
  std::shared_ptr<const BillboardTextures> textures;
  /// From the cloud's coordinates to the scene's; can be undone. None of them: nothing is drawn.
  std::vector<Eigen::Affine3d> placements{Eigen::Affine3d::Identity()};
  /// Null, or that of these textures. Rays then meet the billboards' planes where their opacity in that view,
  /// bilinear between texels and views, is a half and more; and light that comes from a direction leaves as
  /// the reflectance says, from behind too. Shadows of the model on itself and light from face to face are in
  /// it, so that rays which leave such a billboard meet none of its placement. Placements should turn and
  /// scale alike in all directions.
  ///
  /// `Lighting::ambient` and the sky of the camera's light count by what leaves of light from everywhere, and
  /// the camera's lamp with the shadows of the model on itself.
  std::shared_ptr<const BillboardReflectance> reflectance = {};
};

}  // namespace recede
