// Whether triangles are a disk, and its border: the checks before `map_disk`.
#include <recede/geometry/detail/disk_map.h>
#include <recede/geometry/detail/edge_table.h>
#include <recede/geometry/disjoint_sets.h>
#include <recede/geometry/error.h>

#include <fmt/format.h>

namespace recede {
namespace {

[[noreturn]] void no_disk(const std::string& reason) { throw InputError("no disk to map: " + reason); }

void check_indices(std::span<const Vec3> positions, std::span<const Index> triangles) {
  if (triangles.empty() || triangles.size() % 3 != 0) no_disk("there must be three indices a triangle");
  std::vector<bool> used(positions.size(), false);
  for (const Index v : triangles) {
    if (v >= positions.size()) no_disk(fmt::format("vertex {} of {}", v, positions.size()));
    used[v] = true;
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!used[v]) no_disk(fmt::format("no triangle uses vertex {}", v));
    if (!positions[v].allFinite()) no_disk(fmt::format("the position of vertex {} isn't finite", v));
  }
}

/// The vertex after each vertex of the border.
std::vector<Index> border_successors(std::size_t n_vertices, std::span<const Index> triangles,
                                     const detail::EdgeTable& edges) {
  std::vector<Index> after(n_vertices, k_no_index);
  const auto end = [&](Index corner) { return triangles[corner % 3 == 2 ? corner - 2 : corner + 1]; };
  for (std::size_t e = 0; e < edges.n_edges(); ++e) {
    const auto sides = edges.sides(e);
    const Index from = triangles[sides[0]], to = end(sides[0]);
    if (from == to) no_disk(fmt::format("a triangle has vertex {} twice", from));
    if (sides.size() > 2) no_disk(fmt::format("edge {}-{} has more than two triangles", from, to));
    if (sides.size() == 2 && triangles[sides[1]] == from) {
      no_disk(fmt::format("triangles at edge {}-{} disagree in orientation", from, to));
    }
    if (sides.size() == 2) continue;
    if (after[from] != k_no_index) no_disk(fmt::format("the border passes vertex {} twice", from));
    after[from] = to;
  }
  return after;
}

}  // namespace

Parameterization parameterize_disk(std::span<const Vec3> positions, std::span<const Index> triangles,
                                   const ParameterizationOptions& options) {
  check_indices(positions, triangles);
  std::vector<Index> offsets(triangles.size() / 3 + 1);
  for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = static_cast<Index>(3 * t);
  const detail::EdgeTable edges = detail::build_edge_table(positions.size(), triangles, offsets);
  const std::vector<Index> after = border_successors(positions.size(), triangles, edges);

  DisjointSets pieces(positions.size());
  for (std::size_t c = 0; c < triangles.size(); ++c) pieces.unite(triangles[c], triangles[c - c % 3]);
  std::size_t n_border = 0;
  Index start = k_no_index;
  for (Index v = 0; v < positions.size(); ++v) {
    if (pieces.find(v) != 0) no_disk("there is more than one piece");
    if (after[v] == k_no_index) continue;
    ++n_border;
    if (start == k_no_index) start = v;
  }
  if (n_border == 0) no_disk("there is no border");
  // One piece with one border loop and Euler characteristic 1 has neither handles nor vertices where several
  // fans meet.
  if (positions.size() + triangles.size() / 3 != edges.n_edges() + 1) {
    no_disk("there is a handle or more than one border");
  }
  detail::Disk disk{{positions.begin(), positions.end()}, {triangles.begin(), triangles.end()}, {}};
  Index v = start;
  do {
    disk.border.push_back(v);
    v = after[v];
  } while (v != start && v != k_no_index && disk.border.size() <= n_border);
  if (v != start || disk.border.size() != n_border) no_disk("there is more than one border");
  return detail::map_disk(disk, options);
}

}  // namespace recede
