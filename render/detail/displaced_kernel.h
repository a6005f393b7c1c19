// Rays against one displaced patch. Plain data and functions only: the sources behind it are compiled once
// for each kind of processor, and may share no inline code with others.
#pragma once

#include <cstdint>

namespace recede::detail {

/// Lengths and places are those of a scaled scene, of about unit size around the origin.
struct alignas(32) DisplacedVertex {
  float position[4];   ///< the fourth is padding
  float direction[4];  ///< unit length; likewise
};

/// Of patches: stacks of searches are as large as it needs.
inline constexpr int k_most_level = 14;

/// Two triangles (a, b, d) and (c, d, b) of the base, or one of them alone, as a square of 2^level by 2^level
/// small ones each cut in two. The place (i, j) in it lies i steps from a towards b and j from a towards d.
/// Places with i + j <= 2^level are those of the first triangle.
struct DisplacedPatch {
  std::uint32_t vertices[4];  ///< a, b, c, d
  float x[4], y[4];           ///< texel coordinates: cells of the map lie between whole numbers
  /// Bounds of 1 / length of interpolated directions; 0 where these differ so much that every square finds
  /// its own.
  float least_stretch, most_stretch;
  std::uint32_t exception;  ///< number of its `PatchException`, or k_no_exception
  std::uint8_t level;
  std::uint8_t is_single;  ///< there is no second triangle, and c repeats b
  /// Which corner of its triangle in the base a is, and c of the other.
  std::uint8_t first_corner[2];
};
inline constexpr std::uint32_t k_no_exception = 0xffffffffu;

/// The lines of a patch along which it may have neighbours, from their first to their second corner.
enum PatchLine { k_line_ab, k_line_bc, k_line_dc, k_line_ad, k_line_bd, k_patch_lines };

/// What a patch's border takes from its neighbours, so that both sides have the same points.
struct PatchException {
  /// Texel coordinates of both ends, for heights along the line; the patch's own unless bit `line` of
  /// `foreign_lines` is set.
  float line_x[k_patch_lines][2], line_y[k_patch_lines][2];
  float corner_x[4], corner_y[4];  ///< likewise of the corners' heights, with `foreign_corners`
  std::uint8_t foreign_lines, foreign_corners;
  /// Along the line only every 2^coarsening-th point is kept, and the others move to the nearest of those.
  std::uint8_t coarsening[k_patch_lines];
};

/// A displacement map and its pyramid of least and largest samples, for one of the two kinds of samples.
struct HeightMapView {
  static constexpr int k_most_levels = 34;
  const std::uint16_t* whole = nullptr;  ///< samples row by row; one of the two is null
  const float* floats = nullptr;
  int columns = 0, rows = 0;  ///< at least 2
  bool is_periodic = false;
  int levels = 0;
  const void* nodes[k_most_levels] = {};  ///< pairs of least and largest samples; level 0 isn't stored
  int node_columns[k_most_levels] = {};
  /// By how much heights in bounds may differ from those that are looked up: texel coordinates are rounded
  /// differently. Scaled scene, for the whole displacement.
  float height_room = 0;
  float offset = 0, scale = 0;  ///< height = offset + scale * sample, scaled scene
};

/// A square of 2^level steps of a patch from the place (i, j). Embree holds boxes of these.
struct PatchPart {
  std::uint32_t patch;
  std::uint16_t i, j;
  std::uint8_t level;
};

struct PatchArrays {
  const PatchPart* parts = nullptr;  ///< null: every patch is one part
  const DisplacedPatch* patches = nullptr;
  const DisplacedVertex* vertices = nullptr;
  const PatchException* exceptions = nullptr;
  const HeightMapView* map = nullptr;
};

/// A ray and what is found along it.
struct PatchRayQuery {
  float origin[3];
  float direction[3];  ///< of about unit length
  float t_min;
  float t_max;                           ///< a hit sets it to its own t
  bool accepts_equal = true;             ///< a hit at t_max counts
  float fraction = 1;                    ///< of the displacement that is applied, 0 to 1
  std::uint32_t left_out = 0xffffffffu;  ///< number of a small triangle that can't be met
  bool is_met = false;                   ///< set by a hit
  float u, v;              ///< of the hit: place in the patch, a at (0, 0), b at (1, 0), d at (0, 1)
  float normal[3];         ///< of its small triangle, any length, outwards
  std::uint32_t triangle;  ///< its number: 2 * (i + 2^level * j), and 1 more for the upper half of its square
};

/// So many rays are asked together at most.
inline constexpr unsigned k_most_rays = 16;

/// Least and largest corner of a box.
struct PatchBox {
  float lower[3], upper[3];
};

/// One version of the functions below.
struct DisplacedKernel {
  /// The first hit with t from t_min to t_max; of several at one t that of the least number.
  void (*first_hit)(const PatchArrays&, std::uint32_t part, PatchRayQuery&);
  /// Whether there is one.
  void (*is_hit)(const PatchArrays&, std::uint32_t part, PatchRayQuery&);
  /// The same for up to k_most_rays rays of one fraction, which had better run side by side.
  void (*first_hits)(const PatchArrays&, std::uint32_t part, PatchRayQuery* rays, unsigned count);
  void (*are_hit)(const PatchArrays&, std::uint32_t part, PatchRayQuery* rays, unsigned count);
  /// Holds the displaced part, and with `partial` those of all smaller fractions.
  PatchBox (*bounds)(const PatchArrays&, std::uint32_t part, bool partial);
  /// The displaced point at the place (i, j).
  void (*point)(const PatchArrays&, std::uint32_t patch, std::uint32_t i, std::uint32_t j, float fraction,
                float* position);
  /// A small triangle against the ray, as the two searches do it: for references.
  bool (*test_triangle)(const float* a, const float* b, const float* c, PatchRayQuery&);
};

/// The fastest version for this processor. All give the same bits.
const DisplacedKernel& displaced_kernel();

extern const DisplacedKernel k_displaced_kernel_baseline;
#if defined(RECEDE_AVX2_KERNEL)
extern const DisplacedKernel k_displaced_kernel_avx2;
#endif

}  // namespace recede::detail
