#include <recede/geometry/detail/net_enclosure.h>
#include <recede/geometry/error.h>
#include <recede/geometry/nurbs_closest_point.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace recede {

namespace {

using detail::BezierNet;

constexpr double k_missed = 1e-10;    // of the surface's size: a nearer point isn't looked for
constexpr double k_rounding = 1e-14;  // of coordinates and distances, through some hundred operations

std::vector<double> binomials(std::size_t n) {
  std::vector<double> choose(n + 1, 1.0);
  for (std::size_t k = 1; k <= n; ++k)
    choose[k] = choose[k - 1] * static_cast<double>(n + 1 - k) / static_cast<double>(k);
  return choose;
}

// Squared distances of a piece of the surface from a point.
struct SquaredDistances {
  double least = 0;               // at most any of them
  std::array<double, 2> bends{};  // how much coefficients leave straight lines along u and along v
  Vec2 where = Vec2::Zero();      // of the least coefficient, shares of the piece
};

// Products of nets have twice their degrees. The tables are those of one surface.
class DistanceNets {
 public:
  explicit DistanceNets(const std::array<int, 2>& degrees) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      of_net_[axis] = binomials(static_cast<std::size_t>(degrees[axis]));
      of_product_[axis] = binomials(2 * static_cast<std::size_t>(degrees[axis]));
    }
  }

  /// `rounding` is that of coordinates.
  SquaredDistances bound(const BezierNet& net, const Vec3& point, double rounding) {
    const std::size_t n_u = of_product_[0].size(), n_v = of_product_[1].size();
    const double farthest = multiply(net, point);
    SquaredDistances result;
    result.least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < n_u * n_v; ++k) {
      if (!(quotients_[k] < result.least)) continue;
      result.least = quotients_[k];
      result.where = Vec2(static_cast<double>(k / n_v) / static_cast<double>(n_u - 1),
                          static_cast<double>(k % n_v) / static_cast<double>(n_v - 1));
    }
    result.least = std::max(result.least - farthest * (k_rounding * farthest + rounding), 0.0);
    for (std::size_t i = 0; i < n_u; ++i) {
      for (std::size_t j = 0; j < n_v; ++j) {
        if (i + 2 < n_u) result.bends[0] = std::max(result.bends[0], bend(i * n_v + j, n_v));
        if (j + 2 < n_v) result.bends[1] = std::max(result.bends[1], bend(i * n_v + j, 1));
      }
    }
    return result;
  }

 private:
  // Weights are positive, so that all quotients of sums lie between those of coefficients. Returns how far
  // control points are at most.
  double multiply(const BezierNet& net, const Vec3& point) {
    const std::size_t p = net.degrees[0], q = net.degrees[1], n_v = 2 * q + 1;
    double farthest = 0;
    scaled_.resize((p + 1) * (q + 1));
    for (std::size_t i = 0; i <= p; ++i) {
      for (std::size_t j = 0; j <= q; ++j) {
        Vec4 from = net.at(i, j);
        from.head<3>() -= from.w() * point;
        farthest = std::max(farthest, from.head<3>().norm() / from.w());
        scaled_[i * (q + 1) + j] = of_net_[0][i] * of_net_[1][j] * from;
      }
    }
    squares_.assign((2 * p + 1) * n_v, 0.0);
    weights_.assign((2 * p + 1) * n_v, 0.0);
    for (std::size_t a = 0; a < scaled_.size(); ++a) {
      const Vec4& x = scaled_[a];
      for (std::size_t b = a; b < scaled_.size(); ++b) {
        const Vec4& y = scaled_[b];
        const std::size_t k = (a / (q + 1) + b / (q + 1)) * n_v + a % (q + 1) + b % (q + 1);
        const double times = a == b ? 1 : 2;
        squares_[k] += times * x.head<3>().dot(y.head<3>());
        weights_[k] += times * x.w() * y.w();
      }
    }
    quotients_.resize(squares_.size());
    for (std::size_t k = 0; k < squares_.size(); ++k) quotients_[k] = squares_[k] / weights_[k];
    return farthest;
  }

  double bend(std::size_t k, std::size_t step) const {
    return std::abs(quotients_[k] - 2 * quotients_[k + step] + quotients_[k + 2 * step]);
  }

  std::array<std::vector<double>, 2> of_net_, of_product_;
  std::vector<Vec4> scaled_;
  std::vector<double> squares_, weights_, quotients_;
};

