// Points of a scan as surfaces: normals from their neighbours, and small discs that stand for them wherever
// polygons are wanted.
#pragma once

#include <recede/geometry/polygon_soup.h>
#include <recede/geometry/progress.h>

#include <filesystem>

namespace recede {

/// Lists are either empty (absent) or as long as that of positions.
struct PointCloud {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< (0,0,0) where a point has none
  std::vector<Vec4> colors;   ///< linear, with opacity, 0 to 1
};

/// Throws `InputError` when there is no point, a list has the wrong length, or a number isn't finite; the
/// text names the point. `source` stands in front of it.
void validate(const PointCloud& cloud, const std::string& source);

/// The vertices of a mesh file, whether it has faces or not: with colours, and of PLY files with normals of
/// vertices. Throws `InputError` as `read_soup` and `validate` do.
PointCloud read_point_cloud(const std::filesystem::path& path, Progress* progress = nullptr);

/// Unit normals of the planes nearest to each point and its `n_neighbours` nearest others (all, where there
/// are fewer); they may point to either side. Of points on a line: at a right angle to it. Of points at one
/// place: z. Same bytes for any number of threads. Throws `OptionError` for no neighbour, `InputError` for
/// what `validate` refuses.
std::vector<Vec3> estimate_normals(const PointCloud& cloud, std::size_t n_neighbours = 16);

/// The mean distance of each point from its `n_neighbours` nearest others (all, where there are fewer),
/// object units; 0 where there is none. Throws as `estimate_normals` does.
std::vector<double> spacings_of(const PointCloud& cloud, std::size_t n_neighbours = 8);

struct SplatOptions {
  double radius = 0.5;  ///< of a disc, a share of the spacing of its point
  /// No radius is larger than so many times the median: points far from all others are noise.
  double largest_radius = 3;
  std::size_t n_neighbours = 8;          ///< for spacings
  std::size_t n_normal_neighbours = 16;  ///< for normals that are missing
};

struct Splats {
  PolygonSoup soup;  ///< a hexagon for each point, with its colour
  /// Some normals were: either side may be the front.
  bool are_normals_estimated = false;
  std::size_t repeated = 0;  ///< points at the place of an earlier one, which stands for them
};

/// Discs that face along the normals, with radii from the spacing: about as much area as the surface has that
/// the points are on. Throws `InputError` for fewer than two places and for what `validate` refuses,
/// `OptionError` for numbers that aren't above 0.
Splats splats_of(const PointCloud& cloud, const SplatOptions& options = {});

}  // namespace recede
