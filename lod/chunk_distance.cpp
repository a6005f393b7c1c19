#include <recede/geometry/detail/one_sided_distance.h>
#include <recede/geometry/error.h>
#include <recede/lod/detail/chunk_distance.h>
#include <recede/lod/detail/soup_pieces.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace recede::detail {
namespace {

/// What is known so far of one direction, in the frame's units.
struct SideSum {
  double max = 0, bound = 0;
  double squares = 0, area = 0;  ///< of squared distances times area

  void add(const Surface& from, const SampledSide& side, const std::vector<Interval>& intervals) {
    max = std::max(max, side.distance.max);
    squares += from.area * side.distance.rms * side.distance.rms;
    area += from.area;
    for (const Interval& interval : intervals) bound = std::max(bound, interval.upper);
  }
};

class ChunkMeter {
 public:
  ChunkMeter(const ChunkFiles& input, const std::vector<PolygonSoup>& levels, const DistanceOptions& options)
      : input_(input), options_(options), frame_(whole_box(input)) {
    double diagonal = 0;
    for (const PolygonSoup& level : levels) {
      Level& added = levels_.emplace_back(triangulated(level));
      Box3 both = whole_box(input);
      both.extend(bounding_box(added.soup));
      diagonal = std::max(diagonal, both.diagonal().norm());
      added.surface.emplace(frame_.inside(added.soup));
      find_cells(added);
    }
    floor_ = frame_.inside(options.relative_floor * diagonal);
    for (std::size_t i = 0; i < input.n_chunks(); ++i) input_area_ += input.area(i);
  }

  std::vector<LevelError> measure(const std::vector<Vec3>& points, Progress* progress) {
    for (Level& level : levels_) level.known = largest_distance(points, level);
    const auto n = static_cast<double>(input_.n_chunks());
    for (std::size_t i = 0; i < input_.n_chunks(); ++i) {
      report_progress(progress, "measure", 0.5 * static_cast<double>(i) / n);
      measure_chunk(i);
    }
    for (std::size_t i = 0; i < input_.n_chunks(); ++i) {
      report_progress(progress, "measure", 0.5 + 0.5 * static_cast<double>(i) / n);
      measure_cell(i);
    }
    std::vector<LevelError> errors;
    for (const Level& level : levels_) {
      const SideSum &there = level.forward, &back = level.backward;
      const double max = std::max(there.max, back.max), bound = std::max({max, there.bound, back.bound});
      const double area = there.area + back.area;
      const double rms = area > 0 ? std::sqrt((there.squares + back.squares) / area) : 0;
      errors.push_back({frame_.outside(max), frame_.outside(rms), frame_.outside(bound)});
    }
    return errors;
  }

 private:
  struct Level {
    explicit Level(PolygonSoup triangles) : soup(std::move(triangles)) {}
    PolygonSoup soup;  // triangles, object units
    std::optional<Surface> surface;
    std::vector<std::vector<Index>> whole, cut;  // by cell: triangles in it, and those that reach into it
    double area = 0;                             // object units
    double known = 0;                            // a distance that occurs
    SideSum forward, backward;                   // from the input and to it
  };

  static Box3 whole_box(const ChunkFiles& input) {
    Box3 box;
    for (std::size_t i = 0; i < input.n_chunks(); ++i) box.extend(input.box(i));
    return box;
  }

  static Triangle triangle(const PolygonSoup& soup, Index face) {
    const auto corners = soup.face(face);
    return {soup.positions[corners[0]], soup.positions[corners[1]], soup.positions[corners[2]]};
  }

  void find_cells(Level& level) const {
    level.whole.resize(input_.n_chunks());
    level.cut.resize(input_.n_chunks());
    std::vector<Index> met;
    for (Index f = 0; f < level.soup.n_faces(); ++f) {
      met.clear();
      input_.cells().cut(triangle(level.soup, f), [&](Index cell, const Triangle&) { met.push_back(cell); });
      std::sort(met.begin(), met.end());
      met.erase(std::unique(met.begin(), met.end()), met.end());
      for (const Index cell : met) (met.size() == 1 ? level.whole : level.cut)[cell].push_back(f);
      level.area += vector_area(level.soup, f).norm();
    }
  }

  double largest_distance(const std::vector<Vec3>& points, const Level& level) const {
    const auto larger = [](double a, double b) { return std::max(a, b); };
    const auto of_range = [&](const tbb::blocked_range<std::size_t>& range, double squared) {
      for (std::size_t i = range.begin(); i < range.end(); ++i)
        squared = larger(squared, level.surface->tree.closest(frame_.inside(points[i])).squared_distance);
      return squared;
    };
    const tbb::blocked_range<std::size_t> all(0, points.size(), 1024);
    return std::sqrt(tbb::parallel_reduce(all, 0.0, of_range, larger));
  }

