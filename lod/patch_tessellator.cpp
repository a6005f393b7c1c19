#include <recede/geometry/error.h>
#include <recede/lod/detail/lattice_seeds.h>
#include <recede/lod/detail/loop_triangulation.h>
#include <recede/lod/detail/triangle_deviation.h>
#include <recede/lod/patch_tessellator.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>

namespace recede {

namespace {

// Triangles follow the directions of curvature, but aren't this much longer than wide on the surface for
// that.
constexpr double k_most_stretch = 8;
constexpr int k_metric_samples = 5;  // along each axis

// Powers of two, with which parameters can be multiplied without rounding.
double power_of_two_near(double value) { return std::exp2(std::round(std::log2(value))); }

// Factors of u and v after which triangles that are round are good: by the square roots of second
// derivatives, as errors grow with these, limited by lengths on the surface.
Vec2 metric_of(const BezierPatches& surface, const ParameterBox& part) {
  Vec2 lengths = Vec2::Zero(), bends = Vec2::Zero();
  for (int i = 0; i < k_metric_samples; ++i) {
    for (int j = 0; j < k_metric_samples; ++j) {
      const Vec2 share((i + 0.5) / k_metric_samples, (j + 0.5) / k_metric_samples);
      const SurfaceDerivatives at = surface.derivatives(part.min() + share.cwiseProduct(part.sizes()));
      lengths += Vec2(at.du.norm(), at.dv.norm());
      bends += Vec2(at.duu.norm(), at.dvv.norm());
    }
  }
  constexpr double k_count = k_metric_samples * k_metric_samples;
  lengths /= k_count;
  bends /= k_count;
  const Vec2 tiny = 1e-9 * part.sizes().cwiseInverse().cwiseMin(1e150);
  lengths = lengths.cwiseMax(tiny * lengths.cwiseProduct(part.sizes()).maxCoeff()).cwiseMax(1e-150);
  Vec2 curvature = bends.cwiseSqrt().cwiseQuotient(lengths);
  const double most = curvature.maxCoeff();
  curvature = most > 0 ? Vec2(curvature.cwiseMax(most / k_most_stretch) / most) : Vec2(1, 1);
  const Vec2 scale = lengths.cwiseProduct(curvature);
  return {power_of_two_near(scale.x()), power_of_two_near(scale.y())};
}

class PatchRefiner {
 public:
  PatchRefiner(std::span<const SeamLoop> loops, std::span<const Vec3> positions, const PatchSurface& surface,
               const PatchTessellationOptions& options)
      : loops_(loops), positions_(positions), surface_(surface), options_(options) {}

  PatchTriangles run() {
    take_loops();
    triangulate_loops();
    if (needs_points()) {
      seed();
      refine();
    }
    if (!has_area()) add_any_point();
    collect();
    return std::move(result_);
  }

 private:
  void take_loops() {
    for (const SeamLoop& loop : loops_) {
      const auto first = static_cast<Index>(result_.uvs.size());
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const auto here = static_cast<Index>(result_.uvs.size());
        const SeamSlot& slot = loop[i];
        edges_.push_back({here, i + 1 < loop.size() ? here + 1 : first});
        result_.uvs.push_back(slot.uv);
        result_.positions.push_back(positions_[slot.vertex]);
        vertices_.push_back(slot.vertex);
        moves_.push_back((surface_.shape.evaluate(slot.uv) - result_.positions.back()).norm());
        widths_.push_back(static_cast<double>(slot.width));
        domain_.extend(slot.uv);
      }
    }
    if (result_.uvs.size() < 3) throw InputError("a patch without loops has no triangles");
  }

  void triangulate_loops() {
    scale_ = metric_of(surface_.shape, domain_);
    std::vector<Vec2> points;
    for (const Vec2& uv : result_.uvs) points.push_back(uv.cwiseProduct(scale_));
    delaunay_ = detail::triangulate_loops(points, edges_);
  }

