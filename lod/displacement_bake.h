// Maps that carry a fine surface's detail on a coarse one: displacement, normals and colours.
#pragma once

#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/exr.h>
#include <recede/geometry/progress.h>
#include <recede/geometry/raster.h>

#include <optional>
#include <string>
#include <vector>

namespace recede {

/// What becomes of heights and normals.
enum class MapFormat {
  png,  ///< whole numbers
  exr,  ///< floats as well, without steps; `write_hierarchy` writes them beside the PNG files
};

struct MapOptions {
  // Which maps are made. Heights are always found, since the others are read where they lead.
  bool displacement = true;
  bool normal = true;
  bool color = true;  ///< only where the fine surface has vertex colours or materials

  int size = 1024;  ///< texels along each side of the square maps
  /// How far from the coarse surface the fine one is looked for, along the normal and against it, object
  /// units. Unset: `k_reach` times the largest of some 20 000 sampled two-sided distances.
  std::optional<double> search_distance{};
  static constexpr double k_reach = 2;
  /// Unset: seams are closed, so that the heights that are stored differ across them by about a step of the
  /// 16 bits at most, and heights along seams become smooth. Else: how much more a difference of heights
  /// across a seam counts than a change of a texel by as much; 1e4 leaves small differences and more of the
  /// detail along seams, 0 the heights as they were found. See docs/maps.md.
  std::optional<double> seam_weight{};
  MapFormat format = MapFormat::png;
  int normal_bits = 8;  ///< of a sample of the normal map, 8 or 16
  /// For the atlas of a coarse surface whose texture coordinates aren't one-to-one. The packing's resolution
  /// is `size`.
  AtlasOptions atlas = {};
};

/// What baking met.
struct MapReport {
  /// Why a new atlas was made: `no texture coordinates`, `outside the unit square`, `triangles without area`
  /// or `triangles overlap`. Empty: the coarse surface's own texture coordinates serve.
  std::string atlas_reason;
  double search_distance = 0;  ///< object units
  std::size_t texels = 0;      ///< whose middles lie in a triangle of the coarse surface
  std::size_t missed = 0;      ///< those of them whose line met nothing; the closest point took over
  std::size_t seam_edges = 0;  ///< edges whose two sides lie apart in the maps; 0 without displacement
  /// Largest difference of heights between the two sides of a seam, object units: as found, and in the map
  /// that was stored, the floats where there are some. Exact for bilinear lookup.
  double seam_difference_before = 0, seam_difference = 0;
  double seconds = 0;
};

/// A coarse surface and its maps. All maps have the same size and texture coordinates; the texel (x, y) has
/// its middle at u = (x + 0.5) / size, v = 1 - (y + 0.5) / size, and between middles maps are bilinear.
struct BakedMaps {
  /// The coarse surface with `corner_uvs`, one-to-one, and `corner_normals`: unit vectors, the same at all
  /// corners of a point, along which heights count. Everything else is as it was.
  PolygonSoup surface;
  /// C tangents for normal mapping: a unit vector perpendicular to the corner's normal, and 1 or -1, which
  /// times normal x tangent gives the bitangent. See `normal_at`.
  std::vector<Vec4> corner_tangents;

  int size = 0;
  Raster displacement;  ///< grey, 16 bits. height = height_offset + height_scale * sample / 65535
  double height_scale = 0, height_offset = 0;  ///< object units
  Raster normal;  ///< tangent space, glTF's convention: x = 2 * sample / (2^bits - 1) - 1, y up, z away
  Raster color;   ///< sRGB, 8 bits
  /// With `MapFormat::exr`: heights in object units, channel Y; and normals in channels R, G, B, coded from 0
  /// to 1 like those of `normal`, x = 2 R - 1.
  FloatRaster float_displacement, float_normal;
  MapReport report;

  /// Bilinear height at a texture coordinate, object units, of the floats where there are some. Needs
  /// `displacement`.
  double height_at(const Vec2& uv) const;
  /// Bilinear normal at a texture coordinate as a unit vector of tangent space, of the floats where there are
  /// some. Needs `normal`. In object
  /// space it is x T + y B + z N, with tangent, bitangent and normal each interpolated from the corners of
  /// the triangle and then made unit length, as the glTF sample viewer and three.js have them.
  Vec3 normal_at(const Vec2& uv) const;
};

/// Bakes maps from `fine` onto `coarse`. For every texel the point of the coarse surface there and its normal
/// (that of the points, interpolated and made unit length; a point's is the mean of its triangles' normals by
/// angle, whatever normals the mesh brings, so that it is one on all sides of seams and creases) give a
/// line. Its crossing nearest to the coarse surface with a triangle of `fine` that faces along the normal
/// decides; ones that face against it are the back of something. Where there is none within the search
/// distance, the closest point of `fine` does, by its height along the normal.
///
/// The texels around a chart that bilinear lookup inside it reads are found likewise, at the nearest point of
/// the chart. Then heights are changed, as little as possible in the sense of least squares,
/// so that both sides of every seam agree (`MapOptions::seam_weight`), and all other texels are filled by
/// means of ever larger surroundings, so that smaller maps of a pyramid see no foreign values.
///
/// Faces touch where positions are bit-equal. Polygons with more than three sides stand for the triangles of
/// `triangulate`. Same bytes for any number of threads. Throws `InputError` for soups that `validate` refuses
/// or without faces, `OptionError` for options out of range, and `Cancelled`.
BakedMaps bake_maps(const PolygonSoup& fine, const PolygonSoup& coarse, const MapOptions& options = {},
                    Progress* progress = nullptr);

/// `maps.surface` with the colour map as its texture, instead of colours of its own; as it is where there is
/// no colour map.
PolygonSoup colored_surface(const BakedMaps& maps);

struct DiceOptions {
  int parts = 0;  ///< pieces of each triangle's side; 0: pieces of about a texel, a million in all at most
  bool displace = true;  ///< move points by the displacement map, where there is one
};

/// The surface that the maps stand for, as small triangles: every triangle of the coarse surface becomes
/// `parts` squared, with points moved along their normals, and with the normals of the normal map, where
/// there is one, at its corners. Colours are those of `colored_surface`. Same points on common sides of
/// triangles but for differences across seams.
PolygonSoup dice_surface(const BakedMaps& maps, const DiceOptions& options = {});

/// How near the coarse surface comes to the fine one, object units, two-sided and sampled as by
/// `measure_distance`.
struct MapAccuracy {
  double bare_max = 0, bare_rms = 0;  ///< without displacement
  double max = 0, rms = 0;            ///< of `dice_surface`
};
MapAccuracy measure_maps(const PolygonSoup& fine, const BakedMaps& maps, Progress* progress = nullptr);

}  // namespace recede
