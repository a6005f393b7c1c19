#include <recede/geometry/error.h>
#include <recede/lod/detail/attribute_cost.h>
#include <recede/lod/detail/edge_ranker.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {
namespace {

/// Squared double area over the product of two squared sides below which a triangle has no gradient.
constexpr double k_flat = 1e-16;

/// The gradient of a value times the squared double area: `before` and `after` are its differences along the
/// sides, `normal` is their cross product, after x before.
Vec3 weighted_gradient(const Vec3& normal, const Vec3& to_before, const Vec3& to_after, double before,
                       double after) {
  return after * to_before.cross(normal) + before * normal.cross(to_after);
}

/// False where the triangle has too little area for a gradient.
bool has_gradient(const Vec3& normal, const Vec3& to_before, const Vec3& to_after) {
  return normal.squaredNorm() > k_flat * to_before.squaredNorm() * to_after.squaredNorm();
}

}  // namespace

AttributeChannels::AttributeChannels(const CornerTable& table, const AttributeWeights& weights) {
  const auto add_all = [&](bool present, Kind kind, Index n, double weight) {
    for (Index i = 0; present && weight > 0 && i < n; ++i) add(kind, i, weight);
  };
  add_all(table.has_uvs, Kind::uv, 2, weights.uv);
  add_all(table.has_normals, Kind::normal, 3, weights.normal);
  n_of_corners_ = channels_.size();
  add_all(!table.colors.empty(), Kind::color, 4, weights.color);
  for (const auto& [name, weight] : weights.scalars) {
    const auto found = std::find(table.scalar_names.begin(), table.scalar_names.end(), name);
    if (found == table.scalar_names.end()) throw OptionError("no scalar of the vertices is named " + name);
    const auto number = static_cast<Index>(found - table.scalar_names.begin());
    if (!(weight > 0)) continue;
    for (std::size_t p = 0; p < table.n_points(); ++p) {
      if (std::isfinite(table.scalars[p * table.scalar_names.size() + number])) continue;
      throw InputError("the scalar " + name + " has a weight, but isn't finite at vertex " +
                       std::to_string(table.source_vertex[p]));
    }
    add(Kind::scalar, number, weight);
  }
}

void AttributeChannels::add(Kind kind, Index component, double weight) {
  channels_.push_back({kind, component, weight});
}

void AttributeChannels::read_wedge(const CornerTable& table, Index wedge, double* values) const {
  const Wedge& w = table.wedges[wedge];
  for (std::size_t i = 0; i < n_of_corners_; ++i) {
    const Channel& c = channels_[i];
    values[i] = c.weight * (c.kind == Kind::uv ? w.uv[c.component] : w.normal[c.component]);
  }
}

void AttributeChannels::read_point(const CornerTable& table, Index point, double* values) const {
  for (std::size_t i = n_of_corners_; i < channels_.size(); ++i) {
    const Channel& c = channels_[i];
    values[i] = c.weight * (c.kind == Kind::color ? table.colors[point][c.component]
                                                  : table.point_scalars(point)[c.component]);
  }
}

void AttributeChannels::write_wedge(CornerTable& table, Index wedge, const double* values) const {
  Wedge& w = table.wedges[wedge];
  bool turned = false;
  for (std::size_t i = 0; i < n_of_corners_; ++i) {
    const Channel& c = channels_[i];
    (c.kind == Kind::uv ? w.uv[c.component] : w.normal[c.component]) = values[i] / c.weight;
    turned = turned || c.kind == Kind::normal;
  }
  const double length = turned ? w.normal.norm() : 0;
  if (length > 0) w.normal /= length;
}

void AttributeChannels::write_point(CornerTable& table, Index point, const double* values) const {
  for (std::size_t i = n_of_corners_; i < channels_.size(); ++i) {
    const Channel& c = channels_[i];
    (c.kind == Kind::color ? table.colors[point][c.component] : table.point_scalars(point)[c.component]) =
        values[i] / c.weight;
  }
}

