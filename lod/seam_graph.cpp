#include <recede/geometry/detail/interval.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/loop_triangulation.h>
#include <recede/lod/detail/shared_edges.h>
#include <recede/lod/seam_graph.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <unordered_map>

namespace recede {

namespace {

using detail::CurvePiece;
using detail::SampledUse;
using detail::SeamCurve;
using detail::SharedEdges;

constexpr double k_default_tolerance = 1e-4;  // of the diagonal of the model's box
constexpr int k_pieces_of_points = 4;         // of a side of a patch that is one point in space

Box3 box_of(std::span<const PatchSurface> surfaces) {
  Box3 box;
  for (const PatchSurface& surface : surfaces) box.extend(surface.bounds.box(surface.shape.domain()));
  return box;
}

SeamGraphOptions completed(SeamGraphOptions options, std::span<const PatchSurface> surfaces) {
  if (!(options.tolerance >= 0 && options.gap >= 0)) throw OptionError("tolerances of seams are at least 0");
  if (options.tolerance == 0) options.tolerance = k_default_tolerance * box_of(surfaces).diagonal().norm();
  if (options.gap == 0) options.gap = options.tolerance / 2;
  return options;
}

// Pieces as parts of edges and of loops.
class GraphBuilder {
 public:
  GraphBuilder(std::span<const TrimmedPatch> patches, std::span<const PatchSurface> surfaces,
               const SeamGraphOptions& options)
      : patches_(patches), surfaces_(surfaces), options_(options) {}

  SeamGraph run(Progress* progress) {
    report_progress(progress, "match", 0);
    edges_ = detail::find_shared_edges(patches_, surfaces_, options_, graph_.report);
    report_progress(progress, "seams", 0.3);
    sample();
    report_progress(progress, "seams", 0.8);
    connect();
    refine_moved();
    graph_.tolerance = options_.tolerance;
    report_progress(progress, "seams", 1);
    return std::move(graph_);
  }

 private:
  struct Run {  // the points of a piece
    SampledUse points;
    bool runs_against = false;
  };

  void sample() {
    uses_.resize(edges_.is_parallel.size());
    for (std::size_t i = 0; i < edges_.pieces.size(); ++i) uses_[edges_.pieces[i].edge].push_back(i);
    least_pieces_ = least_pieces_of_all();
    runs_.resize(edges_.pieces.size());
    tbb::parallel_for(std::size_t{0}, uses_.size(),
                      [&](std::size_t edge) { sample(edge, options_.tolerance); });
    uncross();
  }

  void sample(std::size_t edge, double tolerance) {
    std::vector<SeamCurve> of_edge;
    int least = 1;
    for (const std::size_t i : uses_[edge]) {
      const CurvePiece& piece = edges_.pieces[i];
      of_edge.push_back({&surfaces_[piece.patch],
                         &patches_[piece.patch].loops[piece.loop].curves[piece.curve].curve, piece.range,
                         piece.runs_against});
      least = std::max(least, least_pieces_[i]);
    }
    std::vector<SampledUse> sampled;
    if (edges_.pieces[uses_[edge].front()].is_point) {
      sampled = sample_edge(of_edge, std::numeric_limits<double>::infinity(), k_pieces_of_points);
    } else if (edges_.is_parallel[edge] || of_edge.size() == 1) {
      sampled = sample_edge(of_edge, tolerance, least);
    } else {
      sampled = sample_matched_edge(of_edge, tolerance, options_.gap, least);
    }
    for (std::size_t k = 0; k < of_edge.size(); ++k)
      runs_[uses_[edge][k]] = {std::move(sampled[k]), of_edge[k].runs_against};
  }

  // Numbers the points of all poly-lines and sews.
  void connect() {
    const SeamReport found = graph_.report;
    graph_ = {};
    graph_.report = found;
    graph_.report.largest_move = 0;
    corners_.clear();
    number_vertices();
    fill_loops();
    place_vertices();
  }

  // Where sewing moves ends of chords, less is left for the chords.
  void refine_moved() {
    constexpr int k_most_rounds = 3;
    double tolerance = options_.tolerance;
    for (int round = 0; round < k_most_rounds; ++round) {
      const std::vector<std::size_t> coarse = edges_beyond_tolerance();
      if (coarse.empty()) return;
      tolerance /= 2;
      tbb::parallel_for(std::size_t{0}, coarse.size(), [&](std::size_t i) { sample(coarse[i], tolerance); });
      connect();
    }
  }

  std::vector<std::size_t> edges_beyond_tolerance() const {
    std::vector<std::size_t> edges;
    std::size_t slot = 0;
    each_loop([&](std::size_t first, std::size_t end) {
      const std::size_t first_slot = slot;
      for (std::size_t i = first; i < end; ++i) {
        for (std::size_t k = 1; k < runs_[i].points.uvs.size(); ++k, ++slot) {
          const bool is_last = i + 1 == end && k + 1 == runs_[i].points.uvs.size();
          if (is_beyond_tolerance(edges_.pieces[i], slot, is_last ? first_slot : slot + 1))
            edges.push_back(edges_.pieces[i].edge);
        }
      }
    });
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
  }

