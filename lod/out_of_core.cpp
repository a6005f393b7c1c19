#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/texture.h>
#include <recede/lod/detail/chunk_distance.h>
#include <recede/lod/detail/hierarchy_options.h>
#include <recede/lod/detail/reduce_chunks.h>
#include <recede/lod/detail/switch_distances.h>
#include <recede/lod/out_of_core.h>

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace recede {
namespace {

// Bytes, as measured with spheres of 1 to 10 million faces, and some more.
constexpr std::size_t k_process = std::size_t{96} << 20;  // the program and what its threads keep
constexpr std::size_t k_least_memory = std::size_t{256} << 20;
constexpr std::size_t k_per_face_in_core = 700;  // of a mesh, with its hierarchy
// Out of core, three quarters go to the levels, and a quarter to chunks that are measured against them.
constexpr std::size_t k_per_level_face = 370;
constexpr std::size_t k_per_chunk_face = 1000;
/// Times that attributes of a face are there at once.
constexpr std::size_t k_copies_of_levels = 4, k_copies_in_chunks = 6;
/// Faces of all levels over those of level 0, where nothing is known but errors.
constexpr double k_levels_by_error = 2.5;
constexpr std::size_t k_piece_faces = 65536;

std::size_t room(std::size_t memory) { return memory > k_process ? memory - k_process : 0; }

void check_memory(std::size_t bytes) {
  if (bytes < k_least_memory)
    throw OptionError(fmt::format("memory must be at least 256 MiB, not {} bytes", bytes));
}

/// As many faces as level 0 may have beside levels of `faces` (decreasing), when there may be `most` in all.
std::size_t finest_faces(std::size_t most, const std::vector<std::size_t>& faces) {
  if (faces.empty()) return static_cast<std::size_t>(static_cast<double>(most) / k_levels_by_error);
  std::size_t others = 0;
  for (auto level = faces.rbegin(); level != faces.rend(); ++level) {
    // As fine as the next level, or as those before leave room for.
    if (2 * *level + others > most) return std::clamp(most - others, std::size_t{1}, *level);
    others += *level;
  }
  return most - others;
}

/// Files whose faces share no vertices get shared ones.
void share_vertices(PolygonSoup& piece) {
  if (piece.positions.size() < piece.n_corners()) return;
  merge_identical_vertices(piece);
  remove_unreferenced_vertices(piece);
}

/// What a first look at a file tells.
struct FileLook {
  FileLook(const std::filesystem::path& file, std::size_t faces, Progress* progress)
      : n_faces(faces), sample(faces) {
    std::size_t bytes = 0;
    const auto look = [&](const PolygonSoup& piece) {
      sample.add(piece);
      box.extend(bounding_box(piece));
      bytes += piece.corner_uvs.size() * sizeof(Vec2) + piece.corner_normals.size() * sizeof(Vec3) +
               piece.vertex_colors.size() * sizeof(Vec4) +
               piece.vertex_scalars.size() * piece.positions.size() * sizeof(double);
    };
    read_soup_in_pieces(file, k_piece_faces, look, progress);
    attributes = bytes / n_faces;
  }

  std::size_t n_faces;
  detail::MiddleSample sample;
  Box3 box;
  std::size_t attributes = 0;  ///< bytes for each face
};

class OutOfCoreBuilder {
 public:
  OutOfCoreBuilder(const std::filesystem::path& file, const HierarchyOptions& options,
                   const OutOfCoreOptions& out_of_core, Progress* progress)
      : file_(file), options_(options), memory_(out_of_core.memory), progress_(progress) {
    limits_.folder = std::filesystem::absolute(out_of_core.scratch);
    while (!std::filesystem::exists(limits_.folder)) limits_.folder = limits_.folder.parent_path();
    limits_.buffer = room(memory_) / 8;
  }

  OutOfCoreHierarchy build(const std::string& name) {
    const std::optional<std::size_t> n_faces = faces_in_pieces(file_);
    if (!n_faces)
      throw InputError::in_file(file_.string(), "can't be read in pieces; binary PLY and binary STL can");
    if (*n_faces == 0) throw InputError::in_file(file_.string(), "a hierarchy needs a mesh with faces");
    const FileLook look(file_, *n_faces, progress_);
    set_targets(look);
    set_limits(look);
    const detail::ChunkFiles chunks = cut(look);
    result_.chunks = chunks.n_chunks();
    const PolygonMesh finest = reduce(chunks, look.box.sizes().maxCoeff());
    if (finest.n_faces() == 0) throw InputError::in_file(file_.string(), "holds no faces after repair");
    set_levels(finest, chunks, look.sample.points());
    result_.hierarchy = build_hierarchy(finest, name, options_, progress_);
    // It may fit after all, where the levels are few and small.
    if (finest.n_faces() < *n_faces) {
      result_.hierarchy.source_faces = *n_faces;
      set_errors(chunks, look.sample.points());
    }
    return std::move(result_);
  }

 private:
  /// Levels as faces or errors, however they were asked for.
  void set_targets(const FileLook& look) {
    HierarchyOptions& o = options_;
    if (o.faces.empty() && o.errors.empty() && o.relative_errors.empty() && o.distances.empty() &&
        o.ratios.empty())
      o.ratios.assign(detail::k_default_ratios.begin(), detail::k_default_ratios.end());
    for (const double ratio : std::exchange(o.ratios, {}))
      o.faces.push_back(
          std::max<std::size_t>(1, static_cast<std::size_t>(ratio * static_cast<double>(look.n_faces))));
    for (const double share : std::exchange(o.relative_errors, {}))
      o.errors.push_back(share * look.box.diagonal().norm());
    for (const double distance : std::exchange(o.distances, {}))
      o.errors.push_back(o.view.pixel_error * pixel_footprint(distance, o.view));
  }

  void set_limits(const FileLook& look) {
    limits_.faces = room(memory_) / 4 / (k_per_chunk_face + k_copies_in_chunks * look.attributes);
    most_faces_ = finest_faces(
        room(memory_) / 4 * 3 / (k_per_level_face + k_copies_of_levels * look.attributes), options_.faces);
    if (!options_.faces.empty() && options_.faces.back() >= most_faces_) {
      throw OptionError(fmt::format("memory allows {} of {} faces, and no level is to have fewer",
                                    most_faces_, look.n_faces));
    }
  }

  detail::ChunkFiles cut(const FileLook& look) {
    detail::ChunkFiles chunks(limits_.folder, look.sample.cells(limits_.faces, 0.5), limits_.buffer);
    const auto add = [&](PolygonSoup piece) {
      share_vertices(piece);
      chunks.add(piece);
    };
    read_soup_in_pieces(file_, k_piece_faces, add, progress_);
    chunks.finish();
    return chunks;
  }

  PolygonMesh reduce(const detail::ChunkFiles& chunks, double side) {
    try {
      detail::ReducedSurface reduced =
          detail::reduce_chunks(chunks, most_faces_, side, limits_, options_.simplify, progress_);
      result_.passes = reduced.passes;
      PictureLoader pictures(file_.parent_path());
      pictures.load(reduced.soup.materials);
      MeshFromSoup repaired = repair_to_polygon_mesh(std::move(reduced.soup));
      result_.repairs = std::move(repaired.report);
      result_.repairs.steps.insert(result_.repairs.steps.begin(), pictures.step());
      return std::move(repaired.mesh);
    } catch (const InputError& error) {
      throw InputError::in_file(file_.string(), error.what());
    }
  }

  /// Levels as what is left to do from level 0 on.
  void set_levels(const PolygonMesh& finest, const detail::ChunkFiles& chunks,
                  const std::vector<Vec3>& points) {
    while (!options_.faces.empty() && options_.faces.front() >= finest.n_faces()) {
      if (options_.faces.front() > finest.n_faces())
        result_.left_out.push_back(static_cast<double>(options_.faces.front()));
      options_.faces.erase(options_.faces.begin());
    }
    if (options_.errors.empty()) {
      if (options_.faces.empty())
        throw OptionError(
            fmt::format("no level is to have fewer faces than level 0, which has {}", finest.n_faces()));
      return;
    }
    // Its own error, and then that to it, are no more together than what is permitted.
    finest_bound_ = measure({to_soup(finest)}, chunks, points).front().bound;
    while (!options_.errors.empty() && options_.errors.front() <= finest_bound_) {
      result_.left_out.push_back(options_.errors.front());
      options_.errors.erase(options_.errors.begin());
    }
    for (double& error : options_.errors) error -= finest_bound_;
    if (options_.errors.empty()) {
      throw OptionError(
          fmt::format("memory allows {} faces, which are off by {:.3g}, and no level may be off by more",
                      finest.n_faces(), finest_bound_));
    }
  }

  std::vector<LevelError> measure(const std::vector<PolygonSoup>& levels, const detail::ChunkFiles& chunks,
                                  const std::vector<Vec3>& points) const {
    return detail::measure_against_chunks(chunks, points, levels, options_.measure, progress_);
  }

  void set_errors(const detail::ChunkFiles& chunks, const std::vector<Vec3>& points) {
    std::vector<LodLevel>& levels = result_.hierarchy.levels;
    std::vector<PolygonSoup> soups;
    for (const LodLevel& level : levels) soups.push_back(to_soup(level.mesh));
    const std::vector<LevelError> errors = measure(soups, chunks, points);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const double proved = finest_bound_ + levels[i].error.bound;
      levels[i].error = errors[i];
      // With limits, both are proved.
      if (finest_bound_ > 0)
        levels[i].error.bound = std::min(errors[i].bound, std::max(proved, errors[i].max));
    }
    levels.front().stop_reason = "as many faces as memory allows";
    detail::set_switch_distances(result_.hierarchy);
  }

  const std::filesystem::path& file_;
  HierarchyOptions options_;
  std::size_t memory_, most_faces_ = 0;
  Progress* progress_;
  detail::ChunkLimits limits_;
  double finest_bound_ = 0;  // of level 0; only where levels are chosen by errors
  OutOfCoreHierarchy result_;
};

}  // namespace

bool needs_more_than(std::size_t memory, const std::filesystem::path& file) {
  check_memory(memory);
  const std::size_t most = room(memory) / k_per_face_in_core;
  const std::optional<std::size_t> n_faces = faces_in_pieces(file);
  if (n_faces) return *n_faces > most;
  // Of other files only the size is known; a face takes no less than this in any.
  constexpr std::uintmax_t k_least_per_face = 16;
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error) throw InputError::in_file(file.string(), error.message());
  if (bytes / k_least_per_face <= most) return false;
  throw InputError::in_file(
      file.string(),
      fmt::format("may have more than {} faces, as many as memory allows, and can't be read in "
                  "pieces; binary PLY and binary STL can",
                  most));
}

OutOfCoreHierarchy build_hierarchy_out_of_core(const std::filesystem::path& file, const std::string& name,
                                               const HierarchyOptions& options,
                                               const OutOfCoreOptions& out_of_core, Progress* progress) {
  detail::check(options);
  check_memory(out_of_core.memory);
  if (options.simplify.cost != CostPolicy::volume)
    throw OptionError("meshes that don't fit in memory are simplified by the cost volume");
  return OutOfCoreBuilder(file, options, out_of_core, progress).build(name);
}

}  // namespace recede
