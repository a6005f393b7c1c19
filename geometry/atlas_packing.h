// Rectangles into one square, without overlap.
#pragma once

#include <recede/geometry/vec.h>

#include <span>
#include <vector>

namespace recede {

struct PackingOptions {
  int resolution = 1024;  ///< texels along each side of the square
  int gutter = 4;  ///< whole texels that stay free between two rectangles, and half as many at the border
};

/// Where rectangles went. All of them have the same scale.
struct PackedRectangles {
  struct Place {
    int x = 0, y = 0;     ///< texel of the lower left corner
    bool turned = false;  ///< the rectangle's first side is the vertical one
  };
  std::vector<Place> places;   ///< one for each rectangle
  double texels_per_unit = 0;  ///< scale of the rectangles' sides
  int resolution = 0;          ///< a power of two times the one asked for, where gutters alone filled that
  double occupancy = 0;        ///< share of the square that rectangles cover, 0 to 1
};

/// Packs rectangles of the given sides (any unit, positive and finite) as large as they fit, with axes along
/// the square's. Highest first, each as low as it fits above what is there (bottom-left by skyline); the
/// scale is found by bisection. Throws `OptionError` for a resolution below 1 or above 65 536 or a negative
/// gutter, and `InputError` for sides that aren't positive, or more rectangles than 65 536 squared texels
/// hold.
PackedRectangles pack_rectangles(std::span<const Vec2> sides, const PackingOptions& options = {});

/// Rectangles of whole texels, in one of the smallest that holds them.
struct PackedTexels {
  std::vector<PackedRectangles::Place> places;  ///< one for each rectangle
  int width = 0, height = 0;                    ///< multiples of 4, as block compression wants them
};

/// Packs rectangles as they are, each turned or not, `gutter` texels apart: the least area of some widths,
/// none more than four times as long as high. Throws like `pack_rectangles`.
PackedTexels pack_texels(std::span<const Eigen::Vector2i> sizes, int gutter);

/// The rectangle of least area around some points.
struct BoundingRectangle {
  Vec2 corner = Vec2::Zero();  ///< the one from which both axes lead along the sides
  Vec2 axis{1, 0};             ///< unit vector along the first side; the second runs 90 degrees to the left
  Vec2 sides = Vec2::Zero();   ///< lengths
};

/// One side of it lies on a side of the points' convex hull (Freeman and Shapira 1975). `points` holds at
/// least one.
BoundingRectangle smallest_rectangle(std::span<const Vec2> points);

}  // namespace recede
