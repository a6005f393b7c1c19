// Texels of billboards' textures, as they are averaged and as they are stored.
#pragma once

#include <recede/geometry/raster.h>

#include <Eigen/Core>

namespace recede::detail {

/// Colour, linear; normal; height as a share of its range, 0 to 1.
using TexelValues = Eigen::Matrix<float, 7, 1>;

/// What an atlas holds.
struct BillboardRasters {
  Raster &color, &normal, &height;

  void start(int columns, int rows);
  void append(const TexelValues& values, float opacity);
};

/// Of the texel with a number, row by row; its opacity goes to `opacity`.
TexelValues texel_values(const Raster& color, const Raster& normal, const Raster& height, std::size_t texel,
                         float& opacity);

}  // namespace recede::detail