  std::array<Vec2, 3> uvs_of(const DelaunayTriangle& triangle) const {
    return {result_.uvs[triangle.vertices[0]], result_.uvs[triangle.vertices[1]],
            result_.uvs[triangle.vertices[2]]};
  }

  bool is_of_loop(Index point) const { return point < moves_.size(); }

  // How far sewing moved its corners, at most.
  double move_of(const DelaunayTriangle& triangle) const {
    double move = 0;
    for (const Index point : triangle.vertices) {
      if (is_of_loop(point)) move = std::max(move, moves_[point]);
    }
    return move;
  }

  // Of the strip between a side of a loop and its trimming curve: how far it is from the side.
  double strip_error(const DelaunayTriangle& triangle, int side) const {
    // Counter-clockwise, sides run as loops do.
    const Index from = triangle.from(side), to = triangle.to(side);
    return widths_[from] + surface_.bounds.deviation(result_.uvs[from], result_.uvs[to]) +
           std::max(moves_[from], moves_[to]);
  }

  double deviation(const DelaunayTriangle& triangle, double enough) const {
    return detail::triangle_deviation(surface_, uvs_of(triangle), std::max(enough, 0.0));
  }

  // What refinement aims at. Where moves or a side of a loop leave less, no point within would ever do: as
  // near as helps the rest.
  double aim(const DelaunayTriangle& triangle) const {
    constexpr double k_least_share = 0.25, k_near_side = 1.25;
    double result = std::max(options_.tolerance - move_of(triangle), k_least_share * options_.tolerance);
    for (int k = 0; k < 3; ++k) {
      // Beside a side that is one point in space, points do help.
      if (!triangle.is_constrained(k) || is_one_point(triangle, k)) continue;
      const Vec2 &from = result_.uvs[triangle.from(k)], &to = result_.uvs[triangle.to(k)];
      result = std::max(result, k_near_side * surface_.bounds.deviation(from, to, result / k_near_side));
    }
    return result;
  }

  bool is_good(const DelaunayTriangle& triangle) const {
    const double allowed = aim(triangle);
    return deviation(triangle, allowed) <= allowed;
  }

  bool needs_points() const {
    const auto triangles = delaunay_->triangles();
    return std::any_of(triangles.begin(), triangles.end(), [&](const DelaunayTriangle& triangle) {
      return triangle.is_inside && !is_good(triangle);
    });
  }

  // A ball between its poles has none without a point within, however little it matters.
  bool has_area() const {
    const auto triangles = delaunay_->triangles();
    return std::any_of(triangles.begin(), triangles.end(), [&](const DelaunayTriangle& triangle) {
      return triangle.is_inside && !is_flat(triangle);
    });
  }

  void add_any_point() {
    const std::size_t n = delaunay_->triangles().size();
    for (std::size_t t = 0; t < n && n_added() < options_.most_points; ++t) {
      const DelaunayTriangle triangle = delaunay_->triangles()[t];
      if (triangle.is_inside && split_and_check(static_cast<Index>(t), triangle)) break;
    }
    split_waiting();
  }

  // Points on lattices that are as wide as the tolerance allows, where they aren't near loops.
  void seed() {
    Index near = k_no_index;
    detail::each_lattice_seed(
        surface_.bounds, domain_, lattice_tolerance(), [&](const Vec2& uv, const Vec2& spacing) {
          if (n_added() >= options_.most_points) return;
          const Vec2 point = uv.cwiseProduct(scale_);
          const TriangleLocation place = delaunay_->locate(point, near);
          if (place.triangle == k_no_index) return;
          near = place.triangle;
          if (!delaunay_->is_inside(place.triangle) || is_crowded(place.triangle, uv, spacing)) return;
          add(point, place.triangle);
        });
  }

