// Pictures made by code.
#pragma once

#include <recede/geometry/raster.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace recede::test {

/// Red, green and blue, 8 bits, row by row from the top.
inline Raster raster_of(int width, int height, const std::vector<std::array<std::uint16_t, 3>>& texels) {
  Raster raster{.width = width, .height = height, .channels = 3, .bits = 8, .srgb = true, .samples = {}};
  for (const auto& texel : texels) raster.samples.insert(raster.samples.end(), texel.begin(), texel.end());
  return raster;
}

/// Of four colours: red and green above blue and white.
inline Raster four_colors() {
  return raster_of(2, 2, {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}});
}

/// The same with four texels of each, so that bilinear lookup finds the colours around the quarters' middles.
inline Raster four_quarters() {
  std::vector<std::array<std::uint16_t, 3>> texels;
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 4; ++x) {
      const Raster four = four_colors();
      texels.push_back({four.at(x / 2, y / 2, 0), four.at(x / 2, y / 2, 1), four.at(x / 2, y / 2, 2)});
    }
  }
  return raster_of(4, 4, texels);
}

inline std::shared_ptr<const std::string> png_of(const Raster& raster) {
  return std::make_shared<const std::string>(encode_png(raster));
}

}  // namespace recede::test
