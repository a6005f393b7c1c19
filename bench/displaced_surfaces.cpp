#include "displaced_surfaces.h"

#include "models.h"
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/lod/displaced_base.h>
#include <recede/lod/simplify.h>

#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

/// A point of one of the six faces of a cube, -1 to 1 along both sides, blown up to the unit sphere. Points
/// on the cube's sides are the same from both faces, to the last bit.
Vec3 on_sphere(int face, double s, double t) {
  const auto tangent = [](double x) { return std::abs(x) == 1 ? x : std::tan(std::numbers::pi / 4 * x); };
  const int axis = face / 2;
  const double side = face % 2 == 0 ? 1 : -1;
  Vec3 place;
  place[axis] = side;
  place[(axis + 1) % 3] = side * tangent(s);
  place[(axis + 2) % 3] = tangent(t);
  return place / place.norm();
}

double along(int k, int n) { return (2.0 * k - n) / n; }

std::uint32_t scrambled(std::uint32_t x) {
  x = (x ^ x >> 16) * 0x7feb352du;
  x = (x ^ x >> 15) * 0x846ca68bu;
  return x ^ x >> 16;
}

/// Smooth noise from 0 to 1 with features of about unit size.
double noise(const Vec3& p) {
  const auto lattice = [](const Eigen::Vector3i& k) {
    std::uint32_t key = 0;
    for (const int coordinate : k) key = scrambled(key + static_cast<std::uint32_t>(coordinate));
    return key / 4294967296.0;
  };
  const Eigen::Vector3i low = p.array().floor().cast<int>();
  Vec3 f = p - low.cast<double>();
  f = f.array().square() * (3 - 2 * f.array());
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3i step(corner & 1, corner >> 1 & 1, corner >> 2);
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= step[axis] == 1 ? f[axis] : 1 - f[axis];
    sum += weight * lattice(low + step);
  }
  return sum;
}

double fractal(const Vec3& p) {
  double sum = 0, weight = 0.5;
  for (double frequency = 4; frequency < 300; frequency *= 2, weight *= 0.55)
    sum += weight * noise(frequency * p);
  return sum;
}

/// Six charts of n x n quads. `uv` tells the texture coordinate of a lattice point of a chart.
template <typename TexturePlace>
PolygonSoup sphere_of_charts(int n, const Vec3& center, const TexturePlace& uv) {
  PolygonSoup soup;
  for (int face = 0; face < 6; ++face) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        for (const auto& [di, dj] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
          const Vec3 direction = on_sphere(face, along(i + di, n), along(j + dj, n));
          soup.corner_vertices.push_back(static_cast<Index>(soup.positions.size()));
          soup.positions.push_back(center + direction);
          soup.corner_normals.push_back(direction);
          soup.corner_uvs.push_back(uv(face, i + di, j + dj));
        }
        soup.face_offsets.push_back(static_cast<Index>(soup.corner_vertices.size()));
      }
    }
  }
  return soup;
}

Raster grey_raster(int width, int height) {
  Raster raster;
  raster.width = width;
  raster.height = height;
  raster.bits = 16;
  raster.samples.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
  return raster;
}

}  // namespace

DisplacedSurface fractal_sphere() {
  // Charts start 1056 texels apart: 1025 that are used, and room to a multiple of 32.
  constexpr int k_quads = 16, k_texels = 64, k_side = k_quads * k_texels, k_apart = 1056, k_first = 31;
  Raster raster = grey_raster(k_first + 2 * k_apart + k_side + 1, k_first + k_apart + k_side + 1);
  const auto start_x = [](int face) { return k_first + face % 3 * k_apart; };
  const auto start_y = [](int face) { return k_first + face / 3 * k_apart; };
  tbb::parallel_for(0, 6 * (k_side + 1), [&](int row) {
    const int face = row / (k_side + 1), j = row % (k_side + 1);
    for (int i = 0; i <= k_side; ++i) {
      const double height = fractal(on_sphere(face, along(i, k_side), along(j, k_side)));
      const auto at = static_cast<std::size_t>(start_y(face) + j) * static_cast<std::size_t>(raster.width) +
                      static_cast<std::size_t>(start_x(face) + i);
      raster.samples[at] = static_cast<std::uint16_t>(std::clamp(65535 * height, 0.0, 65535.0));
    }
  });
  PolygonSoup base = sphere_of_charts(k_quads, Vec3::Zero(), [&](int face, int i, int j) {
    return Vec2((start_x(face) + i * k_texels + 0.5) / raster.width,
                1 - (start_y(face) + j * k_texels + 0.5) / raster.height);
  });
  return {std::move(base), DisplacementMap(std::move(raster), 0.06, 0), 6};
}

DisplacedSurface rough_sphere(int n, const Vec3& center, unsigned seed) {
  constexpr int k_size = 256;
  std::mt19937 random(seed);
  Raster raster = grey_raster(k_size, k_size);
  for (std::uint16_t& sample : raster.samples) sample = static_cast<std::uint16_t>(random() & 0xffff);
  PolygonSoup base = sphere_of_charts(n, center, [&](int face, int i, int j) {
    const double s = static_cast<double>(i) / n, t = static_cast<double>(j) / n;
    return Vec2((face % 3 + 0.05 + 0.9 * s) / 3, (face / 3 + 0.05 + 0.9 * t) / 2);
  });
  return {std::move(base), DisplacementMap(std::move(raster), 0.1, 0), 4};
}

DisplacedSurface tiled_sphere() {
  constexpr int k_size = 4096, k_quads = 289;
  Raster raster = grey_raster(k_size, k_size);
  tbb::parallel_for(0, k_size, [&](int y) {
    for (int x = 0; x < k_size; ++x) {
      const double u = 2 * std::numbers::pi * x / k_size, v = 2 * std::numbers::pi * y / k_size;
      const double height =
          0.5 + 0.2 * std::sin(7 * u) * std::cos(5 * v) + 0.25 * std::sin(90 * u + 4 * std::sin(60 * v));
      raster.samples[static_cast<std::size_t>(y) * k_size + static_cast<std::size_t>(x)] =
          static_cast<std::uint16_t>(std::clamp(65535 * height, 0.0, 65535.0));
    }
  });
  PolygonSoup base = sphere_of_charts(k_quads, Vec3::Zero(), [](int, int i, int j) { return Vec2(i, j); });
  return {std::move(base), DisplacementMap(std::move(raster), 0.002, 0, MapBorder::periodic), 12};
}

BakedMaps bunny_maps(const std::filesystem::path& data, double share) {
  const ModelSource source = model_file(data, "bunny00");
  require_file(source);
  const PolygonSoup fine = load_model(source);
  SimplifyOptions coarser;
  coarser.target.ratio = share;
  const SimplifySoupResult coarse = simplify(fine, coarser);
  MapOptions options;
  options.search_distance = MapOptions::k_reach * coarse.error_bound.value();
  return bake_maps(fine, coarse.soup, options);
}

DisplacedSurface mapped_bunny(const std::filesystem::path& data) {
  const BakedMaps maps = bunny_maps(data, 0.02);
  return {maps.surface, displacement_map_of(maps), 5};
}

}  // namespace recede::bench
