#include <recede/geometry/closest_point.h>
#include <recede/lod/detail/edge_sampling.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

constexpr int k_most_halvings = 16;
// What seams may take of a tolerance, and chords alone of curved surfaces.
constexpr double k_share_of_all = 1 - k_for_sewing, k_share_of_straight = 0.75, k_share_of_curved = 0.6;

// The control points of a use between two shares, times weights, in the edge's direction.
using CurveNet = std::vector<Vec3>;

Vec2 projected(const Vec3& point) { return point.head<2>() / point.z(); }

constexpr double k_same_share = 1e-9;  // knots that mean the same place differ by rounding

// Of the edge, for a parameter of a use.
double share_of(const SeamCurve& use, double t) {
  const double share = (t - use.range.begin) / use.range.length();
  return use.runs_against ? 1 - share : share;
}

// A place of the edge: shares of it at which uses have knots that mean the same.
struct Break {
  double first, last;
};

// Where knots of any use lie, with both ends of the edge, and as many as make `least_pieces` at least.
std::vector<Break> breaks_of(std::span<const SeamCurve> uses, int least_pieces) {
  std::vector<double> shares;
  for (int i = 0; i <= least_pieces; ++i) shares.push_back(static_cast<double>(i) / least_pieces);
  for (const SeamCurve& use : uses) {
    for (const double knot : use.curve->knots) {
      const double share = share_of(use, knot);
      if (share > 0 && share < 1) shares.push_back(share);
    }
  }
  std::sort(shares.begin(), shares.end());
  std::vector<Break> breaks;
  for (const double share : shares) {
    if (breaks.empty() || share > breaks.back().last + k_same_share) {
      breaks.push_back({share, share});
    } else {
      breaks.back().last = share;
    }
  }
  return breaks;
}

double parameter_at(const SeamCurve& use, double share) {
  if (use.runs_against) share = 1 - share;
  return share >= 1 ? use.range.end : use.range.begin + share * use.range.length();
}

// The parameter at a place, where a piece starts there or ends: of its last knot or its first, so that none
// lies within the piece.
double parameter_at(const SeamCurve& use, const Break& place, bool is_start) {
  const std::vector<double>& knots = use.curve->knots;
  const double margin = (place.last - place.first + k_same_share) * use.range.length();
  const double middle = parameter_at(use, place.first);
  double best = is_start ? -1 : 2, result = middle;
  for (auto knot = std::lower_bound(knots.begin(), knots.end(), middle - margin);
       knot != knots.end() && *knot <= middle + margin; ++knot) {
    const double share = share_of(use, *knot);
    if (share < place.first || share > place.last) continue;
    if (is_start ? share > best : share < best) {
      best = share;
      result = *knot;
    }
  }
  return result;
}

CurveNet net_between(const SeamCurve& use, double from, double to) {
  const NurbsCurve2 piece =
      part(*use.curve, use.runs_against ? ParameterRange{to, from} : ParameterRange{from, to});
  CurveNet net;
  for (std::size_t i = 0; i < piece.points.size(); ++i) {
    const double weight = piece.is_rational() ? piece.weights[i] : 1.0;
    net.emplace_back(weight * piece.points[i].x(), weight * piece.points[i].y(), weight);
  }
  if (use.runs_against) std::reverse(net.begin(), net.end());
  return net;
}

std::array<CurveNet, 2> divided(const CurveNet& net, double at) {
  CurveNet left = net, right = net;
  for (std::size_t round = 1; round < net.size(); ++round) {
    for (std::size_t i = 0; i + round < net.size(); ++i) right[i] = (1 - at) * right[i] + at * right[i + 1];
    left[round] = right[0];
  }
  return {left, right};
}

double flat_width(const BezierPatches& plane, std::span<const Vec2> points, const Vec2& from,
                  const Vec2& to) {
  const Vec3 start = plane.evaluate(from), end = plane.evaluate(to);
  double widest = 0;
  for (const Vec2& point : points) {
    const Vec3 there = plane.evaluate(point);
    widest = std::max(widest, (there - closest_point_on_segment(there, start, end)).norm());
  }
  return widest;
}

