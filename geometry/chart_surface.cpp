#include <recede/geometry/detail/chart_surface.h>
#include <recede/geometry/detail/edge_table.h>

#include <algorithm>
#include <numeric>

namespace recede::detail {
namespace {

/// Edges that the options close, by a predicate on two opposite sides.
class ClosedEdges {
 public:
  ClosedEdges(const PolygonSoup& soup, const ChartOptions& options) : soup_(soup), options_(options) {
    if (!options.keep_feature_edges) return;
    for (const auto& [a, b] : soup.feature_edges) features_.push_back(std::minmax(a, b));
    std::sort(features_.begin(), features_.end());
  }

  bool contains(const ChartSurface& surface, Index side, Index other) const {
    if (options_.keep_materials && !soup_.face_materials.empty() &&
        soup_.face_materials[surface.face_of[side]] != soup_.face_materials[surface.face_of[other]]) {
      return true;
    }
    if (options_.keep_uv_seams && !soup_.corner_uvs.empty() &&
        (soup_.corner_uvs[side] != soup_.corner_uvs[surface.after(other)] ||
         soup_.corner_uvs[surface.after(side)] != soup_.corner_uvs[other])) {
      return true;
    }
    return !features_.empty() &&
           std::binary_search(features_.begin(), features_.end(),
                              std::pair<Index, Index>(std::minmax(surface.from(side), surface.to(side))));
  }

 private:
  const PolygonSoup& soup_;
  const ChartOptions& options_;
  std::vector<std::pair<Index, Index>> features_;
};

}  // namespace

ChartSurface::ChartSurface(const PolygonSoup& whole, const ChartOptions& options, ChartReport& report)
    : soup(&whole), opposite(whole.n_corners(), k_no_index), chart_of(whole.n_faces()) {
  std::iota(chart_of.begin(), chart_of.end(), Index{0});
  EdgeTable edges = build_edge_table(whole);
  face_of = std::move(edges.corner_faces);
  const ClosedEdges closed(whole, options);
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const auto sides = edges.sides(e);
    if (sides.size() == 1) {
      ++report.border_edges;
      continue;
    }
    const Index a = sides[0], b = sides[1];
    // A face that passes an edge twice, or has one without length, isn't glued to itself.
    if (sides.size() > 2 || from(a) == from(b) || face_of[a] == face_of[b]) {
      ++report.non_manifold_edges;
    } else if (closed.contains(*this, a, b)) {
      ++report.kept_edges;
    } else {
      opposite[a] = b;
      opposite[b] = a;
    }
  }
}

ChartSurface::ChartSurface(const ChartSurface& whole, PolygonSoup& faces_as_soup,
                           std::span<const Index> faces)
    : soup(&faces_as_soup), chart_of(faces.size()) {
  std::iota(chart_of.begin(), chart_of.end(), Index{0});
  std::vector<Index> vertices;
  for (const Index face : faces) {
    vertices.insert(vertices.end(), whole.soup->face(face).begin(), whole.soup->face(face).end());
    faces_as_soup.add_face(whole.soup->face(face));
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  for (const Index v : vertices) faces_as_soup.positions.push_back(whole.soup->positions[v]);
  for (Index& v : faces_as_soup.corner_vertices) {
    v = static_cast<Index>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
  }
  opposite.assign(faces_as_soup.n_corners(), k_no_index);
  face_of.resize(faces_as_soup.n_corners());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Index first = faces_as_soup.face_offsets[f], whole_first = whole.soup->face_offsets[faces[f]];
    for (Index side = first; side < faces_as_soup.face_offsets[f + 1]; ++side) {
      face_of[side] = static_cast<Index>(f);
      const Index whole_side = whole_first + (side - first);
      if (!whole.is_glued(whole_side)) continue;
      const Index other = whole.opposite[whole_side], other_face = whole.face_of[other];
      const auto place = std::lower_bound(faces.begin(), faces.end(), other_face) - faces.begin();
      opposite[side] = faces_as_soup.face_offsets[static_cast<std::size_t>(place)] +
                       (other - whole.soup->face_offsets[other_face]);
    }
  }
}

std::vector<std::vector<Index>> ChartSurface::faces_by_chart(std::size_t n_charts) const {
  std::vector<std::vector<Index>> faces(n_charts);
  for (Index f = 0; f < chart_of.size(); ++f) faces[chart_of[f]].push_back(f);
  return faces;
}

}  // namespace recede::detail
