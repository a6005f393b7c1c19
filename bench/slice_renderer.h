// Slices through the slabs of a shell with a volume texture, drawn as graphics hardware draws triangles: how
// the source of volume textures shows them, for comparison.
//
// Peng 2004, "Thick Surfaces", chapter 5. On the processor and in double precision, so that it is compared by
// what it shows and by what it looks at, not by the speed of some graphics hardware.
#pragma once

#include <recede/render/camera.h>
#include <recede/shells/textured_shell.h>

#include <array>
#include <functional>
#include <vector>

namespace recede::bench {

/// A hexahedron with texture coordinates. Corners have three bits: later along its first, second and third
/// axis.
struct Slab {
  std::array<Vec3, 8> corners, places;
  int texture = 0;  ///< between slabs with other numbers places mean nothing
};

/// The slabs over faces of a surface whose vertices are those of the shell: triangles, whose fourth corner is
/// the third, and quads.
std::vector<Slab> slabs_of(const TexturedShell& textured, const PolygonSoup& surface);

/// What slabs hold: inside where opacity is a half and more.
struct OpacityField {
  std::function<double(const Vec3& place)> opacity;
  std::function<Vec3(const Vec3& place)> gradient;  ///< for a step of 1 in each coordinate of the place
};

/// The texture must live as long.
OpacityField field_of(const VolumeTexture& texture);

/// A camera's axes and its picture. With parallel rays a pixel's side is `frame.pixel` everywhere, and
/// `frame.position` is in the picture's plane, from which depths count.
struct SliceView {
  CameraFrame frame;
  int width = 0, height = 0;
  bool is_parallel = false;
};

SliceView slice_view(const Camera& camera);

enum class SliceRefinement {
  none,         ///< what the nearest inside fragment says
  coordinates,  ///< between it and the last outside fragment, to where opacity is a half
  normals       ///< gradients of both are blended with the same weights; less is looked up
};

struct SliceOptions {
  int slices = 16;  ///< through each slab, its ends included; at least 2
  SliceRefinement refinement = SliceRefinement::coordinates;
  /// Draws all faces of slabs, too, so that rays that come in through a side have an outside fragment.
  bool with_sides = true;
  /// Of the depth that outside fragments are compared with, 1 to 24; others have 24. 0: exact.
  int depth_bits = 0;
  /// Ends and faces are moved into their slab by this share of it, so that neighbours' don't coincide.
  double border_offset = 1e-4;
  bool keeps_fragments = false;  ///< in `SlicePicture::inside` and `outside`
};

struct SliceFragment {
  int slab = -1;                                    ///< none
  Vec3 local = Vec3::Zero(), place = Vec3::Zero();  ///< weights in the slab, 0 to 1, and texture coordinates
  double depth = 0;                                 ///< along the view's forward axis
  double opacity = 0;
};

struct SlicePixel {
  bool is_hit = false;
  double depth = 0;
  Vec3 place = Vec3::Zero();   ///< texture coordinates of the surface
  Vec3 normal = Vec3::Zero();  ///< in space, unit, from inside to outside
};

struct SlicePicture {
  int width = 0, height = 0;
  std::vector<SlicePixel> pixels{};                ///< rows from the top
  std::vector<SliceFragment> inside{}, outside{};  ///< of each pixel, if they are kept
  std::size_t fragments = 0;                       ///< that one pass draws
};

/// Two passes and a third that lights: the nearest fragment inside, the farthest one outside in front of it,
/// and what is between them. Of opposite faces those most nearly across the view are the first and the last
/// slice; slices are at m / (M - 1), where the source has m / M and so never gets to its last one. Quads are
/// two triangles. The same for any number of threads. Throws `OptionError` for options out of range,
/// `InputError` for slabs that aren't in front of the camera.
SlicePicture draw_slices(const std::vector<Slab>& slabs, const OpacityField& field, const SliceView& view,
                         const SliceOptions& options = {});

struct BlendOptions {
  int slices = 16;  ///< through each slab
  /// With how many a texel's opacity is what it says; each of the slices drawn stops as much less or more.
  /// 0: none, each stops what texels say.
  int slices_of_level = 0;
};

/// Of each pixel: what share of the light slices of transparent matter stop, one after the other, without
/// faces. Throws as `draw_slices` does.
std::vector<double> blend_slices(const std::vector<Slab>& slabs,
                                 const std::function<double(const Vec3& place)>& opacity,
                                 const SliceView& view, const BlendOptions& options = {});

}  // namespace recede::bench
