#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/detail/chart_surface.h>
#include <recede/geometry/detail/disk_map.h>
#include <recede/geometry/error.h>
#include <recede/geometry/texture.h>

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
  double area = 0;          // on the unit-sized surface
  std::vector<Vec2> uvs{};  // in the atlas
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

double plane_area(const detail::Disk& disk, const std::vector<Vec2>& uvs) {
  double area = 0;
  for (std::size_t t = 0; t < disk.triangles.size(); t += 3) {
    const Vec2& a = uvs[disk.triangles[t]];
    const Vec2 ab = uvs[disk.triangles[t + 1]] - a, ac = uvs[disk.triangles[t + 2]] - a;
    area += 0.5 * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
  }
  return area;
}

/// Maps charts, and cuts those that can't be mapped well.
class ChartMapper {
 public:
  ChartMapper(detail::ChartSurface& surface, const AtlasOptions& options, AtlasResult& result)
      : surface_(surface),
        options_(options),
        result_(result),
        disks_(surface),
        charts_(result.report.charts) {
    auto faces = surface.faces_by_chart(charts_.size());
    for (std::size_t c = 0; c < charts_.size(); ++c) {
      charts_[c].faces = std::move(faces[c]);
      pending_.push_back(c);
    }
  }

  /// Until no chart flips or stretches too much.
  void map(Progress* progress) {
    for (int round = 0; !pending_.empty(); ++round) {
      report_progress(progress, "mapping charts", 1 - std::pow(0.5, round));
      std::vector<std::size_t> charts;
      charts.swap(pending_);
      for (const std::size_t c : charts) charts_[c].disk = disks_.make(charts_[c].faces);
      tbb::parallel_for(std::size_t{0}, charts.size(), [&](std::size_t i) {
        MappedChart& chart = charts_[charts[i]];
        chart.map = detail::map_disk(chart.disk, options_.map);
        chart.area = area_of(chart.disk);
      });
      for (const std::size_t c : charts) {
        const Parameterization& map = charts_[c].map;
        if (charts_[c].faces.size() < 2) continue;
        if (map.flipped > 0) {
          cut(c, result_.split_for_flips);
        } else if (!(map.stretch.l2 <= options_.stretch_limit)) {
          cut(c, result_.split_for_stretch);
        }
      }
    }
  }

  /// Rounding at a chart's place in the atlas may flip what its map didn't. Cuts such charts; a single face
  /// becomes a triangle or polygon of a better shape. False when there was nothing to do.
  bool cut_flipped() {
    bool changed = false;
    for (std::size_t c = 0, n = charts_.size(); c < n; ++c) {
      MappedChart& chart = charts_[c];
      if (count_flipped(chart.uvs, chart.disk.triangles) == 0) continue;
      if (chart.faces.size() > 1) {
        cut(c, result_.split_for_flips);
      } else if (chart.map.border == DiskBorder::natural) {
        ParameterizationOptions round = options_.map;
        round.border = DiskBorder::ellipse;
        chart.map = detail::map_disk(chart.disk, round);
      } else {
        continue;
      }
      changed = true;
    }
    return changed;
  }

  std::vector<MappedChart>& charts() { return charts_; }
  Index vertex(Index corner) const { return disks_.vertex(corner); }

 private:
  void cut(std::size_t chart, std::size_t& counter) {
    ++counter;
    const std::size_t n_before = charts_.size();
    charts_.resize(detail::split_chart(surface_, charts_[chart].faces, n_before));
    const std::vector<Index> faces = std::move(charts_[chart].faces);
    charts_[chart].faces.clear();
    for (const Index face : faces) charts_[surface_.chart_of[face]].faces.push_back(face);
    pending_.push_back(chart);
    for (std::size_t added = n_before; added < charts_.size(); ++added) pending_.push_back(added);
  }

  detail::ChartSurface& surface_;
  const AtlasOptions& options_;
  AtlasResult& result_;
  DiskMaker disks_;
  std::vector<MappedChart> charts_;
  std::vector<std::size_t> pending_;  // to be mapped
};

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
    const double present = plane_area(chart.disk, chart.map.uvs);
    const double scale = present > 0 ? std::sqrt(wanted / present) : 0;
    const BoundingRectangle box = smallest_rectangle(chart.map.uvs);
    const Vec2 across(-box.axis.y(), box.axis.x());
    chart.uvs.clear();
    for (const Vec2& uv : chart.map.uvs) {
      const Vec2 p = scale * (uv - box.corner);
      chart.uvs.emplace_back(p.dot(box.axis), p.dot(across));
    }
    const double least = std::sqrt(k_least_area_share * total);
    sides.push_back((scale * box.sides).cwiseMax(least));
  }
  return sides;
}

/// Moves the charts to their places in [0,1]^2.
void place_charts(std::vector<MappedChart>& charts, std::span<const Vec2> sides,
                  const PackedRectangles& packed, AtlasResult& result) {
  result.charts.assign(charts.size(), {});
  result.resolution = packed.resolution;
  for (std::size_t c = 0; c < charts.size(); ++c) {
    const PackedRectangles::Place& place = packed.places[c];
    AtlasChart& chart = result.charts[c];
    const Vec2 texels = packed.texels_per_unit * sides[c];
    chart.x = place.x;
    chart.y = place.y;
    chart.width = static_cast<int>(std::ceil(place.turned ? texels.y() : texels.x()));
    chart.height = static_cast<int>(std::ceil(place.turned ? texels.x() : texels.y()));
    for (Vec2& uv : charts[c].uvs) {
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
    chart.flipped = count_flipped(mapped.uvs, triangles);
    result.flipped += chart.flipped;
    result.uniform_weights += mapped.map.weights == ParameterizationWeights::uniform ? 1 : 0;
    uv_area += plane_area(mapped.disk, mapped.uvs);
    area += mapped.area;
    for (std::size_t t = 0; t < triangles.size(); t += 3) {
      const Index a = triangles[t], b = triangles[t + 1], d = triangles[t + 2];
      whole.add(mapped.disk.positions[a], mapped.disk.positions[b], mapped.disk.positions[d], mapped.uvs[a],
                mapped.uvs[b], mapped.uvs[d]);
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
  ChartMapper mapper(surface, options, result);
  do {
    mapper.map(progress);
    report_progress(progress, "packing charts", 0);
    const std::vector<Vec2> sides = lay_out(mapper.charts(), options.scale_by_stretch);
    place_charts(mapper.charts(), sides, pack_rectangles(sides, options.packing), result);
  } while (mapper.cut_flipped());
  describe(mapper.charts(), sized.unit, result);
  drop_textures(result.soup.materials);
  result.soup.corner_uvs.resize(soup.n_corners());
  for (const MappedChart& chart : mapper.charts()) {
    for (const Index face : chart.faces) {
      for (Index c = soup.face_offsets[face]; c < soup.face_offsets[face + 1]; ++c) {
        result.soup.corner_uvs[c] = chart.uvs[mapper.vertex(c)];
      }
    }
  }
  result.report.charts = result.charts.size();
  result.report.cut_length = detail::cut_length(surface) * sized.unit;
  result.face_charts = surface.chart_of;
  return result;
}

}  // namespace recede
