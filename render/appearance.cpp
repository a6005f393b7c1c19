#include <recede/geometry/error.h>
#include <recede/lod/displaced_base.h>
#include <recede/render/appearance.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace recede {
namespace {

/// Which texels' middles lie in a triangle of the surface, row by row.
std::vector<bool> covered_texels(const PolygonSoup& surface, int columns, int rows) {
  std::vector<bool> covered(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  std::vector<Index> corners;
  triangulate(surface, nullptr, &corners);
  const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    std::array<Vec2, 3> places;  // in texels, whose middles are whole
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2& uv = surface.corner_uvs[corners[t + k]];
      places[k] = Vec2(uv.x() * columns - 0.5, (1 - uv.y()) * rows - 0.5);
    }
    const double area = cross(places[1] - places[0], places[2] - places[0]);
    if (area == 0) continue;
    const Vec2 least = places[0].cwiseMin(places[1]).cwiseMin(places[2]);
    const Vec2 most = places[0].cwiseMax(places[1]).cwiseMax(places[2]);
    const auto inside = [](double coordinate, int count) {
      return static_cast<int>(std::clamp(coordinate, 0.0, count - 1.0));
    };
    for (int y = inside(std::ceil(least.y()), rows); y <= inside(most.y(), rows); ++y) {
      for (int x = inside(std::ceil(least.x()), columns); x <= inside(most.x(), columns); ++x) {
        const Vec2 at(x, y);
        const double first = cross(places[1] - at, places[2] - at) / area;
        const double second = cross(places[2] - at, places[0] - at) / area;
        if (first >= 0 && second >= 0 && first + second <= 1) {
          covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(x)] = true;
        }
      }
    }
  }
  return covered;
}

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

/// 0 for flat maps. `counted` by texel, row by row; empty: all.
double wavelength_of(const DisplacementMap& map, const Vec2& sides, const std::vector<bool>& counted) {
  const Vec2 steps = sides.cwiseQuotient(Vec2(map.columns(), map.rows()));
  const auto counts = [&](int x, int y) {
    return counted.empty() || counted[static_cast<std::size_t>(y) * static_cast<std::size_t>(map.columns()) +
                                      static_cast<std::size_t>(x)];
  };
  double count = 0, sum = 0, squares = 0, slopes = 0;
  const double first = map.texel(0, 0);
  for (int y = 0; y < map.rows(); ++y) {
    for (int x = 0; x < map.columns(); ++x) {
      const int right = map.column(x + 1), below = map.row(y + 1);
      if (!counts(x, y) || !counts(right, y) || !counts(x, below)) continue;
      const double height = map.texel(x, y) - first;  // small numbers keep their digits
      count += 1;
      sum += height;
      squares += height * height;
      slopes += Vec2(map.texel(right, y) - first - height, map.texel(x, below) - first - height)
                    .cwiseQuotient(steps)
                    .squaredNorm();
    }
  }
  if (!(slopes > 0)) return 0;
  return 2 * std::numbers::pi * std::sqrt(std::max(squares - sum * sum / count, 0.0) / slopes);
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

}  // namespace

MapStretch measure_stretch(const PolygonSoup& surface) {
  if (surface.corner_uvs.empty()) throw InputError("a surface without texture coordinates has no stretch");
  std::vector<Index> corners;
  triangulate(surface, nullptr, &corners);
  Vec2 sums = Vec2::Zero(), squares = Vec2::Zero();
  double area = 0;
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const auto side = [&](std::size_t k) {
      return std::pair<Vec3, Vec2>(surface.positions[surface.corner_vertices[corners[t + k]]] -
                                       surface.positions[surface.corner_vertices[corners[t]]],
                                   surface.corner_uvs[corners[t + k]] - surface.corner_uvs[corners[t]]);
    };
    const auto [first, uv_first] = side(1);
    const auto [second, uv_second] = side(2);
    const double turn = uv_first.x() * uv_second.y() - uv_first.y() * uv_second.x();
    const Vec2 lengths((uv_second.y() * first - uv_first.y() * second).norm() / std::abs(turn),
                       (uv_first.x() * second - uv_second.x() * first).norm() / std::abs(turn));
    const double weight = first.cross(second).norm() / 2;
    if (!(weight > 0) || !lengths.allFinite()) continue;
    area += weight;
    sums += weight * lengths;
    squares += weight * lengths.cwiseAbs2();
  }
  if (!(area > 0) || !(sums.minCoeff() > 0))
    throw InputError("all texture coordinates of a surface lie on a line");
  MapStretch stretch;
  stretch.sides = sums / area;
  const Vec2 variance = squares / area - stretch.sides.cwiseAbs2();
  stretch.spread = variance.cwiseMax(0.0).cwiseSqrt().cwiseQuotient(stretch.sides);
  return stretch;
}

