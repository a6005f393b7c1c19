// light_between_places PICTURE.png: a height field under a low sun, displaced and as a bump map: by its
// normals alone, with the shadows that its heights cast, and with the light that its places pass to each
// other.
#include <recede/geometry/error.h>
#include <recede/render/diffuse_scattering.h>
#include <recede/render/image.h>
#include <recede/render/open_ellipses.h>
#include <recede/render/scattering_table.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <vector>

namespace {

using namespace recede;

constexpr double k_pi = std::numbers::pi;

/// Round hills in two rows, each of other hills beside it, with hollows between them.
DisplacementMap make_hills(int size) {
  std::vector<float> heights;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double u = (x + 0.5) / size, v = 1 - (y + 0.5) / size;
      const double rows = std::cos(4 * k_pi * v),
                   hills = std::cos(2 * k_pi * (u + v)) * std::cos(2 * k_pi * (u - v));
      heights.push_back(static_cast<float>(0.11 * hills + 0.03 * rows + 0.02 * std::cos(6 * k_pi * u)));
    }
  }
  return {size, size, std::move(heights), MapBorder::periodic};
}

Vec3 direction_at(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

/// How much light a place sends out, at a texture coordinate and for its normal there; white in the sun is 1.
using Shading = std::function<double(const Vec2& uv, const Vec3& normal)>;

constexpr double k_view_azimuth = -1.9;

/// The plane in parallel projection from an angle; `displaced` or with its heights as a bump map.
Image picture_of(const DisplacedPlane& plane, const Shading& shading, double view_angle, bool displaced) {
  constexpr int k_width = 200, k_height = 130, k_side = 3;
  const Vec3 viewer = direction_at(view_angle, k_view_azimuth);
  const Vec2 nearer = viewer.head<2>().normalized(), right(-nearer.y(), nearer.x());
  Image image(k_width, k_height);
  tbb::parallel_for(0, k_height, [&](int y) {
    for (int x = 0; x < k_width; ++x) {
      double sum = 0;
      for (int sample = 0; sample < k_side * k_side; ++sample) {
        const double across = 2.4 * (x + (sample % k_side + 0.5) / k_side) / k_width;
        const double down = 2.4 * (y + (sample / k_side + 0.5) / k_side) / k_width / viewer.z();
        const Vec2 place = across * right + down * nearer;
        if (!displaced) {
          sum += shading(place, plane.normal_at(place));
        } else if (const auto hit = plane.first_hit(Vec3(place.x(), place.y(), 0) + 2 * viewer, -viewer)) {
          sum += shading(hit->uv, hit->normal);
        }
      }
      image.at(x, y) = Rgb::Constant(static_cast<float>(sum / (k_side * k_side)));
    }
  });
  return image;
}

Image below_each_other(const Image& upper, const Image& lower) {
  Image both(upper.width, upper.height + lower.height);
  both.pixels = upper.pixels;
  both.pixels.insert(both.pixels.end(), lower.pixels.begin(), lower.pixels.end());
  return both;
}

/// Over the whole plane: places that are even over it are even over its picture.
double mean_of(const DisplacedPlane& plane, const Shading& shading, const Vec3& viewer) {
  constexpr int k_count = 1 << 16;
  double sum = 0;
  for (int i = 0; i < k_count; ++i) {
    const double u = i * 0.7548776662466927, v = i * 0.5698402909980532;  // fill the square evenly
    const Vec3 start(u - std::floor(u), v - std::floor(v), plane.heights().max);
    if (const auto hit = plane.first_hit(start + viewer, -viewer))
      sum += shading(hit->uv, hit->normal) / k_count;
  }
  return sum;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: light_between_places PICTURE.png\n";
    return 2;
  }
  constexpr double albedo = 0.8, view_angle = 0.9;
  const recede::DisplacementMap map = make_hills(64);
  const recede::DisplacedPlane plane(map, {1, 1});
  const recede::Vec3 sun = direction_at(1.0, 0.4), viewer = direction_at(view_angle, k_view_azimuth);

  // Once for the height field.
  const recede::HeightFieldVisibility visibility = recede::compute_visibility(plane, {.directions = 512});
  const recede::OpenEllipses ellipses = recede::fit_open_ellipses(visibility);
  const recede::DiffuseTransport transport(visibility);

  // Once for each sun.
  const std::vector<double> direct =
      recede::direct_light(visibility, sun, [&](std::size_t place) { return ellipses.openness(place, sun); });
  const recede::ScatteredLight light = recede::scatter_light(transport, direct);

  // For each pixel: what came straight from the sun is known exactly, the rest between places.
  const auto facing = [&](const recede::Vec3& normal) { return std::max(0.0, normal.dot(sun)); };
  const auto from_places = [&](const recede::Vec2& uv) {
    const recede::PlaceMix mix = recede::mix_of_places(visibility.columns, visibility.rows, uv);
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
      sum += mix.weights[k] * (light.irradiance(mix.places[k], albedo) - direct[mix.places[k]]);
    return sum;
  };
  const std::pair<const char*, Shading> kinds[] = {
      {"normals alone",
       [&](const recede::Vec2&, const recede::Vec3& normal) { return albedo * facing(normal); }},
      {"with shadows",
       [&](const recede::Vec2& uv, const recede::Vec3& normal) {
         return albedo * facing(normal) * ellipses.openness_at(uv, sun);
       }},
      {"with light between places",
       [&](const recede::Vec2& uv, const recede::Vec3& normal) {
         return albedo * (facing(normal) * ellipses.openness_at(uv, sun) + from_places(uv));
       }},
  };
  std::vector<recede::Image> columns;
  for (const auto& [name, shading] : kinds) {
    const recede::Image displaced = picture_of(plane, shading, view_angle, true);
    const recede::Image bump = picture_of(plane, shading, view_angle, false);
    std::cout << fmt::format("{:26} {:.4f}\n", name, mean_of(plane, shading, viewer));
    columns.push_back(below_each_other(displaced, bump));
  }
  recede::write_png(argv[1], recede::side_by_side(columns));

  // From so far that places can't be told apart.
  const recede::ScatteringTable table =
      recede::make_scattering_table(plane, {.azimuths = 16, .samples = 1024});
  const auto series = table.series(viewer, sun);
  std::cout << fmt::format("{:26} {:.4f} with shadows, {:.4f} with light between places\n", "table",
                           albedo * series[0], table.sum(series, albedo));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