  bool is_beyond_tolerance(const CurvePiece& piece, std::size_t slot, std::size_t next) const {
    const double move = std::max(moves_[slot], moves_[next]);
    if (edges_.is_parallel[piece.edge] && move <= detail::k_for_sewing * options_.tolerance) return false;
    const double rest = options_.tolerance - move;  // none: a gap of the file, for which no chord is better
    return rest > 0 &&
           static_cast<double>(graph_.widths[slot]) +
                   surfaces_[piece.patch].bounds.deviation(graph_.slots[slot].uv, graph_.slots[next].uv) >
               rest;
  }

  // Coarse poly-lines of curves that run near to one another can cross: those patches get finer ones, for as
  // long as that helps.
  void uncross() {
    constexpr int k_most_rounds = 4;
    double tolerance = options_.tolerance;
    std::vector<std::size_t> crossed = crossed_patches();
    for (int round = 0; round < k_most_rounds && !crossed.empty(); ++round) {
      tolerance /= 4;
      for (const std::size_t first : crossed) {
        each_piece_of_patch(first, [&](std::size_t i) { sample(edges_.pieces[i].edge, tolerance); });
      }
      crossed = crossed_patches();
    }
    for (const std::size_t first : crossed) {
      each_piece_of_patch(first, [&](std::size_t i) { sample(edges_.pieces[i].edge, options_.tolerance); });
    }
  }

  // Their first pieces.
  std::vector<std::size_t> crossed_patches() const {
    std::vector<std::size_t> firsts, crossed;
    for (std::size_t i = 0; i < edges_.pieces.size(); ++i) {
      if (i == 0 || edges_.pieces[i].patch != edges_.pieces[i - 1].patch) firsts.push_back(i);
    }
    std::vector<unsigned char> crosses(firsts.size());
    tbb::parallel_for(std::size_t{0}, firsts.size(),
                      [&](std::size_t k) { crosses[k] = has_crossed_loops(firsts[k]) ? 1 : 0; });
    for (std::size_t k = 0; k < firsts.size(); ++k) {
      if (crosses[k]) crossed.push_back(firsts[k]);
    }
    return crossed;
  }

  bool has_crossed_loops(std::size_t first) const {
    std::vector<Vec2> points;
    std::vector<std::array<Index, 2>> sides;
    std::size_t start = 0;
    Index loop = 0;
    const auto close = [&] {
      if (!sides.empty()) sides.back()[1] = static_cast<Index>(start);
      start = points.size();
    };
    each_piece_of_patch(first, [&](std::size_t i) {
      if (edges_.pieces[i].loop != loop) close();
      loop = edges_.pieces[i].loop;
      each_point(i, [&](std::size_t at) {
        const auto here = static_cast<Index>(points.size());
        points.push_back(runs_[i].points.uvs[at]);
        sides.push_back({here, here + 1});
      });
    });
    close();
    try {
      detail::triangulate_loops(points, sides);
    } catch (const InputError&) {
      return true;
    }
    return false;
  }

  template <typename Visit>
  void each_piece_of_patch(std::size_t first, Visit&& visit) const {
    const std::vector<CurvePiece>& pieces = edges_.pieces;
    for (std::size_t i = first; i < pieces.size() && pieces[i].patch == pieces[first].patch; ++i) visit(i);
  }

  // All points of a piece but its last, in its own direction.
  template <typename Visit>
  void each_point(std::size_t i, Visit&& visit) const {
    const std::size_t last = runs_[i].points.uvs.size() - 1;
    for (std::size_t k = 0; k < last; ++k) visit(runs_[i].runs_against ? last - k : k);
  }

  // So many that a loop isn't without area.
  std::vector<int> least_pieces_of_all() const {
    std::vector<int> least(edges_.pieces.size(), 1);
    each_loop([&](std::size_t first, std::size_t end) {
      const std::size_t n = end - first;
      for (std::size_t i = first; i < end; ++i) least[i] = n == 1 ? 4 : n == 2 ? 2 : 1;
    });
    return least;
  }

  // Calls `visit(first, end)` with the pieces of each loop.
  template <typename Visit>
  void each_loop(Visit&& visit) const {
    const std::vector<CurvePiece>& pieces = edges_.pieces;
    for (std::size_t first = 0; first < pieces.size();) {
      std::size_t end = first;
      while (end < pieces.size() && pieces[end].patch == pieces[first].patch &&
             pieces[end].loop == pieces[first].loop)
        ++end;
      visit(first, end);
      first = end;
    }
  }

  // Corners first, as they come; then the points within edges.
  void number_vertices() {
    n_vertices_ = 0;
    first_within_.assign(edges_.is_parallel.size(), k_no_index);
    for (std::size_t i = 0; i < edges_.pieces.size(); ++i) {
      const CurvePiece& piece = edges_.pieces[i];
      for (const Index corner : piece.corners) {
        if (corners_.try_emplace(corner, n_vertices_).second) ++n_vertices_;
      }
      if (piece.is_point || first_within_[piece.edge] != k_no_index) continue;
      first_within_[piece.edge] = n_vertices_;
      n_vertices_ += static_cast<Index>(runs_[i].points.uvs.size() - 2);
    }
  }

