#include <recede/geometry/error.h>
#include <recede/lod/lod_selection.h>

#include <cmath>

namespace recede {
namespace {

void require(bool holds, const char* what) {
  if (!holds) throw OptionError(what);
}

void require_levels(const LodHierarchy& hierarchy) {
  if (hierarchy.levels.empty()) throw InputError("a hierarchy without levels has none to choose from");
}

}  // namespace

std::size_t level_by_error(const LodHierarchy& hierarchy, double distance,
                           const LevelByErrorOptions& options) {
  require_levels(hierarchy);
  require(options.hysteresis >= 0 && options.hysteresis < 1, "the hysteresis must lie between 0 and 1");
  require(options.view.pixel_error > 0 && options.view.image_height > 0 && options.view.field_of_view > 0,
          "the numbers of a view must be positive");
  const std::size_t n = hierarchy.levels.size(), current = options.current.value_or(n);
  for (std::size_t level = n; level-- > 1;) {
    const double share = level > current ? 1 - options.hysteresis : 1;
    ViewSettings view = options.view;
    view.pixel_error *= share;
    if (switch_distance(hierarchy.levels[level].error.bound, view) <= distance) return level;
  }
  return 0;
}

std::size_t level_by_distance(const LodHierarchy& hierarchy, double to_sphere, double to_surface,
                              const LevelByDistanceOptions& options) {
  require_levels(hierarchy);
  require(options.unit > 0 && std::isfinite(options.unit), "the unit of distances must be positive");
  require(options.near_limit >= 0, "the near limit must not be negative");
  const std::size_t last = hierarchy.levels.size() - 1;
  if (to_surface < options.near_limit * options.unit) return last;
  const auto faces = [&](std::size_t level) {
    return static_cast<double>(hierarchy.levels[level].mesh.n_faces());
  };
  for (std::size_t level = last; level > 0; --level) {
    if (faces(level) > 0 && to_sphere >= options.unit * faces(0) / faces(level)) return level;
  }
  return 0;
}

}  // namespace recede
