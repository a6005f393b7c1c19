#include <recede/geometry/detail/edge_table.h>

#include <algorithm>

namespace recede::detail {
namespace {

struct Side {
  Index upper;  // the larger vertex of the edge
  Index corner;
};

}  // namespace

EdgeTable build_edge_table(std::size_t n_vertices, std::span<const Index> corner_vertices,
                           std::span<const Index> face_offsets) {
  EdgeTable table;
  const std::size_t n_corners = corner_vertices.size();
  table.corner_faces.resize(n_corners);
  for (std::size_t f = 0; f + 1 < face_offsets.size(); ++f) {
    std::fill(table.corner_faces.begin() + face_offsets[f], table.corner_faces.begin() + face_offsets[f + 1],
              static_cast<Index>(f));
  }
  // Counting sort of all sides by their lower vertex; each bucket is small and sorted by the upper one.
  const auto ends = [&](std::size_t corner) -> std::pair<Index, Index> {
    const Index face = table.corner_faces[corner];
    const std::size_t after = corner + 1 == face_offsets[face + 1] ? face_offsets[face] : corner + 1;
    const Index a = corner_vertices[corner], b = corner_vertices[after];
    return std::minmax(a, b);
  };
  std::vector<Index> bucket_ends(n_vertices + 1, 0);
  for (std::size_t c = 0; c < n_corners; ++c) ++bucket_ends[ends(c).first + 1];
  for (std::size_t v = 1; v < bucket_ends.size(); ++v) bucket_ends[v] += bucket_ends[v - 1];
  std::vector<Index> bucket_fill(bucket_ends.begin(), bucket_ends.end() - 1);
  std::vector<Side> sides(n_corners);
  for (std::size_t c = 0; c < n_corners; ++c) {
    const auto [lower, upper] = ends(c);
    sides[bucket_fill[lower]++] = {upper, static_cast<Index>(c)};
  }
  table.edge_of_corner.resize(n_corners);
  table.edge_corners.resize(n_corners);
  for (std::size_t v = 0; v + 1 < bucket_ends.size(); ++v) {
    const auto first = sides.begin() + bucket_ends[v], last = sides.begin() + bucket_ends[v + 1];
    std::sort(first, last, [](const Side& x, const Side& y) {
      return x.upper != y.upper ? x.upper < y.upper : x.corner < y.corner;
    });
    for (auto side = first; side != last; ++side) {
      const auto place = static_cast<std::size_t>(side - sides.begin());
      if (side == first || side->upper != (side - 1)->upper)
        table.edge_offsets.push_back(static_cast<Index>(place));
      table.edge_corners[place] = side->corner;
      table.edge_of_corner[side->corner] = static_cast<Index>(table.edge_offsets.size() - 1);
    }
  }
  table.edge_offsets.push_back(static_cast<Index>(n_corners));
  return table;
}

}  // namespace recede::detail
