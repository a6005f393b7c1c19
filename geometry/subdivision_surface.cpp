#include <recede/geometry/detail/grid_numbers.h>
#include <recede/geometry/detail/limit_error.h>
#include <recede/geometry/error.h>
#include <recede/geometry/shading_normals.h>
#include <recede/geometry/subdivision_surface.h>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <numbers>

namespace recede {
namespace {

using detail::ControlMesh;
using detail::FaceGrid;
using detail::FaceLimit;
using detail::GridNumbers;
using detail::GridPlace;
using detail::GridPoint;
using detail::LimitSurface;

constexpr std::size_t k_faces_of_a_task = 8;
constexpr std::size_t k_blocks = 32;  // between two of them progress is reported

/// The points and facets of one level.
class Subdivider {
 public:
  Subdivider(const ControlMesh& control, const SubdivisionOptions& options, int level)
      : control_(control),
        options_(options),
        level_(level),
        surface_(control, options, detail::limit_sample_level(options.scheme, level)),
        grids_(detail::make_face_grids(control, options.scheme, level)),
        points_(detail::number_positions(control, grids_, level)) {
    if (!control.corner_uv_numbers.empty()) uvs_ = detail::number_uvs(control, grids_, level);
    find_sharp_points();
  }

  SubdivisionResult run(Progress* progress) {
    allocate();
    tbb::enumerable_thread_specific<FaceLimit> limits([&] { return FaceLimit(surface_); });
    const std::size_t n_faces = control_.soup.n_faces();
    for (std::size_t block = 0; block < k_blocks; ++block) {
      report_progress(progress, "subdividing", static_cast<double>(block) / k_blocks);
      const tbb::blocked_range<std::size_t> faces(n_faces * block / k_blocks,
                                                  n_faces * (block + 1) / k_blocks, k_faces_of_a_task);
      tbb::parallel_for(faces, [&](const auto& range) {
        FaceLimit& limit = limits.local();
        for (std::size_t f = range.begin(); f != range.end(); ++f) {
          limit.set_face(f, true);
          evaluate_face(f, limit);
          write_facets(f);
        }
      });
    }
    join_sharp_normals();
    finish_corners();
    keep_feature_edges();
    SubdivisionResult result;
    result.level = level_;
    result.triangulated = control_.triangulated;
    for (std::size_t e = 0; e < control_.edges.n_edges(); ++e) {
      if (control_.edge_sharpness[e] > 0 && control_.edges.sides(e).size() == 2) ++result.crease_edges;
    }
    result.error_estimate =
        detail::estimate_limit_error(control_, surface_, options_.scheme, level_, soup_, progress);
    result.soup = std::move(soup_);
    return result;
  }

 private:
  const FaceGrid& grid(std::size_t face) const { return grids_.at(control_.soup.face_size(face)); }

  /// Where the limit surface may have several normals: their mean is taken, side by side.
  void find_sharp_points() {
    const PolygonSoup& soup = control_.soup;
    sharp_edges_at_.assign(soup.positions.size(), 0);
    for (std::size_t e = 0; e < control_.edges.n_edges(); ++e) {
      if (!control_.is_sharp(e)) continue;
      const Index side = control_.edges.sides(e)[0];
      ++sharp_edges_at_[control_.from(side)];
      ++sharp_edges_at_[control_.to(side)];
    }
    first_side_.assign(soup.n_corners(), k_no_index);
    std::size_t n_sides = 0;
    for (Index c = 0; c < soup.n_corners(); ++c) {
      if (is_crease(c)) first_side_[c] = static_cast<Index>(n_sides++);
    }
    corner_normals_.assign(soup.n_corners(), Vec3(0, 0, 0));
    side_normals_.assign(n_sides * points_.steps, Vec3(0, 0, 0));
  }

