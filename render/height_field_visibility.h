// What the places of a displaced plane see of each other: precomputed once, for light, shadows and
// reflectance without further rays.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/render/displaced_plane.h>
#include <recede/render/sphere_directions.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace recede {

struct VisibilityOptions {
  int directions = 128;  ///< over the whole sphere, 6 to 4096
  /// Places along u and v, up to 32 768 each. 0: as many as the map has texels.
  int columns = 0, rows = 0;
};

/// What is seen from a place in one direction.
struct SeenPlace {
  static constexpr std::uint16_t k_nothing = 0xffff;  ///< as a column: the sky
  static constexpr std::uint16_t k_below = 0xfffe;    ///< as a column: the direction leads under the facet

  std::uint16_t column = k_nothing, row = 0;

  bool is_place() const { return column < k_below; }
  bool is_nothing() const { return column == k_nothing; }
  bool operator==(const SeenPlace&) const = default;
};

/// The scatter textures of Heidrich, Daubert, Kautz and Seidel ("Illuminating micro geometry based on
/// precomputed visibility", 2000): for each direction, which place every place sees.
///
/// Places are the middles of the map's cells, where facets have one normal, rather than its texels, where
/// four of them meet: place (x, y) is at u = x / columns, v = 1 - y / rows. Row 0 is on top.
struct HeightFieldVisibility {
  int columns = 0, rows = 0;
  Vec2 sides = Vec2::Ones();  ///< of the plane
  SphereDirections sphere{};
  std::vector<double> heights{};  ///< by place, row by row
  std::vector<Vec3> normals{};    ///< by place, unit length
  std::vector<SeenPlace> seen{};  ///< by direction, then place
  /// As `seen`: lengths of the way there, in the units of the heights; 0 where no place is seen. With the
  /// direction they say in which copy of the map the seen place lies.
  std::vector<float> distances{};

  std::size_t place_count() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x);
  }
  std::size_t place(const SeenPlace& seen_place) const { return place(seen_place.column, seen_place.row); }
  /// The one nearest to a texture coordinate; periodic.
  std::size_t place_near(const Vec2& uv) const;
  /// In the unit square, but for v = 1 of row 0.
  Vec2 uv(std::size_t place) const;
  const SeenPlace& seen_from(std::size_t place, std::size_t direction) const {
    return seen[direction * place_count() + place];
  }
  float distance_from(std::size_t place, std::size_t direction) const {
    return distances[direction * place_count() + place];
  }
  std::size_t bytes() const { return sizeof(SeenPlace) * seen.size() + sizeof(float) * distances.size(); }
};

/// Four places around a texture coordinate, and how much each of them counts. Periodic.
struct PlaceMix {
  std::array<std::size_t, 4> places{};
  std::array<double, 4> weights{};
};
PlaceMix mix_of_places(int columns, int rows, const Vec2& uv);

/// Traces one ray for each place and direction that isn't below its facet, against the surface itself (see
/// `DisplacedPlane`), and keeps the place nearest to its hit, in whichever copy. A hit from the back counts
/// as nothing. One that is nearest to the place itself is kept: rays start above the surface and meet it
/// exactly, so it is no rounding but another facet, which begins there when the place lies in a crease.
///
/// Same bytes for any number of threads. Throws `OptionError` for options out of range or more than 2^30
/// pairs of place and direction, `InputError` when the map has more texels along a side than there can be
/// places, and `Cancelled`.
HeightFieldVisibility compute_visibility(const DisplacedPlane& plane, const VisibilityOptions& options = {},
                                         Progress* progress = nullptr);

/// Whether a place is open towards a unit direction, by a ray: the truth that the rest approximates. False
/// below the place's facet. `plane` is that of the visibility.
bool is_open(const DisplacedPlane& plane, const HeightFieldVisibility& visibility, std::size_t place,
             const Vec3& direction);

/// How far it is from a place to the surface in a unit direction, by the same ray; infinite when it is open.
double distance_to_hit(const DisplacedPlane& plane, const HeightFieldVisibility& visibility,
                       std::size_t place, const Vec3& direction);

/// Whether a place is open by the nearest of the directions alone. False below the place's facet and at or
/// below the horizon.
bool is_open_by_nearest(const HeightFieldVisibility& visibility, std::size_t place, const Vec3& direction);

/// How open a place is, 0 to 1, linear between the three directions around. Those below the facet count as
/// the others do that aren't; 0 below the facet and at or below the horizon.
double openness_by_three(const HeightFieldVisibility& visibility, std::size_t place, const Vec3& direction);

}  // namespace recede
