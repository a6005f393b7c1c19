// Textures of billboards: what stands in front of their planes, in one atlas.
//
// J. Meseth: Towards Predictive Rendering in Virtual Reality. Dissertation, Bonn 2008, section 7.2. Heights
// in every texel after S. Mantler, S. Jeschke, M. Wimmer: Displacement Mapped Billboard Clouds. Technical
// report, Vienna 2007.
#pragma once

#include <recede/geometry/raster.h>
#include <recede/lod/billboard_cloud.h>

namespace recede {

struct BillboardTextureOptions {
  double texels_per_error = 1;  ///< a texel's sides are at most the cloud's error over this
  int samples = 4;              ///< rays along each side of a texel
  /// How far, in texels, a billboard also shows faces of others beside its own ones, so that no gaps open
  /// between them.
  int overlap = 2;
  int gutter = 1;  ///< texels between billboards in the atlas
};

/// Texels of a billboard in the atlas.
struct BillboardPlace {
  int x = 0, y = 0;  ///< of the upper left one
  int width = 0, height = 0;
};

struct BillboardTextures {
  double error = 0;                    ///< of the cloud
  double texel = 0;                    ///< its longest side, object units
  double height_range = 0;             ///< heights go from minus this to this
  std::vector<Billboard> billboards;   ///< rows of the atlas run along `axis_u`
  std::vector<BillboardPlace> places;  ///< of each: whole texels, which divide it evenly
  Raster color;   ///< width x height x 4, sRGB: colour, and opacity, of which half and more is drawn
  Raster normal;  ///< x 3, along a billboard's axes and normal: 0 to 255 are -1 to 1
  Raster height;  ///< x 1, over the billboard: 0 to 255 are -`height_range` to `height_range`
  bool is_impostor = false;  ///< of such a cloud
  std::size_t left_out = 0;  ///< the cloud's faces without area
  double covered = 0;        ///< share of the atlas that is drawn
  double packed = 0;         ///< share of the atlas that billboards take

  std::size_t n_texels() const;  ///< of the billboards
  /// Of all textures in memory, without mipmaps: 8 a texel.
  std::size_t bytes() const {
    return 8 * static_cast<std::size_t>(color.width) * static_cast<std::size_t>(color.height);
  }
};

/// The textures of a cloud of `model`: the means of some samples in each texel, which rays from in front of
/// its billboard meet. Opacity is the covered share, and more in billboards of which half and more would show
/// less than four fifths of what is covered. Throws `OptionError` for options out of range, and where the
/// atlas would have more than 2^28 texels; `Cancelled`.
BillboardTextures texture_billboards(const PolygonSoup& model, const BillboardCloud& cloud,
                                     const BillboardTextureOptions& options = {},
                                     Progress* progress = nullptr);

/// The billboards as rectangles with texture coordinates and normals.
PolygonSoup quads_of(const BillboardTextures& textures);

/// The reverse: sets billboards and places from such rectangles, but not the faces that they stand for. False
/// where a face isn't a rectangle, or lies outside of the atlas.
bool place_billboards(const PolygonSoup& quads, BillboardTextures& textures);

}  // namespace recede
