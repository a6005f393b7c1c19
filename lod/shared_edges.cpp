#include <recede/geometry/closest_point.h>
#include <recede/geometry/disjoint_sets.h>
#include <recede/lod/detail/edge_sampling.h>
#include <recede/lod/detail/point_grid.h>
#include <recede/lod/detail/shared_edges.h>

#include <algorithm>
#include <map>
#include <optional>

namespace recede::detail {

namespace {

constexpr int k_grid_cells = 64;

constexpr double k_listed_gaps = 0.01;  // of the model's size: farther away nothing is missing

class EdgeFinder {
 public:
  EdgeFinder(std::span<const TrimmedPatch> patches, std::span<const PatchSurface> surfaces,
             const SeamGraphOptions& options, SeamReport& report)
      : patches_(patches), surfaces_(surfaces), options_(options), report_(report) {}

  SharedEdges run() {
    take_pieces();
    take_nodes();
    unite_nodes();
    cut_pieces();
    number_edges_of_file();
    group_pieces();
    for (Piece& piece : pieces_) {
      for (Index& corner : piece.corners) corner = sets_.find(corner);
      result_.pieces.push_back(piece);
    }
    count_edges();
    return std::move(result_);
  }

 private:
  struct Piece : CurvePiece {
    bool is_free = true;  ///< its edge isn't known yet
    Polyline line{};      ///< of free pieces that aren't points
  };

  const NurbsCurve2& curve_of(const Piece& piece) const {
    return patches_[piece.patch].loops[piece.loop].curves[piece.curve].curve;
  }
  Vec3 point_at(const Piece& piece, double t) const {
    return surfaces_[piece.patch].shape.evaluate(evaluate(curve_of(piece), t));
  }
  Vec3 point_at_share(const Piece& piece, double share) const {
    return point_at(piece, piece.range.begin + share * piece.range.length());
  }

  // What poly-lines may be off.
  double near_enough() const { return options_.tolerance / 2; }

  void take_pieces() {
    std::vector<Index> uses;
    for (std::size_t patch = 0; patch < patches_.size(); ++patch) {
      for (std::size_t loop = 0; loop < patches_[patch].loops.size(); ++loop) {
        const std::vector<TrimmingCurve>& curves = patches_[patch].loops[loop].curves;
        for (std::size_t i = 0; i < curves.size(); ++i) {
          Piece piece;
          piece.patch = static_cast<Index>(patch);
          piece.loop = static_cast<Index>(loop);
          piece.curve = static_cast<Index>(i);
          piece.range = curves[i].curve.domain();
          if (options_.use_connectivity) {
            piece.edge = curves[i].edge;
            piece.runs_against = curves[i].runs_against;
            piece.corners = curves[i].corners;
          }
          if (piece.edge != k_no_index) {
            uses.resize(std::max<std::size_t>(uses.size(), piece.edge + 1), 0);
            ++uses[piece.edge];
          }
          pieces_.push_back(std::move(piece));
        }
      }
    }
    for (Piece& piece : pieces_) {
      piece.is_free = piece.edge == k_no_index || uses[piece.edge] < 2;
      if (!piece.is_free) continue;
      piece.edge = k_no_index;
      piece.runs_against = false;
      piece.is_point = is_point(piece);
      if (!piece.is_point) piece.line = polyline_of(use_of(piece), near_enough());
    }
  }

  bool is_point(const Piece& piece) const {
    const Vec3 start = point_at_share(piece, 0);
    for (int i = 1; i <= 8; ++i) {
      if ((point_at_share(piece, i / 8.0) - start).norm() > near_enough()) return false;
    }
    return true;
  }

  SeamCurve use_of(const Piece& piece) const {
    return {&surfaces_[piece.patch], &curve_of(piece), piece.range, false};
  }

