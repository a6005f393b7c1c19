// appearances PICTURE.png: a wavy plane from four angles, displaced, with its heights as a bump map, as a
// redistributed bump map, and by a reflectance table. The light stands behind it.
#include <recede/geometry/error.h>
#include <recede/render/image.h>
#include <recede/render/redistributed_bump.h>
#include <recede/render/reflectance_table.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <random>
#include <vector>

namespace {

using namespace recede;

constexpr double k_pi = std::numbers::pi;

/// Forty waves of up to four to a side of the map.
DisplacementMap make_waves(int size, double height) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> frequency(-4, 4);
  std::uniform_real_distribution<double> phase(0, 2 * k_pi);
  const auto side = static_cast<std::size_t>(size);
  std::vector<float> heights(side * side, 0.0F);
  for (int wave = 0; wave < 40; ++wave) {
    const int u = frequency(random), v = frequency(random);
    const double start = phase(random);
    for (std::size_t i = 0; i < heights.size(); ++i) {
      const double x = static_cast<double>(i % side) / size, y = static_cast<double>(i / side) / size;
      heights[i] += static_cast<float>(height / 40 * std::cos(2 * k_pi * (u * x + v * y) + start));
    }
  }
  return {size, size, std::move(heights), MapBorder::periodic};
}

/// What a viewer sees where a ray through a place of the plane lands; white is 1.
using Shading = std::function<double(const Vec2& place, const Vec3& toward_viewer, const Vec3& toward_light)>;

Vec3 direction_at(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

/// The light stands behind the plane, a little to the side, whatever the viewer's azimuth is.
double shade(const Shading& shading, const Vec2& place, double view_angle, double azimuth) {
  return shading(place, direction_at(view_angle, azimuth), direction_at(0.8, azimuth + 2.7));
}

/// The plane without end in parallel projection.
Image picture_of(const Shading& shading, double view_angle) {
  constexpr int k_width = 128, k_height = 84, k_side = 4;
  constexpr double k_azimuth = 0.3;
  const Vec2 nearer(std::cos(k_azimuth), std::sin(k_azimuth)), right(-nearer.y(), nearer.x());
  Image image(k_width, k_height);
  tbb::parallel_for(0, k_height, [&](int y) {
    for (int x = 0; x < k_width; ++x) {
      double sum = 0;
      for (int sample = 0; sample < k_side * k_side; ++sample) {
        const double across = (x + (sample % k_side + 0.5) / k_side) / k_width;
        const double down = (y + (sample / k_side + 0.5) / k_side) / k_width / std::cos(view_angle);
        sum += shade(shading, across * right + down * nearer, view_angle, k_azimuth);
      }
      image.at(x, y) = Rgb::Constant(static_cast<float>(sum / (k_side * k_side)));
    }
  });
  return image;
}

/// Over the whole plane and all azimuths: places that are even over it are even over its picture.
double mean_of(const Shading& shading, double view_angle) {
  constexpr int k_count = 1 << 17;
  double sum = 0;
  for (int i = 0; i < k_count; ++i) {
    const double u = i * 0.7548776662466927, v = i * 0.5698402909980532;  // fill the square evenly
    const Vec2 place(u - std::floor(u), v - std::floor(v));
    sum += shade(shading, place, view_angle, 2 * k_pi * i / k_count) / k_count;
  }
  return sum;
}

Image below_each_other(const std::vector<Image>& rows) {
  Image all(rows[0].width, rows[0].height * static_cast<int>(rows.size()));
  all.pixels.clear();
  for (const Image& row : rows) all.pixels.insert(all.pixels.end(), row.pixels.begin(), row.pixels.end());
  return all;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: appearances PICTURE.png\n";
    return 2;
  }
  const recede::DisplacementMap map = make_waves(64, 0.3);
  const recede::DisplacedPlane plane(map, {1, 1});
  const recede::VisibleNormals normals = recede::sample_visible_normals(plane);
  const recede::RedistributedBump bump(normals);
  const recede::ReflectanceTable table = recede::make_reflectance_table(normals);

  const auto lit = [](const recede::Vec3& normal, const recede::Vec3& toward_light) {
    return std::max(0.0, normal.dot(toward_light));
  };
  const std::pair<const char*, Shading> kinds[] = {
      {"displaced",
       [&](const recede::Vec2& place, const recede::Vec3& viewer, const recede::Vec3& light) {
         const recede::Vec3 start(place.x(), place.y(), plane.heights().max);
         const auto hit = plane.first_hit(start + viewer, -viewer);
         return hit ? lit(hit->normal, light) : 0.0;
       }},
      {"bump map", [&](const recede::Vec2& place, const recede::Vec3&,
                       const recede::Vec3& light) { return lit(plane.normal_at(place), light); }},
      {"redistributed",
       [&](const recede::Vec2& place, const recede::Vec3& viewer, const recede::Vec3& light) {
         return lit(bump.normal_for_view(plane.normal_at(place), viewer), light);
       }},
      {"table", [&](const recede::Vec2&, const recede::Vec3& viewer,
                    const recede::Vec3& light) { return table.value(viewer, light); }},
  };

  std::vector<recede::Image> rows;
  for (const auto& [name, shading] : kinds) {
    std::vector<recede::Image> pictures;
    std::cout << fmt::format("{:14}", name);
    for (const double degrees : {15, 45, 70, 80}) {
      pictures.push_back(picture_of(shading, degrees * k_pi / 180));
      std::cout << fmt::format("  {:.4f} at {}", mean_of(shading, degrees * k_pi / 180), degrees);
    }
    std::cout << '\n';
    rows.push_back(recede::side_by_side(pictures));
  }
  recede::write_png(argv[1], below_each_other(rows));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
