#include <recede/geometry/error.h>
#include <recede/lod/displaced_base.h>
#include <recede/render/appearance.h>
#include <recede/render/detail/angle_knots.h>
#include <recede/render/detail/even_points.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

namespace recede {
namespace {

bool is_covered(const std::vector<bool>& covered, const DisplacementMap& map, const Vec2& uv) {
  const int x = std::clamp(static_cast<int>(uv.x() * map.columns()), 0, map.columns() - 1);
  const int y = std::clamp(static_cast<int>((1 - uv.y()) * map.rows()), 0, map.rows() - 1);
  return covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.columns()) +
                 static_cast<std::size_t>(x)];
}

/// The map, its mirror images to the right and below, and below these the image of both: it has a period.
DisplacementMap with_mirror_images(const DisplacementMap& map) {
  std::vector<float> heights;
  const int columns = map.columns(), rows = map.rows();
  const auto mirrored = [](int k, int count) { return k < count ? k : 2 * count - 1 - k; };
  for (int y = 0; y < 2 * rows; ++y) {
    for (int x = 0; x < 2 * columns; ++x)
      heights.push_back(static_cast<float>(map.texel(mirrored(x, columns), mirrored(y, rows))));
  }
  return DisplacementMap(2 * columns, 2 * rows, std::move(heights), MapBorder::periodic);
}

/// A coordinate of the map with its images as one of the map alone, and the sign of steps along it.
std::pair<double, double> unfolded(double coordinate, bool first_is_lower) {
  const double twice = 2 * coordinate;
  const bool is_image = first_is_lower ? twice > 1 : twice < 1;
  const double own = first_is_lower ? twice : twice - 1;
  if (!is_image) return {own, 1};
  return {first_is_lower ? 2 - own : -own, -1};
}

VisibleNormals normals_of_images(const DisplacedPlane& plane, const DisplacementMap& map,
                                 const std::vector<bool>& covered,
                                 const std::function<Vec3(const Vec2&)>& normal_at,
                                 VisibleNormalsOptions options, Progress* progress) {
  if (std::find(covered.begin(), covered.end(), true) == covered.end())
    throw InputError("the surface covers no texel of its map");
  options.normal_at = [&](const Vec2& uv) -> std::optional<Vec3> {
    const auto [u, u_sign] = unfolded(uv.x(), true);
    const auto [v, v_sign] = unfolded(uv.y(), false);  // rows begin above, at v = 1
    if (!is_covered(covered, map, {u, v})) return std::nullopt;
    const Vec3 own = normal_at({u, v});
    return Vec3(u_sign * own.x(), v_sign * own.y(), own.z());
  };
  return sample_visible_normals(plane, options, progress);
}

/// Factors by which shadows, and light that is passed on, change light that nothing shades; `unshadowed` is
/// that of the plane.
ScatteringTable shading_of(const DisplacedPlane& plane, const ReflectanceTable& unshadowed, int samples,
                           Progress* progress) {
  ScatteringTable table = make_scattering_table(plane,
                                                {.views = unshadowed.views,
                                                 .azimuths = unshadowed.azimuths,
                                                 .samples = samples,
                                                 .light_angles = unshadowed.light_angles,
                                                 .light_azimuths = unshadowed.light_azimuths},
                                                progress);
  const auto depth = static_cast<std::size_t>(table.orders);
  for (std::size_t i = 0; i < unshadowed.values.size(); ++i) {
    for (std::size_t order = 0; order < depth; ++order) {
      double& value = table.values[i * depth + order];
      // Both are means over rays of their own: where little light comes at all, chance says how much of it.
      constexpr double k_least = 1e-3, k_most = 4;
      value = std::min(value / std::max(unshadowed.values[i], k_least), k_most);
    }
  }
  return table;
}

constexpr std::size_t k_bump_normals = 8192;

/// A normal of the bump map, and where around it the viewer stands.
struct TurnedNormal {
  Vec3 normal;
  double azimuth = 0;
};

ReflectanceTable bump_light_of(const std::vector<TurnedNormal>& own, const VisibleNormals& normals,
                               const AppearanceOptions& options) {
  const RedistributedBump bump(normals, options.redistribution);
  ReflectanceTable table{.views = normals.views,
                         .azimuths = normals.azimuths,
                         .light_angles = options.reflectance.light_angles,
                         .light_azimuths = options.reflectance.light_azimuths};
  table.values.resize(normals.slice_count() * table.slice_size());
  const auto azimuths = static_cast<std::size_t>(normals.azimuths);
  tbb::parallel_for(std::size_t{0}, normals.slice_count(), [&](std::size_t slice) {
    const double view = normals.view_angle(static_cast<int>(slice / azimuths));
    std::vector<Vec3> moved;  // in the viewer's frame
    for (const TurnedNormal& turned : own) {
      const double azimuth = azimuths == 1 ? turned.azimuth
                                           : 2 * std::numbers::pi * static_cast<double>(slice % azimuths) /
                                                 static_cast<double>(azimuths);
      const Vec3 n = bump.normal_for_view(turned.normal, detail::direction_of(view, azimuth));
      const double c = std::cos(azimuth), s = std::sin(azimuth);
      moved.emplace_back(c * n.x() + s * n.y(), c * n.y() - s * n.x(), n.z());
    }
    double* values = table.values.data() + slice * table.slice_size();
    for (int row = 0; row < table.light_angles; ++row) {
      for (int column = 0; column < table.light_azimuths; ++column) {
        const Vec3 light = detail::direction_of(row * std::numbers::pi / 2 / (table.light_angles - 1),
                                                column * 2 * std::numbers::pi / table.light_azimuths);
        double sum = 0;
        for (const Vec3& n : moved) sum += std::max(0.0, n.dot(light));
        values[row * table.light_azimuths + column] = sum / static_cast<double>(moved.size());
      }
    }
  });
  return table;
}