  // The corners of the file, and one where two curves of a loop meet that it knows nothing about.
  void take_nodes() {
    Index n_nodes = 0;
    for (const Piece& piece : pieces_) {
      for (const Index corner : piece.corners) {
        if (corner != k_no_index) n_nodes = std::max(n_nodes, corner + 1);
      }
    }
    for (std::size_t first = 0; first < pieces_.size();) {
      std::size_t end = first;
      while (end < pieces_.size() && pieces_[end].patch == pieces_[first].patch &&
             pieces_[end].loop == pieces_[first].loop)
        ++end;
      for (std::size_t i = first; i < end; ++i) {
        Index& start = pieces_[i].corners[0];
        Index& end_before = pieces_[i > first ? i - 1 : end - 1].corners[1];
        if (start == k_no_index) start = end_before;
        if (start == k_no_index) start = n_nodes++;
        if (end_before == k_no_index) end_before = start;
      }
      first = end;
    }
    node_points_.assign(n_nodes, Vec3::Zero());
    is_free_node_.assign(n_nodes, false);
    sets_ = DisjointSets(n_nodes);
    for (const Piece& piece : pieces_) {
      node_points_[piece.corners[0]] = point_at_share(piece, 0);
      if (!piece.is_free) continue;
      for (const Index corner : piece.corners) is_free_node_[corner] = true;
      if (piece.is_point) sets_.unite(piece.corners[0], piece.corners[1]);
    }
  }

  void unite_nodes() {
    grid_.emplace(node_points_, k_grid_cells);
    for (Index node = 0; node < node_points_.size(); ++node) {
      if (!is_free_node_[node]) continue;
      const Vec3& point = node_points_[node];
      grid_->each_near(point, point, options_.gap, [&](Index other) {
        if ((node_points_[other] - point).norm() <= options_.gap) sets_.unite(node, other);
      });
    }
  }

  struct Cut {
    double parameter;
    Index node;
  };

  // Where corners of others lie within a free piece, so that pieces that meet have both ends in common.
  void cut_pieces() {
    std::vector<Piece> cut;
    for (Piece& piece : pieces_) {
      const std::vector<Cut> cuts = piece.is_free && !piece.is_point ? cuts_of(piece) : std::vector<Cut>();
      for (const Cut& at : cuts) {
        Piece before = piece;
        before.range.end = piece.range.begin = at.parameter;
        before.corners[1] = piece.corners[0] = at.node;
        before.line = polyline_of(use_of(before), near_enough());
        cut.push_back(std::move(before));
      }
      if (!cuts.empty()) piece.line = polyline_of(use_of(piece), near_enough());
      cut.push_back(std::move(piece));
    }
    pieces_ = std::move(cut);
  }

