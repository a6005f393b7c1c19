// Whether a billboard cloud keeps what it promises.
#pragma once

#include <recede/lod/billboard_cloud.h>

namespace recede::bench {

struct CloudCheck {
  double distance = 0;  ///< the largest of a point of a face from its billboard's plane, over the error
  double deviation =
      0;  ///< the largest angle between a flat face that has a direction and its billboard, radians
  std::size_t bent = 0;       ///< faces that no plane across their normal is within the error of
  std::size_t uncovered = 0;  ///< faces with an area in no billboard
  std::size_t repeated = 0;   ///< faces in more than one

  bool is_sound(double largest_deviation) const;
};

/// From the model's points: no number that a billboard says of itself is used.
CloudCheck check_cloud(const PolygonSoup& model, const BillboardCloud& cloud, bool is_two_sided);

/// Of rectangles, in texels with sides of the cloud's error.
std::size_t count_texels(const BillboardCloud& cloud);

}  // namespace recede::bench