double bounded_width(const DerivativeBounds& most, std::span<const Vec2> points, const Vec2& from,
                     const Vec2& to) {
  const Vec2 scale(most.u, most.v);
  const Vec2 chord = (to - from).cwiseProduct(scale);
  const double squared = chord.squaredNorm();
  double widest = 0;
  for (const Vec2& point : points) {
    const Vec2 away = (point - from).cwiseProduct(scale);
    const double share = squared > 0 ? std::clamp(away.dot(chord) / squared, 0.0, 1.0) : 0.0;
    widest = std::max(widest, (away - share * chord).lpNorm<1>());
  }
  return widest;
}

// The distance from a chord is convex, and nothing at its ends: a curve is nearer than its control points by
// the largest share that those between the ends have in a point of it.
double curve_share(const CurveNet& net) {
  const double of_ends = std::exp2(2.0 - static_cast<double>(net.size()));  // without weights, at least
  double least_end = std::min(net.front().z(), net.back().z()), most_between = 0;
  for (std::size_t i = 1; i + 1 < net.size(); ++i) most_between = std::max(most_between, net[i].z());
  const double between = most_between * (1 - of_ends), ends = least_end * of_ends;
  return between / (between + ends);
}

// Of the strip between a curve and the chord of its ends.
double curve_width(const PatchSurface& surface, const CurveNet& net) {
  std::vector<Vec2> points;
  for (const Vec3& point : net) points.push_back(projected(point));
  return curve_share(net) * strip_width(surface, points, points.front(), points.back());
}

class EdgeSampler {
 public:
  EdgeSampler(std::span<const SeamCurve> uses, double tolerance)
      : uses_(uses), tolerance_(tolerance), result_(uses.size()) {}

  std::vector<SampledUse> run(int least_pieces) {
    const std::vector<Break> breaks = breaks_of(uses_, least_pieces);
    for (std::size_t k = 0; k < uses_.size(); ++k) {
      result_[k].parameters.push_back(parameter_at(uses_[k], 0));
      result_[k].uvs.push_back(evaluate(*uses_[k].curve, result_[k].parameters[0]));
    }
    for (std::size_t i = 0; i + 1 < breaks.size(); ++i) {
      Nets nets;
      for (const SeamCurve& use : uses_) {
        nets.push_back(
            net_between(use, parameter_at(use, breaks[i], true), parameter_at(use, breaks[i + 1], false)));
      }
      const double begin = i > 0 ? breaks[i].first : 0, end = i + 2 < breaks.size() ? breaks[i + 1].first : 1;
      for (const Chord& chord : chords_of(nets, {begin, end}, k_most_halvings)) add(chord);
    }
    return std::move(result_);
  }

 private:
  using Nets = std::vector<CurveNet>;  // of a piece of the edge, by use

  struct Chord {
    double end;  // as share of the edge
    double error = 0;
    std::vector<Vec2> ends;      // by use
    std::vector<double> widths;  // by use
  };

  Chord chord_of(const Nets& nets, double end) const {
    Chord chord{end, 0, {}, {}};
    for (std::size_t k = 0; k < uses_.size(); ++k) {
      const PatchSurface& surface = *uses_[k].surface;
      const double width = curve_width(surface, nets[k]);
      chord.ends.push_back(projected(nets[k].back()));
      chord.widths.push_back(width);
      const double deviation = surface.bounds.deviation(projected(nets[k].front()), chord.ends.back());
      chord.error = std::max(chord.error, seam_error(surface.bend, width, deviation));
    }
    return chord;
  }