  /// The corner's side has two faces and stays sharp. On a border one face has the only normal.
  bool is_crease(Index corner) const {
    const Index edge = control_.edges.edge_of_corner[corner];
    return control_.edges.sides(edge).size() == 2 && control_.is_sharp(edge);
  }
  bool has_several_normals(std::size_t vertex) const {
    return sharp_edges_at_[vertex] > 0 || control_.vertex_sharpness[vertex] >= float{k_infinite_sharpness};
  }

  void allocate() {
    const PolygonSoup& control = control_.soup;
    soup_.positions.resize(points_.count());
    normals_.resize(points_.count());
    uv_values_.resize(control_.corner_uv_numbers.empty() ? 0 : uvs_.count());
    if (!control.vertex_colors.empty()) soup_.vertex_colors.resize(points_.count());
    for (const VertexScalar& scalar : control.vertex_scalars)
      soup_.vertex_scalars.push_back({scalar.name, std::vector<double>(points_.count())});
    soup_.materials = control.materials;
    first_cells_.push_back(0);
    std::size_t n_corners = 0;
    for (std::size_t f = 0; f < control.n_faces(); ++f) {
      const FaceGrid& cells = grid(f);
      for (std::size_t k = 0; k < cells.n_cells(); ++k) {
        n_corners += cells.cell_sides;
        soup_.face_offsets.push_back(static_cast<Index>(n_corners));
        if (!control.face_materials.empty()) soup_.face_materials.push_back(control.face_materials[f]);
      }
      first_cells_.push_back(first_cells_.back() + cells.n_cells());
    }
    soup_.corner_vertices.resize(n_corners);
    soup_.corner_normals.resize(n_corners);
    soup_.corner_uvs.resize(uv_values_.empty() ? 0 : n_corners);
  }

  void evaluate_face(std::size_t face, const FaceLimit& limit) {
    const Index first_corner = control_.soup.face_offsets[face];
    std::vector<double> attributes(surface_.n_attributes());
    for (const GridPoint& point : grid(face).points) {
      const bool is_owner = points_.is_owner(first_corner, point);
      Vec3* const side_normal = side_normal_of(first_corner, point);
      if (is_owner || side_normal != nullptr) {
        const FaceLimit::Point at = limit.at(point.at);
        const std::size_t number = points_.of(face, first_corner, point);
        if (side_normal != nullptr) {
          *side_normal = one_sided_normal(face, point, at, limit);
        } else {
          normals_[number] = smooth_normal(face, point, at.du.cross(at.dv));
        }
        if (is_owner) {
          soup_.positions[number] = at.position;
          if (!attributes.empty()) {
            limit.attributes(point.at, attributes);
            set_attributes(number, attributes);
          }
        }
      }
      if (!uv_values_.empty() && uvs_.is_owner(first_corner, point))
        uv_values_[uvs_.of(face, first_corner, point)] = limit.uv(point.at);
    }
  }

  /// Where the face's own normal goes at a point with several; else nullptr.
  Vec3* side_normal_of(Index first_corner, const GridPoint& point) {
    const Index corner = first_corner + point.element;
    if (point.place == GridPlace::corner && has_several_normals(control_.soup.corner_vertices[corner]))
      return &corner_normals_[corner];
    if (point.place == GridPlace::side && first_side_[corner] != k_no_index)
      return &side_normals_[first_side_[corner] * points_.steps + point.step - 1];
    return nullptr;
  }

  /// Unit length but for (0,0,0), where there is none.
  Vec3 smooth_normal(std::size_t face, const GridPoint& point, const Vec3& cross) const {
    Vec3 exact(0, 0, 0);
    if (point.place == GridPlace::corner) {
      exact = surface_.vertex_normals()[control_.soup.face(face)[point.element]];
    } else if (point.place == GridPlace::inside && point.step == 0 &&
               !surface_.face_center_normals().empty()) {
      exact = surface_.face_center_normals()[face];
    }
    if (!(exact.norm() > 0)) return cross.norm() > 0 ? Vec3(cross.normalized()) : Vec3(0, 0, 0);
    return exact.dot(cross) < 0 ? Vec3(-exact) : exact;
  }

