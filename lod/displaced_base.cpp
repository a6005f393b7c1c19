#include <recede/geometry/error.h>
#include <recede/lod/detail/map_surface.h>
#include <recede/lod/displaced_base.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

/// Squares of areas and of longer things would overflow.
constexpr double k_largest = 1e120;

template <typename Vector>
void require_no_larger(const std::vector<Vector>& values, const char* what) {
  for (const Vector& value : values) {
    if (value.cwiseAbs().maxCoeff() > k_largest)
      throw InputError(fmt::format("the base surface has {} beyond {}", what, k_largest));
  }
}

/// How far from 0 lookups of any level may lie.
class Reaches {
 public:
  explicit Reaches(const DisplacementLevels& levels) {
    for (int l = 0; l < levels.count(); ++l) bounds_.emplace_back(levels.level(l));
  }
  double of(const std::array<Vec2, 3>& uvs) const {
    const DisplacementMap& map = bounds_.front().map();
    const Vec2 texels(map.columns(), map.rows());
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, (uvs[(k + 1) % 3] - uvs[k]).cwiseProduct(texels).norm());
    const Vec2 around = longest * texels.cwiseInverse();
    const Vec2 least = uvs[0].cwiseMin(uvs[1]).cwiseMin(uvs[2]) - around;
    const Vec2 largest = uvs[0].cwiseMax(uvs[1]).cwiseMax(uvs[2]) + around;
    double reach = 0;
    for (const HeightBounds& level : bounds_) {
      const HeightRange range = level.of_box(least, largest);
      reach = std::max({reach, -range.min, range.max});
    }
    return reach;
  }

 private:
  std::vector<HeightBounds> bounds_;
};

}  // namespace

DisplacementMap displacement_map_of(const BakedMaps& maps) {
  if (!maps.float_displacement.samples.empty()) {
    return {maps.float_displacement.width, maps.float_displacement.height, maps.float_displacement.samples};
  }
  if (maps.displacement.samples.empty()) throw InputError("there is no displacement map");
  return {maps.displacement, maps.height_scale, maps.height_offset};
}

DisplacedBase::DisplacedBase(const BakedMaps& maps, const LevelOptions& levels, Progress* progress)
    : DisplacedBase(colored_surface(maps), displacement_map_of(maps), levels, progress) {}

DisplacedBase::DisplacedBase(const PolygonSoup& surface, DisplacementMap map, const LevelOptions& levels,
                             Progress* progress) {
  validate(surface, "base surface");
  if (surface.n_faces() == 0) throw InputError("the base surface has no faces");
  if (surface.corner_uvs.empty()) throw InputError("the base surface has no texture coordinates");
  report_progress(progress, "base surface", 0);
  find_points(surface);
  require_no_larger(positions_, "positions");
  require_no_larger(surface.corner_uvs, "texture coordinates");
  map_ = std::make_unique<DisplacementMap>(std::move(map));
  levels_ = std::make_unique<DisplacementLevels>(*map_, levels, progress);
  report_progress(progress, "height bounds", 0);
  find_reaches();
  if (largest_reach_ > k_largest)
    throw InputError(fmt::format("the base surface has heights beyond {}", k_largest));
  report_progress(progress, "height bounds", 1);
}

void DisplacedBase::find_points(const PolygonSoup& surface) {
  const std::vector<Index> points = detail::points_of_corners(surface);
  std::vector<Index> numbers(surface.positions.size(), k_no_index);
  const std::vector<Vec3> directions = detail::point_directions(surface, points);
  for (std::size_t c = 0; c < surface.n_corners(); ++c) {
    Index& number = numbers[points[c]];
    if (number != k_no_index) continue;
    number = static_cast<Index>(positions_.size());
    positions_.push_back(surface.positions[surface.corner_vertices[c]]);
    directions_.push_back(directions[points[c]]);
  }
  Box3 box;
  for (const Vec3& position : positions_) box.extend(position);
  diagonal_ = box.diagonal().norm();
  materials_ = surface.materials;
  std::vector<Index> faces, corners;
  recede::triangulate(surface, &faces, &corners);
  n_input_ = corners.size() / 3;
  for (std::size_t c = 0; c < corners.size(); c += 3) {
    Triangle triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.points[k] = numbers[points[corners[c + k]]];
      triangle.uvs[k] = surface.corner_uvs[corners[c + k]];
    }
    if (!surface.face_materials.empty()) triangle.material = surface.face_materials[faces[c / 3]];
    const auto& [p, q, r] = triangle.points;
    if (p != q && q != r && r != p) triangles_.push_back(triangle);
  }
}

void DisplacedBase::find_reaches() {
  const Reaches reaches(*levels_);
  tbb::parallel_for(std::size_t{0}, triangles_.size(),
                    [&](std::size_t t) { triangles_[t].reach = reaches.of(triangles_[t].uvs); });
  std::vector<double> of_points(positions_.size(), 0.0);
  for (const Triangle& triangle : triangles_) {
    for (const Index p : triangle.points) of_points[p] = std::max(of_points[p], triangle.reach);
  }
  for (Triangle& triangle : triangles_) {
    const auto& p = triangle.points;
    triangle.reach = std::max({of_points[p[0]], of_points[p[1]], of_points[p[2]]});
    largest_reach_ = std::max(largest_reach_, triangle.reach);
  }
}

}  // namespace recede
