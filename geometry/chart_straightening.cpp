// Borders between two charts become shortest ways along edges (Ramsey's dissertation, section 6.2).
#include <recede/geometry/detail/chart_surface.h>

#include <algorithm>
#include <queue>

namespace recede::detail {
namespace {

/// A piece of border that two charts share, as sides of the lower chart, and what lies next to it on both
/// charts' borders.
struct SharedBorder {
  std::vector<Index> sides;
  Index chart, other;
  Index rest, other_rest;  // a side of each chart's border that isn't shared here
  double length = 0;
};

class Straightener {
 public:
  explicit Straightener(ChartSurface& surface)
      : surface_(surface),
        way_(surface.soup->positions.size()),
        corner_at_(surface.soup->positions.size(), k_no_index),
        n_corners_at_(surface.soup->positions.size(), 0),
        mark_(surface.soup->n_corners(), 0) {
    for (Index corner = 0; corner < surface.soup->n_corners(); ++corner) {
      corner_at_[surface.from(corner)] = corner;
      ++n_corners_at_[surface.from(corner)];
    }
  }

  /// True when the border became shorter.
  bool straighten(const SharedBorder& border) {
    if (border.sides.size() < 2) return false;
    ++round_;
    for (const Index side : border.sides) mark_[edge(side)] = border_mark();
    const std::vector<Index> path = shortest_path(border);
    if (path.empty()) return false;
    assign_faces(border, path);
    return true;
  }

 private:
  struct Way {
    double distance = 0;
    Index side = k_no_index;  // that leads here
    Index round = 0;          // in which the rest is valid
    bool allowed = false;
    bool done = false;
  };

  // Marks of edges, new in every round.
  Index border_mark() const { return 3 * round_; }
  Index end_mark() const { return 3 * round_ + 1; }
  Index path_mark() const { return 3 * round_ + 2; }

  Index edge(Index side) const { return std::min(side, surface_.opposite[side]); }

  /// The side lies inside the two charts, glued along the border at hand and along no other.
  bool is_inside(Index side) const {
    return surface_.opposite[side] != k_no_index &&
           (surface_.is_glued(side) || mark_[edge(side)] == border_mark() || mark_[edge(side)] == end_mark());
  }

  /// Sides from the vertex at which `side` starts, in the fan of the two charts' faces around it.
  void sides_around(Index side, std::vector<Index>& sides) const {
    sides.clear();
    sides.push_back(side);
    for (Index at = surface_.before(side); is_inside(at);) {  // counter-clockwise
      const Index next = surface_.opposite[at];
      if (next == side) return;  // all around
      sides.push_back(next);
      at = surface_.before(next);
    }
    for (Index at = side; is_inside(at);) {  // clockwise
      at = surface_.after(surface_.opposite[at]);
      if (!is_inside(at)) return;
      sides.push_back(at);
    }
  }

  /// Only the two charts' faces are around the vertex, in one fan without borders but the one at hand.
  bool is_free(Index vertex) const {
    const Index start = corner_at_[vertex];
    Index side = start, n = 0;
    do {
      const Index incoming = surface_.before(side);
      if (!is_inside(incoming)) return false;
      side = surface_.opposite[incoming];
      ++n;
    } while (side != start);
    return n == n_corners_at_[vertex];
  }

  /// Dijkstra from the border's start to its end through free vertices: the sides of a path that is shorter
  /// than the border, or none.
  std::vector<Index> shortest_path(const SharedBorder& border) {
    const Index start = surface_.from(border.sides.front()), end = surface_.to(border.sides.back());
    if (start == end) return {};
    std::vector<Index> around;
    // An end may be passed by other borders, so that only one fan of edges leads there.
    sides_around(surface_.opposite[border.sides.back()], around);
    for (const Index side : around) {
      if (is_inside(side)) mark_[edge(side)] = end_mark();
    }
    using Entry = std::pair<double, Index>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    sides_around(border.sides.front(), around);
    way_[start] = {0, k_no_index, round_, false, true};
    double distance = 0;
    for (;;) {
      for (const Index side : around) {
        if (!is_inside(side)) continue;
        const Index to = surface_.to(side);
        Way& way = way_[to];
        if (way.round != round_) way = {border.length, k_no_index, round_, to != end && is_free(to), false};
        const bool may_enter = to == end ? mark_[edge(side)] == end_mark() : way.allowed;
        const double reached = distance + surface_.length(side);
        if (!may_enter || way.done || !(reached < way.distance * (1 - k_shorter))) continue;
        way.distance = reached;
        way.side = side;
        queue.emplace(reached, to);
      }
      while (!queue.empty() && way_[queue.top().second].done) queue.pop();
      if (queue.empty()) return {};
      const Index at = queue.top().second;
      distance = queue.top().first;
      queue.pop();
      way_[at].done = true;
      if (at == end) return path_to(end, start);
      sides_around(surface_.after(way_[at].side), around);
    }
  }