  /// The face's normal times the angle that it fills around a vertex; on sides without it.
  Vec3 one_sided_normal(std::size_t face, const GridPoint& point, const FaceLimit::Point& at,
                        const FaceLimit& limit) const {
    const auto unit = [](const FaceLimit::Point& p) {
      const Vec3 cross = p.du.cross(p.dv);
      return cross.norm() > 0 ? Vec3(cross.normalized()) : Vec3(0, 0, 0);
    };
    if (point.place == GridPlace::side) return unit(at);
    const double angle = angle_between(at.du, at.dv);
    if (!fills_half_turn(face, point)) return angle * unit(at);
    // Both sides have one direction there and no cross product: a line through two points near by leads to
    // the normal. They are points that are exact, and so near that the rest is of the order of 1e-5.
    constexpr double k_near = 1.0 / 256;
    const auto near = [&](double distance) {
      return unit(limit.at(detail::grid_coordinate(options_.scheme, control_.soup.face_size(face),
                                                   point.element, distance, distance)));
    };
    return std::numbers::pi * (2 * near(k_near) - near(2 * k_near));
  }

  /// A smooth crease or border turns the corner of a single face into half a turn.
  bool fills_half_turn(std::size_t face, const GridPoint& point) const {
    const Index first = control_.soup.face_offsets[face];
    const auto sides = static_cast<Index>(control_.soup.face_size(face));
    const Index corner = first + point.element, before = first + (point.element + sides - 1) % sides;
    const Index next_edge = control_.edges.edge_of_corner[corner];
    const Index edge_before = control_.edges.edge_of_corner[before];
    const Index vertex = control_.soup.corner_vertices[corner];
    if (!control_.is_sharp(next_edge) || !control_.is_sharp(edge_before)) return false;
    if (sharp_edges_at_[vertex] != 2 || control_.vertex_sharpness[vertex] > 0) return false;
    const bool is_only_face =
        control_.edges.sides(next_edge).size() == 1 && control_.edges.sides(edge_before).size() == 1;
    return !is_only_face || options_.boundary == SubdivisionBoundary::edge_only;
  }

  void set_attributes(std::size_t number, const std::vector<double>& values) {
    std::size_t next = 0;
    if (!soup_.vertex_colors.empty()) {
      for (Eigen::Index i = 0; i < 4; ++i) soup_.vertex_colors[number][i] = values[next++];
    }
    for (VertexScalar& scalar : soup_.vertex_scalars) scalar.values[number] = values[next++];
  }

  void write_facets(std::size_t face) {
    const FaceGrid& cells = grid(face);
    const Index first_corner = control_.soup.face_offsets[face];
    std::size_t corner = soup_.face_offsets[first_cells_[face]];
    for (const Index place : cells.cell_points) {
      soup_.corner_vertices[corner] = static_cast<Index>(points_.of(face, first_corner, cells.points[place]));
      ++corner;
    }
  }

  void join_sharp_normals() {
    const PolygonSoup& soup = control_.soup;
    std::vector<Vec3> sums(soup.positions.size(), Vec3(0, 0, 0));
    for (std::size_t c = 0; c < soup.n_corners(); ++c) sums[soup.corner_vertices[c]] += corner_normals_[c];
    for (std::size_t v = 0; v < sums.size(); ++v) {
      if (has_several_normals(v)) normals_[v] = sums[v].norm() > 0 ? Vec3(sums[v].normalized()) : sums[v];
    }
    for (std::size_t e = 0; e < control_.edges.n_edges(); ++e) {
      const auto sides = control_.edges.sides(e);
      if (first_side_[sides[0]] == k_no_index) continue;
      for (std::size_t step = 0; step < points_.steps; ++step) {
        // The other face runs along the edge the other way.
        const Vec3 sum = side_normals_[first_side_[sides[0]] * points_.steps + step] +
                         side_normals_[first_side_[sides[1]] * points_.steps + points_.steps - 1 - step];
        const std::size_t place = points_.is_against[sides[0]] ? points_.steps - 1 - step : step;
        normals_[points_.first_on_lines() + e * points_.steps + place] =
            sum.norm() > 0 ? Vec3(sum.normalized()) : sum;
      }
    }
  }

