// A plane that a periodic height map displaces, without end, and where rays meet it.
#pragma once

#include <recede/geometry/height_field.h>

#include <optional>

namespace recede {

/// The normals with which a displaced plane is shaded.
enum class PlaneNormals {
  facets,  ///< of the bilinear patches between texels; they jump from one to the next
  smooth   ///< by `DisplacementMap::smooth_derivative_at`
};

/// The surface (x, y, height) over the whole plane: a map lies side by side with itself. x grows with u, y
/// with v. Nothing is tessellated (see `HeightField`). Queries may run in parallel. Keeps a reference to the
/// map, which must stay in place.
class DisplacedPlane {
 public:
  /// `sides` are the lengths of the map along u and v, in the units of its heights: they decide how steep its
  /// slopes are. To make the heights s times as high, divide the sides by s: the shape is the same. Throws
  /// `InputError` unless the map is periodic (others jump where copies meet) and `OptionError` unless both
  /// lengths are finite and greater than 0.
  DisplacedPlane(const DisplacementMap& map, const Vec2& sides, PlaneNormals normals = PlaneNormals::facets);
  DisplacedPlane(DisplacementMap&&, const Vec2&, PlaneNormals = PlaneNormals::facets) = delete;

  struct Hit {
    double t = 0;                ///< in lengths of the direction
    Vec2 uv = Vec2::Zero();      ///< in the unit square
    Vec3 normal = Vec3::Zero();  ///< unit length, upwards
  };

  /// The first point in which a ray meets the surface, from above or below. A ray without direction, or with
  /// numbers that aren't finite, meets nothing; nor does one that runs so level that it passes over 65 536
  /// copies of the map.
  std::optional<Hit> first_hit(const Vec3& origin, const Vec3& direction) const;
  /// Whether there is one; faster.
  bool is_hit(const Vec3& origin, const Vec3& direction) const;

  /// The normal over a place of the map, as bump mapping has it: unit length, upwards.
  Vec3 normal_at(const Vec2& uv) const;

  const DisplacementMap& map() const { return field_.bounds().map(); }
  const Vec2& sides() const { return sides_; }
  /// The range of all heights.
  HeightRange heights() const { return heights_; }

 private:
  template <class Visit>
  void visit_copies(const Vec3& origin, const Vec3& direction, const Visit& visit) const;

  HeightField field_;
  Vec2 sides_;
  PlaneNormals normals_;
  HeightRange heights_;
};

}  // namespace recede