AttributeCost::AttributeCost(const CornerTable& table, const AttributeChannels& channels)
    : table_(table),
      channels_(channels),
      at_(channels.size()),
      before_(channels.size()),
      after_(channels.size()) {}

std::size_t AttributeCost::add_group(std::size_t first_channel, std::size_t end_channel) {
  groups_.push_back({0, first_channel, end_channel});
  sums_.resize(groups_.size() * channels_.size());
  std::fill(sums_.end() - static_cast<std::ptrdiff_t>(channels_.size()), sums_.end(), Sum{});
  return groups_.size() - 1;
}

std::size_t AttributeCost::group_of(Index wedge) const {
  const auto found =
      std::find_if(wedges_.begin(), wedges_.end(), [&](const EndWedge& e) { return e.wedge == wedge; });
  return found == wedges_.end() ? groups_.size() : found->group;
}

/// Wedges of an end that aren't known yet get a group each; over a face of the edge, they join that of the
/// other end.
void AttributeCost::add_wedges(const std::vector<RingCorner>& ring, Index end) {
  const auto join = [&](const RingCorner& corner, bool on_edge) {
    const Index wedge = table_.wedge[corner.corner];
    if (corner.on_edge != on_edge || group_of(wedge) < groups_.size()) return;
    std::size_t group = groups_.size();
    if (on_edge) {
      const Index after = table_.next(corner.corner), before = table_.previous(corner.corner);
      for (const Index other : {after, before}) group = std::min(group, group_of(table_.wedge[other]));
    }
    if (group == groups_.size()) group = add_group(0, channels_.n_of_corners());
    wedges_.push_back({wedge, end, group});
  };
  for (const RingCorner& corner : ring) join(corner, true);
  for (const RingCorner& corner : ring) join(corner, false);
}

void AttributeCost::start(const EdgeRings& rings, Index first, Index second, const Vec3& center) {
  center_ = center;
  squares_ = {};
  groups_.clear();
  sums_.clear();
  wedges_.clear();
  add_group(channels_.n_of_corners(), channels_.size());
  if (channels_.n_of_corners() == 0) return;
  add_wedges(rings.removed, first);
  add_wedges(rings.kept, second);
}

/// Adds what a triangle, whose values stand in `at_`, `before_` and `after_`, predicts for a group.
void AttributeCost::predict(std::size_t group, const Vec3& normal, const Vec3& to_before,
                            const Vec3& to_after, const Vec3& place) {
  Group& g = groups_[group];
  const double weight = normal.squaredNorm();
  const bool is_first = g.weight == 0;
  g.weight += weight;
  for (std::size_t i = g.first_channel; i < g.end_channel; ++i) {
    const Vec3 slope =
        weighted_gradient(normal, to_before, to_after, before_[i] - at_[i], after_[i] - at_[i]);
    const double offset = weight * at_[i] - slope.dot(place);
    squares_.add_square(slope, offset, 1 / weight);
    Sum& s = sum(group, i);
    s.slope += slope;
    s.offset += offset;
    const auto [low, high] = std::minmax({at_[i], before_[i], after_[i]});
    s.low = is_first ? low : std::min(s.low, low);
    s.high = is_first ? high : std::max(s.high, high);
  }
}

void AttributeCost::add_triangle(Index at, Index before, Index after) {
  const auto position = [&](Index corner) -> const Vec3& { return table_.positions[table_.point[corner]]; };
  const Vec3 to_before = position(before) - position(at), to_after = position(after) - position(at);
  const Vec3 normal = to_after.cross(to_before);
  if (!has_gradient(normal, to_before, to_after)) return;
  channels_.read(table_, at, at_.data());
  channels_.read(table_, before, before_.data());
  channels_.read(table_, after, after_.data());
  const Vec3 place = position(at) - center_;
  if (groups_[0].first_channel < groups_[0].end_channel) predict(0, normal, to_before, to_after, place);
  if (channels_.n_of_corners() == 0) return;
  const std::size_t group = group_of(table_.wedge[at]);
  if (group < groups_.size()) predict(group, normal, to_before, to_after, place);
}