/// `of_plane` are the normals of the whole plane, `own` some of those of the bump map.
std::shared_ptr<const Appearance> appearance_of(AppearanceTables tables, const DisplacedPlane& plane,
                                                const VisibleNormals& of_plane,
                                                const std::vector<TurnedNormal>& own,
                                                const AppearanceOptions& options, Progress* progress) {
  tables.bump_light = bump_light_of(own, tables.normals, options);
  if (options.shading) {
    tables.shading = shading_of(plane, make_reflectance_table(of_plane, options.reflectance),
                                options.shading_samples, progress);
  }
  return std::make_shared<const Appearance>(std::move(tables), options);
}

/// Of a map that isn't periodic. Shading is that of the whole map with its images.
std::shared_ptr<const Appearance> appearance_of_images(const PolygonSoup& surface, const DisplacementMap& map,
                                                       const MapStretch& stretch,
                                                       const std::function<Vec3(const Vec2&)>& normal_at,
                                                       const AppearanceOptions& options, Progress* progress) {
  const std::vector<bool> covered = covered_texels(surface, map.columns(), map.rows());
  const DisplacementMap images = with_mirror_images(map);
  const DisplacedPlane plane(images, 2 * stretch.sides, PlaneNormals::smooth);
  AppearanceTables tables{.stretch = stretch, .wavelength = mean_wavelength(map, stretch.sides, covered)};
  tables.normals = normals_of_images(plane, map, covered, normal_at, options.normals, progress);
  VisibleNormals of_plane;
  if (options.shading) of_plane = sample_visible_normals(plane, options.normals, progress);
  std::vector<TurnedNormal> own;
  // Many places have no surface.
  const detail::EvenPoints places(0, true);
  for (std::uint64_t k = 0; k < 4 * k_bump_normals && own.size() < k_bump_normals; ++k) {
    const Vec3 place = places.point(k);
    const Vec2 uv = place.head<2>();
    if (!is_covered(covered, map, uv)) continue;
    const Vec3 n = normal_at(uv);
    const double mirror_x = own.size() % 2 == 0 ? 1 : -1, mirror_y = own.size() % 4 < 2 ? 1 : -1;
    own.push_back({{mirror_x * n.x(), mirror_y * n.y(), n.z()}, 2 * std::numbers::pi * place.z()});
  }
  if (own.empty()) own.push_back({Vec3::UnitZ(), 0});
  return appearance_of(std::move(tables), plane, of_plane, own, options, progress);
}

}  // namespace

std::shared_ptr<const Appearance> make_appearance(const PolygonSoup& surface, const DisplacementMap& map,
                                                  const AppearanceOptions& options, Progress* progress) {
  const MapStretch stretch = measure_stretch(surface);
  if (map.border() == MapBorder::periodic) {
    const DisplacedPlane plane(map, stretch.sides, PlaneNormals::smooth);
    AppearanceTables tables{.stretch = stretch, .wavelength = mean_wavelength(map, stretch.sides)};
    tables.normals = sample_visible_normals(plane, options.normals, progress);
    std::vector<TurnedNormal> own;
    const detail::EvenPoints places(0, true);
    for (std::uint64_t k = 0; k < k_bump_normals; ++k) {
      const Vec3 place = places.point(k);
      own.push_back({plane.normal_at(place.head<2>()), 2 * std::numbers::pi * place.z()});
    }
    const VisibleNormals of_plane = tables.normals;
    return appearance_of(std::move(tables), plane, of_plane, own, options, progress);
  }
  const auto normal_at = [&](const Vec2& uv) {
    const Vec2 slope = map.smooth_derivative_at(uv).cwiseQuotient(stretch.sides);
    return Vec3(Vec3(-slope.x(), -slope.y(), 1).normalized());
  };
  return appearance_of_images(surface, map, stretch, normal_at, options, progress);
}

std::shared_ptr<const Appearance> make_appearance(const BakedMaps& maps, const AppearanceOptions& options,
                                                  Progress* progress) {
  const DisplacementMap map = displacement_map_of(maps);
  if (maps.normal.samples.empty()) return make_appearance(maps.surface, map, options, progress);
  const auto normal_at = [&](const Vec2& uv) { return maps.normal_at(uv); };
  return appearance_of_images(maps.surface, map, measure_stretch(maps.surface), normal_at, options, progress);
}

}  // namespace recede