// The part of a net between two parameters along an axis, by de Casteljau's algorithm at both of them.
void clip(BezierNet& net, std::size_t axis, double from, double to) {
  const auto along = static_cast<int>(axis);
  const std::size_t degree = net.degrees[axis], step = axis == 0 ? net.degrees[1] + 1 : 1,
                    row_step = axis == 0 ? 1 : net.degrees[1] + 1;
  const double begin = net.part.min()[along], width = net.part.sizes()[along];
  const double first = (from - begin) / width, last = (to - begin) / width;
  const auto each_row = [&](auto&& change) {
    for (std::size_t row = 0; row <= net.degrees[1 - axis]; ++row) change(net.points.data() + row * row_step);
  };
  if (last < 1) {
    each_row([&](Vec4* points) {
      for (std::size_t round = 1; round <= degree; ++round) {
        for (std::size_t i = degree; i >= round; --i)
          points[i * step] = (1 - last) * points[(i - 1) * step] + last * points[i * step];
      }
    });
  }
  if (first > 0) {
    const double share = last > 0 ? std::min(first / std::min(last, 1.0), 1.0) : 0.0;
    each_row([&](Vec4* points) {
      for (std::size_t round = 1; round <= degree; ++round) {
        for (std::size_t i = 0; i + round <= degree; ++i)
          points[i * step] = (1 - share) * points[i * step] + share * points[(i + 1) * step];
      }
    });
  }
  net.part.min()[along] = from;
  net.part.max()[along] = to;
}

// Newton's method within a rectangle, down to where steps are rounding.
class Polish {
 public:
  Polish(const BezierPatches& surface, const ParameterBox& part, const Vec3& point)
      : surface_(surface), part_(part), point_(point) {}

  NearestOnSurface from(const Vec2& start) const {
    State now = at(start);
    constexpr int k_most_steps = 60;
    for (int step = 0; step < k_most_steps; ++step) {
      const Vec2 move = newton_move(now);
      if (move.isZero(0) || !advance(now, move)) break;
    }
    return {now.uv, now.here.point, std::sqrt(now.squared)};
  }

 private:
  struct State {
    Vec2 uv;
    SurfaceDerivatives here;
    Vec3 from;  // the point to the surface
    double squared;
    Vec2 slope;  // half of the squared distance's; 0 along an axis where the border holds it
  };

  State at(const Vec2& uv) const {
    State state;
    state.uv = uv;
    state.here = surface_.derivatives(uv);
    state.from = state.here.point - point_;
    state.squared = state.from.squaredNorm();
    state.slope = Vec2(state.from.dot(state.here.du), state.from.dot(state.here.dv));
    for (int axis = 0; axis < 2; ++axis) {
      const bool is_low = uv[axis] <= part_.min()[axis], is_high = uv[axis] >= part_.max()[axis];
      if ((is_low && state.slope[axis] >= 0) || (is_high && state.slope[axis] <= 0)) state.slope[axis] = 0;
    }
    return state;
  }

  // Of Newton where the squared distance is convex, of Gauss and Newton where it isn't.
  Vec2 newton_move(const State& now) const {
    const SurfaceDerivatives& here = now.here;
    const Vec2 squares(here.du.squaredNorm(), here.dv.squaredNorm());
    const double cross = here.du.dot(here.dv);
    const Vec2 bent(squares.x() + now.from.dot(here.duu), squares.y() + now.from.dot(here.dvv));
    const double bent_cross = cross + now.from.dot(here.duv);
    const bool u_is_free = now.slope.x() != 0, v_is_free = now.slope.y() != 0;
    if (u_is_free && v_is_free) {
      if (const double area = bent.x() * bent.y() - bent_cross * bent_cross; bent.x() > 0 && area > 0)
        return solved(now.slope, bent, bent_cross, area);
      constexpr double k_parallel = 1e-12;
      const double area = squares.x() * squares.y() - cross * cross;
      if (area > k_parallel * squares.x() * squares.y()) return solved(now.slope, squares, cross, area);
    }
    Vec2 move = Vec2::Zero();
    for (int axis = 0; axis < 2; ++axis) {
      const double steepness = bent[axis] > 0 ? bent[axis] : squares[axis];
      if (now.slope[axis] != 0 && steepness > 0) move[axis] = -now.slope[axis] / steepness;
    }
    return move;
  }

  static Vec2 solved(const Vec2& slope, const Vec2& diagonal, double cross, double area) {
    return Vec2(cross * slope.y() - diagonal.y() * slope.x(), cross * slope.x() - diagonal.x() * slope.y()) /
           area;
  }

  // Shorter and shorter until it is nearer, or as near as rounding can tell and flatter.
  bool advance(State& now, const Vec2& move) const {
    constexpr double k_as_near = 4e-16;
    for (double share = 1; share > 1e-6; share /= 4) {
      const Vec2 uv = (now.uv + share * move).cwiseMax(part_.min()).cwiseMin(part_.max());
      if (uv == now.uv) return false;
      const State next = at(uv);
      const bool is_flatter = share == 1 && next.slope.cwiseAbs2().sum() < 0.25 * now.slope.squaredNorm();
      if (next.squared < now.squared || (is_flatter && next.squared <= now.squared * (1 + k_as_near))) {
        now = next;
        return true;
      }
    }
    return false;
  }