  // Of the point with a number along its edge.
  Index vertex_of(std::size_t i, std::size_t along_edge) const {
    const CurvePiece& piece = edges_.pieces[i];
    const std::size_t last = runs_[i].points.uvs.size() - 1;
    if (along_edge == 0) return corners_.at(piece.corners[piece.runs_against ? 1 : 0]);
    if (along_edge == last || piece.is_point) return corners_.at(piece.corners[piece.runs_against ? 0 : 1]);
    return first_within_[piece.edge] + static_cast<Index>(along_edge) - 1;
  }

  void fill_loops() {
    std::size_t n_loops = 0;
    each_loop([&](std::size_t first, std::size_t end) {
      const CurvePiece& piece = edges_.pieces[first];
      while (graph_.patch_loops.size() <= piece.patch)
        graph_.patch_loops.push_back(static_cast<Index>(n_loops));
      for (std::size_t i = first; i < end; ++i) add_run(i);
      graph_.loop_offsets.push_back(static_cast<Index>(graph_.slots.size()));
      ++n_loops;
    });
    while (graph_.patch_loops.size() <= patches_.size())
      graph_.patch_loops.push_back(static_cast<Index>(n_loops));
  }

  void add_run(std::size_t i) {
    const Run& run = runs_[i];
    each_point(i, [&](std::size_t at) {
      graph_.slots.push_back({run.points.uvs[at], vertex_of(i, at)});
      const double width = run.points.widths[run.runs_against ? at - 1 : at];
      graph_.widths.push_back(width > 0 ? detail::rounded_up(width) : 0);
    });
  }

  void place_vertices() {
    graph_.positions.assign(n_vertices_, Vec3::Zero());
    std::vector<Index> counts(n_vertices_, 0);
    std::vector<Vec3> own(graph_.slots.size());
    moves_.resize(graph_.slots.size());
    each_slot([&](std::size_t patch, std::size_t slot) {
      const auto& [uv, vertex] = graph_.slots[slot];
      own[slot] = surfaces_[patch].shape.evaluate(uv);
      graph_.positions[vertex] += own[slot];
      ++counts[vertex];
    });
    for (std::size_t i = 0; i < counts.size(); ++i) graph_.positions[i] /= counts[i];
    each_slot([&](std::size_t, std::size_t slot) {
      moves_[slot] = (own[slot] - graph_.positions[graph_.slots[slot].vertex]).norm();
      graph_.report.largest_move = std::max(graph_.report.largest_move, moves_[slot]);
    });
  }

  template <typename Visit>
  void each_slot(Visit&& visit) const {
    for (std::size_t patch = 0; patch < patches_.size(); ++patch) {
      const std::size_t first = graph_.loop_offsets[graph_.patch_loops[patch]];
      const std::size_t end = graph_.loop_offsets[graph_.patch_loops[patch + 1]];
      for (std::size_t slot = first; slot < end; ++slot) visit(patch, slot);
    }
  }

  std::span<const TrimmedPatch> patches_;
  std::span<const PatchSurface> surfaces_;
  SeamGraphOptions options_;
  SharedEdges edges_;
  std::vector<std::vector<std::size_t>> uses_;  // by edge: its pieces
  std::vector<int> least_pieces_;               // by piece
  std::vector<Run> runs_;                       // by piece
  std::unordered_map<Index, Index> corners_;
  std::vector<Index> first_within_;  // by edge: the vertex after its first corner
  Index n_vertices_ = 0;
  std::vector<double> moves_;  // by slot, by sewing
  SeamGraph graph_;
};

}  // namespace

std::vector<Index> SeamGraph::patches_of_loops() const {
  std::vector<Index> patches;
  for (std::size_t patch = 0; patch < n_patches(); ++patch)
    patches.resize(patch_loops[patch + 1], static_cast<Index>(patch));
  return patches;
}

std::vector<SeamLoop> SeamGraph::loops_of(std::size_t patch) const {
  std::vector<SeamLoop> loops;
  for (std::size_t l = patch_loops[patch]; l < patch_loops[patch + 1]; ++l) {
    loops.push_back({{loop(l).begin(), loop(l).end()},
                     {widths.begin() + loop_offsets[l], widths.begin() + loop_offsets[l + 1]}});
  }
  return loops;
}

SeamGraph build_seam_graph(std::span<const TrimmedPatch> patches, std::span<const PatchSurface> surfaces,
                           const SeamGraphOptions& options, Progress* progress) {
  for (const TrimmedPatch& patch : patches) {
    for (const TrimmingLoop& loop : patch.loops) {
      for (const TrimmingCurve& curve : loop.curves)
        validate(curve.curve, "patch " + patch.name + ": trimming curve");
    }
  }
  return GraphBuilder(patches, surfaces, completed(options, surfaces)).run(progress);
}

}  // namespace recede
