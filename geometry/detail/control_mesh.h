// A control mesh that was found to be one: manifold, with a sharpness for every edge.
#pragma once

#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/subdivision_surface.h>

namespace recede::detail {

struct ControlMesh {
  PolygonSoup soup;  ///< without vertices that have no face; triangles for Loop
  EdgeTable edges;
  std::vector<float> edge_sharpness;    ///< E, at most `k_infinite_sharpness`; borders are sharp without it
  std::vector<float> vertex_sharpness;  ///< V
  std::vector<bool> is_feature;         ///< E: pieces become feature edges
  /// C numbers of texture coordinates: corners at a vertex have the same one when their faces hang together
  /// there by edges on which texture coordinates agree. Empty without any.
  std::vector<Index> corner_uv_numbers;
  std::size_t n_uv_numbers = 0;
  std::size_t triangulated = 0;

  /// The next corner of the same face; the vertices from and to which the corner's side runs.
  Index after(Index corner) const { return next_corner(soup, edges.corner_faces, corner); }
  Index from(Index corner) const { return soup.corner_vertices[corner]; }
  Index to(Index corner) const { return soup.corner_vertices[after(corner)]; }

  /// The side stays sharp at every level: a border or an infinitely sharp crease.
  bool is_sharp(std::size_t edge) const {
    return edges.sides(edge).size() == 1 || edge_sharpness[edge] >= float{k_infinite_sharpness};
  }
};

/// Throws what `subdivide` does, but for the number of facets, which `require_few_facets` looks at.
ControlMesh make_control_mesh(const PolygonSoup& control, const SubdivisionOptions& options);
/// Throws `OptionError` for a level of more than `k_most_faces`; `wish` stands in front of the text.
void require_few_facets(const ControlMesh& control, SubdivisionScheme scheme, int level,
                        const std::string& wish = "");

}  // namespace recede::detail
