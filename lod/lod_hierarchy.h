// Levels of detail of one model: each with its measured error and the distance from which on it serves.
#pragma once

#include <recede/geometry/cad_import.h>
#include <recede/geometry/mesh_distance.h>
#include <recede/lod/billboard_texture.h>
#include <recede/lod/displacement_bake.h>
#include <recede/lod/simplify.h>
#include <recede/lod/view_settings.h>

#include <filesystem>
#include <string>
#include <vector>

namespace recede {

/// Deviation of a level from level 0, or from the file that was too large for memory (see out_of_core.h),
/// two-sided, object units.
struct LevelError {
  double max = 0;  ///< largest sampled distance
  double rms = 0;  ///< root mean square, pooled over both sides, weighted by area
  /// Certified upper bound of the maximum; not certified where there are billboards.
  double bound = 0;
};

struct LodLevel {
  PolygonMesh mesh{};
  LevelError error{};
  double switch_distance = 0;   ///< from the certified bound; this level serves from here on, object units
  double screen_coverage = 1;   ///< share of the image height that the bounding sphere covers there, 0 to 1
  double simplify_seconds = 0;  ///< from the start of the run to this level
  double measure_seconds = 0;
  std::string stop_reason{};  ///< empty for level 0 that is the input
  /// When they were asked for; never for level 0. `maps->surface` is `mesh` with other texture coordinates
  /// and normals.
  std::optional<BakedMaps> maps{};
  std::optional<MapAccuracy> map_accuracy{};  ///< when there is a displacement map
  /// Of billboards, whose rectangles `mesh` holds; see `billboard_level` for what the error then is.
  std::optional<BillboardTextures> billboards{};
  /// Of an assembly: each part once, in its own coordinates; `mesh` has them where instances are.
  std::vector<PolygonSoup> parts{};
};

struct LodHierarchy {
  std::string name;
  ViewSettings view;
  Vec3 center = Vec3::Zero();    ///< of the bounding sphere of level 0
  double radius = 0;             ///< of that sphere
  std::vector<LodLevel> levels;  ///< finest first; level 0 is the input, or as much of it as fits in memory
  std::size_t source_faces = 0;  ///< of the input when it has more than level 0; else 0
  /// Of an assembly: where the levels' parts are, and what these are called.
  std::vector<CadInstance> instances{};
  std::vector<std::string> part_names{};
};

struct HierarchyOptions {
  /// At most one of the five ways to choose levels; without one, ratios 0.5, 0.25, 0.1, 0.03 and 0.01. The
  /// input itself is always level 0 and not named here.
  std::vector<std::size_t> faces{};  ///< at most so many, decreasing
  std::vector<double> ratios;        ///< face counts as shares of the input, decreasing, each in (0, 1)
  std::vector<double> errors;        ///< certified bounds that the levels must keep, increasing, object units
  std::vector<double> relative_errors{};  ///< the same as shares of the box's diagonal
  std::vector<double>
      distances;  ///< camera distances, increasing, object units: error = what `view` permits there
  ViewSettings view;
  SimplifyOptions simplify;  ///< `target` is ignored
  /// Measurement of each level. `bound_tolerance` may not be unset here.
  DistanceOptions measure{.samples = 100'000, .bound_tolerance = 0.1};
  /// When set, level 0 is baked onto every other level. `search_distance` is taken from each level's bound
  /// unless it is given.
  std::optional<MapOptions> maps{};
};

/// Builds and measures the levels, each from the one before. With `errors` or `distances`, each level keeps
/// its limit by proof (see `SimplifyTarget::error`); where no coarser mesh was found that does, it is the
/// level before once more. Throws `OptionError` for options out of range.
LodHierarchy build_hierarchy(const PolygonMesh& mesh, const std::string& name,
                             const HierarchyOptions& options, Progress* progress = nullptr);

/// The maps of a level; empty paths: there is no such map.
struct MapFiles {
  std::filesystem::path displacement, normal, color;
  std::filesystem::path displacement_exr, normal_exr;  ///< with `MapFormat::exr`, beside the PNG files
  std::filesystem::path height{};                      ///< of billboards
};

/// Files that were written.
struct HierarchyFiles {
  std::filesystem::path glb;     ///< all levels, MSFT_lod and MSFT_screencoverage
  std::filesystem::path folder;  ///< the hierarchy's own data: hierarchy.json and one PLY per level
  std::vector<std::filesystem::path> level_files;
  std::vector<std::uintmax_t> level_bytes;
  std::vector<MapFiles> map_files{};                ///< one for each level
  std::vector<std::filesystem::path> level_glbs{};  ///< see `HierarchyWriteOptions`
};

struct HierarchyWriteOptions {
  /// Also writes `<folder>/<name>_level_<number>.glb` for each level, for engines that don't know `MSFT_lod`.
  bool glb_per_level = false;
};

/// Writes `<folder>/<name>.glb` and `<folder>/<name>.recede/`. The GLB holds triangles; the folder holds
/// polygons in double precision and can be read back. Same bytes for the same levels: the seconds that they
/// took aren't in the files. Maps are PNG files in the folder, and once more inside the GLB, which needs no
/// other file: `normalTexture` and `baseColorTexture` of the level's materials, and
/// `extras.recede_displacement` of its mesh with the number of its `image`, `scale`, `offset` and `space`.
/// Such a level is written as `BakedMaps::surface`, the GLB with its tangents. Billboards have their colours
/// with opacity, which the GLB takes as a mask, normals and heights as PNG files; `extras.recede_billboards`
/// of their mesh has the number of that of heights in `image`, `range` (object units: black to white is
/// -range to range), and the cloud's `error`.
/// Pictures that materials have (`Material::base_color_picture`) are in the GLB and beside the levels' files.
HierarchyFiles write_hierarchy(const std::filesystem::path& folder, const LodHierarchy& hierarchy,
                               const HierarchyWriteOptions& options = {});

/// Reads what `write_hierarchy` wrote below `<name>.recede/`, maps too, but of what baking met only why there
/// is an atlas, of assemblies the levels as a whole, and of billboards not the faces that they stand for.
/// Throws `InputError`.
LodHierarchy read_hierarchy(const std::filesystem::path& folder);

}  // namespace recede
