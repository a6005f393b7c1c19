#include <recede/geometry/error.h>
#include <recede/render/height_field_visibility.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede {
namespace {

constexpr int k_most_places = 32'768;  // along a side
constexpr std::size_t k_most_pairs = std::size_t{1} << 30;
/// Rays start so far above a place, in sides of a cell.
constexpr double k_raise = 1e-6;

double cell_side(const HeightFieldVisibility& visibility) {
  return std::min(visibility.sides.x() / visibility.columns, visibility.sides.y() / visibility.rows);
}

/// Straight up, so that it is above the surface beside kinks too.
Vec3 start_above(const HeightFieldVisibility& visibility, std::size_t place) {
  const Vec2 at = visibility.uv(place).cwiseProduct(visibility.sides);
  return {at.x(), at.y(), visibility.heights[place] + k_raise * cell_side(visibility)};
}

int places_along(const char* name, int wanted, int texels) {
  if (wanted < 0 || wanted > k_most_places)
    throw OptionError(fmt::format("{} of visibility: 0 to {}, not {}", name, k_most_places, wanted));
  if (wanted > 0) return wanted;
  if (texels > k_most_places)
    throw InputError(fmt::format("visibility: {} of {} texels, the most is {}; ask for fewer", name, texels,
                                 k_most_places));
  return texels;
}

HeightFieldVisibility without_rays(const DisplacedPlane& plane, const VisibilityOptions& options) {
  HeightFieldVisibility visibility{.columns = places_along("columns", options.columns, plane.map().columns()),
                                   .rows = places_along("rows", options.rows, plane.map().rows()),
                                   .sides = plane.sides(),
                                   .sphere = spread_directions(options.directions)};
  if (visibility.place_count() > k_most_pairs / visibility.sphere.size())
    throw OptionError(fmt::format("visibility of {} x {} places in {} directions doesn't fit in memory",
                                  visibility.columns, visibility.rows, visibility.sphere.size()));
  for (std::size_t place = 0; place < visibility.place_count(); ++place) {
    const Vec2 uv = visibility.uv(place);
    visibility.heights.push_back(plane.map().height_at(uv));
    visibility.normals.push_back(plane.normal_at(uv));
  }
  visibility.seen.resize(visibility.place_count() * visibility.sphere.size());
  visibility.distances.resize(visibility.seen.size(), 0.0F);
  return visibility;
}

/// The nearest of `count` lines along one axis, counted from 0 in the periodic unit interval.
int nearest_line(double coordinate, int count) {
  const double turns = coordinate - std::floor(coordinate);
  return static_cast<int>(turns * count + 0.5) % count;
}

void look(const DisplacedPlane& plane, std::size_t place, std::size_t direction,
          HeightFieldVisibility& visibility) {
  const std::size_t at = direction * visibility.place_count() + place;
  const Vec3& d = visibility.sphere.directions[direction];
  if (!(visibility.normals[place].dot(d) > 0)) {
    visibility.seen[at].column = SeenPlace::k_below;
    return;
  }
  const auto hit = plane.first_hit(start_above(visibility, place), d);
  if (!hit || !(hit->normal.dot(d) < 0)) return;
  visibility.seen[at] = {static_cast<std::uint16_t>(nearest_line(hit->uv.x(), visibility.columns)),
                         static_cast<std::uint16_t>(nearest_line(1 - hit->uv.y(), visibility.rows))};
  visibility.distances[at] = static_cast<float>(hit->t);
}

bool faces(const HeightFieldVisibility& visibility, std::size_t place, const Vec3& direction) {
  return direction.z() > 0 && visibility.normals[place].dot(direction) > 0;
}

}  // namespace

std::size_t HeightFieldVisibility::place_near(const Vec2& uv) const {
  return place(nearest_line(uv.x(), columns), nearest_line(1 - uv.y(), rows));
}

Vec2 HeightFieldVisibility::uv(std::size_t place) const {
  const auto width = static_cast<std::size_t>(columns);
  return {static_cast<double>(place % width) / columns, 1 - static_cast<double>(place / width) / rows};
}

PlaceMix mix_of_places(int columns, int rows, const Vec2& uv) {
  struct Lines {
    int before, after;
    double fraction;
  };
  const auto around = [](double coordinate, int count) {
    const double steps = (coordinate - std::floor(coordinate)) * count;
    const int before = std::min(static_cast<int>(steps), count - 1);
    return Lines{before, (before + 1) % count, std::min(steps - before, 1.0)};
  };
  const Lines x = around(uv.x(), columns), y = around(1 - uv.y(), rows);
  const auto place = [&](int column, int row) {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(column);
  };
  return {{place(x.before, y.before), place(x.after, y.before), place(x.before, y.after),
           place(x.after, y.after)},
          {(1 - x.fraction) * (1 - y.fraction), x.fraction * (1 - y.fraction), (1 - x.fraction) * y.fraction,
           x.fraction * y.fraction}};
}

HeightFieldVisibility compute_visibility(const DisplacedPlane& plane, const VisibilityOptions& options,
                                         Progress* progress) {
  HeightFieldVisibility visibility = without_rays(plane, options);
  for (std::size_t direction = 0; direction < visibility.sphere.size(); ++direction) {
    report_progress(progress, "visibility",
                    static_cast<double>(direction) / static_cast<double>(visibility.sphere.size()));
    tbb::parallel_for(0, visibility.rows, [&](int y) {
      for (int x = 0; x < visibility.columns; ++x) look(plane, visibility.place(x, y), direction, visibility);
    });
  }
  report_progress(progress, "visibility", 1);
  return visibility;
}

bool is_open(const DisplacedPlane& plane, const HeightFieldVisibility& visibility, std::size_t place,
             const Vec3& direction) {
  return visibility.normals[place].dot(direction) > 0 &&
         !plane.is_hit(start_above(visibility, place), direction);
}

double distance_to_hit(const DisplacedPlane& plane, const HeightFieldVisibility& visibility,
                       std::size_t place, const Vec3& direction) {
  const auto hit = plane.first_hit(start_above(visibility, place), direction);
  return hit ? hit->t : std::numeric_limits<double>::infinity();
}

bool is_open_by_nearest(const HeightFieldVisibility& visibility, std::size_t place, const Vec3& direction) {
  if (!faces(visibility, place, direction)) return false;
  // The nearest one may lead below the facet, though the direction doesn't: nothing is known to be there.
  return !visibility.seen_from(place, nearest_direction(visibility.sphere.directions, direction)).is_place();
}

double openness_by_three(const HeightFieldVisibility& visibility, std::size_t place, const Vec3& direction) {
  if (!faces(visibility, place, direction)) return 0;
  const DirectionMix mix = mix_of_three(visibility.sphere.directions, visibility.sphere.triangles, direction);
  double open = 0, all = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const SeenPlace& seen = visibility.seen_from(place, static_cast<std::size_t>(mix.directions[k]));
    if (!seen.is_place() && !seen.is_nothing()) continue;
    all += mix.weights[k];
    if (seen.is_nothing()) open += mix.weights[k];
  }
  return all > 0 ? open / all : 1.0;
}

}  // namespace recede
