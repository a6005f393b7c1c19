#include <recede/geometry/bezier_patches.h>
#include <recede/geometry/detail/knots.h>
#include <recede/geometry/detail/weighted.h>

#include <algorithm>

namespace recede {

namespace {

using detail::k_most_degree;
using detail::Weighted;

// Where the knots cut the domain.
std::vector<double> breaks_of(const NurbsSurface& surface, std::size_t axis) {
  const ParameterRange domain = surface.domain(axis);
  std::vector<double> breaks;
  for (const double knot : surface.knots[axis]) {
    if (domain.contains(knot) && (breaks.empty() || knot > breaks.back())) breaks.push_back(knot);
  }
  return breaks;
}

// Weighs control points of spline rows so that they become those of Bezier pieces: by the blossom, whose
// arguments are the piece's ends.
class PieceWeights {
 public:
  PieceWeights(const std::vector<double>& knots, int degree, std::size_t span)
      : size_(static_cast<std::size_t>(degree) + 1) {
    const double begin = knots[span], end = knots[span + 1];
    for (std::size_t point = 0; point < size_; ++point) {
      std::array<double, k_most_degree + 1> row{};
      for (std::size_t basis = 0; basis < size_; ++basis) {
        row = {};
        row[basis] = 1;
        // de Boor's triangle, with `point` of the arguments at the end.
        for (std::size_t round = 1; round < size_; ++round) {
          const double t = round <= point ? end : begin;
          for (std::size_t i = size_; i-- > round;) {
            const double left = knots[span + i + 1 - size_];
            const double right = knots[span + i + 1 - round];
            const double share = (t - left) / (right - left);
            row[i] = (1 - share) * row[i - 1] + share * row[i];
          }
        }
        weights_[point][basis] = row[size_ - 1];
      }
    }
  }

  double operator()(std::size_t point, std::size_t basis) const { return weights_[point][basis]; }

 private:
  std::size_t size_;
  std::array<std::array<double, k_most_degree + 1>, k_most_degree + 1> weights_;
};

std::vector<PieceWeights> weights_along(const NurbsSurface& surface, std::size_t axis,
                                        const std::vector<double>& breaks, std::vector<std::size_t>& spans) {
  std::vector<PieceWeights> weights;
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
    spans.push_back(
        detail::find_span(surface.knots[axis], surface.degrees[axis], surface.n_points(axis), breaks[i]));
    weights.emplace_back(surface.knots[axis], surface.degrees[axis], spans.back());
  }
  return weights;
}

// Bernstein polynomials of one degree with their first two derivatives.
struct Bernstein {
  std::array<std::array<double, k_most_degree + 1>, 3> of;

  Bernstein(std::size_t degree, double t, bool with_derivatives) {
    std::array<double, k_most_degree + 1>& values = of[0];
    values[0] = 1;
    for (std::size_t d = 1; d <= degree; ++d) {
      if (with_derivatives && d + 1 == degree) differences(d - 1, static_cast<double>(degree * d), 2);
      if (with_derivatives && d == degree) differences(d - 1, static_cast<double>(degree), 1);
      raise(d, t);
    }
    if (with_derivatives && degree < 2) std::fill_n(of[2].begin(), degree + 1, 0.0);
  }

 private:
  void raise(std::size_t d, double t) {
    std::array<double, k_most_degree + 1>& values = of[0];
    double carried = 0;
    for (std::size_t i = 0; i < d; ++i) {
      const double value = values[i];
      values[i] = carried + (1 - t) * value;
      carried = t * value;
    }
    values[d] = carried;
  }

  // Derivatives of the functions `order` degrees higher, from the present ones of degree d.
  void differences(std::size_t d, double factor, std::size_t order) {
    std::array<double, k_most_degree + 1>& result = of[order];
    std::fill_n(result.begin(), d + 1 + order, 0.0);
    for (std::size_t i = 0; i <= d; ++i) {
      const double value = factor * of[0][i];
      if (order == 1) {
        result[i] -= value;
        result[i + 1] += value;
      } else {
        result[i] += value;
        result[i + 1] -= 2 * value;
        result[i + 2] += value;
      }
    }
  }
};

Weighted<3> read_point(const double* numbers, bool is_rational) {
  return {Vec3(numbers[0], numbers[1], numbers[2]), is_rational ? numbers[3] : 1.0};
}

}  // namespace

BezierPatches::BezierPatches(const NurbsSurface& surface)
    : degrees_(surface.degrees), is_rational_(surface.is_rational()) {
  validate(surface, "surface");
  std::array<std::vector<std::size_t>, 2> spans;
  std::array<std::vector<PieceWeights>, 2> weights;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    breaks_[axis] = breaks_of(surface, axis);
    weights[axis] = weights_along(surface, axis, breaks_[axis], spans[axis]);
  }
  const auto p = static_cast<std::size_t>(degrees_[0]), q = static_cast<std::size_t>(degrees_[1]);
  const std::size_t n_v = surface.n_points(1);
  numbers_.reserve(n_patches(0) * n_patches(1) * (p + 1) * (q + 1) * (is_rational_ ? 4 : 3));
  std::vector<Weighted<3>> rows((p + 1) * (q + 1));
  for (std::size_t a = 0; a < n_patches(0); ++a) {
    for (std::size_t b = 0; b < n_patches(1); ++b) {
      for (std::size_t i = 0; i <= p; ++i) {
        for (std::size_t j = 0; j <= q; ++j) {
          Weighted<3>& row = rows[i * (q + 1) + j];
          row = {};
          for (std::size_t k = 0; k <= q; ++k) {
            const std::size_t from = (spans[0][a] - p + i) * n_v + spans[1][b] - q + k;
            row.add(weights[1][b](j, k), detail::weighted_point<3>(surface, from));
          }
        }
      }
      for (std::size_t i = 0; i <= p; ++i) {
        for (std::size_t j = 0; j <= q; ++j) {
          Weighted<3> point;
          for (std::size_t k = 0; k <= p; ++k) point.add(weights[0][a](i, k), rows[k * (q + 1) + j]);
          numbers_.insert(numbers_.end(), point.sum.begin(), point.sum.end());
          if (is_rational_) numbers_.push_back(point.weight);
        }
      }
    }
  }
}

