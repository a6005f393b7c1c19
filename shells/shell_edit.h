// Editing of the matter in a shell's layer: bodies are united with it or carved out of it, parts are cut and
// moved over the surface.
//
// Peng 2004, "Thick Surfaces", sections 7.2 and 7.3. All of it changes numbers of a texture only: holes and
// handles come and go without a thought for connectivity.
#pragma once

#include <recede/geometry/progress.h>
#include <recede/geometry/signed_distance.h>
#include <recede/shells/layer_grid.h>
#include <recede/shells/textured_shell.h>

#include <functional>
#include <optional>

namespace recede {

/// Matter, or none, everywhere; not periodic.
VolumeTexture make_uniform_volume(const LayerGrid& grid, double opacity);

/// A texture's matter where it is in the layer, sampled anew: of a texture that repeats, each place has its
/// own texels then. Throws `InputError` when `textured` is refused by `TexturedShell::layer` or is on another
/// base or side than `grid`.
VolumeTexture unwrap_volume(const TexturedShell& textured, const LayerGrid& grid);

/// Where texels of the grid are as large as those of the texture on the average, along s and t; along r as
/// many as it has. At least 1, and at most 2048 along s and t.
std::array<int, 3> unwrapped_size(const TexturedShell& textured);

/// What edits need: a texture that fills its layer once, and where its texels are.
struct FilledLayer {
  LayerGrid grid;
  VolumeTexture texture;
};

/// The texture as it is where it fills the layer once, in texels of `size` if that is given; else it is
/// unwrapped, to `size` or `unwrapped_size`. Errors are those of `LayerGrid` and `unwrap_volume`.
FilledLayer fill_once(const TexturedShell& textured, const std::optional<std::array<int, 3>>& size = {});

/// With the edited texture, without smaller versions, in the same layer.
TexturedShell with_texture(const TexturedShell& textured, VolumeTexture texture);

/// The place of a shell's base that is nearest to a point, at height 0; triangles without area have none.
/// Throws `InputError` where all are such, and `OptionError` for a point without a finite
/// distance.
ShellPlace nearest_place(const Shell& shell, const Vec3& point);

/// Bodies for `combine` and `cut`. Throws `OptionError` unless numbers are finite and the radius above 0.
InsideDistance ball_body(const Vec3& center, double radius);
InsideDistance mesh_body(std::shared_ptr<const SignedDistance> mesh);

enum class VolumeOperation {
  unite,      ///< matter is where it was or where the body is
  intersect,  ///< where both are
  carve       ///< where it was and the body isn't
};

struct CombineOptions {
  VolumeOperation operation = VolumeOperation::carve;
  /// Half of the width over which opacity goes from 0 to 1 at the body's surface, in longest sides of texels.
  double ramp_texels = 2;
  /// sRGB-encoded, 0 to 1: what `unite` adds. Matter without colours so far gets `other_color` then.
  std::optional<Vec3> color{};
  Vec3 other_color{0.85, 0.85, 0.85};  ///< by default as pictures draw what has no colours
};

struct EditReport {
  std::size_t changed = 0;  ///< texels whose opacity is another now, those around charts too
  /// Of the body within the layer, object units to the third; of what was cut the same; 0 of what moves.
  double volume = 0;
};

/// Combines a body with matter: opacity is the larger, the smaller, or the smaller of it and what the body
/// leaves. `body` is above 0 inside and changes by no more than a point moves; it is called from several
/// threads. Throws `InputError` for a texture of another size than the grid's or a periodic one, or a body
/// that isn't a number, `OptionError` for a ramp or colour out of range, and `Cancelled`, after which the
/// texture is as before.
EditReport combine(VolumeTexture& texture, const LayerGrid& grid, const InsideDistance& body,
                   const CombineOptions& options = {}, Progress* progress = nullptr);

/// Opacity becomes 0 in all texels with their middles in a region: sharp ends. `is_cut` gets a texel's (s, t,
/// r) and its point of space; it is called from several threads. Errors are those of `combine`.
EditReport cut(VolumeTexture& texture, const LayerGrid& grid,
               const std::function<bool(const Vec3& place, const Vec3& point)>& is_cut);

struct MoveOptions {
  ShellPlace from{}, to{};  ///< middles of the two discs, on the base
  double radius = 0;        ///< of the discs, along the surface, object units, above 0
  double turn = 0;          ///< counter-clockwise, seen from outside, radians
  bool is_copy = false;     ///< else nothing is left where it was
};

struct MoveReport {
  EditReport edit{};
  double stretch = 1;  ///< L2 stretch of the larger of both discs' maps; 1: none
  /// Texels of the target without a source: the surface ends there. They get nothing.
  std::size_t without_source = 0;
};

/// Moves what is within a disc of the surface to another place of it, where it is united with what is there.
/// Both discs are mapped to the plane with little stretch (`parameterize_disk`), of the same area as on the
/// surface; directions are those of space, turned as the normal turns. Errors are those of `combine`, and
/// `OptionError` for places that aren't on the base or a radius out of range.
MoveReport move_matter(VolumeTexture& texture, const LayerGrid& grid, const MoveOptions& options);

}  // namespace recede