  const BezierPatches& surface_;
  const ParameterBox& part_;
  const Vec3& point_;
};

// A piece in the queue. Those of whole Bezier patches have a box only until they are looked at.
struct Piece {
  double least;        // squared distance
  std::size_t number;  // in the order in which they came: equal ones are taken in that order
  std::array<std::size_t, 2> patch{};
  std::optional<BezierNet> net;
  SquaredDistances distances{};

  bool operator<(const Piece& other) const {
    return least != other.least ? least > other.least : number > other.number;
  }
};

class Search {
 public:
  struct Slack {
    double missed;    // a nearer point isn't looked for
    double rounding;  // of coordinates
  };

  Search(const BezierPatches& surface, const ParameterBox& part, const Vec3& point, const Slack& slack)
      : surface_(surface),
        part_(part),
        point_(point),
        slack_(slack),
        nets_(surface.degrees()),
        polish_(surface, part, point) {
    best_.distance = std::numeric_limits<double>::infinity();
  }

  // Looks at a patch at once; what it finds spares others.
  void start(const std::array<std::size_t, 2>& patch, double least) { look_at(patch_net(patch), least); }

  void add(const std::array<std::size_t, 2>& patch, double least) {
    if (may_be_nearer(least)) queue_.push({least, n_pieces_++, patch, {}});
  }

  NearestOnSurface run() {
    while (!queue_.empty()) {
      Piece piece = queue_.top();
      queue_.pop();
      if (!may_be_nearer(piece.least)) break;
      if (!piece.net) {
        look_at(patch_net(piece.patch), piece.least);
        continue;
      }
      const std::size_t axis = axis_to_halve(piece);
      const auto along = static_cast<int>(axis);
      const double middle = piece.net->part.center()[along];
      // As short as numbers allow, and a place of it was tried.
      if (!(piece.net->part.min()[along] < middle && middle < piece.net->part.max()[along])) continue;
      for (BezierNet& half : halves(*piece.net, axis)) look_at(std::move(half), piece.least);
    }
    return best_;
  }

 private:
  bool may_be_nearer(double least) const {
    const double enough = std::max(best_.distance - slack_.missed, 0.0);
    return least < enough * enough;
  }

  BezierNet patch_net(const std::array<std::size_t, 2>& patch) const {
    const std::array<int, 2> degrees = surface_.degrees();
    const std::span<const double> u = surface_.breaks(0), v = surface_.breaks(1);
    BezierNet net{{static_cast<std::size_t>(degrees[0]), static_cast<std::size_t>(degrees[1])},
                  surface_.is_rational(),
                  {Vec2(u[patch[0]], v[patch[1]]), Vec2(u[patch[0] + 1], v[patch[1] + 1])},
                  surface_.net(patch[0], patch[1])};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto along = static_cast<int>(axis);
      const double from = std::max(net.part.min()[along], part_.min()[along]);
      const double to = std::min(net.part.max()[along], part_.max()[along]);
      if (from > net.part.min()[along] || to < net.part.max()[along]) clip(net, axis, from, to);
    }
    return net;
  }

  // Tries where the piece seems nearest, and keeps it while something nearer may be there.
  void look_at(BezierNet net, double least) {
    Piece piece{least, n_pieces_++, {}, {}, nets_.bound(net, point_, slack_.rounding)};
    piece.least = std::max(least, piece.distances.least);
    if (!may_be_nearer(piece.least)) return;
    const Vec2 seems_nearest = net.part.min() + piece.distances.where.cwiseProduct(net.part.sizes());
    const Vec2 uv = seems_nearest.cwiseMin(net.part.max());
    const double distance = (surface_.evaluate(uv) - point_).norm();
    // Far from a valley's ground others lead there as well.
    if (distance < best_.distance) {
      const NearestOnSurface found = polish_.from(uv);
      if (found.distance < best_.distance) best_ = found;
    }
    if (!may_be_nearer(piece.least)) return;
    piece.net = std::move(net);
    queue_.push(std::move(piece));
  }

  static std::size_t axis_to_halve(const Piece& piece) {
    const Vec2 sizes = piece.net->part.sizes();
    if (!(sizes.y() > 0)) return 0;
    if (!(sizes.x() > 0)) return 1;
    return piece.distances.bends[0] >= piece.distances.bends[1] ? 0 : 1;
  }

  const BezierPatches& surface_;
  const ParameterBox& part_;
  const Vec3& point_;
  Slack slack_;
  DistanceNets nets_;
  Polish polish_;
  std::priority_queue<Piece> queue_;
  std::size_t n_pieces_ = 0;
  NearestOnSurface best_;
};