  // Bounds over many pieces of a surface are far from what triangles reach there. A tolerance with which most
  // triangles of lattices are within the one that was asked for.
  double lattice_tolerance() const {
    constexpr int k_rounds = 4;
    constexpr double k_most_growth = 4;  // in a round: what is met changes with size
    double tolerance = options_.tolerance;
    for (int round = 0; round < k_rounds; ++round) {
      const double reached = reached_by_lattice(tolerance);
      if (!(reached > 0 && reached < 0.9 * options_.tolerance)) break;
      tolerance *= std::min(options_.tolerance / reached, k_most_growth);
    }
    return tolerance;
  }

  // Of the deviations of some of a lattice's triangles, what four of five don't exceed.
  double reached_by_lattice(double tolerance) const {
    constexpr std::size_t k_samples = 128;
    std::size_t n = 0, i = 0;
    detail::each_lattice_seed(surface_.bounds, domain_, tolerance, [&](const Vec2&, const Vec2&) { ++n; });
    std::vector<double> reached;
    detail::each_lattice_seed(surface_.bounds, domain_, tolerance, [&](const Vec2& uv, const Vec2& spacing) {
      if (i++ % (n / k_samples + 1) != 0) return;
      const Vec2 half = spacing / 2;
      reached.push_back(detail::measured_deviation(
          surface_, {uv - half, uv + Vec2(half.x(), -half.y()), uv + Vec2(0, half.y())}));
    });
    if (reached.empty()) return 0;
    const auto place = reached.begin() + static_cast<std::ptrdiff_t>(reached.size() * 4 / 5);
    std::nth_element(reached.begin(), place, reached.end());
    return *place;
  }

  // Nearer to a corner or a side of a loop than half of the spacing.
  bool is_crowded(Index triangle, const Vec2& uv, const Vec2& spacing) const {
    constexpr double k_near = 0.5;
    const DelaunayTriangle& at = delaunay_->triangles()[triangle];
    for (int k = 0; k < 3; ++k) {
      const Vec2 a = (result_.uvs[at.from(k)] - uv).cwiseQuotient(spacing);
      if (a.squaredNorm() < k_near * k_near) return true;
      if (!at.is_constrained(k)) continue;
      const Vec2 b = (result_.uvs[at.to(k)] - uv).cwiseQuotient(spacing), along = b - a;
      const double cross = a.x() * b.y() - a.y() * b.x();
      if (cross * cross < k_near * k_near * along.squaredNorm()) return true;
    }
    return false;
  }

  std::size_t n_added() const { return result_.uvs.size() - moves_.size(); }

  bool add(const Vec2& point, Index near) {
    const Insertion inserted = delaunay_->insert(point, near);
    if (inserted.status != InsertionStatus::inserted) return false;
    const Vec2 uv = point.cwiseQuotient(scale_);
    result_.uvs.push_back(uv);
    result_.positions.push_back(surface_.shape.evaluate(uv));
    return true;
  }

  void refine() {
    const auto triangles = delaunay_->triangles();
    for (std::size_t t = 0; t < triangles.size(); ++t) check(static_cast<Index>(t));
    split_waiting();
    constexpr int k_most_rounds = 4;
    for (int round = 0; round < k_most_rounds && split_inverted(); ++round) split_waiting();
  }

  // The worst first, by powers of two; those of a power in the order in which they came.
  void split_waiting() {
    while (!waiting_.empty() && n_added() < options_.most_points) {
      const Waiting next = waiting_.top();
      waiting_.pop();
      const DelaunayTriangle triangle = delaunay_->triangles()[next.triangle];
      if (triangle.vertices != next.vertices || !triangle.is_inside) continue;
      split_and_check(next.triangle, triangle);
    }
  }

  // Where it can't be split it is as good as numbers allow.
  bool split_and_check(Index t, const DelaunayTriangle& triangle) {
    if (!split(t, triangle)) return false;
    for (const Index changed : delaunay_->changed()) check(changed);
    return true;
  }

