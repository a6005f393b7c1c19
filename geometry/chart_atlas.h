// Charts of a surface and their texture atlas: patches without holes, mapped to the plane and packed.
#pragma once

#include <recede/geometry/atlas_packing.h>
#include <recede/geometry/parameterization.h>
#include <recede/geometry/progress.h>

#include <array>
#include <optional>
#include <string_view>

namespace recede {

/// How the faces of a surface are put into charts. Neighbouring charts merge, the cheapest pair first
/// (Ramsey's dissertation, section 6.2, after Sander, Snyder, Gortler and Hoppe 2001, "Texture mapping
/// progressive meshes"). A merge costs
///
///     sum of A_i (1 - N . N_i)  +  compactness * perimeter^2
///
/// in square units of the object, over the merged chart's faces of areas A_i and unit normals N_i.
/// The source prints A_i (N . N_i), which is least for folded charts. Its N is the mean of both charts'
/// normals; here N is the mean of all faces' normals by area, for which the sum is least.
struct ChartOptions {
  std::optional<std::size_t> charts{};  ///< merge until so many are left
  std::optional<double> cost_limit{};   ///< no merge costs more, square units
  /// No merge gives a chart whose mean of 1 - N . N_i by area is larger: 0 holds flat charts only, 0.29 two
  /// equal faces at a right angle, 0.36 half a cylinder, 0.5 a hemisphere, 1 everything. Unset:
  /// `k_bend_limit`, unless `charts` or `cost_limit` is set.
  std::optional<double> bend_limit{};
  static constexpr double k_bend_limit = 0.2;

  double compactness = 1;  ///< weight of the squared perimeter
  /// A merge must leave a chart with so many corners, as the source asks; see `VertexPlace`. Neighbours of
  /// both charts may lose one.
  std::size_t least_corners = 3;
  bool straighten = true;  ///< borders between two charts become shortest ways along edges

  // Edges that charts don't cross, beside borders, edges of more than two faces, and edges whose two faces
  // disagree in orientation.
  bool keep_materials = true;      ///< between faces of different materials
  bool keep_feature_edges = true;  ///< the soup's feature edges
  bool keep_uv_seams = false;      ///< where the texture coordinates of both faces differ
};

/// Where a vertex stands among the charts. Borders and closed edges count as a chart more, so that the ends
/// of a cut are corners.
enum class VertexPlace : unsigned char { interior, boundary, corner };

/// Why neighbouring charts weren't merged.
enum class ChartRefusal : std::size_t {
  no_disk,      ///< the result would be closed, or have more than one border
  few_corners,  ///< fewer corners than `ChartOptions::least_corners`
  bend,         ///< `ChartOptions::bend_limit`
  limit,        ///< nothing; the number of charts or the cost limit came first
  count
};
std::string_view to_string(ChartRefusal refusal);

/// What was done.
struct ChartReport {
  std::size_t charts = 0;
  std::size_t merges = 0;
  double largest_cost = 0;  ///< of a merge that was made, square units
  /// Pairs of neighbouring charts that are left, by what keeps them apart.
  std::array<std::size_t, static_cast<std::size_t>(ChartRefusal::count)> refused{};
  std::size_t straightened = 0;  ///< borders between two charts that became shorter
  double cut_length = 0;         ///< of borders between charts, units; a closed surface has to be cut

  // Edges that no chart crosses.
  std::size_t border_edges = 0;
  std::size_t non_manifold_edges = 0;  ///< more than two faces, or two that disagree in orientation
  std::size_t kept_edges = 0;          ///< materials, feature edges and texture seams
};

/// The chart of every face. Charts are disks: one piece, one border, no handle, whatever the input was.
struct Charts {
  std::vector<Index> face_charts;          ///< F numbers from 0, in the order of the charts' lowest faces
  std::vector<VertexPlace> vertex_places;  ///< V
  ChartReport report;
};

/// Puts the faces of a soup into charts. Faces touch along edges of common vertices: run
/// `merge_identical_vertices` first where a file holds every face by itself. Polygons with more than three
/// sides stay whole. Same result on every run. Throws `InputError` for a soup that `validate` refuses,
/// `OptionError` for negative options, and `Cancelled`.
Charts make_charts(const PolygonSoup& soup, const ChartOptions& options = {}, Progress* progress = nullptr);

struct AtlasOptions {
  ChartOptions charts = {};
  ParameterizationOptions map = {};
  /// Charts whose L2 stretch is larger are cut in two, and again. Infinity: only where triangles flip.
  double stretch_limit = 1.25;
  /// Charts get an area in the atlas like that on the surface, or, when this is set, that times their squared
  /// L2 stretch (Sander et al. 2001): badly stretched ones take more texels.
  bool scale_by_stretch = false;
  PackingOptions packing = {};
};

/// A chart in the atlas.
struct AtlasChart {
  std::size_t faces = 0;
  double area = 0;  ///< on the surface, square units
  Stretch stretch;
  ParameterizationWeights weights = ParameterizationWeights::mean_value;
  DiskBorder border = DiskBorder::natural;
  std::size_t flipped = 0;  ///< triangles in the atlas that don't turn counter-clockwise, by exact signs
  /// The whole texels that the chart's rectangle takes; no other comes nearer than the gutter.
  int x = 0, y = 0, width = 0, height = 0;
};

struct AtlasResult {
  /// The input with `corner_uvs` in [0,1]^2. Where a chart ends, an edge has other ones on its other side.
  /// Materials have no textures, whose coordinates were others.
  PolygonSoup soup;
  std::vector<Index> face_charts;  ///< F
  std::vector<AtlasChart> charts;
  /// `charts` and `cut_length` are those of the atlas, the rest is as it was before charts were split.
  ChartReport report;

  Stretch stretch;                    ///< of the whole atlas; the scale of charts against each other counts
  std::size_t split_for_flips = 0;    ///< charts cut since triangles flipped
  std::size_t split_for_stretch = 0;  ///< charts cut by `AtlasOptions::stretch_limit`
  std::size_t uniform_weights = 0;    ///< charts where these had to take over
  std::size_t flipped = 0;            ///< sum over charts. 0: the atlas is one-to-one
  int resolution = 0;                 ///< texels; more than asked for where charts were too many
  double occupancy = 0;               ///< share of the atlas that charts cover, 0 to 1
  double units_per_uv = 0;            ///< length on the surface for which a uv length of 1 stands, by area
};

/// Charts, their maps and their packing in one call. Positions, faces and all other attributes of the input
/// stay as they are; texture coordinates are new. Polygons are mapped as the triangles of `triangulate`.
/// Faces and charts without area get some, so that every triangle has an inside. Throws what `make_charts`,
/// `pack_rectangles` and `parameterize_disk` throw for wrong options, and `Cancelled`. Same result for any
/// number of threads.
AtlasResult make_atlas(const PolygonSoup& soup, const AtlasOptions& options = {},
                       Progress* progress = nullptr);

}  // namespace recede
