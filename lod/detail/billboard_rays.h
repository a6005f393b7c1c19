// What billboards show: rays from in front of them on to the faces that they stand for.
#pragma once

#include <recede/lod/billboard_cloud.h>
#include <recede/lod/detail/embree_device.h>
#include <recede/lod/detail/surface_attributes.h>

#include <array>
#include <optional>

namespace recede::detail {

/// What a ray meets.
struct BillboardSample {
  bool is_own = false;  ///< a face that the billboard stands for, not one of its neighbours'
  TrianglePlace place;
  double height = 0;  ///< over the billboard, object units
  Vec3 color = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< unit, towards the viewer's side
};

/// Faces of a model in Embree.
class BillboardRays {
 public:
  /// Keeps references. Textures of the model are averaged over `spacing`, that of rays, object units.
  BillboardRays(const PolygonSoup& model, const BillboardCloud& cloud, double spacing = 0);
  BillboardRays(const BillboardRays&) = delete;
  BillboardRays& operator=(const BillboardRays&) = delete;

  /// The foremost face at a place of a billboard, by coordinates along its axes from its middle, that is near
  /// to it: its own ones, and others within the cloud's error that aren't turned farther away than it
  /// permits.
  std::optional<BillboardSample> sample(std::size_t billboard, const Vec2& at) const;
  /// The same as seen from a unit direction, not along the billboard: places are those where the ray goes
  /// through its plane.
  std::optional<BillboardSample> sample_towards(std::size_t billboard, const Vec2& at,
                                                const Vec3& viewer) const;

 private:
  const PolygonSoup& model_;
  const BillboardCloud& cloud_;
  double spacing_;
  SurfaceAttributes attributes_;
  std::vector<Index> billboard_of_;  // triangle
  std::vector<Vec3> normals_;        // of triangles
  std::vector<std::array<float, 4>> positions_;
  OwnedScene scene_;
  Vec3 center_ = Vec3::Zero();
  double scale_ = 1;
};

}  // namespace recede::detail