QuadraticForm AttributeCost::form() const {
  QuadraticForm result = squares_;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (!(groups_[g].weight > 0)) continue;
    for (std::size_t i = groups_[g].first_channel; i < groups_[g].end_channel; ++i) {
      result.add_square(sum(g, i).slope, sum(g, i).offset, -1 / groups_[g].weight);
    }
  }
  return result;
}

double AttributeCost::best_value(std::size_t group, std::size_t channel, const Vec3& place) const {
  const Sum& s = sum(group, channel);
  return (s.slope.dot(place) + s.offset) / groups_[group].weight;
}

double AttributeCost::cost_of_keeping(Index kept, const Vec3& place) {
  double cost = 0;
  const auto add = [&](std::size_t group) {
    const Group& g = groups_[group];
    for (std::size_t i = g.first_channel; g.weight > 0 && i < g.end_channel; ++i) {
      const double off = at_[i] - best_value(group, i, place);
      cost += g.weight * off * off;
    }
  };
  channels_.read_point(table_, kept, at_.data());
  add(0);
  for (const EndWedge& end : wedges_) {
    if (end.end != kept) continue;
    channels_.read_wedge(table_, end.wedge, at_.data());
    add(end.group);
  }
  return cost;
}

void AttributeCost::write_best(CornerTable& table, Index kept, const Vec3& place) {
  const auto find_best = [&](std::size_t group) {
    const Group& g = groups_[group];
    for (std::size_t i = g.first_channel; i < g.end_channel; ++i) {
      at_[i] = std::clamp(best_value(group, i, place), sum(group, i).low, sum(group, i).high);
    }
    return g.weight > 0;
  };
  if (groups_[0].weight > 0 && find_best(0)) channels_.write_point(table, kept, at_.data());
  for (const EndWedge& end : wedges_) {
    if (groups_[end.group].weight > 0 && find_best(end.group)) {
      channels_.write_wedge(table, end.wedge, at_.data());
    }
  }
}

void add_rank_sums(const CornerTable& table, const AttributeChannels& channels, Index point, double scale,
                   PointMatrix& matrix, float* sums, std::vector<double>& scratch) {
  const std::size_t n = channels.size();
  scratch.resize(3 * n);
  double *const at = scratch.data(), *const before = at + n, *const after = before + n;
  std::fill_n(sums, channels.rank_stride(), 0.0f);
  const auto place = [&](Index corner) -> Vec3 { return scale * table.positions[table.point[corner]]; };
  const Index first_corner = table.ring[table.ring_start[point]];
  channels.read(table, first_corner, at);
  for (std::size_t i = 0; i < n; ++i) sums[1 + 4 * i] = static_cast<float>(scale * at[i]);
  for (Index r = table.ring_start[point]; r < table.ring_start[point + 1]; ++r) {
    const Index corner = table.ring[r], next = table.next(corner), previous = table.previous(corner);
    const Vec3 to_after = place(next) - place(corner), to_before = place(previous) - place(corner);
    const Vec3 normal = to_after.cross(to_before);
    if (!has_gradient(normal, to_before, to_after)) continue;
    channels.read(table, previous, before);
    channels.read(table, next, after);
    const double weight = normal.squaredNorm();
    sums[0] += static_cast<float>(weight);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 slope =
          scale * weighted_gradient(normal, to_before, to_after, before[i] - at[i], after[i] - at[i]);
      add_square(matrix.squares, (slope / std::sqrt(weight)).cast<float>());
      Eigen::Map<Eigen::Vector3f>(sums + 2 + 4 * i) += slope.cast<float>();
    }
  }
}

}  // namespace recede::detail
