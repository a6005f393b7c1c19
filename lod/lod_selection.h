// Which level of a hierarchy serves at a distance.
#pragma once

#include <recede/lod/lod_hierarchy.h>

#include <optional>

namespace recede {

struct LevelByErrorOptions {
  ViewSettings view;
  /// The level that is shown now. One that is coarser must stay below (1 - hysteresis) of the error in
  /// pixels, so that nothing flickers at a limit.
  std::optional<std::size_t> current{};
  double hysteresis = 0.1;
};

/// The coarsest level whose certified bound covers at most `view.pixel_error` pixels at `distance` (to the
/// nearest point of the surface, object units), or the finest. Throws `OptionError` for a hysteresis
/// outside 0 to 1 or numbers of the view that aren't positive, and `InputError` without levels.
std::size_t level_by_error(const LodHierarchy& hierarchy, double distance,
                           const LevelByErrorOptions& options = {});

struct LevelByDistanceOptions {
  double unit = 1;  ///< of the distances in the rule, object units
  /// In that unit. Nearer than this to the surface only a few polygons are seen, whose shape doesn't matter:
  /// the coarsest level, which needs displacement or a normal map to look right. 0: never.
  double near_limit = 0;
};

/// Ramsey's rule for displaced hierarchies: a level with the share p of the faces serves from the distance
/// 1/p on, since polygons of half the size may be half as many. It knows nothing of errors. `to_sphere` is
/// the distance to the bounding sphere, which may be negative inside, `to_surface` that to the nearest point,
/// both in object units. Throws `OptionError` for a unit or a limit out of range, and `InputError` without
/// levels.
std::size_t level_by_distance(const LodHierarchy& hierarchy, double to_sphere, double to_surface,
                              const LevelByDistanceOptions& options = {});

}  // namespace recede
