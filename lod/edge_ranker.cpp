#include <recede/lod/detail/edge_ranker.h>
#include <recede/lod/detail/volume_cost.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <array>

namespace recede::detail {
namespace {

/// Pull towards the middle of the edge where the triangles leave the place open, as a share of their weight:
/// more than for exact places, because of single precision.
constexpr float k_rank_regularization = 1e-5f;

using Lanes = Eigen::Array<float, EdgeRanker::k_lanes, 1>;
using Matrices = SymmetricMatrix<Lanes>;

/// Three numbers for each edge.
struct Vectors {
  Lanes x, y, z;
};

EIGEN_STRONG_INLINE Lanes dot(const Vectors& a, const Vectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
EIGEN_STRONG_INLINE Vectors operator+(const Vectors& a, const Vectors& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
EIGEN_STRONG_INLINE Vectors operator-(const Vectors& a, const Vectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
EIGEN_STRONG_INLINE Vectors operator*(const Lanes& s, const Vectors& v) {
  return {s * v.x, s * v.y, s * v.z};
}
EIGEN_STRONG_INLINE Vectors operator*(const Matrices& m, const Vectors& v) {
  return {m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
          m.xz * v.x + m.yz * v.y + m.zz * v.z};
}
EIGEN_STRONG_INLINE Matrices operator+(const Matrices& a, const Matrices& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.xz + b.xz, a.yy + b.yy, a.yz + b.yz, a.zz + b.zz};
}
EIGEN_STRONG_INLINE Matrices operator-(const Matrices& a, const Matrices& b) {
  return {a.xx - b.xx, a.xy - b.xy, a.xz - b.xz, a.yy - b.yy, a.yz - b.yz, a.zz - b.zz};
}
EIGEN_STRONG_INLINE Matrices operator*(const Lanes& s, const Matrices& m) {
  return {s * m.xx, s * m.xy, s * m.xz, s * m.yy, s * m.yz, s * m.zz};
}
EIGEN_STRONG_INLINE Lanes trace(const Matrices& m) { return m.xx + m.yy + m.zz; }

/// The inverse times the determinant.
EIGEN_STRONG_INLINE Matrices adjugate(const Matrices& m) {
  return {m.yy * m.zz - m.yz * m.yz, m.xz * m.yz - m.xy * m.zz, m.xy * m.yz - m.xz * m.yy,
          m.xx * m.zz - m.xz * m.xz, m.xy * m.xz - m.xx * m.yz, m.xx * m.yy - m.xy * m.xy};
}

/// Matrices and sums of normals of one end of each edge.
struct Ends {
  Matrices squares;
  Vectors sum;

  void set(Eigen::Index lane, const PointMatrix& m) {
    squares.xx[lane] = m.squares.xx;
    squares.xy[lane] = m.squares.xy;
    squares.xz[lane] = m.squares.xz;
    squares.yy[lane] = m.squares.yy;
    squares.yz[lane] = m.squares.yz;
    squares.zz[lane] = m.squares.zz;
    sum.x[lane] = m.sum.x();
    sum.y[lane] = m.sum.y();
    sum.z[lane] = m.sum.z();
  }
};

/// Costs as quadratic forms of the place: x.matrix x - 2 pull.x + constant, relative to the middle of the
/// edge and in units of the weight.
struct Forms {
  Matrices matrix;
  Vectors pull;
  Lanes constant;

  EIGEN_STRONG_INLINE Lanes at(const Vectors& x) const {
    return dot(x, matrix * x) - 2 * dot(pull, x) + constant;
  }
};

/// Where the forms are least among the places that keep the volume, which `normal`.x = `volume` says.
EIGEN_STRONG_INLINE Vectors best_places(const Forms& forms, const Vectors& normal, const Lanes& volume,
                                        Lanes& determinant) {
  Matrices regular = forms.matrix;
  regular.xx += k_rank_regularization;
  regular.yy += k_rank_regularization;
  regular.zz += k_rank_regularization;
  const Matrices inverse = adjugate(regular);
  determinant = regular.xx * inverse.xx + regular.xy * inverse.xy + regular.xz * inverse.xz;
  const Vectors place = determinant.inverse() * (inverse * forms.pull);
  const Vectors way = inverse * normal;
  const Lanes slope = dot(normal, way);
  const Lanes step = (volume - dot(normal, place)) / slope;
  return place + (slope > 0).select(step, 0.0f) * way;
}

}  // namespace

void EdgeRanker::start(double scale) {
  scale_ = scale;
  matrices_.resize(table_.n_points());
  if (!table_.has_polygons) measure_normals();
  if (!channels_.empty()) sums_.resize(table_.n_points() * channels_.rank_stride());
}

/// Twice the vector area of the triangle at a corner.
Eigen::Vector3f EdgeRanker::corner_normal(Index corner) const {
  const Vec3& at = table_.positions[table_.point[corner]];
  const Vec3 after = scale_ * (table_.positions[table_.point_after(corner)] - at),
             before = scale_ * (table_.positions[table_.point_before(corner)] - at);
  return after.cross(before).cast<float>();
}

void EdgeRanker::measure_normals() {
  normals_.resize(table_.n_faces());
  tbb::parallel_for(tbb::blocked_range<Index>(0, static_cast<Index>(table_.n_faces()), 4096),
                    [&](const auto& range) {
                      for (Index f = range.begin(); f < range.end(); ++f) normals_[f] = corner_normal(3 * f);
                    });
}

PointMatrix EdgeRanker::point_matrix(Index point) const {
  PointMatrix m;
  for (Index i = table_.ring_start[point]; i < table_.ring_start[point + 1]; ++i) {
    const Index corner = table_.ring[i];
    const Eigen::Vector3f n = table_.has_polygons ? corner_normal(corner) : normals_[corner / 3];
    add_square(m.squares, n);
    m.sum += n;
  }
  return m;
}

void EdgeRanker::prepare(Index first, Index last) {
  std::vector<double> scratch;
  for (Index p = first; p < last; ++p) {
    matrices_[p] = point_matrix(p);
    if (channels_.empty() || table_.classes[p] != PointClass::smooth) continue;
    add_rank_sums(table_, channels_, p, scale_, matrices_[p], sums_.data() + p * channels_.rank_stride(),
                  scratch);
  }
}

namespace {

/// The part of the attributes: for each channel the squared differences from the value that is best at x, of
/// which `add_rank_sums` added the squares of slopes to the matrices. `number(end, i)` gives the i-th number
/// of an end.
template <typename Number>
void add_attributes(std::size_t n_numbers, Number&& number, const Vectors& half, const Lanes& unit,
                    Forms& forms) {
  const Lanes weight_a = number(0, 0), weight_b = number(1, 0);
  const Lanes weight = weight_a + weight_b;
  const Lanes share = (weight > 0).select(-unit / weight, 0.0f);
  const Lanes counted = (weight > 0).select(unit, 0.0f);
  for (std::size_t i = 1; i < n_numbers; i += 4) {
    const Vectors at_a{number(0, i + 1), number(0, i + 2), number(0, i + 3)},
        at_b{number(1, i + 1), number(1, i + 2), number(1, i + 3)};
    const Lanes difference = number(1, i) - number(0, i);
    // Predicted values, summed up, are slope.x + offset when they are counted from that of the first end.
    const Vectors slope = at_a + at_b;
    const Lanes offset = weight_b * difference + dot(at_a - at_b, half);
    forms.matrix = forms.matrix + share * Matrices{slope.x * slope.x, slope.x * slope.y, slope.x * slope.z,
                                                   slope.y * slope.y, slope.y * slope.z, slope.z * slope.z};
    forms.pull = forms.pull - (counted * difference) * at_b - (share * offset) * slope;
    forms.constant +=
        counted * difference * (weight_b * difference - 2 * dot(at_b, half)) + share * offset * offset;
  }
}

}  // namespace

void EdgeRanker::rank(std::span<const PointPair> edges, float* costs) const {
  Ends a, b;
  Vectors half;
  std::array<PointPair, k_lanes> lanes;
  for (std::size_t lane = 0; lane < k_lanes; ++lane) {
    lanes[lane] = edges[std::min(lane, edges.size() - 1)];
    const auto [first, second] = lanes[lane];
    const auto i = static_cast<Eigen::Index>(lane);
    a.set(i, matrices_[first]);
    b.set(i, matrices_[second]);
    const Vec3 way = 0.5 * scale_ * (table_.positions[second] - table_.positions[first]);
    half.x[i] = static_cast<float>(way.x());
    half.y[i] = static_cast<float>(way.y());
    half.z[i] = static_cast<float>(way.z());
  }
  const Matrices total = a.squares + b.squares;
  const Lanes weight = trace(total);
  const Lanes unit = (weight > 0).select(weight.inverse(), 0.0f);
  Forms forms{unit * total, unit * ((b.squares - a.squares) * half), {}};
  forms.constant = dot(half, forms.matrix * half);
  if (!channels_.empty()) {
    const std::size_t stride = channels_.rank_stride();
    const auto number = [&](int end, std::size_t i) {
      Lanes values;
      for (std::size_t lane = 0; lane < k_lanes; ++lane) {
        const Index p = end == 0 ? lanes[lane].first : lanes[lane].second;
        values[static_cast<Eigen::Index>(lane)] = sums_[p * stride + i];
      }
      return values;
    };
    add_attributes(stride, number, half, unit, forms);
  }
  const Lanes squared_half = dot(half, half);
  Lanes cost = forms.constant;
  if (placement_ == VertexPlacement::half_edge) {
    cost += dot(half, forms.matrix * half) - 2 * dot(forms.pull, half).abs();
  } else if (placement_ != VertexPlacement::midpoint) {
    Lanes determinant;
    const Vectors place = best_places(forms, a.sum + b.sum, dot(b.sum - a.sum, half), determinant);
    constexpr auto k_most = static_cast<float>(4 * k_reach * k_reach);
    const Eigen::Array<bool, k_lanes, 1> is_usable =
        determinant > 0 && dot(place, place) <= k_most * squared_half;
    cost = is_usable.select(forms.at(place), cost);
  }
  cost = weight * cost.max(0.0f) + weight * static_cast<float>(k_length_weight) * squared_half;
  for (std::size_t lane = 0; lane < edges.size(); ++lane) costs[lane] = cost[static_cast<Eigen::Index>(lane)];
}

}  // namespace recede::detail