  std::vector<Index> path_to(Index end, Index start) const {
    std::vector<Index> path;
    for (Index v = end; v != start; v = surface_.from(path.back())) path.push_back(way_[v].side);
    std::reverse(path.begin(), path.end());
    return path;
  }

  /// Faces that hang together with `side`'s, not over the path.
  void flood(Index side, std::vector<Index>& faces, Index chart) {
    faces.assign(1, surface_.face_of[side]);
    reached_.resize(surface_.n_faces(), 0);
    const Index stamp = 2 * round_ + chart;
    reached_[faces[0]] = stamp;
    const PolygonSoup& soup = *surface_.soup;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      for (Index s = soup.face_offsets[faces[i]]; s < soup.face_offsets[faces[i] + 1]; ++s) {
        if (!is_inside(s)) continue;  // the path's mark isn't inside where it replaces the border's
        if (mark_[edge(s)] == path_mark()) continue;
        const Index next = surface_.face_of[surface_.opposite[s]];
        if (reached_[next] == stamp) continue;
        reached_[next] = stamp;
        faces.push_back(next);
      }
    }
  }

  void assign_faces(const SharedBorder& border, const std::vector<Index>& path) {
    for (const Index side : path) mark_[edge(side)] = path_mark();
    std::vector<Index> faces, other_faces;
    flood(border.rest, faces, 0);
    flood(border.other_rest, other_faces, 1);
    for (const Index face : faces) surface_.chart_of[face] = border.chart;
    for (const Index face : other_faces) surface_.chart_of[face] = border.other;
  }

  // Paths must be shorter by more than this share: rounding doesn't decide among equals.
  static constexpr double k_shorter = 1e-9;

  ChartSurface& surface_;
  std::vector<Way> way_;
  std::vector<Index> corner_at_, n_corners_at_;  // of each vertex: some corner, and how many there are
  std::vector<Index> mark_;                      // of each edge
  std::vector<Index> reached_;                   // of each face
  Index round_ = 0;
};

Index chart_beyond(const ChartSurface& surface, Index side) {
  const Index other = surface.opposite[side];
  return other == k_no_index ? k_no_index : surface.chart_of[surface.face_of[other]];
}

/// `next`, which follows `side` on a chart's border, belongs to the same shared border.
bool is_shared_on(const ChartSurface& surface, Index side, Index next) {
  return chart_beyond(surface, side) == chart_beyond(surface, next) &&
         surface.next_on_border(surface.opposite[next]) == surface.opposite[side];
}

/// The shared border that starts with `side`.
SharedBorder follow(const ChartSurface& surface, Index side) {
  SharedBorder border;
  border.chart = surface.chart_of[surface.face_of[side]];
  border.other = chart_beyond(surface, side);
  for (Index next;; side = next) {
    border.sides.push_back(side);
    border.length += surface.length(side);
    next = surface.next_on_border(side);
    if (!is_shared_on(surface, side, next)) {
      border.rest = next;
      border.other_rest = surface.next_on_border(surface.opposite[border.sides.front()]);
      return border;
    }
  }
}

/// First sides of all borders between two charts, on the lower chart's side.
std::vector<Index> shared_border_starts(const ChartSurface& surface) {
  std::vector<Index> starts;
  for (Index side = 0; side < surface.soup->n_corners(); ++side) {
    const Index other = chart_beyond(surface, side);
    if (other == k_no_index || other <= surface.chart_of[surface.face_of[side]]) continue;
    // The side before on the border, found around the vertex.
    Index before = surface.before(side);
    while (surface.is_glued(before)) before = surface.before(surface.opposite[before]);
    if (!is_shared_on(surface, before, side)) starts.push_back(side);
  }
  return starts;
}

}  // namespace

std::size_t straighten_borders(ChartSurface& surface, Progress* progress) {
  std::size_t straightened = 0, done = 0;
  Straightener straightener(surface);
  const std::vector<Index> starts = shared_border_starts(surface);
  for (const Index start : starts) {
    if (done++ % 64 == 0) {
      report_progress(progress, "straightening borders",
                      static_cast<double>(done) / static_cast<double>(starts.size()));
    }
    if (straightener.straighten(follow(surface, start))) ++straightened;
  }
  return straightened;
}

}  // namespace recede::detail
