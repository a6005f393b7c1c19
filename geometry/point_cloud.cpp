#include <recede/geometry/atomic_file.h>
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/detail/nearest_points.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/point_cloud.h>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace recede {

namespace {

// Calls `visit(point, neighbours)` for each point with its nearest others, on several threads.
template <typename Visit>
void for_neighbours(const std::vector<Vec3>& points, std::size_t n_neighbours, Visit&& visit) {
  if (n_neighbours < 1) throw OptionError("points need a neighbour at least");
  const detail::NearestPoints nearest(points);
  const std::size_t n_found = std::min(n_neighbours + 1, points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    std::vector<Index> found(n_found);
    nearest.find(points[i], found);
    // Among points at one place it needn't be the first, nor among those found at all.
    const auto self = std::find(found.begin(), found.end(), static_cast<Index>(i));
    found.erase(self == found.end() ? found.end() - 1 : self);
    visit(i, found);
  });
}

bool is_less(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

// One point for each place: the first one there.
PointCloud without_repeated(const PointCloud& cloud) {
  std::vector<Index> order(cloud.positions.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return is_less(cloud.positions[a], cloud.positions[b]); });
  order.erase(std::unique(order.begin(), order.end(),
                          [&](Index a, Index b) { return cloud.positions[a] == cloud.positions[b]; }),
              order.end());
  std::sort(order.begin(), order.end());
  PointCloud result;
  for (const Index point : order) {
    result.positions.push_back(cloud.positions[point]);
    if (!cloud.normals.empty()) result.normals.push_back(cloud.normals[point]);
    if (!cloud.colors.empty()) result.colors.push_back(cloud.colors[point]);
  }
  return result;
}

// Fills in those that are missing. Returns whether there were any.
bool complete_normals(PointCloud& cloud, std::size_t n_neighbours) {
  cloud.normals.resize(cloud.positions.size(), Vec3::Zero());
  const auto is_missing = [](const Vec3& normal) { return !(normal.norm() > 0); };
  if (std::none_of(cloud.normals.begin(), cloud.normals.end(), is_missing)) return false;
  const std::vector<Vec3> estimated = estimate_normals(cloud, n_neighbours);
  for (std::size_t i = 0; i < estimated.size(); ++i) {
    if (is_missing(cloud.normals[i])) cloud.normals[i] = estimated[i];
  }
  return true;
}

std::vector<double> radii_of(const PointCloud& cloud, const SplatOptions& options) {
  std::vector<double> radii = spacings_of(cloud, options.n_neighbours);
  for (double& radius : radii) radius *= options.radius;
  std::vector<double> sorted = radii;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  for (double& radius : radii) radius = std::min(radius, options.largest_radius * *middle);
  return radii;
}

}  // namespace

void validate(const PointCloud& cloud, const std::string& source) {
  if (cloud.positions.empty()) throw InputError(source + ": holds no points");
  const auto check = [&](const auto& list, const char* name) {
    if (!list.empty() && list.size() != cloud.positions.size())
      throw InputError(
          fmt::format("{}: {} {} for {} points", source, list.size(), name, cloud.positions.size()));
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (!list[i].allFinite())
        throw InputError(fmt::format("{}: {} of point {} aren't finite", source, name, i));
    }
  };
  check(cloud.positions, "coordinates");
  check(cloud.normals, "normals");
  check(cloud.colors, "colours");
}

PointCloud read_point_cloud(const std::filesystem::path& path, Progress* progress) {
  PointCloud cloud;
  PolygonSoup soup;
  if (detail::lower_case_extension(path) == ".ply") {
    const std::string content = read_whole_file(path);
    const detail::InputFile file{path, path.string(), content, progress};
    soup = detail::read_ply(file, cloud.normals);
    for (Vec3& normal : cloud.normals) {
      if (!normal.allFinite()) normal.setZero();  // as of meshes
    }
  } else {
    soup = read_soup(path, progress);
  }
  cloud.positions = std::move(soup.positions);
  cloud.colors = std::move(soup.vertex_colors);
  validate(cloud, path.string());
  return cloud;
}

std::vector<Vec3> estimate_normals(const PointCloud& cloud, std::size_t n_neighbours) {
  validate(cloud, "normals of points");
  std::vector<Vec3> normals(cloud.positions.size(), Vec3::UnitZ());
  for_neighbours(cloud.positions, n_neighbours, [&](std::size_t i, const std::vector<Index>& neighbours) {
    // Around the point itself, so that large coordinates cost no digits.
    Vec3 mean = Vec3::Zero();
    double farthest = 0;
    for (const Index other : neighbours) {
      const Vec3 offset = cloud.positions[other] - cloud.positions[i];
      mean += offset;
      farthest = std::max(farthest, offset.cwiseAbs().maxCoeff());
    }
    if (!(farthest > 0)) return;
    mean /= static_cast<double>(neighbours.size() + 1);
    Eigen::Matrix3d spread = mean * mean.transpose() / (farthest * farthest);
    for (const Index other : neighbours) {
      const Vec3 offset = (cloud.positions[other] - cloud.positions[i] - mean) / farthest;
      spread += offset * offset.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
    normals[i] = solver.eigenvectors().col(0);
  });
  return normals;
}

std::vector<double> spacings_of(const PointCloud& cloud, std::size_t n_neighbours) {
  validate(cloud, "spacings of points");
  std::vector<double> spacings(cloud.positions.size(), 0);
  for_neighbours(cloud.positions, n_neighbours, [&](std::size_t i, const std::vector<Index>& neighbours) {
    for (const Index other : neighbours)
      spacings[i] +=
          (cloud.positions[other] - cloud.positions[i]).norm() / static_cast<double>(neighbours.size());
  });
  return spacings;
}

Splats splats_of(const PointCloud& cloud, const SplatOptions& options) {
  constexpr Index k_sides = 6;
  validate(cloud, "discs of points");
  if (!(options.radius > 0 && std::isfinite(options.radius) && options.largest_radius > 0))
    throw OptionError("radii of points are above 0");
  PointCloud points = without_repeated(cloud);
  if (points.positions.size() < 2) throw InputError("discs need points at two places at least");
  Splats result;
  result.repeated = cloud.positions.size() - points.positions.size();
  result.are_normals_estimated = complete_normals(points, options.n_normal_neighbours);
  const std::vector<double> radii = radii_of(points, options);
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const Vec3 normal = points.normals[i].normalized(), u = normal.unitOrthogonal(), v = normal.cross(u);
    std::array<Index, k_sides> corners;
    for (Index side = 0; side < k_sides; ++side) {
      const double angle = 2 * std::numbers::pi * side / k_sides;
      corners[side] = static_cast<Index>(result.soup.positions.size());
      result.soup.positions.push_back(points.positions[i] +
                                      radii[i] * (std::cos(angle) * u + std::sin(angle) * v));
      if (!points.colors.empty()) result.soup.vertex_colors.push_back(points.colors[i]);
    }
    result.soup.add_face(corners);
  }
  return result;
}

}  // namespace recede
