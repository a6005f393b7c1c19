// What billboards send of the light from each direction to each viewer: bidirectional texture functions.
//
// J. Meseth: Towards Predictive Rendering in Virtual Reality. Dissertation, Bonn 2008, sections 7.2 and 7.4.
#pragma once

#include <recede/lod/billboard_texture.h>
#include <recede/render/direction_grid.h>
#include <recede/render/local_pca.h>

#include <cstdint>
#include <filesystem>
#include <vector>

namespace recede {

struct BillboardReflectanceOptions {
  int view_side = 7;   ///< `DirectionGrid::side` of the views over each side of a billboard; 1 to 32
  int light_side = 7;  ///< of the lights around it; 1 to 32
  int samples = 4;     ///< rays along each side of a texel in each view, for its opacity; 1 to 16
  /// Of the places that those rays meet, evenly taken, as many at most get a ray to each light; 1 or more.
  int shaded = 8;
  /// From face to face before light leaves towards the viewer, 0 to 16; 0: direct light with its shadows.
  int bounces = 1;
  LocalPcaOptions radiance{.training_vectors = 1152};
  /// Of the values as halves: there are fewer clusters where the result would take more, but one. Above 0.
  double largest_share = 0.01;
  /// Bytes for values between the two times that compression reads them; those for which there is no room
  /// are made twice. 0 or more.
  double memory = 2e9;
};

/// Of each texel that shows something, and for each side of its billboard, a vector: by view and light the
/// radiance that leaves towards the viewer, for each colour, when the light alone gives an irradiance of 1 to
/// what faces it; and what share of the texel is covered in each view. Directions are along the billboard's
/// axes and normal; on its back along -`axis_u`, `axis_v` and minus the normal.
struct BillboardReflectance {
  static constexpr std::uint32_t k_none = 0xffffffffu;

  int view_side = 0, light_side = 0;
  int width = 0, height = 0;  ///< of the textures' atlas
  bool is_two_sided = false;  ///< else there are fronts alone
  /// By side (the front first) and texel of the atlas: the number of its vector, or `k_none`.
  std::vector<std::uint32_t> vectors{};
  /// By vector and view, 0 to 255: a byte is little beside the rest, and what is lost here is seen at each
  /// outline.
  std::vector<std::uint8_t> opacity{};
  LocalPca radiance{};    ///< numbers by view, light and colour
  LocalPcaError error{};  ///< of compressing those, over the vectors that were looked at

  DirectionGrid views() const { return {.side = view_side}; }
  DirectionGrid lights() const { return {.side = light_side, .whole_sphere = true}; }
  std::size_t vector_count() const { return radiance.vector_count(); }
};

/// Size of the local PCA, the opacities, and the numbers of vectors, four bytes each.
std::size_t bytes(const BillboardReflectance& reflectance);

/// What the values of the radiance would take as halves, and the opacities.
std::size_t raw_bytes(const BillboardReflectance& reflectance);

/// The reflectance of a cloud of `model` for its textures. Faces are matt with the colours that pictures of
/// the model have, both sides alike. Each texel in each view is seen by parallel rays through its part of the
/// billboard's plane, which meet the faces near the billboard as those of textures do: its own ones, and
/// others where the texture shows something. A ray to each light, against the whole model, says whether it is
/// in shadow, and a ray that the surface scatters what it gets from others. This one ray serves all lights;
/// its noise is another one in each texel and view, and most of it is in none of the directions that
/// compression keeps.
///
/// Opacity is as that of textures, in each view. Where a view of a texel shows nothing, its radiance is the
/// mean of the views that do.
///
/// Clouds of two-sided faces have a second vector for the back of each texel; others have none, and from
/// behind they are seen as along their planes.
///
/// Memory besides what `make_local_pca` takes: `memory`, 4 bytes for each texel, side and view, and 64 MB.
/// The same result for any number of threads, on a processor of the same kind. Throws `OptionError` for
/// options out of range; `InputError` for impostors, clouds that don't know their faces, when textures and
/// cloud don't belong together, or nothing is shown; and `Cancelled`.
BillboardReflectance make_billboard_reflectance(const PolygonSoup& model, const BillboardCloud& cloud,
                                                const BillboardTextures& textures,
                                                const BillboardReflectanceOptions& options = {},
                                                Progress* progress = nullptr);

/// Writes one file: "recede billboard reflectance 1" and a line break; the sides of both grids, the atlas's
/// width and height, the number of sides (32 bits each), the error, the numbers of vectors (32 bits each),
/// the local PCA as `write_local_pca` has it, and the opacities. All little-endian. No half-written file is
/// ever seen. Throws `InputError` when the file can't be written.
void write_billboard_reflectance(const std::filesystem::path& path, const BillboardReflectance& reflectance);

/// The same, bit for bit. Throws `InputError` for anything else.
BillboardReflectance read_billboard_reflectance(const std::filesystem::path& path);

}  // namespace recede
