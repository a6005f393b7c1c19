#include <recede/lod/detail/billboard_texels.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

float share_of(std::uint16_t byte) { return static_cast<float>(byte) / 255.0f; }

std::uint16_t byte_of(float share) {
  return static_cast<std::uint16_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
}

Raster raster(int width, int height, int channels, bool is_srgb) {
  return {.width = width, .height = height, .channels = channels, .bits = 8, .srgb = is_srgb, .samples = {}};
}

}  // namespace

void BillboardRasters::start(int columns, int rows) {
  color = raster(columns, rows, 4, true);
  normal = raster(columns, rows, 3, false);
  height = raster(columns, rows, 1, false);
}

void BillboardRasters::append(const TexelValues& values, float opacity) {
  for (int k = 0; k < 3; ++k) color.samples.push_back(byte_of(encode_srgb(values[k])));
  color.samples.push_back(byte_of(opacity));
  const Eigen::Vector3f unit = values.segment<3>(3).stableNormalized();
  for (int k = 0; k < 3; ++k) normal.samples.push_back(byte_of(0.5f + 0.5f * unit[k]));
  height.samples.push_back(byte_of(values[6]));
}

TexelValues texel_values(const Raster& color, const Raster& normal, const Raster& height, std::size_t texel,
                         float& opacity) {
  TexelValues values;
  for (std::size_t k = 0; k < 3; ++k) {
    values[static_cast<Eigen::Index>(k)] = decode_srgb(share_of(color.samples[4 * texel + k]));
    values[static_cast<Eigen::Index>(3 + k)] = 2 * share_of(normal.samples[3 * texel + k]) - 1;
  }
  values[6] = share_of(height.samples[texel]);
  opacity = share_of(color.samples[4 * texel + 3]);
  return values;
}

}  // namespace recede::detail