  std::size_t samples_of(double area, double whole) const {
    if (!(whole > 0)) return 0;
    return static_cast<std::size_t>(std::ceil(static_cast<double>(options_.samples) * area / whole));
  }

  BoundGoal goal(const Level& level) const {
    return {std::max({level.known, level.forward.max, level.backward.max}), *options_.bound_tolerance,
            floor_};
  }

  void measure_chunk(std::size_t number) {
    if (input_.n_faces(number) == 0) return;
    const Surface chunk = frame_.inside(input_.load(number).soup);
    for (Level& level : levels_) {
      const SampledSide side =
          sampled_distance(chunk, *level.surface, samples_of(input_.area(number), input_area_));
      level.known = std::max(level.known, side.distance.max);
      level.forward.add(chunk, side, certified_intervals(chunk, *level.surface, side.nearest, goal(level)));
    }
  }

  /// The part of a level in one cell.
  PolygonSoup part_in(const Level& level, Index cell) const {
    std::vector<Index> vertices;
    PolygonSoup part = cut_out(level.soup, level.whole[cell], vertices);
    for (const Index f : level.cut[cell]) {
      input_.cells().cut(triangle(level.soup, f), [&](Index at, const Triangle& t) {
        if (at != cell) return;
        const auto first = static_cast<Index>(part.positions.size());
        part.positions.insert(part.positions.end(), {t.a, t.b, t.c});
        part.add_face(std::vector<Index>{first, first + 1, first + 2});
      });
    }
    return part;
  }

  /// All faces of the input that reach into a box.
  PolygonSoup input_in(const Box3& box) const {
    PolygonSoup result;
    std::vector<Index> faces, vertices;
    for (std::size_t i = 0; i < input_.n_chunks(); ++i) {
      if (!input_.box(i).intersects(box)) continue;
      const PolygonSoup soup = input_.load(i).soup;
      faces.clear();
      for (Index f = 0; f < soup.n_faces(); ++f) {
        Box3 around;
        for (const Index v : soup.face(f)) around.extend(soup.positions[v]);
        if (around.intersects(box)) faces.push_back(f);
      }
      append(result, cut_out(soup, faces, vertices));
    }
    return result;
  }

  void measure_cell(std::size_t number) {
    const auto cell = static_cast<Index>(number);
    std::vector<PolygonSoup> parts;
    Box3 box;
    double reach = 0;  // as far as the nearest points are likely to be
    for (const Level& level : levels_) {
      parts.push_back(part_in(level, cell));
      if (parts.back().n_faces() == 0) continue;
      box.extend(bounding_box(parts.back()));
      reach = std::max(reach, frame_.outside(level.forward.bound));
    }
    if (box.isEmpty()) return;
    std::optional<Surface> near;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      if (parts[i].n_faces() == 0) continue;
      const Surface part = frame_.inside(parts[i]);
      measure_part(levels_[i], part, box, near, reach);
    }
  }

  /// Measures a part of a level to what is near it of the input; farther on when that turns out to be too
  /// little. What is left out can only make distances larger, so that bounds hold in any case.
  void measure_part(Level& level, const Surface& part, const Box3& box, std::optional<Surface>& near,
                    double& reach) {
    const Box3 all = whole_box(input_);
    for (;;) {
      const double margin = 1.5 * reach + 1e-9 * all.diagonal().norm();
      const Box3 around(box.min() - Vec3::Constant(margin), box.max() + Vec3::Constant(margin));
      if (!near) {
        const PolygonSoup soup = input_in(around);
        if (soup.n_faces() > 0) near.emplace(frame_.inside(soup));
      }
      if (!near) {
        reach = std::max(2 * reach, 1e-3 * all.diagonal().norm());
        continue;
      }
      const SampledSide side =
          sampled_distance(part, *near, samples_of(frame_.outside(frame_.outside(part.area)), level.area));
      const std::vector<Interval> intervals = certified_intervals(part, *near, side.nearest, goal(level));
      SideSum found;
      found.add(part, side, intervals);
      const double bound = frame_.outside(found.bound);
      if (bound <= margin || around.contains(all)) {
        level.backward.add(part, side, intervals);
        return;
      }
      reach = bound;
      near.reset();
    }
  }

  const ChunkFiles& input_;
  const DistanceOptions& options_;
  Frame frame_;
  std::vector<Level> levels_;
  double input_area_ = 0, floor_ = 0;
};

}  // namespace

std::vector<LevelError> measure_against_chunks(const ChunkFiles& input, const std::vector<Vec3>& points,
                                               const std::vector<PolygonSoup>& levels,
                                               const DistanceOptions& options, Progress* progress) {
  if (!options.bound_tolerance) throw OptionError("a hierarchy needs a certified bound");
  return ChunkMeter(input, levels, options).measure(points, progress);
}

}  // namespace recede::detail