  // Slivers beside a pole can be turned over though they are within the tolerance. Those between points of
  // loops alone are left to finer loops.
  bool split_inverted() {
    extend_normals();
    bool has_split = false;
    const std::size_t n = delaunay_->triangles().size();
    for (std::size_t t = 0; t < n && n_added() < options_.most_points; ++t) {
      const DelaunayTriangle triangle = delaunay_->triangles()[t];
      const auto& points = triangle.vertices;
      if (!triangle.is_inside ||
          std::all_of(points.begin(), points.end(), [&](Index point) { return is_of_loop(point); }))
        continue;
      // Points of this round have no normals yet.
      if (*std::max_element(points.begin(), points.end()) >= normals_.size() || !is_inverted(points))
        continue;
      has_split |= split_and_check(static_cast<Index>(t), triangle);
    }
    return has_split;
  }

  void extend_normals() {
    while (normals_.size() < result_.uvs.size())
      normals_.push_back(surface_.shape.normal(result_.uvs[normals_.size()]));
  }

  bool is_inverted(const std::array<Index, 3>& points) const {
    const Vec3& origin = result_.positions[points[0]];
    const Vec3 normal = (result_.positions[points[1]] - origin).cross(result_.positions[points[2]] - origin);
    // Triangles between points of a plane that the surface stands upright on point neither way.
    constexpr double k_least_sine = 1e-6;
    return std::all_of(points.begin(), points.end(), [&](Index point) {
      return normals_[point].dot(normal) < -k_least_sine * normal.norm();
    });
  }

  void check(Index t) {
    const DelaunayTriangle& triangle = delaunay_->triangles()[t];
    if (!triangle.is_inside) return;
    const double allowed = aim(triangle), reached = deviation(triangle, allowed);
    if (reached <= allowed) return;
    const double excess = std::min(reached / allowed, 1e300);
    waiting_.push({std::ilogb(excess), n_checked_++, t, triangle.vertices});
  }

  // Puts a point into a triangle, or near to it where its circle's center is.
  bool split(Index t, const DelaunayTriangle& triangle) {
    std::array<Vec2, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = delaunay_->point(triangle.vertices[k]);
    if (is_needle(corners)) return false;
    const Vec2 center = circumcenter(corners);
    if (center.allFinite()) {
      const TriangleLocation place = delaunay_->locate(center, t);
      if (place.triangle != k_no_index && delaunay_->is_inside(place.triangle) &&
          !is_near_loop(place.triangle, center) && add(center, place.triangle)) {
        return true;
      }
    }
    return add(beside_longest(triangle, corners), t);
  }

  // So flat that points within it are no help, as beside a border that is too coarse.
  static bool is_needle(const std::array<Vec2, 3>& corners) {
    constexpr double k_least_height = 1e-9;  // of its length
    const Vec2 a = corners[1] - corners[0], b = corners[2] - corners[0];
    const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
    return a.x() * b.y() - a.y() * b.x() < k_least_height * longest;
  }

  static Vec2 circumcenter(const std::array<Vec2, 3>& corners) {
    const Vec2 a = corners[1] - corners[0], b = corners[2] - corners[0];
    const double cross = a.x() * b.y() - a.y() * b.x();
    const Vec2 c =
        (a.squaredNorm() * Vec2(b.y(), -b.x()) + b.squaredNorm() * Vec2(-a.y(), a.x())) / (2 * cross);
    return corners[0] + c;
  }

  // So near to a side of a loop that the triangle on it would be flat: within a fourth of its length.
  bool is_near_loop(Index t, const Vec2& point) const {
    const DelaunayTriangle& triangle = delaunay_->triangles()[t];
    for (int k = 0; k < 3; ++k) {
      if (!triangle.is_constrained(k)) continue;
      const Vec2 a = delaunay_->point(triangle.from(k)), along = delaunay_->point(triangle.to(k)) - a,
                 to = point - a;
      const double height = (along.x() * to.y() - along.y() * to.x()) / along.norm();
      if (height < 0.25 * along.norm()) return true;
    }
    return false;
  }

