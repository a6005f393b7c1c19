#include <recede/geometry/error.h>
#include <recede/render/virtual_goniometer.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace recede {
namespace {

constexpr double k_pi = std::numbers::pi;

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

}  // namespace

VirtualGoniometer::VirtualGoniometer(const DisplacedPlane& plane, const GoniometerOptions& options,
                                     Progress* progress)
    : plane_(&plane),
      orders_(options.orders),
      visibility_(compute_visibility(plane, options.visibility, progress)),
      transport_(visibility_) {
  scatter_light(transport_, std::vector<double>(visibility_.place_count(), 0.0), orders_);  // refuses orders
  if (options.test == OpennessTest::ellipses) ellipses_ = fit_open_ellipses(visibility_, {}, progress);
}

double VirtualGoniometer::openness(std::size_t place, const Vec3& direction) const {
  if (ellipses_) return ellipses_->openness(place, direction);
  return is_open(*plane_, visibility_, place, direction) ? 1 : 0;
}

ScatteredLight VirtualGoniometer::light(const Vec3& toward_light) const {
  const auto open = [&](std::size_t place) { return openness(place, toward_light); };
  return scatter_light(transport_, direct_light(visibility_, toward_light, open), orders_);
}

std::vector<double> VirtualGoniometer::seen_areas(const Vec3& toward_viewer) const {
  std::vector<double> areas(visibility_.place_count(), 0.0);
  if (!(toward_viewer.z() > 0)) return areas;
  tbb::parallel_for(std::size_t{0}, areas.size(), [&](std::size_t place) {
    const Vec3& normal = visibility_.normals[place];
    const double facing = normal.dot(toward_viewer);
    if (facing > 0) areas[place] = facing / normal.z() * openness(place, toward_viewer);
  });
  return areas;
}

double VirtualGoniometer::area_error(const Vec3& toward_viewer) const {
  const std::vector<double> areas = seen_areas(toward_viewer);
  return sum_of(areas) / static_cast<double>(areas.size()) / toward_viewer.z() - 1;
}

double VirtualGoniometer::brdf(const Vec3& toward_viewer, const Vec3& toward_light, double albedo) const {
  return local_brdfs(toward_viewer, toward_light, albedo, 1, 1).front();
}

std::vector<double> VirtualGoniometer::local_brdfs(const Vec3& toward_viewer, const Vec3& toward_light,
                                                   double albedo, int columns, int rows) const {
  if (columns < 1 || columns > visibility_.columns || rows < 1 || rows > visibility_.rows)
    throw OptionError("parts of a map to measure: at least one, at most as many as there are places");
  const auto parts = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<double> sums(parts, 0.0), areas(parts, 0.0);
  if (!(toward_light.z() > 0)) return sums;
  const std::vector<double> seen = seen_areas(toward_viewer);
  const ScatteredLight light = this->light(toward_light);
  for (int y = 0; y < visibility_.rows; ++y) {
    for (int x = 0; x < visibility_.columns; ++x) {
      const std::size_t place = visibility_.place(x, y);
      const auto part =
          static_cast<std::size_t>(y * rows / visibility_.rows * columns + x * columns / visibility_.columns);
      sums[part] += seen[place] * light.irradiance(place, albedo);
      areas[part] += seen[place];
    }
  }
  for (std::size_t part = 0; part < parts; ++part) {
    if (areas[part] > 0) sums[part] *= albedo / (k_pi * toward_light.z() * areas[part]);
  }
  return sums;
}

Image VirtualGoniometer::texture(const Vec3& toward_viewer, const ScatteredLight& light,
                                 const Rgb& albedo) const {
  const std::vector<double> seen = seen_areas(toward_viewer);
  Image image(visibility_.columns, visibility_.rows);
  for (std::size_t place = 0; place < seen.size(); ++place) {
    if (!(seen[place] > 0)) continue;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto share = static_cast<double>(albedo[k]);
      image.pixels[place][k] = static_cast<float>(share * light.irradiance(place, share));
    }
  }
  return image;
}

Image VirtualGoniometer::texture(const Vec3& toward_viewer, const Vec3& toward_light,
                                 const Rgb& albedo) const {
  return texture(toward_viewer, light(toward_light), albedo);
}

std::vector<Image> VirtualGoniometer::light_field(std::span<const Vec3> toward_viewers,
                                                  const Vec3& toward_light, const Rgb& albedo) const {
  const ScatteredLight light = this->light(toward_light);
  std::vector<Image> images;
  for (const Vec3& toward_viewer : toward_viewers) images.push_back(texture(toward_viewer, light, albedo));
  return images;
}

}  // namespace recede
