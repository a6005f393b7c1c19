// What a chart is while charts merge, and what a merge costs.
#include <recede/geometry/agglomerate.h>
#include <recede/geometry/detail/chart_surface.h>

#include <cmath>

namespace recede::detail {
namespace {

constexpr double k_infinity = std::numeric_limits<double>::infinity();
// Weight of the squared perimeter where a chart is cut in two: small, so that the cut runs along creases and
// not through the middle; not 0, or flat parts would be cut in any shape. Over nine models, scanned and
// mechanical, 0.001 gave a quarter fewer charts than 1.
constexpr double k_cut_compactness = 0.001;

/// Keeps every chart's border as a doubly linked loop of sides. Two disks become one disk exactly when the
/// sides that they share are one unbroken piece of both loops, and not both whole loops.
class ChartMerger {
 public:
  ChartMerger(const ChartSurface& surface, const ChartOptions& options, double bend_limit)
      : surface_(surface), options_(options), bend_limit_(bend_limit), charts_(surface.n_faces()) {
    const PolygonSoup& soup = *surface.soup;
    next_.resize(soup.n_corners());
    previous_.resize(soup.n_corners());
    lengths_.resize(soup.n_corners());
    border_.resize(surface.n_faces());
    for (std::size_t f = 0; f < surface.n_faces(); ++f) {
      Border& border = border_[f];
      border.side = soup.face_offsets[f];
      border.n_sides = static_cast<Index>(soup.face_size(f));
      border.area = vector_area(soup, f);
      border.face_area = border.area.norm();
      for (Index side = soup.face_offsets[f]; side < soup.face_offsets[f + 1]; ++side) {
        next_[side] = surface.after(side);
        previous_[side] = surface.before(side);
        lengths_[side] = surface.length(side);
        border.perimeter += lengths_[side];
      }
    }
  }

  double cost(Index a, Index b) {
    ChartRefusal refusal;
    return cost(a, b, refusal);
  }

  /// The same, with the reason where it is infinite.
  double cost(Index a, Index b, ChartRefusal& refusal) {
    const Border &first = border_[a], &second = border_[b];
    const double face_area = first.face_area + second.face_area;
    const double deviation = std::max(0.0, face_area - (first.area + second.area).norm());
    refusal = ChartRefusal::bend;
    if (deviation > bend_limit_ * face_area) return k_infinity;
    Seam seam;
    refusal = ChartRefusal::no_disk;
    if (!find_seam(a, b, seam)) return k_infinity;
    refusal = ChartRefusal::few_corners;
    if (!has_corners(seam)) return k_infinity;
    refusal = ChartRefusal::limit;
    const double perimeter = std::max(0.0, first.perimeter + second.perimeter - 2 * seam.length);
    return deviation + options_.compactness * perimeter * perimeter;
  }

  void merge(Index a, Index b) {
    Seam seam;
    find_seam(a, b, seam);
    Border &kept = border_[a], &absorbed = border_[b];
    const Index p = previous_[seam.first], n = next_[seam.last];
    const Index q = previous_[seam.other_last], r = next_[seam.other_first];
    // Where a loop consists of the seam alone, the other closes over it.
    const bool first_is_all = n == seam.first, second_is_all = r == seam.other_last;
    kept.side = first_is_all ? r : n;
    if (first_is_all) {
      link(q, r);
    } else if (second_is_all) {
      link(p, n);
    } else {
      link(p, r);
      link(q, n);
    }
    kept.n_sides += absorbed.n_sides - 2 * seam.n_sides;
    kept.perimeter = std::max(0.0, kept.perimeter + absorbed.perimeter - 2 * seam.length);
    kept.area += absorbed.area;
    kept.face_area += absorbed.face_area;
    charts_.merge(a, b);
  }

  /// The chart of a face.
  Index chart(Index face) { return charts_.find(face); }

 private:
  struct Border {
    Index side = k_no_index;  // any one
    Index n_sides = 0;
    double perimeter = 0;
    double face_area = 0;      // sum of the faces' areas
    Vec3 area = Vec3::Zero();  // sum of their vector areas
  };

  /// The sides that two charts share: first to last along the one, other_last to other_first along the other.
  struct Seam {
    Index first = k_no_index, last = k_no_index;
    Index other_first = k_no_index, other_last = k_no_index;
    Index n_sides = 0;
    double length = 0;
  };

  void link(Index side, Index next) {
    next_[side] = next;
    previous_[next] = side;
  }

  /// The chart beyond a side of a border; `k_no_index` where there is none.
  Index beyond(Index side) {
    const Index other = surface_.opposite[side];
    return other == k_no_index ? k_no_index : charts_.find(surface_.face_of[other]);
  }

  /// `side` and `next`, one after the other along a border, have the same chart beyond, and are one after the
  /// other on its border as well.
  bool runs_on(Index side, Index next) {
    const Index chart_beyond = beyond(side);
    return chart_beyond != k_no_index && chart_beyond == beyond(next) &&
           next_[surface_.opposite[next]] == surface_.opposite[side];
  }