  // On the middle of the longest side, or above it where it is a loop's: a half of the side high, or of the
  // triangle.
  Vec2 beside_longest(const DelaunayTriangle& triangle, const std::array<Vec2, 3>& corners) const {
    int longest = 0;
    double length = 0;
    for (int k = 0; k < 3; ++k) {
      const double here = (delaunay_->point(triangle.to(k)) - delaunay_->point(triangle.from(k))).norm();
      if (here > length) {
        length = here;
        longest = k;
      }
    }
    const Vec2 a = delaunay_->point(triangle.from(longest)), b = delaunay_->point(triangle.to(longest));
    const Vec2 middle = (a + b) / 2;
    if (!triangle.is_constrained(longest)) return middle;
    const Vec2 apex = corners[static_cast<std::size_t>(longest)];
    const double height = ((b - a).x() * (apex - a).y() - (b - a).y() * (apex - a).x()) / length;
    return middle + std::min(0.5, 0.5 * length / height) * (apex - middle);
  }

  void collect() {
    double worst = 0;
    for (const DelaunayTriangle& triangle : delaunay_->triangles()) {
      if (!triangle.is_inside) continue;
      const double move = move_of(triangle);
      worst = std::max(worst, move + deviation(triangle, options_.tolerance - move));
      for (int k = 0; k < 3; ++k) {
        if (triangle.is_constrained(k) && widths_[triangle.from(k)] > 0)
          worst = std::max(worst, strip_error(triangle, k));
      }
      if (!is_flat(triangle)) result_.triangles.push_back(triangle.vertices);
    }
    result_.error_bound = worst;
    result_.reached_tolerance = worst <= options_.tolerance;
    count_inverted();
  }

  bool is_one_point(const DelaunayTriangle& triangle, int side) const {
    const Index a = triangle.from(side), b = triangle.to(side);
    return is_of_loop(a) && is_of_loop(b) && vertices_[a] == vertices_[b];
  }

  // Two corners are the same point in space.
  bool is_flat(const DelaunayTriangle& triangle) const {
    return is_one_point(triangle, 0) || is_one_point(triangle, 1) || is_one_point(triangle, 2);
  }

  void count_inverted() {
    extend_normals();
    for (const auto& triangle : result_.triangles)
      if (is_inverted(triangle)) ++result_.inverted;
  }

  struct Waiting {
    int power;
    std::size_t number;
    Index triangle;
    std::array<Index, 3> vertices;
    bool operator<(const Waiting& other) const {
      return power != other.power ? power < other.power : number > other.number;
    }
  };

  std::span<const SeamLoop> loops_;
  std::span<const Vec3> positions_;
  const PatchSurface& surface_;
  const PatchTessellationOptions& options_;
  PatchTriangles result_;
  std::vector<std::array<Index, 2>> edges_;
  std::vector<Index> vertices_;  // of the graph, by point of loops
  std::vector<double> moves_;    // by sewing, by point of loops
  std::vector<double> widths_;   // of the strip up to the next point of a loop
  std::vector<Vec3> normals_;    // of the surface, by point
  ParameterBox domain_;
  Vec2 scale_ = Vec2(1, 1);
  std::optional<ConstrainedDelaunay> delaunay_;
  std::priority_queue<Waiting> waiting_;
  std::size_t n_checked_ = 0;
};

}  // namespace

PatchTriangles triangulate_patch(std::span<const SeamLoop> loops, std::span<const Vec3> positions,
                                 const PatchSurface& surface, const PatchTessellationOptions& options) {
  if (!(options.tolerance > 0)) throw OptionError("the tolerance of a tessellation is above 0");
  return PatchRefiner(loops, positions, surface, options).run();
}

}  // namespace recede
