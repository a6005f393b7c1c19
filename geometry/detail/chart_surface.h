// A soup cut into charts: which faces hang together, and the border of each chart.
#pragma once

#include <recede/geometry/chart_atlas.h>

#include <span>
#include <vector>

namespace recede::detail {

/// Sides are named by their corners: the side of corner c runs from its vertex to the next corner's.
/// Faces of one chart that share a side both ways are glued along it. All charts are disks: with their glued
/// sides alone every one is a surface with one border loop and no handle. Where vertices meet without a glued
/// side between them, the surface is open.
class ChartSurface {
 public:
  /// Every face is a chart. `soup` must stay. Counts the edges that are closed to charts in `report`.
  ChartSurface(const PolygonSoup& soup, const ChartOptions& options, ChartReport& report);

  /// The faces of a chart as a surface of their own, in their order; every face is a chart.
  ChartSurface(const ChartSurface& whole, PolygonSoup& faces_as_soup, std::span<const Index> faces);

  std::size_t n_faces() const { return soup->n_faces(); }
  Index after(Index side) const {
    const Index face = face_of[side];
    return side + 1 == soup->face_offsets[face + 1] ? soup->face_offsets[face] : side + 1;
  }
  Index before(Index side) const {
    const Index face = face_of[side];
    return side == soup->face_offsets[face] ? soup->face_offsets[face + 1] - 1 : side - 1;
  }
  Index from(Index side) const { return soup->corner_vertices[side]; }
  Index to(Index side) const { return soup->corner_vertices[after(side)]; }
  double length(Index side) const { return (soup->positions[from(side)] - soup->positions[to(side)]).norm(); }

  /// The side lies within a chart.
  bool is_glued(Index side) const {
    return opposite[side] != k_no_index && chart_of[face_of[side]] == chart_of[face_of[opposite[side]]];
  }
  /// The next side of the chart's border after a side of that border.
  Index next_on_border(Index side) const {
    side = after(side);
    while (is_glued(side)) side = after(opposite[side]);
    return side;
  }
  /// Faces of each of `n_charts` charts, ascending.
  std::vector<std::vector<Index>> faces_by_chart(std::size_t n_charts) const;

  const PolygonSoup* soup;
  std::vector<Index> face_of;  ///< of each side
  std::vector<Index>
      opposite;  ///< the side that runs the other way, `k_no_index` at borders and closed edges
  std::vector<Index> chart_of;  ///< of each face
};

/// The soup's faces with positions in a box of about unit size, so that squares and products neither overflow
/// nor vanish.
struct UnitSized {
  explicit UnitSized(const PolygonSoup& original);
  PolygonSoup soup;
  double unit = 1;  ///< length in the original that is 1 here, a power of two
};

/// Charts of a unit-sized soup. `report` receives lengths and costs in the original's units.
ChartSurface find_charts(const UnitSized& sized, const ChartOptions& options, ChartReport& report,
                         Progress* progress);

/// Merges the surface's charts, which are single faces, and numbers what comes out from 0 in the order of the
/// lowest faces. Returns the number of charts.
std::size_t merge_charts(ChartSurface& surface, const ChartOptions& options, ChartReport& report,
                         Progress* progress);

/// Replaces every border between two charts by the shortest way along edges, as far as it stays inside the
/// two. Returns how many were replaced.
std::size_t straighten_borders(ChartSurface& surface, Progress* progress);

/// Cuts a chart of more than one face into two or more; new charts are numbered from `n_charts` on. Returns
/// the new number of charts.
std::size_t split_chart(ChartSurface& surface, std::span<const Index> faces, std::size_t n_charts);

/// Length of the borders between charts.
double cut_length(const ChartSurface& surface);
std::vector<VertexPlace> vertex_places(const ChartSurface& surface);
void check(const ChartOptions& options);

}  // namespace recede::detail
