#include <recede/geometry/detail/cad_parameters.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede::detail {

namespace {

// Full turns come as 2 pi give or take some bits, which must not make a fifth arc.
constexpr double k_angle_slack = 1e-9;

}  // namespace

ParameterMap ParameterMap::angles(const ParameterRange& range) {
  const double quarters = range.length() / (std::numbers::pi / 2);
  const int spans = std::max(1, static_cast<int>(std::ceil(quarters - k_angle_slack)));
  return {Kind::angle, range.begin, range.length() / spans, spans};
}

ParameterMap ParameterMap::hyperbola(const ParameterRange& range) {
  return {Kind::hyperbolic, range.begin, range.length(), 1};
}

// With end weights of 1, the tangent of half the angle from a span's middle is proportional to the NURBS
// parameter from there; for hyperbolas it is the hyperbolic tangent.
double ParameterMap::to_nurbs(double t) const {
  if (kind == Kind::same) return t;
  const double span = std::clamp(std::floor((t - begin) / step), 0.0, spans - 1.0);
  const double middle = begin + (span + 0.5) * step, half = (t - middle) / 2;
  if (kind == Kind::angle) return middle + step / 2 * std::tan(half) / std::tan(step / 4);
  return middle + step / 2 * std::tanh(half) / std::tanh(step / 4);
}

double ParameterMap::to_file(double x) const {
  if (kind == Kind::same) return x;
  const double span = std::clamp(std::floor((x - begin) / step), 0.0, spans - 1.0);
  const double middle = begin + (span + 0.5) * step, share = (x - middle) / (step / 2);
  if (kind == Kind::angle) return middle + 2 * std::atan(share * std::tan(step / 4));
  return middle + 2 * std::atanh(share * std::tanh(step / 4));
}

std::vector<double> ParameterMap::span_ends() const {
  std::vector<double> ends;
  if (kind == Kind::same) return ends;
  for (int i = 0; i <= spans; ++i) ends.push_back(begin + i * step);
  return ends;
}

double ParameterMap::middle_weight() const {
  return kind == Kind::angle ? std::cos(step / 2) : std::cosh(step / 2);
}

}  // namespace recede::detail
