#include <recede/geometry/detail/same_positions.h>
#include <recede/lod/detail/chunk_ladder.h>
#include <recede/lod/detail/simplifier.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

SimplifyOptions options_of_chunk(SimplifyOptions options, double factor) {
  options.weights.uv *= factor;
  options.weights.normal *= factor;
  options.weights.color *= factor;
  for (auto& scalar : options.weights.scalars) scalar.second *= factor;
  // Parts of a chunk may be one elsewhere.
  options.drop_parts = false;
  options.join_distance = 0;
  return options;
}

/// A face that occurs twice would keep its edges from being collapsed. Vertices keep their numbers.
void remove_repeated_faces(PolygonSoup& soup) {
  const std::vector<Index> lowest = lowest_at_same_position(soup.positions);
  for (Index& v : soup.corner_vertices) v = lowest[v];
  remove_degenerate_faces(soup);
  remove_duplicate_faces(soup);
}

}  // namespace

std::vector<Rung> make_ladder(Chunk chunk, double step, double least_share, double side,
                              const SimplifyOptions& options) {
  remove_repeated_faces(chunk.soup);
  CornerTable table = build_corner_table(
      chunk.soup, {options.keep_uv_seams, options.keep_normal_seams, options.lock_borders});
  for (Index p = 0; p < table.n_points(); ++p) {
    if (chunk.shared[table.source_vertex[p]] != 0) table.classes[p] = PointClass::fixed;
  }
  const double scale = table.scale / side, unit = std::pow(scale, 6);
  const std::size_t n_faces = table.n_alive_faces;
  const auto simplifier = make_simplifier(std::move(table), options_of_chunk(options, 1 / scale));
  std::vector<Rung> rungs;
  for (double share = step; share > least_share; share *= step) {
    const std::size_t faces_before = simplifier->table().n_alive_faces;
    const double cost_before = simplifier->counts().cost;
    Limits limits;
    limits.faces = std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(n_faces)));
    limits.error = std::numeric_limits<double>::infinity();
    const StopReason reason = simplifier->run(limits, nullptr);
    const std::size_t gone = faces_before - simplifier->table().n_alive_faces;
    if (gone > 0) {
      const double cost = unit * (simplifier->counts().cost - cost_before) / static_cast<double>(gone);
      rungs.push_back({to_soup(simplifier->table(), chunk.soup.positions),
                       std::max(cost, rungs.empty() ? 0 : rungs.back().cost)});
    }
    if (reason != StopReason::face_target) break;
  }
  rungs.insert(rungs.begin(), {std::move(chunk.soup), 0});
  return rungs;
}

}  // namespace recede::detail