double mean_wavelength(const DisplacementMap& map, const Vec2& sides) {
  return wavelength_of(map, sides, {});
}

namespace {

ReflectanceTableOptions from_below(ReflectanceTableOptions options) {
  options.from_below = true;
  return options;
}

}  // namespace

namespace {

template <class Table>
bool fits(const Table& table, const ReflectanceTable& other) {
  return table.views == other.views && table.azimuths == other.azimuths &&
         table.light_angles == other.light_angles && table.light_azimuths == other.light_azimuths;
}

}  // namespace

Appearance::Appearance(AppearanceTables tables, const AppearanceOptions& options)
    : tables_(std::move(tables)),
      bump_(tables_.normals, options.redistribution),
      redistributes_(options.redistribute),
      table_(make_reflectance_table(tables_.normals, options.reflectance)),
      from_below_(make_reflectance_table(tables_.normals, from_below(options.reflectance))),
      sampler_(table_) {
  const MapStretch& stretch = tables_.stretch;
  if (!stretch.sides.allFinite() || !(stretch.sides.minCoeff() > 0))
    throw OptionError("the sides of a map are lengths greater than 0");
  if (!(tables_.wavelength >= 0) || !std::isfinite(tables_.wavelength))
    throw OptionError("a wavelength is a length, or 0 for a flat map");
  const std::optional<ScatteringTable>& shading = tables_.shading;
  if (shading &&
      (!fits(*shading, table_) || shading->values.size() != shading->slice_count() * shading->slice_size()))
    throw InputError("the shading of an appearance has other angles than its table");
  const std::optional<ReflectanceTable>& bump = tables_.bump_light;
  if (bump && (!fits(*bump, table_) || bump->values.size() != table_.values.size()))
    throw InputError("the light of an appearance's bump map has other angles than its table");
  const VisibleNormals& normals = tables_.normals;
  for (std::size_t slice = 0; slice < normals.slice_count(); ++slice) {
    Vec3 mean = Vec3::Zero();
    const std::span<const double> shares = normals.slice(slice);
    for (std::size_t bin = 0; bin < shares.size(); ++bin) mean += shares[bin] * normals.normal_of_bin(bin);
    mean_normals_.push_back(mean);
  }
  if (bump && normals.azimuths == 1) {
    bump_factors_ = detail::FactorGrid(
        [&](const Vec3& viewer, const Vec3& light) { return exact_bump_factor(viewer, light); });
  }
}

double Appearance::exact_bump_factor(const Vec3& toward_viewer, const Vec3& toward_light) const {
  // From beyond the horizon as from there.
  const Vec3 light(toward_light.x(), toward_light.y(), std::max(toward_light.z(), 0.0));
  const double bump = tables_.bump_light->value(toward_viewer, light);
  constexpr double k_least = 1e-3, k_most = 4;  // no more is made of what the bump map hardly has
  return std::clamp(table_.value(toward_viewer, light) / std::max(bump, k_least), 1 / k_most, k_most);
}

double Appearance::bump_factor(const Vec3& toward_viewer, const Vec3& toward_light, double displaced) const {
  if (!redistributes_ || !tables_.bump_light || displaced >= 1) return 1;
  const double factor = bump_factors_.is_empty() ? exact_bump_factor(toward_viewer, toward_light)
                                                 : bump_factors_(toward_viewer, toward_light);
  return factor + displaced * (1 - factor);
}

double Appearance::unshadowed(const Vec3& toward_viewer, const Vec3& toward_light) const {
  if (toward_light.z() >= 0) return table_.value(toward_viewer, toward_light);
  return from_below_.value(toward_viewer, {toward_light.x(), toward_light.y(), -toward_light.z()});
}

Rgb Appearance::shading(const Rgb& albedo, const Vec3& toward_viewer, const Vec3& toward_light,
                        bool passed_on, double displaced) const {
  if (toward_light.z() < 0) return Rgb::Zero();
  const std::optional<ScatteringTable>& shading = tables_.shading;
  if (!shading || displaced >= 1) return Rgb::Ones();
  const ScatteringTable::Series whole = shading->series(toward_viewer, toward_light);
  double own = 1;  // what a part of the heights shades itself
  if (displaced > 0) {
    // Heights times s hide as the whole ones do from directions whose tangents are s times as large.
    const auto equivalent = [&](const Vec3& direction) {
      const double z = std::max(direction.z(), 0.0);
      return Vec3(Vec3(displaced * direction.x(), displaced * direction.y(), z).stableNormalized());
    };
    constexpr double k_least = 0.02;  // of light that is nearly gone, no more is taken away or given back
    own = std::max(k_least, shading->series(equivalent(toward_viewer), equivalent(toward_light))[0]);
  }
  if (!passed_on) return Rgb::Constant(static_cast<float>(whole[0] / own));
  // Slopes times s pass on s^2 of the light, and rays find that.
  const double missing = 1 - displaced * displaced;
  Rgb factors;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto share = static_cast<double>(albedo[k]);
    const double all = share > 0 ? shading->sum(whole, share) / share : whole[0];
    factors[k] = static_cast<float>((whole[0] + missing * (all - whole[0])) / own);
  }
  return factors;
}