  /// False when the shared sides are no single piece.
  bool find_seam(Index a, Index b, Seam& seam) {
    const bool swapped = border_[a].n_sides > border_[b].n_sides;
    const Index walked = swapped ? b : a, other = swapped ? a : b;
    const Index start = border_[walked].side;
    Index side = start;
    do {
      if (beyond(side) == other) {
        ++seam.n_sides;
        seam.length += lengths_[side];
        if (!runs_on(previous_[side], side)) {
          if (seam.first != k_no_index) return false;
          seam.first = side;
        }
        if (!runs_on(side, next_[side])) seam.last = side;
      }
      side = next_[side];
    } while (side != start);
    if (seam.first == k_no_index) return false;  // none, or all of both
    seam.other_first = surface_.opposite[seam.first];
    seam.other_last = surface_.opposite[seam.last];
    if (swapped) seam = {seam.other_last, seam.other_first, seam.last, seam.first, seam.n_sides, seam.length};
    return true;
  }

  /// The side after `side` on the border of the merged chart.
  Index next_after_merge(Index side, const Seam& seam) const {
    Index next = next_[side];
    // Twice, for a loop that is all seam.
    for (int i = 0; i < 2; ++i) {
      if (next == seam.first) next = next_[seam.other_first];
      if (next == seam.other_last) next = next_[seam.last];
    }
    return next;
  }

  /// Whether the merged chart's border has three sides, and corners enough: vertices where the chart beyond
  /// changes. On borders and closed edges every vertex counts, since nothing beyond has to match.
  bool has_corners(const Seam& seam) {
    Index start = next_[seam.last];
    if (start == seam.first) start = next_[seam.other_first];
    std::size_t n_sides = 0, n_corners = 0;
    Index side = start;
    do {
      const Index next = next_after_merge(side, seam);
      ++n_sides;
      if (!runs_on(side, next)) ++n_corners;
      if (n_sides >= 3 && n_corners >= options_.least_corners) return true;
      side = next;
    } while (side != start);
    return false;
  }

  const ChartSurface& surface_;
  const ChartOptions& options_;
  double bend_limit_;
  DisjointSets charts_;
  std::vector<Index> next_, previous_;  // along the borders of charts; void inside
  std::vector<double> lengths_;
  std::vector<Border> border_;
};

std::vector<std::pair<Index, Index>> neighbouring_faces(const ChartSurface& surface) {
  std::vector<std::pair<Index, Index>> neighbours;
  for (Index side = 0; side < surface.opposite.size(); ++side) {
    const Index other = surface.opposite[side];
    if (other != k_no_index && side < other)
      neighbours.emplace_back(surface.face_of[side], surface.face_of[other]);
  }
  return neighbours;
}

void count_refused(ChartMerger& merger, std::vector<std::pair<Index, Index>> pairs, ChartReport& report) {
  for (auto& [a, b] : pairs) std::tie(a, b) = std::minmax({merger.chart(a), merger.chart(b)});
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  for (const auto& [a, b] : pairs) {
    if (a == b) continue;
    ChartRefusal refusal;
    merger.cost(a, b, refusal);
    ++report.refused[static_cast<std::size_t>(refusal)];
  }
}

}  // namespace

std::size_t merge_charts(ChartSurface& surface, const ChartOptions& options, ChartReport& report,
                         Progress* progress) {
  const bool other_limit = options.charts || options.cost_limit;
  ChartMerger merger(surface, options,
                     options.bend_limit.value_or(other_limit ? 1.0 : ChartOptions::k_bend_limit));
  const auto neighbours = neighbouring_faces(surface);
  AgglomerationOptions limits;
  limits.clusters = options.charts.value_or(1);
  limits.cost_limit = options.cost_limit.value_or(k_infinity);
  const Agglomeration tree = agglomerate(surface.n_faces(), neighbours, merger, limits, progress);
  count_refused(merger, neighbours, report);
  report.merges += tree.merges.size();
  for (const ClusterMerge& merge : tree.merges) {
    report.largest_cost = std::max(report.largest_cost, merge.cost);
  }
  surface.chart_of = clusters_after(tree, tree.merges.size());
  return tree.n_clusters();
}

std::size_t split_chart(ChartSurface& surface, std::span<const Index> faces, std::size_t n_charts) {
  PolygonSoup soup;
  ChartSurface part(surface, soup, faces);
  ChartOptions options;
  options.charts = 2;
  options.compactness = k_cut_compactness;
  options.least_corners = 0;
  ChartReport report;
  const std::size_t n_parts = merge_charts(part, options, report, nullptr);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (part.chart_of[f] > 0) {
      surface.chart_of[faces[f]] = static_cast<Index>(n_charts + part.chart_of[f] - 1);
    }
  }
  return n_charts + n_parts - 1;
}

}  // namespace recede::detail