  std::vector<Cut> cuts_of(const Piece& piece) {
    std::vector<Cut> cuts;
    const Polyline& line = piece.line;
    const double reach = options_.gap + near_enough();
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
      const Vec3 &a = line.points[i], &b = line.points[i + 1];
      grid_->each_near(a, b, reach, [&](Index node) {
        const Vec3& point = node_points_[node];
        for (const Vec3& end : {line.points.front(), line.points.back()}) {
          if ((point - end).norm() <= options_.gap) return;
        }
        if (sets_.find(node) == sets_.find(piece.corners[0]) ||
            sets_.find(node) == sets_.find(piece.corners[1]))
          return;
        const Foot foot = foot_on({{line.parameters[i], line.parameters[i + 1]}, {a, b}}, point);
        if (foot.distance > reach) return;
        const double t = nearest_parameter(use_of(piece), foot.parameter, point);
        if ((point_at(piece, t) - point).norm() <= options_.gap) cuts.push_back({t, sets_.find(node)});
      });
    }
    std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.parameter < b.parameter; });
    std::vector<Cut> distinct;
    Vec3 last = line.points.front();
    for (const Cut& cut : cuts) {
      const Vec3 here = point_at(piece, cut.parameter);
      if ((here - last).norm() <= options_.gap || (here - line.points.back()).norm() <= options_.gap)
        continue;
      distinct.push_back(cut);
      last = here;
    }
    return distinct;
  }

  void number_edges_of_file() {
    std::map<Index, Index> numbers;
    for (Piece& piece : pieces_) {
      if (piece.is_free) continue;
      piece.edge = numbers.try_emplace(piece.edge, static_cast<Index>(numbers.size())).first->second;
    }
    result_.is_parallel.assign(numbers.size(), true);
  }

  // Free pieces that have both corners in common and lie at the same place are an edge.
  void group_pieces() {
    std::map<std::pair<Index, Index>, std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& piece = pieces_[i];
      if (!piece.is_free) continue;
      const Index a = sets_.find(piece.corners[0]), b = sets_.find(piece.corners[1]);
      groups[{std::min(a, b), std::max(a, b)}].push_back(i);
    }
    for (const auto& [corners, members] : groups) {
      for (std::size_t i = 0; i < members.size(); ++i) {
        Piece& piece = pieces_[members[i]];
        if (piece.edge != k_no_index) continue;
        piece.edge = static_cast<Index>(result_.is_parallel.size());
        result_.is_parallel.push_back(false);
        if (piece.is_point) continue;
        for (std::size_t k = i + 1; k < members.size(); ++k) {
          Piece& other = pieces_[members[k]];
          if (other.edge != k_no_index || other.is_point || !coincide(piece, other)) continue;
          other.edge = piece.edge;
          other.runs_against = runs_against(piece, other);
        }
      }
    }
  }

  bool coincide(const Piece& a, const Piece& b) const {
    const double limit = options_.gap + near_enough();
    for (int i = 1; i < 8; ++i) {
      if (foot_on(b.line, point_at_share(a, i / 8.0)).distance > limit) return false;
      if (foot_on(a.line, point_at_share(b, i / 8.0)).distance > limit) return false;
    }
    return true;
  }

  static double share_of(const Piece& piece, double parameter) {
    return (parameter - piece.range.begin) / piece.range.length();
  }

  bool runs_against(const Piece& leader, const Piece& other) const {
    const double early = foot_on(leader.line, point_at_share(other, 0.25)).parameter;
    const double late = foot_on(leader.line, point_at_share(other, 0.75)).parameter;
    return share_of(leader, early) > share_of(leader, late);
  }

  void count_edges() {
    std::vector<std::size_t> uses(result_.is_parallel.size(), 0);
    for (const Piece& piece : pieces_) uses[piece.edge] += piece.is_point ? 0 : 1;
    for (std::size_t edge = 0; edge < uses.size(); ++edge) {
      if (uses[edge] == 1) ++report_.free_edges;
      if (uses[edge] >= 2) ++(result_.is_parallel[edge] ? report_.edges_of_file : report_.edges_by_position);
      if (uses[edge] >= 3) ++report_.crowded_edges;
    }
    list_gaps(uses);
  }

  // Borders that have another border near them, though not near enough.
  void list_gaps(const std::vector<std::size_t>& uses) {
    std::vector<Vec3> points;
    std::vector<Index> corners, labels;
    Box3 box;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& piece = pieces_[i];
      if (piece.is_point || uses[piece.edge] != 1) continue;
      for (std::size_t k = 0; k < piece.line.points.size(); ++k) {
        if (k > 0) {
          const auto here = static_cast<Index>(points.size());
          corners.insert(corners.end(), {here - 1, here, here});
          labels.push_back(static_cast<Index>(i));
        }
        points.push_back(piece.line.points[k]);
        box.extend(points.back());
      }
    }
    if (labels.empty()) return;
    ClosestPointTree tree(points, corners);
    tree.set_labels(labels);
    const double limit = k_listed_gaps * box.diagonal().norm();
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& piece = pieces_[i];
      if (piece.is_point || uses[piece.edge] != 1) continue;
      SeamGap gap;
      gap.patch = piece.patch;
      bool is_near = true;
      for (int k = 1; k < 8 && is_near; ++k) {
        const Vec3 point = point_at_share(piece, k / 8.0);
        const ClosestPointTree::Hit hit = tree.closest_of_others(point, static_cast<Index>(i), limit * limit);
        is_near = hit.triangle != k_no_index;
        if (!is_near || hit.squared_distance < gap.distance * gap.distance) continue;
        gap.distance = std::sqrt(hit.squared_distance);
        gap.point = point;
        gap.other = pieces_[labels[hit.triangle]].patch;
      }
      if (is_near) report_.gaps.push_back(gap);
    }
  }

  std::span<const TrimmedPatch> patches_;
  std::span<const PatchSurface> surfaces_;
  const SeamGraphOptions& options_;
  SeamReport& report_;
  std::vector<Piece> pieces_;
  std::vector<Vec3> node_points_;
  std::vector<bool> is_free_node_;
  DisjointSets sets_{0};
  std::optional<PointGrid> grid_;
  SharedEdges result_;
};

}  // namespace

SharedEdges find_shared_edges(std::span<const TrimmedPatch> patches, std::span<const PatchSurface> surfaces,
                              const SeamGraphOptions& options, SeamReport& report) {
  return EdgeFinder(patches, surfaces, options, report).run();
}

}  // namespace recede::detail