Vec3 Appearance::mean_normal(const Vec3& toward_viewer) const {
  const double level = toward_viewer.head<2>().norm();
  const double c = level > 0 ? toward_viewer.x() / level : 1, s = level > 0 ? toward_viewer.y() / level : 0;
  const ViewMix mix = mix_for_view(tables_.normals.views, tables_.normals.azimuths,
                                   std::atan2(level, std::max(toward_viewer.z(), 0.0)), std::atan2(s, c));
  Vec3 mean = Vec3::Zero();
  for (std::size_t k = 0; k < static_cast<std::size_t>(mix.count); ++k)
    mean += mix.weights[k] * mean_normals_[mix.slices[k]];
  return {c * mean.x() - s * mean.y(), s * mean.x() + c * mean.y(), mean.z()};
}

namespace {

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

/// Places on a unit square, evenly spread (Roberts 2018: powers of the plastic number's inverse), with a
/// number from 0 to 1 that is spread beside them.
template <class Use>
void for_even_places(int count, const Use& use) {
  const auto fraction = [](double number) { return number - std::floor(number); };
  for (int k = 0; k < count; ++k) {
    use(Vec2(fraction(0.5 + k * 0.7548776662466927), fraction(0.5 + k * 0.5698402909980532)),
        (k + 0.5) / count);
  }
}

constexpr int k_bump_normals = 8192;

/// A normal of the bump map, and where around it the viewer stands.
struct TurnedNormal {
  Vec3 normal;
  double azimuth = 0;
};

Vec3 direction_of(double angle, double azimuth) {
  return {std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle)};
}

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
      const Vec3 n = bump.normal_for_view(turned.normal, direction_of(view, azimuth));
      const double c = std::cos(azimuth), s = std::sin(azimuth);
      moved.emplace_back(c * n.x() + s * n.y(), c * n.y() - s * n.x(), n.z());
    }
    double* values = table.values.data() + slice * table.slice_size();
    for (int row = 0; row < table.light_angles; ++row) {
      for (int column = 0; column < table.light_azimuths; ++column) {
        const Vec3 light = direction_of(row * std::numbers::pi / 2 / (table.light_angles - 1),
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
  AppearanceTables tables{.stretch = stretch, .wavelength = wavelength_of(map, stretch.sides, covered)};
  tables.normals = normals_of_images(plane, map, covered, normal_at, options.normals, progress);
  VisibleNormals of_plane;
  if (options.shading) of_plane = sample_visible_normals(plane, options.normals, progress);
  std::vector<TurnedNormal> own;
  // Many places have no surface.
  for_even_places(4 * k_bump_normals, [&](const Vec2& uv, double turn) {
    if (static_cast<int>(own.size()) == k_bump_normals || !is_covered(covered, map, uv)) return;
    const Vec3 n = normal_at(uv);
    const double mirror_x = own.size() % 2 == 0 ? 1 : -1, mirror_y = own.size() % 4 < 2 ? 1 : -1;
    own.push_back({{mirror_x * n.x(), mirror_y * n.y(), n.z()}, 2 * std::numbers::pi * turn});
  });
  if (own.empty()) own.push_back({Vec3::UnitZ(), 0});
  return appearance_of(std::move(tables), plane, of_plane, own, options, progress);
}

}  // namespace

std::shared_ptr<const Appearance> make_appearance(const PolygonSoup& surface, const DisplacementMap& map,
                                                  const AppearanceOptions& options, Progress* progress) {
  const MapStretch stretch = measure_stretch(surface);
  if (map.border() == MapBorder::periodic) {
    const DisplacedPlane plane(map, stretch.sides, PlaneNormals::smooth);
    AppearanceTables tables{.stretch = stretch, .wavelength = wavelength_of(map, stretch.sides, {})};
    tables.normals = sample_visible_normals(plane, options.normals, progress);
    std::vector<TurnedNormal> own;
    for_even_places(k_bump_normals, [&](const Vec2& uv, double turn) {
      own.push_back({plane.normal_at(uv), 2 * std::numbers::pi * turn});
    });
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
