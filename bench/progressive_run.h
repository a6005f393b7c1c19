// Progressive meshes, texture deviation, charts and maps measured, beside OpenMesh's progressive mesh.
#pragma once

#include "section_run.h"
#include <recede/lod/progressive_mesh.h>
#include <recede/lod/selective_mesh.h>

#include <optional>

namespace recede::bench {

/// A base of `k_base_share` of the faces with half-edge collapses, and everything up to the input. Times are
/// processor seconds of one thread.
struct ProgressiveFigures {
  std::size_t base_faces = 0;
  double simplify_seconds = 0;                     ///< to the same base, without proof
  double build_seconds = 0;                        ///< without proof
  double proof_seconds = 0;                        ///< of the errors of all levels
  double refine_seconds = 0, coarsen_seconds = 0;  ///< a cursor from the base to the input, and back
  struct File {
    std::size_t bytes = 0;
    std::size_t numbering_bytes = 0;  ///< of them, where the input has several vertices at one place
    double write_seconds = 0, read_seconds = 0;
  } lossless, quantised;  ///< positions as floats; with `k_bits` bits
};
inline constexpr double k_base_share = 0.01;
inline constexpr int k_bits = 14;

/// A peer's way to the same base, positions as floats.
struct ProgressivePeerFigures {
  std::size_t base_faces = 0, bytes = 0;
  double build_seconds = 0, write_seconds = 0;
};

/// What a new atlas costs and how well two simplifications with it keep the surface at `k_texture_share` of
/// the faces. Errors are shares of the diagonal.
struct TextureFigures {
  std::size_t charts = 0;
  double atlas_seconds = 0;  ///< charts, their maps and their packing
  double stretch = 0;        ///< L2, 1 is best
  double deviation_rms = 0, deviation_seconds = 0;
  double volume_rms = 0, volume_seconds = 0;  ///< half-edge collapses
};
inline constexpr double k_texture_share = 0.1;

/// Maps of `k_map_size` texels on `k_map_share` of the faces. Errors are shares of the diagonal.
struct MapFigures {
  std::size_t faces = 0, texels = 0, missed = 0;
  double seconds = 0;
  double bare_rms = 0, rms = 0, bare_max = 0, max = 0;
};
inline constexpr double k_map_share = 0.02;
inline constexpr int k_map_size = 1024;

/// A camera that goes half around the model in `k_walk_frames` steps, near and far by turns, the whole model
/// or a part of it in a picture of 1920 x 1080 pixels, at an error of one pixel. The proved errors count.
/// Times are processor seconds of updates, in milliseconds.
struct WalkFigures {
  double setup_seconds = 0;
  double first = 0, median = 0, slow = 0,
         slowest = 0;           ///< the first starts at the base; slow: 95 of 100 are faster
  double faces = 0, moves = 0;  ///< medians: faces; splits and merges of an update
};
inline constexpr int k_walk_frames = 300;
/// Larger models are only walked around.
inline constexpr std::size_t k_large = 500'000;

/// What a measurement gave, or why it gave nothing.
template <class Figures>
struct Measured {
  std::optional<Figures> figures{};
  std::string failure{};
};

struct ProgressiveRow {
  std::string model;
  std::size_t faces = 0, vertices = 0;
  Measured<ProgressiveFigures> ours{};
  Measured<ProgressivePeerFigures> openmesh{};
  Measured<TextureFigures> texture{};
  Measured<MapFigures> maps{};
  Measured<WalkFigures> walk{};
};

/// All triangle models whose name `options.models` finds, each measurement in a process of its own and in one
/// thread. Writes progressive.md and progressive.csv into `options.out`.
BenchSection measure_progressive(const BenchOptions& options);

/// Plots of one model, as far as `options.models` finds it: errors over faces and over bytes that have come,
/// and time over the error of a view.
std::vector<Plot> progressive_curves(const BenchOptions& options);

/// As progressive.md and progressive.csv have them.
std::string progressive_tables(const std::vector<ProgressiveRow>& rows);
std::string progressive_csv(const std::vector<ProgressiveRow>& rows);

/// RMS distance over the input's diagonal.
double rms_share(const PolygonSoup& input, const PolygonSoup& result);
std::size_t share_of_faces(const PolygonSoup& soup, double share);
/// To the base, by half-edge collapses.
ProgressiveOptions progressive_options(const PolygonSoup& soup, bool prove);
/// Of a walk around a model with this box.
RefinementView view_of_frame(int frame, const Box3& box);

/// In OpenMesh: quadrics and a bound on turning normals, to `base_faces`, recorded and written to `file`.
ProgressivePeerFigures run_openmesh_progressive(const PolygonSoup& soup, std::size_t base_faces,
                                                const std::filesystem::path& file, std::size_t repeats);

}  // namespace recede::bench
