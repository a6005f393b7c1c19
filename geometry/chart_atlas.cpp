#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/detail/chart_surface.h>
#include <recede/geometry/detail/disk_map.h>
#include <recede/geometry/detail/orientation.h>
#include <recede/geometry/error.h>

#include <tbb/parallel_for.h>

#include <cmath>

namespace recede {
namespace {

// Charts of less than this share of the whole area are scaled as if they had it.
constexpr double k_least_area_share = 1e-9;

/// A chart on its way into the atlas.
struct MappedChart {
  std::vector<Index> faces;
  detail::Disk disk;
  Parameterization map;
  double area = 0;  // on the unit-sized surface
};

/// Makes disks of charts: triangles over vertices that are numbered anew in each chart, a mesh vertex once
/// for every fan of the chart's faces around it.
class DiskMaker {
 public:
  explicit DiskMaker(const detail::ChartSurface& surface)
      : surface_(surface), vertex_of_corner_(surface.soup->n_corners(), k_no_index) {
    triangulate(*surface.soup, nullptr, &triangle_corners_);
  }

  /// Corners of the face's triangles, three each.
  std::span<const Index> triangle_corners(Index face) const {
    const std::size_t first = 3 * (surface_.soup->face_offsets[face] - std::size_t{2} * face);
    return {triangle_corners_.data() + first, 3 * (surface_.soup->face_size(face) - 2)};
  }

  /// Vertex of the corner in its chart's disk.
  Index vertex(Index corner) const { return vertex_of_corner_[corner]; }

  detail::Disk make(std::span<const Index> faces) {
    const PolygonSoup& soup = *surface_.soup;
    for (const Index face : faces) {
      for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c)
        vertex_of_corner_[c] = k_no_index;
    }
    detail::Disk disk;
    Index border_start = k_no_index;
    for (const Index face : faces) {
      for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c) {
        if (vertex_of_corner_[c] == k_no_index) {
          number_fan(c, static_cast<Index>(disk.positions.size()));
          disk.positions.push_back(soup.positions[soup.corner_vertices[c]]);
        }
        if (border_start == k_no_index && !surface_.is_glued(c)) border_start = c;
      }
    }
    for (const Index face : faces) {
      for (const Index corner : triangle_corners(face)) disk.triangles.push_back(vertex_of_corner_[corner]);
    }
    Index side = border_start;
    do {
      disk.border.push_back(vertex_of_corner_[side]);
      side = surface_.next_on_border(side);
    } while (side != border_start);
    return disk;
  }

 private:
  /// All corners of the fan around a corner's vertex.
  void number_fan(Index corner, Index vertex) {
    Index at = corner;
    do {
      vertex_of_corner_[at] = vertex;
      const Index incoming = surface_.before(at);
      if (!surface_.is_glued(incoming)) break;
      at = surface_.opposite[incoming];
    } while (at != corner);
    for (at = corner; surface_.is_glued(at);) {
      at = surface_.after(surface_.opposite[at]);
      if (vertex_of_corner_[at] == vertex) break;
      vertex_of_corner_[at] = vertex;
    }
  }

  const detail::ChartSurface& surface_;
  std::vector<Index> triangle_corners_;
  std::vector<Index> vertex_of_corner_;
};

double area_of(const detail::Disk& disk) {
  double area = 0;
  for (std::size_t t = 0; t < disk.triangles.size(); t += 3) {
    const Vec3& a = disk.positions[disk.triangles[t]];
    area +=
        0.5 *
        (disk.positions[disk.triangles[t + 1]] - a).cross(disk.positions[disk.triangles[t + 2]] - a).norm();
  }
  return area;
}

double plane_area(const MappedChart& chart) {
  double area = 0;
  for (std::size_t t = 0; t < chart.disk.triangles.size(); t += 3) {
    const Vec2& a = chart.map.uvs[chart.disk.triangles[t]];
    const Vec2 ab = chart.map.uvs[chart.disk.triangles[t + 1]] - a,
               ac = chart.map.uvs[chart.disk.triangles[t + 2]] - a;
    area += 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
  }
  return area;
}

/// Maps all charts, cutting those that flip or stretch too much, until none has to be cut any more.
std::vector<MappedChart> map_charts(detail::ChartSurface& surface, DiskMaker& disks,
                                    const AtlasOptions& options, AtlasResult& result, Progress* progress) {
  std::vector<MappedChart> charts(result.report.charts);
  auto faces = surface.faces_by_chart(charts.size());
  std::vector<std::size_t> pending(charts.size());
  for (std::size_t c = 0; c < charts.size(); ++c) {
    charts[c].faces = std::move(faces[c]);
    pending[c] = c;
  }
  for (int round = 0; !pending.empty(); ++round) {
    report_progress(progress, "mapping charts", 1 - std::pow(0.5, round));
    for (const std::size_t c : pending) charts[c].disk = disks.make(charts[c].faces);
    tbb::parallel_for(std::size_t{0}, pending.size(), [&](std::size_t i) {
      MappedChart& chart = charts[pending[i]];
      chart.map = detail::map_disk(chart.disk, options.map);
      chart.area = area_of(chart.disk);
    });
    std::vector<std::size_t> cut;
    for (const std::size_t c : pending) {
      const bool flips = charts[c].map.flipped > 0;
      if (charts[c].faces.size() < 2 || (!flips && charts[c].map.stretch.l2 <= options.stretch_limit))
        continue;
      ++(flips ? result.split_for_flips : result.split_for_stretch);
      const std::size_t n_before = charts.size();
      charts.resize(detail::split_chart(surface, charts[c].faces, n_before));
      std::vector<Index> all = std::move(charts[c].faces);
      charts[c].faces.clear();
      for (const Index face : all) charts[surface.chart_of[face]].faces.push_back(face);
      cut.push_back(c);
      for (std::size_t added = n_before; added < charts.size(); ++added) cut.push_back(added);
    }
    pending = std::move(cut);
  }
  return charts;
}

