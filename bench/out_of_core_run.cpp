#include "out_of_core_run.h"

#include "child_process.h"
#include "plot_sheet.h"
#include <recede/geometry/atomic_file.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/geometry/subdivision_surface.h>
#include <recede/lod/out_of_core.h>

#include <fmt/format.h>

#include <functional>

namespace recede::bench {
namespace {

struct LargeModel {
  const char* name;
  std::function<PolygonSoup()> make;
  std::vector<std::size_t> mebibytes;  ///< of memory, each of which is tried
};

struct BakedLevel {
  std::size_t faces = 0;
  LevelError error;
};

struct BakedFile {
  double seconds = 0;  ///< of the processor, all threads
  std::size_t peak = 0, chunks = 0, passes = 0;
  std::vector<BakedLevel> levels;
};

std::vector<LargeModel> large_models(const BenchOptions& options) {
  const auto sphere = [](std::size_t faces) {
    return [faces] { return make_displaced_sphere(faces, true); };
  };
  if (options.quick) return {{"sphere 400 k", sphere(400'000), {256}}};
  const auto scan = [data = options.data] {
    SubdivisionOptions twice;
    twice.scheme = SubdivisionScheme::loop;
    twice.level = 2;
    return subdivide(read_soup(data / "refined_elephant.off"), twice).soup;
  };
  return {{"sphere 2 M", sphere(2'000'000), {300, 500, 1024}},
          {"sphere 10 M", sphere(10'000'000), {1024}},
          {"elephant 1.4 M", scan, {500, 1024}}};
}

HierarchyOptions by_ratios() {
  HierarchyOptions options;
  options.ratios = {0.1, 0.03, 0.01, 0.002};
  return options;
}

/// Runs in a child, which has the peak for itself.
BakedFile bake_in_child(const std::function<BakedFile()>& bake) {
  constexpr unsigned k_seconds_allowed = 3600;
  const ChildAnswer answer = run_in_child(
      [&] {
        BakedFile baked = bake();
        std::string bytes;
        put(bytes, baked.seconds);
        put(bytes, peak_resident_bytes());
        put(bytes, baked.chunks);
        put(bytes, baked.passes);
        put(bytes, baked.levels);
        return bytes;
      },
      k_seconds_allowed);
  if (!answer.succeeded) throw InputError(answer.failure);
  ByteReader reader(answer.bytes);
  BakedFile baked;
  baked.seconds = reader.take<double>();
  baked.peak = reader.take<std::size_t>();
  baked.chunks = reader.take<std::size_t>();
  baked.passes = reader.take<std::size_t>();
  reader.take(baked.levels);
  return baked;
}

BakedFile taken(const LodHierarchy& hierarchy) {
  BakedFile baked;
  for (const LodLevel& level : hierarchy.levels) baked.levels.push_back({level.mesh.n_faces(), level.error});
  return baked;
}

BakedFile bake_whole(const std::filesystem::path& file) {
  BakedFile baked;
  baked.seconds = median_seconds(
      1, [&] { baked.levels = taken(build_hierarchy(read_mesh(file).mesh, "whole", by_ratios())).levels; });
  return baked;
}

BakedFile bake_chunks(const std::filesystem::path& file, std::size_t memory) {
  BakedFile baked;
  const double seconds = median_seconds(1, [&] {
    const OutOfCoreHierarchy built =
        build_hierarchy_out_of_core(file, "chunks", by_ratios(), {memory, file.parent_path()});
    baked = taken(built.hierarchy);
    baked.chunks = built.chunks;
    baked.passes = built.passes;
  });
  baked.seconds = seconds;
  return baked;
}

/// The level of both that has as many faces, and isn't the input.
const BakedLevel* same_level(const BakedFile& baked, std::size_t faces) {
  for (const BakedLevel& level : baked.levels) {
    if (level.faces == faces && level.error.max > 0) return &level;
  }
  return nullptr;
}

std::string mebibytes(std::size_t bytes) { return fmt::format("{} MiB", bytes >> 20); }

void add_rows(const LargeModel& model, const BakedFile& whole, std::size_t memory, const BakedFile& chunks,
              BenchSection& section) {
  std::string sizes, rms, bounds;
  for (const BakedLevel& ours : chunks.levels) {
    const BakedLevel* const theirs = same_level(whole, ours.faces);
    section.rows.push_back({{"model", model.name},
                            {"memory", memory},
                            {"peak", chunks.peak},
                            {"seconds", chunks.seconds},
                            {"faces", ours.faces},
                            {"max", ours.error.max},
                            {"rms", ours.error.rms},
                            {"bound", ours.error.bound}});
    if (theirs == nullptr) continue;
    const char* const gap = sizes.empty() ? "" : " ; ";
    sizes += fmt::format("{}{}", gap, ours.faces);
    rms += fmt::format("{}{:.2f}", gap, ours.error.rms / theirs->error.rms);
    bounds += fmt::format("{}{:.2f}", gap, ours.error.bound / theirs->error.bound);
  }
  section.markdown += fmt::format("| {} | {} | {} | {} | {:.3g} | {} | {} | {} | {} |\n", model.name,
                                  mebibytes(memory), mebibytes(chunks.peak), chunks.chunks, chunks.seconds,
                                  chunks.levels.front().faces, sizes, rms, bounds);
}

}  // namespace

BenchSection measure_out_of_core(const BenchOptions& options) {
  std::filesystem::create_directories(options.out);
  const std::filesystem::path file = options.out / "out-of-core.ply";
  BenchSection section;
  section.markdown =
      "Errors as factors of those in memory.\n\n| model | memory | peak | chunks | processor s | faces of "
      "level "
      "0 | of levels | RMS | bound |\n|---|---|---|---|---|---|---|---|---|\n";
  Plot peaks = log_plot("Memory", "MiB that are allowed", "MiB at the peak");
  for (const LargeModel& model : large_models(options)) {
    if (!is_wanted(model.name, options.models)) continue;
    // Where threads are started, and memory is left over.
    const ChildAnswer made = run_in_child(
        [&] {
          write_soup(file, model.make(), {.ascii = false, .double_precision = false});
          return std::string();
        },
        3600);
    if (!made.succeeded) throw InputError(made.failure);
    const BakedFile whole = bake_in_child([&] { return bake_whole(file); });
    section.markdown += fmt::format("| {} | all | {} | | {:.3g} | {} | | | |\n", model.name,
                                    mebibytes(whole.peak), whole.seconds, whole.levels.front().faces);
    Plot errors = log_plot(model.name, "faces", "RMS, object units");
    const auto add_levels = [&](const std::string& series, const BakedFile& baked) {
      for (const BakedLevel& level : baked.levels) {
        if (level.error.rms > 0) add_point(errors, series, static_cast<double>(level.faces), level.error.rms);
      }
    };
    add_levels("in memory", whole);
    for (const std::size_t allowed : model.mebibytes) {
      const std::size_t memory = allowed << 20;
      const BakedFile chunks = bake_in_child([&] { return bake_chunks(file, memory); });
      add_rows(model, whole, memory, chunks, section);
      add_point(peaks, model.name, static_cast<double>(allowed), static_cast<double>(chunks.peak >> 20));
      add_levels(mebibytes(memory), chunks);
    }
    section.curves.push_back(errors);
  }
  std::filesystem::remove(file);
  std::string lines;
  for (const nlohmann::json& row : section.rows) lines += row.dump() + '\n';
  write_file_atomically(options.out / "out-of-core.jsonl", lines);
  section.curves.push_back(peaks);
  return section;
}

}  // namespace recede::bench
