// height_field PICTURE.png: a fractal landscape of 2048 x 2048 heights, rendered by its own rays, with
// shadows.
#include <recede/geometry/displacement_levels.h>
#include <recede/geometry/error.h>
#include <recede/geometry/height_field.h>
#include <recede/render/camera.h>
#include <recede/render/image.h>

#include <tbb/parallel_for.h>

#include <cmath>
#include <iostream>
#include <random>
#include <vector>

namespace {

using namespace recede;

/// Midpoint displacement on a periodic grid of 2^steps a side: every round halves the distance between known
/// heights and the size of what is added to their means.
std::vector<float> make_fractal(int steps) {
  const int size = 1 << steps;
  std::mt19937 random(12);
  std::uniform_real_distribution<float> change(-1, 1);
  std::vector<float> heights(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), 0.0F);
  const auto at = [&](int x, int y) -> float& {
    return heights[static_cast<std::size_t>(y & (size - 1)) * static_cast<std::size_t>(size) +
                   static_cast<std::size_t>(x & (size - 1))];
  };
  float amplitude = 0.25F;
  for (int half = size / 2; half > 0; half /= 2, amplitude *= 0.46F) {
    for (int y = half; y < size; y += 2 * half) {
      for (int x = half; x < size; x += 2 * half) {
        const float sum =
            at(x - half, y - half) + at(x + half, y - half) + at(x - half, y + half) + at(x + half, y + half);
        at(x, y) = sum / 4 + amplitude * change(random);
      }
    }
    for (int y = 0; y < size; y += half) {
      for (int x = (y / half + 1) % 2 * half; x < size; x += 2 * half) {
        const float sum = at(x - half, y) + at(x + half, y) + at(x, y - half) + at(x, y + half);
        at(x, y) = sum / 4 + 0.7F * amplitude * change(random);
      }
    }
  }
  return heights;
}

/// What a ray sees: earth that turns to rock where it is steep, in sunlight with a little of the sky's.
Rgb color_along(const HeightField& field, const Vec3& origin, const Vec3& direction) {
  const Rgb sky(0.55F, 0.7F, 0.9F);
  const auto hit = field.first_hit(origin, direction);
  if (!hit) return sky;
  const Vec3 sun = Vec3(-0.7, 0.35, 0.5).normalized();
  const Vec3 point = origin + hit->t * direction;
  const double facing = hit->normal.dot(sun);
  const bool lit = facing > 0 && !field.is_hit(point + 1e-6 * hit->normal, sun);
  const auto steep = static_cast<float>(std::clamp(2.5 * (1 - hit->normal.z()), 0.0, 1.0));
  const Rgb ground = (1 - steep) * Rgb(0.35F, 0.4F, 0.2F) + steep * Rgb(0.45F, 0.38F, 0.33F);
  const float light = lit ? static_cast<float>(facing) : 0.0F;
  const auto open = static_cast<float>(0.5 + 0.5 * hit->normal.z());
  return ground.cwiseProduct(1.6F * light * Rgb(1.0F, 0.95F, 0.85F) + 0.45F * open * sky);
}

Image picture_of(const HeightField& field) {
  constexpr int k_width = 416, k_height = 208, k_side = 3;
  Camera camera;
  camera.position = {0.45, -0.05, 0.42};
  camera.target = {0.5, 0.5, 0.02};
  camera.field_of_view = 0.65;
  camera.up = Vec3::UnitZ();
  camera.width = k_width;
  camera.height = k_height;
  const CameraFrame frame = frame_of(camera);
  Image image(k_width, k_height);
  tbb::parallel_for(0, k_height, [&](int y) {
    for (int x = 0; x < k_width; ++x) {
      Rgb& pixel = image.at(x, y);
      for (int sample = 0; sample < k_side * k_side; ++sample) {
        const double dx = (sample % k_side + 0.5) / k_side, dy = (sample / k_side + 0.5) / k_side;
        pixel += color_along(field, frame.position, frame.direction(x + dx, y + dy)) / (k_side * k_side);
      }
    }
  });
  return image;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: height_field PICTURE.png\n";
    return 2;
  }
  const recede::DisplacementMap map(2048, 2048, make_fractal(11), recede::MapBorder::periodic);
  const recede::HeightField field(map);
  std::cout << map.bytes() << " bytes of heights, " << field.bounds().bytes() << " of bounds\n";
  if (const auto hit = field.first_hit({0.5, -1, 1}, {0, 1, -0.7})) {
    std::cout << "a ray lands at (" << hit->uv.x() << ", " << hit->uv.y() << ") after " << hit->t << '\n';
  }

  const recede::DisplacementLevels levels(map);
  std::cout << "level 4 is off by " << levels.difference(4).mean << " in the mean, "
            << levels.difference(4).max << " at most\n";

  recede::write_png(argv[1], picture_of(field));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
