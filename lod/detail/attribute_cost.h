// What a collapse does to attributes (texture coordinates, normals, colours, named scalars), as part of its
// cost.
//
// An attribute is linear over a triangle; continued over the triangle's plane it predicts a value at the new
// place x. The cost is the sum over the triangles of the squared difference between that and the value s
// which the new point gets, times the squared double area, as for the swept volumes. This is the quadric of
// H. Hoppe (New Quadric Metric for Simplifying Meshes with Appearance Attributes, Visualization 1999),
// without memory of earlier collapses. It is least, for every x, at the weighted mean of the predicted
// values, so s is eliminated and the cost stays a quadratic form of x alone. Corners of one point with
// different texture coordinates or normals (seams) have an s each.
#pragma once

#include <recede/lod/detail/collapse_rules.h>
#include <recede/lod/simplify.h>

#include <span>

namespace recede::detail {

/// x.matrix x - 2 pull.x + constant.
struct QuadraticForm {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Vec3 pull = Vec3::Zero();
  double constant = 0;

  /// Not below 0, which rounding may reach.
  double at(const Vec3& x) const { return std::max(0.0, x.dot(matrix * x) - 2 * pull.dot(x) + constant); }
  /// Adds factor * (slope.x + offset)^2.
  void add_square(const Vec3& slope, double offset, double factor) {
    matrix += factor * slope * slope.transpose();
    pull -= factor * offset * slope;
    constant += factor * offset * offset;
  }
  QuadraticForm& operator+=(const QuadraticForm& other) {
    matrix += other.matrix;
    pull += other.pull;
    constant += other.constant;
    return *this;
  }
};

/// The numbers that count, each times its weight, so that all are lengths in table units: those of corners
/// (texture coordinates, normals) before those of points (colours, scalars).
class AttributeChannels {
 public:
  /// Throws `OptionError` for a scalar that isn't there, `InputError` for values that aren't finite.
  AttributeChannels(const CornerTable& table, const AttributeWeights& weights);

  bool empty() const { return channels_.empty(); }
  std::size_t size() const { return channels_.size(); }
  std::size_t n_of_corners() const { return n_of_corners_; }

  /// Weighted values: those of corners first, `n_of_corners()` of `size()`. `values` is the place of the
  /// first channel, whatever part is read or written.
  void read_wedge(const CornerTable& table, Index wedge, double* values) const;
  void read_point(const CornerTable& table, Index point, double* values) const;
  void read(const CornerTable& table, Index corner, double* values) const {
    if (n_of_corners_ > 0) read_wedge(table, table.wedge[corner], values);
    read_point(table, table.point[corner], values);
  }
  void write_wedge(CornerTable& table, Index wedge, const double* values) const;
  void write_point(CornerTable& table, Index point, const double* values) const;

  /// Numbers for each point by `add_rank_sums`: the squared double areas of the triangles around it, then for
  /// each channel the value and the sum of gradients.
  std::size_t rank_stride() const { return 1 + 4 * size(); }

 private:
  enum class Kind { uv, normal, color, scalar };
  struct Channel {
    Kind kind;
    Index component;
    double weight;
  };
  void add(Kind kind, Index component, double weight);

  std::vector<Channel> channels_;
  std::size_t n_of_corners_ = 0;
};

/// Sums the attribute cost over the triangles that move with an edge. Keeps lists between edges, so that no
/// memory is allocated: one object per thread.
class AttributeCost {
 public:
  AttributeCost(const CornerTable& table, const AttributeChannels& channels);

  /// Begins with the edge from `first` to `second`; places are relative to `center`.
  void start(const EdgeRings& rings, Index first, Index second, const Vec3& center);
  /// A triangle given by corners; `at` is the one that moves.
  void add_triangle(Index at, Index before, Index after);
  /// The cost with the best values.
  QuadraticForm form() const;
  /// How much more it costs when the values at `kept` stay as they are.
  double cost_of_keeping(Index kept, const Vec3& place);
  /// Writes the best values at `place`, relative to the center, never outside of what the triangles have.
  void write_best(CornerTable& table, Index kept, const Vec3& place);

 private:
  /// Predictions for one value: the sum of weights, and for each channel the sums of slopes and offsets.
  struct Sum {
    Vec3 slope = Vec3::Zero();
    double offset = 0, low = 0, high = 0;
  };
  /// What gets one value: the channels of the point (group 0), or those of corners that agree.
  struct Group {
    double weight = 0;
    std::size_t first_channel = 0, end_channel = 0;
  };
  /// A wedge of an end of the edge, and its group.
  struct EndWedge {
    Index wedge, end;
    std::size_t group;
  };
  std::size_t add_group(std::size_t first_channel, std::size_t end_channel);
  std::size_t group_of(Index wedge) const;
  void add_wedges(const std::vector<RingCorner>& ring, Index end);
  void predict(std::size_t group, const Vec3& normal, const Vec3& to_before, const Vec3& to_after,
               const Vec3& place);
  double best_value(std::size_t group, std::size_t channel, const Vec3& place) const;
  Sum& sum(std::size_t group, std::size_t channel) { return sums_[group * channels_.size() + channel]; }
  const Sum& sum(std::size_t group, std::size_t channel) const {
    return sums_[group * channels_.size() + channel];
  }

  const CornerTable& table_;
  const AttributeChannels& channels_;
  Vec3 center_ = Vec3::Zero();
  QuadraticForm squares_;
  std::vector<Group> groups_;
  std::vector<EndWedge> wedges_;
  std::vector<Sum> sums_;
  std::vector<double> at_, before_, after_;  // values at a triangle's corners
};

struct PointMatrix;

/// Adds the attributes' part to a smooth point's matrix and fills its `rank_stride()` numbers. `scale`
/// multiplies lengths; `scratch` keeps its memory between calls.
void add_rank_sums(const CornerTable& table, const AttributeChannels& channels, Index point, double scale,
                   PointMatrix& matrix, float* sums, std::vector<double>& scratch);

}  // namespace recede::detail
