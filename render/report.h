// What `recede bake` shows of its work: every level in numbers, in plots, and as a camera sees it where it
// serves.
#pragma once

#include <recede/lod/lod_hierarchy.h>

#include <filesystem>

namespace recede {

struct ReportOptions {
  /// Points upwards in the pictures. The camera looks from the front, a little from the right and above.
  Vec3 up = Vec3::UnitY();
  /// By level: patches that are left of a CAD model; empty: it isn't one.
  std::vector<std::size_t> patches{};
  /// Levels of more triangles are left out of the viewer, whose data takes some 6 bytes for each; 0: no
  /// viewer.
  std::size_t viewer_triangles = 200'000;
};

/// Files that were written.
struct ReportFiles {
  std::filesystem::path html;  ///< one file for any browser; refers to nothing outside itself
  std::filesystem::path json;  ///< the same numbers for programs
  double seconds = 0;          ///< spent on pictures and files
};

/// Writes `<folder>/report.html` and `<folder>/report.json`, each whole or not at all.
///
/// For every level but the first, the level and the original are rendered by the camera of `hierarchy.view`
/// with the nearest point of the bounding sphere at the level's switch distance, at that camera's true
/// pixels, and compared over the sphere's square and a margin of a tenth (at most the image itself).
///
/// Fields of report.json; lengths are object units:
///   name, diagonal (of level 0's box), center and radius (of its bounding sphere), glb (file name),
///   view: image_height (pixels), field_of_view (radians, vertical), pixel_error (pixels), up,
///   levels, finest first, each: level, file (name), bytes, faces, triangles, quads, larger_polygons,
///   vertices,
///     error: max, rms, bound, and the same as shares of the diagonal in max_relative, rms_relative,
///     bound_relative; switch_distance, screen_coverage (0 to 1), seconds: simplify, measure; stop_reason;
///     image_difference: null for level 0, else rmse, max, changed_share (see image_difference.h),
///       width, height (pixels compared), samples_per_pixel, camera_distance (to the sphere's center);
///     maps: null without any, else size (texels a side), max and rms (of the displaced level; null without
///       a displacement map), seam_difference, texels, missed, search_distance, atlas_reason, seconds
///       (see displacement_bake.h);
///     patches: null but for CAD models;
///     viewer: null for levels that the page's viewer doesn't show, else triangles, and largest_distance of a
///       vertex to level 0.
/// Numbers that aren't finite are null.
///
/// Throws `OptionError` when `files` doesn't fit the hierarchy's levels or `up` is zero, `InputError` when a
/// file can't be written or a level has no faces, and `Cancelled`.
ReportFiles write_report(const std::filesystem::path& folder, const LodHierarchy& hierarchy,
                         const HierarchyFiles& files, const ReportOptions& options = {},
                         Progress* progress = nullptr);

}  // namespace recede
