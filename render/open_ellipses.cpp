#include <recede/geometry/error.h>
#include <recede/render/open_ellipses.h>

#include <Eigen/Eigenvalues>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace recede {
namespace {

constexpr double k_never = 1e-12;   // radius squared of what is never open
constexpr double k_regular = 1e-4;  // variance that even a single direction has

/// 0 below -1/2, 1 above 1/2, smooth in between.
double smooth_step(double x) {
  const double t = std::clamp(x + 0.5, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Along a meridian, `inside` falls as fast as the height of the direction is large.
double openness_of(const OpenEllipse& ellipse, const Vec3& direction, double soft_edge) {
  if (!(direction.z() > 0)) return 0;
  const double inside = ellipse.inside(direction.head<2>());
  if (!(soft_edge > 0)) return inside >= 0 ? 1 : 0;
  return smooth_step(inside / (soft_edge * direction.z()));
}

struct Sample {
  Vec3 direction;
  bool open;
};

std::vector<Sample> samples_of(const HeightFieldVisibility& visibility, std::size_t place,
                               const BaseCurvature& curvature) {
  const BentDirections bent = bend_directions(visibility, place, curvature);
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < bent.directions.size(); ++i) {
    const SeenPlace& seen = visibility.seen_from(place, i);
    const Vec3& d = bent.directions[i];
    if ((seen.is_place() || seen.is_nothing()) && d.z() > 0 && bent.normal.dot(d) > 0)
      samples.push_back({d, seen.is_nothing()});
  }
  return samples;
}

/// Centre, the angle of the major axis, and two radii: what the search moves.
struct Shape {
  Vec2 center;
  double angle = 0;
  std::array<double, 2> radii;

  OpenEllipse ellipse() const {
    const double c = std::cos(angle), s = std::sin(angle);
    const double a = radii[0] * radii[0], b = radii[1] * radii[1];
    return {center, c * c * a + s * s * b, c * s * (a - b), s * s * a + c * c * b};
  }
};

Shape shape_of(const OpenEllipse& ellipse) {
  const OpenEllipse::Axes axes = ellipse.axes();
  return {ellipse.center, std::atan2(axes.major.y(), axes.major.x()), {axes.radii.x(), axes.radii.y()}};
}

class EllipseFit {
 public:
  EllipseFit(std::vector<Sample> samples, const OpenEllipsesOptions& options)
      : samples_(std::move(samples)), options_(options) {}

  /// `start`: where the search begins; nothing: at the mean and the variance.
  OpenEllipse fit(const OpenEllipse* start) const {
    const auto open = static_cast<std::size_t>(
        std::count_if(samples_.begin(), samples_.end(), [](const Sample& sample) { return sample.open; }));
    if (open == samples_.size()) return {};
    if (open == 0) return {.xx = k_never, .yy = k_never};
    constexpr double k_first_step = 1.3, k_step_from_start = 1.05;
    if (start != nullptr) return search(shape_of(*start), k_step_from_start).ellipse();
    return search(first_shape(static_cast<double>(open)), k_first_step).ellipse();
  }

 private:
  /// Evenly spread directions of a hemisphere have the variance 1/3 along x and along y: the start from all
  /// of them is the unit circle.
  Shape first_shape(double open) const {
    Vec2 mean = Vec2::Zero();
    for (const Sample& sample : samples_) {
      if (sample.open) mean += sample.direction.head<2>() / open;
    }
    Eigen::Matrix2d variance = Eigen::Matrix2d::Identity() * k_regular;
    for (const Sample& sample : samples_) {
      const Vec2 from_mean = sample.direction.head<2>() - mean;
      if (sample.open) variance += from_mean * from_mean.transpose() / open;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(variance);
    const Vec2 major = solver.eigenvectors().col(1);
    return {mean,
            std::atan2(major.y(), major.x()),
            {std::sqrt(3 * solver.eigenvalues()[1]), std::sqrt(3 * solver.eigenvalues()[0])}};
  }

  /// The openness of directions to the sky, less that of directions to other places. Its edge is soft even
  /// where that of the tests is sharp: counts alone leave a shape anywhere between two directions.
  double quality(const Shape& shape) const {
    const OpenEllipse ellipse = shape.ellipse();
    const double edge = std::max(options_.soft_edge, 0.1);
    double sum = 0;
    for (const Sample& sample : samples_) {
      const double openness = openness_of(ellipse, sample.direction, edge);
      sum += sample.open ? openness : -openness;
    }
    return sum;
  }

  /// The shapes one step away, the step as a factor of radii.
  std::vector<Shape> neighbours(const Shape& shape, double step) const {
    std::vector<Shape> result;
    const std::array<double, 3> factors{1, step, 1 / step};
    for (std::size_t k = 1; k < 9; ++k) {
      Shape moved = shape;
      moved.radii[0] *= factors[k % 3];
      moved.radii[1] *= factors[k / 3];
      result.push_back(moved);
    }
    if (options_.radii_only) return result;
    for (const double way : {step - 1, 1 - step}) {
      Shape moved = shape;
      moved.angle += way;
      result.push_back(moved);
      const Vec2 axis(std::cos(shape.angle), std::sin(shape.angle));
      for (const Vec2& along : {axis, Vec2(-axis.y(), axis.x())}) {
        moved = shape;
        moved.center += way * along;
        result.push_back(moved);
      }
    }
    return result;
  }

  Shape search(Shape best, double step) const {
    constexpr double k_last_step = 1.005;
    limit(best);
    double best_quality = quality(best);
    while (step >= k_last_step) {
      bool better = false;
      for (Shape& shape : neighbours(best, step)) {
        limit(shape);
        const double found = quality(shape);
        if (!(found > best_quality)) continue;
        best = shape;
        best_quality = found;
        better = true;
      }
      if (!better) step = std::sqrt(step);
    }
    return best;
  }

  /// Beyond what reaches the horizon on the far side, radii would grow without end.
  static void limit(Shape& shape) {
    for (double& radius : shape.radii) radius = std::min(radius, 1 + shape.center.norm());
  }

  std::vector<Sample> samples_;
  const OpenEllipsesOptions& options_;
};

/// a + factor * (b - c), number by number.
OpenEllipse sum_of(const OpenEllipse& a, double factor, const OpenEllipse& b, const OpenEllipse& c) {
  return {a.center + factor * (b.center - c.center), a.xx + factor * (b.xx - c.xx),
          a.xy + factor * (b.xy - c.xy), a.yy + factor * (b.yy - c.yy)};
}

OpenEllipse no_ellipse() { return {Vec2::Zero(), 0, 0, 0}; }

/// Keeps both radii above those of a point.
OpenEllipse kept_positive(OpenEllipse e) {
  e.xx = std::max(e.xx, k_never);
  e.yy = std::max(e.yy, k_never);
  const double most = std::sqrt(e.xx * e.yy) * (1 - 1e-9);
  e.xy = std::clamp(e.xy, -most, most);
  return e;
}

/// `start`: ellipses from which the search begins, or null.
OpenEllipses fit_all(const HeightFieldVisibility& visibility, const OpenEllipsesOptions& options,
                     const OpenEllipses* start, Progress* progress) {
  if (!(options.soft_edge >= 0 && options.soft_edge <= 1))
    throw OptionError("the soft edge of open ellipses is a number from 0 to 1");
  bend_directions(visibility, 0, options.curvature);  // refuses curvatures in this thread
  OpenEllipses ellipses{
      .columns = visibility.columns, .rows = visibility.rows, .soft_edge = options.soft_edge};
  ellipses.places.resize(visibility.place_count());
  for (int y = 0; y < visibility.rows; ++y) {
    if (y % 16 == 0) report_progress(progress, "open ellipses", static_cast<double>(y) / visibility.rows);
    tbb::parallel_for(0, visibility.columns, [&](int x) {
      const std::size_t place = visibility.place(x, y);
      ellipses.places[place] = EllipseFit(samples_of(visibility, place, options.curvature), options)
                                   .fit(start != nullptr ? &start->places[place] : nullptr);
    });
  }
  report_progress(progress, "open ellipses", 1);
  return ellipses;
}

}  // namespace

double OpenEllipse::inside(const Vec2& at) const {
  const Vec2 from = at - center;
  const double determinant = xx * yy - xy * xy;
  const double squared = yy * from.x() * from.x() - 2 * xy * from.x() * from.y() + xx * from.y() * from.y();
  return 1 - squared / determinant;
}

OpenEllipse::Axes OpenEllipse::axes() const {
  const double half = (xx + yy) / 2, apart = std::hypot((xx - yy) / 2, xy);
  const double angle = std::atan2(xy, (xx - yy) / 2) / 2;
  return {{std::cos(angle), std::sin(angle)},
          {std::sqrt(half + apart), std::sqrt(std::max(half - apart, 0.0))}};
}

double OpenEllipses::openness(std::size_t place, const Vec3& direction) const {
  return openness_of(places[place], direction, soft_edge);
}

double OpenEllipses::openness_at(const Vec2& uv, const Vec3& direction) const {
  const PlaceMix mix = mix_of_places(columns, rows, uv);
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) sum += mix.weights[k] * openness(mix.places[k], direction);
  return sum;
}

OpenEllipses fit_open_ellipses(const HeightFieldVisibility& visibility, const OpenEllipsesOptions& options,
                               Progress* progress) {
  return fit_all(visibility, options, nullptr, progress);
}

OpenEllipses BendableEllipses::bent(const BaseCurvature& curvature) const {
  OpenEllipses result = flat;
  for (std::size_t place = 0; place < result.places.size(); ++place) {
    OpenEllipse& ellipse = result.places[place];
    ellipse = sum_of(ellipse, curvature.along_u, along_u[place], no_ellipse());
    ellipse = kept_positive(sum_of(ellipse, curvature.along_v, along_v[place], no_ellipse()));
  }
  return result;
}

BendableEllipses fit_bendable_ellipses(const HeightFieldVisibility& visibility,
                                       const OpenEllipsesOptions& options, double change,
                                       Progress* progress) {
  if (!(change > 0 && std::isfinite(change)))
    throw OptionError("the change of curvature that ellipses are fitted at is a number greater than 0");
  const double step = change / visibility.sides.maxCoeff();
  OpenEllipsesOptions bent = options;
  bent.curvature = {};
  const OpenEllipses flat = fit_open_ellipses(visibility, bent, progress);
  // From the flat ones on: a search from elsewhere may end at another shape that is as good.
  const auto fitted = [&](double along_u, double along_v) {
    bent.curvature = {along_u, along_v};
    return fit_all(visibility, bent, &flat, progress);
  };
  const auto change_between = [&](const OpenEllipses& more, const OpenEllipses& less) {
    std::vector<OpenEllipse> changes;
    for (std::size_t place = 0; place < more.places.size(); ++place)
      changes.push_back(sum_of(no_ellipse(), 1 / (2 * step), more.places[place], less.places[place]));
    return changes;
  };
  return {flat, change_between(fitted(step, 0), fitted(-step, 0)),
          change_between(fitted(0, step), fitted(0, -step))};
}

OpennessErrors measure_openness_errors(const DisplacedPlane& plane, const HeightFieldVisibility& visibility,
                                       const OpenEllipses& ellipses, int directions, Progress* progress) {
  if (directions < 3 || directions > 2048)
    throw OptionError("directions to measure errors of openness in: 3 to 2048");
  std::vector<Vec3> upper = spread_directions(2 * directions).directions;
  upper.resize(static_cast<std::size_t>(directions));  // from +z down
  // Turned, so that they aren't those of the visibility when there are as many.
  for (Vec3& d : upper) d = Eigen::AngleAxisd(1, Vec3::UnitZ()) * d;
  std::vector<std::array<int, 3>> wrong(visibility.place_count(), {0, 0, 0});
  for (std::size_t k = 0; k < upper.size(); ++k) {
    report_progress(progress, "errors of openness", static_cast<double>(k) / directions);
    const Vec3& d = upper[k];
    tbb::parallel_for(std::size_t{0}, wrong.size(), [&](std::size_t place) {
      const bool open = is_open(plane, visibility, place, d);
      const bool faces = visibility.normals[place].dot(d) > 0;
      wrong[place][0] += is_open_by_nearest(visibility, place, d) != open;
      wrong[place][1] += (openness_by_three(visibility, place, d) >= 0.5) != open;
      wrong[place][2] += (faces && ellipses.openness(place, d) >= 0.5) != open;
    });
  }
  OpennessErrors errors;
  OpennessErrors::Share* shares[] = {&errors.nearest, &errors.three, &errors.ellipses};
  for (std::size_t k = 0; k < 3; ++k) {
    for (const auto& counts : wrong) {
      const double share = static_cast<double>(counts[k]) / directions;
      shares[k]->mean += share / static_cast<double>(wrong.size());
      shares[k]->worst = std::max(shares[k]->worst, share);
    }
  }
  return errors;
}

}  // namespace recede
