#include <recede/geometry/detail/grid_numbers.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

namespace recede {

LevelInterpolation interpolate_level(const PolygonSoup& control, const SubdivisionOptions& options,
                                     int coarse_level) {
  const detail::ControlMesh mesh = detail::make_control_mesh(control, options);
  const int level = options.level;
  if (coarse_level < 0 || coarse_level > level)
    throw OptionError(fmt::format("points of level {} stand between those of levels 0 to {}, not {}", level,
                                  level, coarse_level));
  detail::require_few_facets(mesh, options.scheme, level);
  const detail::FaceGrids grids = detail::make_face_grids(mesh, options.scheme, level);
  std::map<std::size_t, std::vector<detail::GridMean>> means;
  for (const auto& [sides, grid] : grids)
    means[sides] = detail::make_grid_means(options.scheme, sides, level, coarse_level);
  const detail::GridNumbers numbers = detail::number_positions(mesh, grids, level);
  const auto each_point = [&](auto&& visit) {
    for (std::size_t f = 0; f < mesh.soup.n_faces(); ++f) {
      const std::size_t sides = mesh.soup.face_size(f);
      const Index first_corner = mesh.soup.face_offsets[f];
      const std::vector<detail::GridPoint>& points = grids.at(sides).points;
      const std::vector<detail::GridMean>& of_points = means.at(sides);
      for (std::size_t k = 0; k < points.size(); ++k) {
        if (numbers.is_owner(first_corner, points[k]))
          visit(numbers.of(f, first_corner, points[k]), of_points[k],
                [&](Index place) { return numbers.of(f, first_corner, points[place]); });
      }
    }
  };
  LevelInterpolation result;
  result.starts.assign(numbers.count() + 1, 0);
  each_point([&](std::size_t point, const detail::GridMean& mean, const auto&) {
    result.starts[point + 1] = mean.points.size();
  });
  for (std::size_t k = 0; k < numbers.count(); ++k) result.starts[k + 1] += result.starts[k];
  result.points.resize(result.starts.back());
  result.weights.resize(result.starts.back());
  each_point([&](std::size_t point, const detail::GridMean& mean, const auto& number_of) {
    for (std::size_t k = 0; k < mean.points.size(); ++k) {
      result.points[result.starts[point] + k] = static_cast<Index>(number_of(mean.points[k]));
      result.weights[result.starts[point] + k] = mean.weights[k];
    }
  });
  return result;
}

}  // namespace recede