ParameterBox BezierPatches::domain() const {
  return {Vec2(breaks_[0].front(), breaks_[1].front()), Vec2(breaks_[0].back(), breaks_[1].back())};
}

BezierPatches::Place BezierPatches::place(const Vec2& uv) const {
  std::array<std::size_t, 2> patch;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const std::vector<double>& breaks = breaks_[axis];
    const auto after = std::upper_bound(breaks.begin() + 1, breaks.end() - 1, uv[static_cast<int>(axis)]);
    patch[axis] = static_cast<std::size_t>(after - breaks.begin()) - 1;
  }
  const double u = breaks_[0][patch[0]], v = breaks_[1][patch[1]];
  const double width = breaks_[0][patch[0] + 1] - u, height = breaks_[1][patch[1] + 1] - v;
  const std::size_t n_points =
      static_cast<std::size_t>(degrees_[0] + 1) * static_cast<std::size_t>(degrees_[1] + 1);
  return {(patch[0] * n_patches(1) + patch[1]) * n_points * (is_rational_ ? 4 : 3), (uv.x() - u) / width,
          (uv.y() - v) / height, width, height};
}

Vec3 BezierPatches::evaluate(const Vec2& uv) const {
  const Place at = place(uv);
  const auto p = static_cast<std::size_t>(degrees_[0]), q = static_cast<std::size_t>(degrees_[1]);
  const Bernstein u(p, at.u, false), v(q, at.v, false);
  const std::size_t stride = is_rational_ ? 4 : 3;
  const double* numbers = numbers_.data() + at.first;
  Weighted<3> sum;
  for (std::size_t i = 0; i <= p; ++i) {
    Weighted<3> row;
    for (std::size_t j = 0; j <= q; ++j, numbers += stride)
      row.add(v.of[0][j], read_point(numbers, is_rational_));
    sum.add(u.of[0][i], row);
  }
  if (is_rational_) return sum.sum / sum.weight;
  return sum.sum;
}

SurfaceDerivatives BezierPatches::derivatives(const Vec2& uv) const {
  const Place at = place(uv);
  const auto p = static_cast<std::size_t>(degrees_[0]), q = static_cast<std::size_t>(degrees_[1]);
  const Bernstein u(p, at.u, true), v(q, at.v, true);
  const std::size_t stride = is_rational_ ? 4 : 3;
  const double* numbers = numbers_.data() + at.first;
  detail::WeightedDerivatives sums;
  for (std::size_t i = 0; i <= p; ++i) {
    std::array<Weighted<3>, 3> row;
    for (std::size_t j = 0; j <= q; ++j, numbers += stride) {
      const Weighted<3> point = read_point(numbers, is_rational_);
      for (std::size_t order = 0; order < 3; ++order) row[order].add(v.of[order][j], point);
    }
    sums.add_row({u.of[0][i], u.of[1][i], u.of[2][i]}, row);
  }
  SurfaceDerivatives result = sums.projected(is_rational_);
  result.du /= at.width;
  result.dv /= at.height;
  result.duu /= at.width * at.width;
  result.duv /= at.width * at.height;
  result.dvv /= at.height * at.height;
  return result;
}

Vec3 BezierPatches::normal(const Vec2& uv) const {
  const auto normal_at = [&](const Vec2& at) {
    const SurfaceDerivatives here = derivatives(at);
    const Vec3 normal = here.du.cross(here.dv);
    constexpr double k_least_sine = 1e-9;  // parallel, but for rounding
    const double length = normal.norm();
    return length > k_least_sine * here.du.norm() * here.dv.norm() ? Vec3(normal / length) : Vec3::Zero();
  };
  Vec3 normal = normal_at(uv);
  // From the middle of the domain it is seen from inside.
  for (double step = 1e-6; normal.isZero(0) && step < 0.1; step *= 10)
    normal = normal_at(uv + step * (domain().center() - uv));
  return normal;
}

std::vector<Vec4> BezierPatches::net(std::size_t patch_u, std::size_t patch_v) const {
  const std::size_t n_points =
      static_cast<std::size_t>(degrees_[0] + 1) * static_cast<std::size_t>(degrees_[1] + 1);
  const std::size_t stride = is_rational_ ? 4 : 3;
  const double* numbers = numbers_.data() + (patch_u * n_patches(1) + patch_v) * n_points * stride;
  std::vector<Vec4> net;
  for (std::size_t i = 0; i < n_points; ++i, numbers += stride)
    net.emplace_back(numbers[0], numbers[1], numbers[2], is_rational_ ? numbers[3] : 1.0);
  return net;
}

}  // namespace recede