  void finish_corners() {
    const auto has_none = [](const Vec3& normal) { return !(normal.norm() > 0.5); };  // or isn't finite
    if (std::any_of(normals_.begin(), normals_.end(), has_none)) {
      const std::vector<Vec3> facets = shading_normals(soup_, std::numbers::pi);
      for (std::size_t c = 0; c < soup_.n_corners(); ++c) {
        Vec3& normal = normals_[soup_.corner_vertices[c]];
        if (has_none(normal)) normal = has_none(facets[c]) ? Vec3(0, 0, 1) : facets[c];
      }
    }
    const std::size_t n_faces = control_.soup.n_faces();
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n_faces, k_faces_of_a_task), [&](const auto& range) {
      for (std::size_t f = range.begin(); f != range.end(); ++f) {
        const FaceGrid& cells = grid(f);
        std::size_t corner = soup_.face_offsets[first_cells_[f]];
        for (const Index place : cells.cell_points) {
          soup_.corner_normals[corner] = normals_[soup_.corner_vertices[corner]];
          if (!uv_values_.empty()) {
            soup_.corner_uvs[corner] =
                uv_values_[uvs_.of(f, control_.soup.face_offsets[f], cells.points[place])];
          }
          ++corner;
        }
      }
    });
  }

  void keep_feature_edges() {
    for (std::size_t e = 0; e < control_.edges.n_edges(); ++e) {
      if (!control_.is_feature[e] && first_side_[control_.edges.sides(e)[0]] == k_no_index) continue;
      const Index side = control_.edges.sides(e)[0];
      Index last = std::min(control_.from(side), control_.to(side));
      const Index end = std::max(control_.from(side), control_.to(side));
      const std::size_t first = points_.first_on_lines() + e * points_.steps;
      for (std::size_t step = 0; step <= points_.steps; ++step) {
        const Index next = step == points_.steps ? end : static_cast<Index>(first + step);
        soup_.feature_edges.push_back(std::minmax(last, next));
        last = next;
      }
    }
  }

  const ControlMesh& control_;
  const SubdivisionOptions& options_;
  int level_;
  LimitSurface surface_;
  detail::FaceGrids grids_;
  GridNumbers points_, uvs_;
  std::vector<Index> sharp_edges_at_;  // V
  std::vector<Index> first_side_;      // C: place in side_normals_ of a crease's side, in lines
  std::vector<Vec3> corner_normals_, side_normals_;
  PolygonSoup soup_;
  std::vector<Vec3> normals_;  // of points
  std::vector<Vec2> uv_values_;
  std::vector<std::size_t> first_cells_;  // F + 1
};

}  // namespace

SubdivisionResult subdivide(const PolygonSoup& control, const SubdivisionOptions& options,
                            Progress* progress) {
  const ControlMesh mesh = detail::make_control_mesh(control, options);
  if (!options.error) {
    detail::require_few_facets(mesh, options.scheme, options.level);
    return Subdivider(mesh, options, options.level).run(progress);
  }
  for (int level = 0; level <= SubdivisionOptions::k_largest_level; ++level) {
    detail::require_few_facets(mesh, options.scheme, level, "the error is too small: ");
    SubdivisionResult result = Subdivider(mesh, options, level).run(progress);
    if (result.error_estimate <= *options.error) return result;
  }
  throw OptionError(fmt::format("the error is too small: it needs more than {} levels",
                                SubdivisionOptions::k_largest_level));
}

}  // namespace recede