  // The fewest of equal parts of a piece, or of those of its halves.
  std::vector<Chord> chords_of(const Nets& nets, const ParameterRange& shares, int halvings_left) const {
    const Chord whole = chord_of(nets, shares.end);
    if (whole.error <= tolerance_ || halvings_left == 0) return {whole};
    const auto [left, right] = divided_all(nets, 0.5);
    const double middle = (shares.begin + shares.end) / 2;
    std::vector<Chord> chords = chords_of(left, {shares.begin, middle}, halvings_left - 1);
    const std::vector<Chord> others = chords_of(right, {middle, shares.end}, halvings_left - 1);
    chords.insert(chords.end(), others.begin(), others.end());
    for (std::size_t n = fewest_parts(whole.error); n < chords.size();) {
      const std::size_t tried = (n + chords.size()) / 2;
      std::vector<Chord> parts = equal_parts(nets, shares, tried);
      if (parts.empty()) {
        n = tried + 1;
      } else {
        chords = std::move(parts);
      }
    }
    return chords;
  }

  // Errors grow with squares of lengths, but not alike everywhere.
  std::size_t fewest_parts(double error) const {
    constexpr double k_for_unlike = 0.75;
    const double parts = k_for_unlike * std::sqrt(error / tolerance_);
    return parts < 3 ? 3 : static_cast<std::size_t>(std::min(parts, 1e6));
  }

  // None where one of them isn't good enough.
  std::vector<Chord> equal_parts(const Nets& nets, const ParameterRange& shares, std::size_t n) const {
    std::vector<Chord> parts;
    Nets rest = nets;
    for (std::size_t i = 1; i <= n; ++i) {
      const double end =
          i < n ? shares.begin + shares.length() * static_cast<double>(i) / static_cast<double>(n)
                : shares.end;
      Nets part = rest;
      if (i < n) std::tie(part, rest) = divided_all(rest, 1.0 / static_cast<double>(n - i + 1));
      parts.push_back(chord_of(part, end));
      if (!(parts.back().error <= tolerance_)) return {};
    }
    return parts;
  }

  static std::pair<Nets, Nets> divided_all(const Nets& nets, double at) {
    std::pair<Nets, Nets> both;
    for (const CurveNet& net : nets) {
      std::array<CurveNet, 2> parts = divided(net, at);
      both.first.push_back(std::move(parts[0]));
      both.second.push_back(std::move(parts[1]));
    }
    return both;
  }

  void add(const Chord& chord) {
    for (std::size_t k = 0; k < uses_.size(); ++k) {
      result_[k].parameters.push_back(parameter_at(uses_[k], chord.end));
      result_[k].uvs.push_back(chord.ends[k]);
      result_[k].widths.push_back(chord.widths[k]);
    }
  }

  std::span<const SeamCurve> uses_;
  double tolerance_;
  std::vector<SampledUse> result_;
};

SampledUse sampled_at(const SeamCurve& use, std::span<const double> shares) {
  SampledUse result;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    result.parameters.push_back(parameter_at(use, shares[i]));
    result.uvs.push_back(evaluate(*use.curve, result.parameters.back()));
    if (i == 0) continue;
    result.widths.push_back(
        curve_width(*use.surface, net_between(use, result.parameters[i - 1], result.parameters[i])));
  }
  return result;
}

}  // namespace

double seam_error(SurfaceBend bend, double strip, double deviation) {
  const double share = bend == SurfaceBend::none      ? k_share_of_all
                       : bend == SurfaceBend::one_way ? k_share_of_straight
                                                      : k_share_of_curved;
  return std::max((strip + deviation) / k_share_of_all, deviation / share);
}

std::vector<SampledUse> sample_edge(std::span<const SeamCurve> uses, double tolerance, int least_pieces) {
  return EdgeSampler(uses, tolerance).run(least_pieces);
}

Polyline polyline_of(const SeamCurve& use, double tolerance, int least_pieces) {
  const SampledUse sampled = sample_edge({&use, 1}, tolerance, least_pieces).front();
  Polyline line{sampled.parameters, {}};
  for (const Vec2& uv : sampled.uvs) line.points.push_back(use.surface->shape.evaluate(uv));
  return line;
}

