// A height map as a surface over the unit square, and where rays meet it.
#pragma once

#include <recede/geometry/bilinear_patch.h>
#include <recede/geometry/displacement_map.h>

#include <limits>
#include <optional>
#include <vector>

namespace recede {

/// The surface (u, v, height(u, v)) over the unit square. Every cell of the map is one bilinear patch, so
/// nothing is tessellated: beside the map there are only its bounds. Queries may run in parallel. Keeps a
/// reference to the map, which must stay in place.
class HeightField {
 public:
  explicit HeightField(const DisplacementMap& map);
  explicit HeightField(DisplacementMap&&) = delete;

  struct Hit {
    double t = 0;  ///< in lengths of the direction
    Vec2 uv = Vec2::Zero();
    Vec3 normal = Vec3::Zero();  ///< unit length, upwards
    int cell_x = 0, cell_y = 0;  ///< see `DisplacementMap`
  };

  /// The first point with t from `t_min` to `t_max` in which a ray meets the surface, from above or below;
  /// the same as of a test of all cells one by one (of hits at one t, any). Rays don't slip through between
  /// cells. `direction` has any length; a ray without direction, or with numbers that aren't finite, meets
  /// nothing.
  std::optional<Hit> first_hit(const Vec3& origin, const Vec3& direction, double t_min = 0,
                               double t_max = std::numeric_limits<double>::infinity()) const;
  /// Whether there is one; faster.
  bool is_hit(const Vec3& origin, const Vec3& direction, double t_min = 0,
              double t_max = std::numeric_limits<double>::infinity()) const;

  /// The patch of a cell: its u and v grow with the texel's x and y. Cells along the border are cut by it.
  BilinearPatch cell(int x, int y) const;

  const HeightBounds& bounds() const { return bounds_; }

 private:
  struct Node;
  struct Search;
  double height_at_node(int x, int y) const;
  void test_cell(const Node& node, Search& search) const;
  std::size_t open(const Node& node, const Search& search, Node* children) const;
  void search(Search& search) const;

  const DisplacementMap* map_;
  HeightBounds bounds_;
  std::vector<double> u_, v_;  // of the lines between cells, the borders included
};

}  // namespace recede
