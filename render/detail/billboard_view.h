// What places of billboards with reflectance send to viewers.
#pragma once

#include <recede/geometry/vec.h>
#include <recede/render/billboard_reflectance.h>
#include <recede/render/image.h>

#include <array>
#include <memory>

namespace recede::detail {

/// Reflectance, and what it sums to.
struct ReflectanceTables {
  explicit ReflectanceTables(std::shared_ptr<const BillboardReflectance> with);

  std::shared_ptr<const BillboardReflectance> reflectance;
  DirectionGrid views, lights;
  /// As `LocalPca::parts` of the radiance, over all lights: by cluster, view and colour, per radiance that
  /// comes from everywhere.
  std::vector<float> sky;
};

/// A place between four texels of a billboard, as one viewer sees it.
struct BillboardView {
  const ReflectanceTables* tables = nullptr;  ///< null: no reflectance
  Eigen::Matrix3d to_side;  ///< from directions of the scene to any length along the axes of the seen side
  NodeMix views;
  std::array<std::uint32_t, 4> vectors;  ///< of the texels
  /// By texel and view, with the opacity of each: they sum to 1, or are 0 where nothing is seen.
  std::array<std::array<float, 4>, 4> shares;

  /// Radiance that leaves towards the viewer per irradiance of what faces the light.
  Rgb value(const Vec3& toward_light) const;
  /// Radiance that leaves towards the viewer per radiance that comes from everywhere.
  Rgb albedo() const;
};

}  // namespace recede::detail