/// Turns each chart into its smallest rectangle, in the scale of the unit-sized surface: its lower left
/// corner lies at the origin. Returns the rectangles' sides.
std::vector<Vec2> lay_out(std::vector<MappedChart>& charts, bool scale_by_stretch) {
  double total = 0;
  for (const MappedChart& chart : charts) total += chart.area;
  if (!(total > 0)) total = 1;
  std::vector<Vec2> sides;
  for (MappedChart& chart : charts) {
    const double stretch = scale_by_stretch ? chart.map.stretch.l2 : 1;
    const double wanted =
        std::max(chart.area * (std::isfinite(stretch) ? stretch * stretch : 1), k_least_area_share * total);
    const double present = plane_area(chart);
    const double scale = present > 0 ? std::sqrt(wanted / present) : 0;
    for (Vec2& uv : chart.map.uvs) uv *= scale;
    const BoundingRectangle box = smallest_rectangle(chart.map.uvs);
    const Vec2 across(-box.axis.y(), box.axis.x());
    for (Vec2& uv : chart.map.uvs) {
      const Vec2 p = uv - box.corner;
      uv = {p.dot(box.axis), p.dot(across)};
    }
    const double least = std::sqrt(k_least_area_share * total);
    sides.push_back(box.sides.cwiseMax(least));
  }
  return sides;
}

/// Moves the charts to their places in [0,1]^2.
void place_charts(std::vector<MappedChart>& charts, std::span<const Vec2> sides,
                  const PackedRectangles& packed, AtlasResult& result) {
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const PackedRectangles::Place& place = packed.places[c];
    AtlasChart& chart = result.charts[c];
    const Vec2 texels = packed.texels_per_unit * sides[c];
    chart.x = place.x;
    chart.y = place.y;
    chart.width = static_cast<int>(std::ceil(place.turned ? texels.y() : texels.x()));
    chart.height = static_cast<int>(std::ceil(place.turned ? texels.x() : texels.y()));
    for (Vec2& uv : charts[c].map.uvs) {
      // A quarter turn, not a reflection: it keeps triangles counter-clockwise.
      Vec2 p = packed.texels_per_unit * (place.turned ? Vec2(sides[c].y() - uv.y(), uv.x()) : uv);
      p = p.cwiseMax(0.0).cwiseMin(Vec2(chart.width, chart.height));
      uv = (p + Vec2(place.x, place.y)) / packed.resolution;
    }
  }
}

void describe(const std::vector<MappedChart>& charts, double unit, AtlasResult& result) {
  detail::StretchSum whole;
  double uv_area = 0, area = 0;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const MappedChart& mapped = charts[c];
    const auto& triangles = mapped.disk.triangles;
    AtlasChart& chart = result.charts[c];
    chart.faces = mapped.faces.size();
    chart.area = mapped.area * unit * unit;
    chart.weights = mapped.map.weights;
    chart.border = mapped.map.border;
    chart.stretch = mapped.map.stretch;
    chart.flipped = count_flipped(mapped.map.uvs, triangles);
    result.flipped += chart.flipped;
    result.uniform_weights += mapped.map.weights == ParameterizationWeights::uniform ? 1 : 0;
    uv_area += plane_area(mapped);
    area += mapped.area;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      const Index a = triangles[t], b = triangles[t + 1], d = triangles[t + 2];
      whole.add(mapped.disk.positions[a], mapped.disk.positions[b], mapped.disk.positions[d],
                mapped.map.uvs[a], mapped.map.uvs[b], mapped.map.uvs[d]);
    }
  }
  result.stretch = whole.stretch();
  result.occupancy = uv_area;
  result.units_per_uv = uv_area > 0 ? std::sqrt(area / uv_area) * unit : 0;
}

}  // namespace

AtlasResult make_atlas(const PolygonSoup& soup, const AtlasOptions& options, Progress* progress) {
  validate(soup, "atlas");
  detail::check(options.charts);
  if (!(options.stretch_limit >= 1)) throw OptionError("the stretch limit must be at least 1");
  AtlasResult result;
  result.soup = soup;
  const detail::UnitSized sized(soup);
  detail::ChartSurface surface = detail::find_charts(sized, options.charts, result.report, progress);
  DiskMaker disks(surface);
  std::vector<MappedChart> charts = map_charts(surface, disks, options, result, progress);
  report_progress(progress, "packing charts", 0);
  const std::vector<Vec2> sides = lay_out(charts, options.scale_by_stretch);
  const PackedRectangles packed = pack_rectangles(sides, options.packing);
  result.charts.resize(charts.size());
  place_charts(charts, sides, packed, result);
  describe(charts, sized.unit, result);
  result.soup.corner_uvs.resize(soup.n_corners());
  for (const MappedChart& chart : charts) {
    for (const Index face : chart.faces) {
      for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c) {
        result.soup.corner_uvs[c] = chart.map.uvs[disks.vertex(c)];
      }
    }
  }
  result.report.charts = charts.size();
  result.report.cut_length = detail::cut_length(surface) * sized.unit;
  result.face_charts = surface.chart_of;
  result.resolution = packed.resolution;
  return result;
}

}  // namespace recede