Foot foot_on(const Polyline& line, const Vec3& point) {
  Foot foot;
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    const Vec3 along = line.points[i + 1] - line.points[i], to = point - line.points[i];
    const double squared = along.squaredNorm();
    const double share = squared > 0 ? std::clamp(to.dot(along) / squared, 0.0, 1.0) : 0.0;
    const double distance = (to - share * along).norm();
    if (distance < foot.distance)
      foot = {distance, line.parameters[i] + share * (line.parameters[i + 1] - line.parameters[i])};
  }
  return foot;
}

double nearest_parameter(const SeamCurve& use, double t, const Vec3& point) {
  for (int step = 0; step < 4; ++step) {
    const CurveDerivatives<2> at = derivatives(*use.curve, t);
    const SurfaceDerivatives there = use.surface->shape.derivatives(at.point);
    const Vec3 along = at.first.x() * there.du + at.first.y() * there.dv;
    const double squared = along.squaredNorm();
    if (!(squared > 0)) break;
    t = std::clamp(t + (point - there.point).dot(along) / squared, use.range.begin, use.range.end);
  }
  return t;
}

std::vector<SampledUse> sample_matched_edge(std::span<const SeamCurve> uses, double tolerance, double gap,
                                            int least_pieces) {
  // Points of one use fall a little beside those of another, which makes some pieces longer.
  constexpr double k_for_shifts = 0.7;
  std::vector<Polyline> lines;
  for (const SeamCurve& use : uses) lines.push_back(polyline_of(use, k_for_shifts * tolerance, least_pieces));
  // Places on the first use, in its direction, as shares of it.
  const SeamCurve& leader = uses.front();
  std::vector<double> places;
  for (std::size_t k = 0; k < uses.size(); ++k) {
    for (std::size_t i = 1; i + 1 < lines[k].points.size(); ++i) {
      const double t = k == 0 ? lines[0].parameters[i] : foot_on(lines[0], lines[k].points[i]).parameter;
      places.push_back(share_of(leader, t));
    }
  }
  std::sort(places.begin(), places.end());
  // The places as shares of each use, without those that would turn back on one of them.
  std::vector<std::vector<double>> shares(uses.size(), {0.0});
  Vec3 last = lines[0].points.front();
  for (const double place : places) {
    const Vec3 point = leader.surface->shape.evaluate(evaluate(*leader.curve, parameter_at(leader, place)));
    if ((point - last).norm() <= gap / 2 || (point - lines[0].points.back()).norm() <= gap / 2) continue;
    std::vector<double> here(uses.size(), place);
    bool moves_on = place > shares[0].back();
    for (std::size_t k = 1; k < uses.size() && moves_on; ++k) {
      const double t = nearest_parameter(uses[k], foot_on(lines[k], point).parameter, point);
      here[k] = share_of(uses[k], t);
      constexpr double k_least_step = 1e-9;
      moves_on = here[k] > shares[k].back() + k_least_step && here[k] < 1 - k_least_step;
    }
    if (!moves_on) continue;
    for (std::size_t k = 0; k < uses.size(); ++k) shares[k].push_back(here[k]);
    last = point;
  }
  std::vector<SampledUse> result(uses.size());
  for (std::size_t k = 0; k < uses.size(); ++k) {
    shares[k].push_back(1);
    result[k] = sampled_at(uses[k], shares[k]);
  }
  return result;
}

double strip_width(const PatchSurface& surface, std::span<const Vec2> points, const Vec2& from,
                   const Vec2& to) {
  ParameterBox around;
  around.extend(from);
  around.extend(to);
  const ParameterBox chord_box = around;
  for (const Vec2& point : points) around.extend(point);
  // On the chord already: parallel to an axis.
  if (around.contains(chord_box) && chord_box.contains(around) && (around.sizes().array() == 0).any())
    return 0;
  return surface.bend == SurfaceBend::none
             ? flat_width(surface.shape, points, from, to)
             : bounded_width(surface.bounds.derivatives(around), points, from, to);
}

}  // namespace recede::detail
