// How low light may stand to reach a place of a height field, by azimuth (after Max 1988).
#pragma once

#include <recede/render/height_field_visibility.h>

#include <cstddef>
#include <vector>

namespace recede::detail {

/// What of a height field ends the view from a place along an azimuth: everything above it is open.
struct Crest {
  /// Height over level distance of the line to it; right within a quarter of a degree.
  float slope = 0;
  /// Level distance to it, units of the heights; 0 where nothing ends the view above the horizon, negative
  /// where the place's own facet does and nothing before it.
  float distance = 0;
};

/// The crests around the places of a visibility, found by rays.
struct HorizonMap {
  std::vector<Vec2> directions{};  ///< of the azimuths, evenly from u on, unit length
  std::vector<Crest> crests{};     ///< by place, azimuth

  const Crest* of_place(std::size_t place) const { return crests.data() + place * directions.size(); }
};

/// Same values for any number of threads. Throws `Cancelled`.
HorizonMap find_horizons(const DisplacedPlane& plane, const HeightFieldVisibility& visibility, int azimuths,
                         Progress* progress);

/// The slopes above which a point of the surface is open, one for each azimuth into `slopes`: the median of
/// those to the crests of the four places around, as the point sees them and by how near they are. Means
/// would follow the steep slopes to crests that the point is about to pass. Places whose own facet ends the
/// view tell nothing about others, so they are left out; where all do, the slope is 0 and the facet of the
/// point itself has to tell.
void horizons_at(const HorizonMap& map, const HeightFieldVisibility& visibility, const Vec2& uv,
                 double height, double* slopes);

}  // namespace recede::detail