ParameterBox part_of_domain(const ParameterBox& domain, const std::optional<ParameterBox>& part) {
  if (!part) return domain;
  const ParameterBox inside = domain.intersection(*part);
  const bool is_there = (inside.min().array() <= inside.max().array()).all();
  if (!is_there || part->min().hasNaN() || part->max().hasNaN())
    throw OptionError("the part of a surface to search lies outside of its domain");
  return inside;
}

// A surface whose other parameter changes nothing.
template <int Dimension>
NurbsSurface swept(const NurbsCurve<Dimension>& curve) {
  NurbsSurface surface{{curve.degree, 1}, {curve.knots, {0, 0, 1, 1}}, {}, {}};
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    Vec3 point = Vec3::Zero();
    point.template head<Dimension>() = curve.points[i];
    surface.points.insert(surface.points.end(), 2, point);
    if (curve.is_rational()) surface.weights.insert(surface.weights.end(), 2, curve.weights[i]);
  }
  return surface;
}

}  // namespace

NearestOnSurfaceSearch::NearestOnSurfaceSearch(const NurbsSurface& surface) : patches_(surface) {
  Box3 all;
  for (std::size_t i = 0; i < patches_.n_patches(0); ++i) {
    for (std::size_t j = 0; j < patches_.n_patches(1); ++j) {
      Box3& box = boxes_.emplace_back();
      for (const Vec4& point : patches_.net(i, j)) box.extend(Vec3(point.head<3>() / point.w()));
      all.extend(box);
    }
  }
  size_ = all.diagonal().norm();
  rounding_ = k_rounding * std::max(all.min().cwiseAbs().maxCoeff(), all.max().cwiseAbs().maxCoeff());
}

NearestOnSurface NearestOnSurfaceSearch::closest(const Vec3& point,
                                                 const std::optional<ParameterBox>& part) const {
  if (!point.allFinite()) throw OptionError("the point to find the nearest one for isn't finite");
  const ParameterBox inside = part_of_domain(patches_.domain(), part);
  Box3 all;
  for (const Box3& box : boxes_) all.extend(box);
  const double missed = k_missed * size_ + 10 * (rounding_ + k_rounding * all.exteriorDistance(point));
  Search search(patches_, inside, point, {missed, rounding_});
  const std::span<const double> u = patches_.breaks(0), v = patches_.breaks(1);
  const auto each_patch = [&](auto&& visit) {
    for (std::size_t i = 0; i + 1 < u.size(); ++i) {
      if (u[i] > inside.max().x() || u[i + 1] < inside.min().x()) continue;
      for (std::size_t j = 0; j + 1 < v.size(); ++j) {
        if (v[j] > inside.max().y() || v[j + 1] < inside.min().y()) continue;
        const Box3& box = boxes_[i * patches_.n_patches(1) + j];
        visit(std::array<std::size_t, 2>{i, j}, box.squaredExteriorDistance(point));
      }
    }
  };
  std::array<std::size_t, 2> first{};
  double least_of_all = std::numeric_limits<double>::infinity();
  each_patch([&](const std::array<std::size_t, 2>& patch, double least) {
    if (!(least < least_of_all)) return;
    first = patch;
    least_of_all = least;
  });
  search.start(first, least_of_all);
  each_patch([&](const std::array<std::size_t, 2>& patch, double least) {
    if (patch != first) search.add(patch, least);
  });
  return search.run();
}

NearestOnSurface closest_point(const NurbsSurface& surface, const Vec3& point,
                               const std::optional<ParameterBox>& part) {
  return NearestOnSurfaceSearch(surface).closest(point, part);
}

template <int Dimension>
NearestOnCurve<Dimension> closest_point(const NurbsCurve<Dimension>& curve,
                                        const Eigen::Matrix<double, Dimension, 1>& point,
                                        const std::optional<ParameterRange>& part) {
  validate(curve, "curve");
  const ParameterRange range = part.value_or(curve.domain());
  Vec3 in_space = Vec3::Zero();
  in_space.template head<Dimension>() = point;
  const NearestOnSurface nearest =
      closest_point(swept(curve), in_space, ParameterBox(Vec2(range.begin, 0), Vec2(range.end, 0)));
  return {nearest.uv.x(), nearest.point.template head<Dimension>(), nearest.distance};
}

template NearestOnCurve<2> closest_point(const NurbsCurve<2>&, const Vec2&,
                                         const std::optional<ParameterRange>&);
template NearestOnCurve<3> closest_point(const NurbsCurve<3>&, const Vec3&,
                                         const std::optional<ParameterRange>&);

}  // namespace recede
