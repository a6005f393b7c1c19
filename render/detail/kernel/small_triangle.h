// Small triangles of a displaced patch, and rays against them without gaps between neighbours.
//
// A line is sheared so that it becomes the third axis (Woop, Benthin and Wald 2013, "Watertight ray/triangle
// intersection"). A point's sheared coordinates depend on that point alone, and the turn of a side around the
// line on its two ends alone, but for the sign: so the triangles on both sides of it agree, and as turns of
// zero count as inside for both, nothing slips through. A triangle all of whose turns are zero is seen
// edge-on and isn't met: its neighbours are. Turns are found in float, and t in double from the corners in
// float: it lies between theirs, however flat the triangle is seen.
#pragma once

#include <recede/render/detail/kernel/height_lanes.h>
#include <recede/render/detail/kernel/patch_points.h>

namespace recede::detail {
namespace {

// Nine points of two by two squares, row by row.
struct LeafPoints {
  Float8 eight[3];
  float ninth[3];

  struct Point {
    float at[3];
  };
  Point at(int k) const {
    if (k == 8) return {{ninth[0], ninth[1], ninth[2]}};
    return {{eight[0][k], eight[1][k], eight[2][k]}};
  }
};

struct SmallTriangleHit {
  float t = __builtin_nanf("");
  float weights[3] = {0, 0, 0};
  float normal[3] = {0, 0, 0};
};

class WatertightLine {
 public:
  explicit WatertightLine(const PatchRayQuery& ray) {
    for (int axis = 0; axis < 3; ++axis) {
      origin[axis] = ray.origin[axis];
      direction_[axis] = ray.direction[axis];
    }
    const auto size = [&](int axis) { return __builtin_fabsf(direction_[axis]); };
    z = size(0) > size(1) ? (size(0) > size(2) ? 0 : 2) : (size(1) > size(2) ? 1 : 2);
    x = (z + 1) % 3;
    y = (z + 2) % 3;
    shear_x = direction_[x] / direction_[z];
    shear_y = direction_[y] / direction_[z];
  }

  // Whether the line meets the triangle, by the turns in float that `LeafCover` finds for many at once.
  bool is_inside(const float* a, const float* b, const float* c) const {
    float px[3], py[3];
    const float* points[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) {
      const float depth = points[k][z] - origin[z];
      px[k] = (points[k][x] - origin[x]) - shear_x * depth;
      py[k] = (points[k][y] - origin[y]) - shear_y * depth;
    }
    bool is_left = true, is_right = true;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      const float turn = px[k] * py[next] - py[k] * px[next];
      is_left = is_left && turn >= 0;
      is_right = is_right && turn <= 0;
    }
    return is_left != is_right;
  }

  // Where the line meets a triangle that it is inside of; no t when it is seen edge-on.
  SmallTriangleHit meet(const LeafPoints::Point& a, const LeafPoints::Point& b,
                        const LeafPoints::Point& c) const {
    const LeafPoints::Point* const points[3] = {&a, &b, &c};
    const double per_z = 1 / static_cast<double>(direction_[z]);
    const double dx = direction_[x] * per_z, dy = direction_[y] * per_z;
    double px[3], py[3], depth[3];
    for (int k = 0; k < 3; ++k) {
      const auto from_origin = [&](int axis) {
        return static_cast<double>(points[k]->at[axis]) - static_cast<double>(origin[axis]);
      };
      const double along = from_origin(z);
      px[k] = from_origin(x) - dx * along;
      py[k] = from_origin(y) - dy * along;
      depth[k] = along * per_z;
    }
    double turns[3];  // opposite to each corner
    for (int k = 0; k < 3; ++k) {
      const int p = (k + 1) % 3, q = (k + 2) % 3;
      turns[k] = px[p] * py[q] - py[p] * px[q];
    }
    const double sum = turns[0] + turns[1] + turns[2];
    if (sum < 0) {
      for (double& turn : turns) turn = -turn;
    }
    // In double, the line may lie just outside.
    for (double& turn : turns) turn = turn > 0 ? turn : 0;
    const double whole = turns[0] + turns[1] + turns[2];
    SmallTriangleHit hit;
    if (!(whole > 0)) return hit;
    double t = 0;
    for (int k = 0; k < 3; ++k) {
      t += turns[k] * depth[k];
      hit.weights[k] = static_cast<float>(turns[k] / whole);
    }
    hit.t = static_cast<float>(t / whole);
    double ab[3], ac[3];
    for (int axis = 0; axis < 3; ++axis) {
      ab[axis] = static_cast<double>(b.at[axis]) - static_cast<double>(a.at[axis]);
      ac[axis] = static_cast<double>(c.at[axis]) - static_cast<double>(a.at[axis]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const int p = (axis + 1) % 3, q = (axis + 2) % 3;
      hit.normal[axis] = static_cast<float>(ab[p] * ac[q] - ab[q] * ac[p]);
    }
    return hit;
  }

  float origin[3];
  int x, y, z;
  float shear_x, shear_y;

 private:
  float direction_[3];
};

// Which of the triangles of two by two squares a line meets: bit k of `lower` is (k, k + 1, k + 3), bit k of
// `upper` is (k + 4, k + 3, k + 1), for k = 0, 1, 3, 4.
struct LeafCover {
  LeafCover(const WatertightLine& line, const LeafPoints& p) {
    const Float8 depth = p.eight[line.z] - line.origin[line.z];
    const Float8 x = (p.eight[line.x] - line.origin[line.x]) - line.shear_x * depth;
    const Float8 y = (p.eight[line.y] - line.origin[line.y]) - line.shear_y * depth;
    const float depth9 = p.ninth[line.z] - line.origin[line.z];
    const float x9 = (p.ninth[line.x] - line.origin[line.x]) - line.shear_x * depth9;
    const float y9 = (p.ninth[line.y] - line.origin[line.y]) - line.shear_y * depth9;
    const Float8 x1 = next_points(x, x9), y1 = next_points(y, y9);    // lane k: the point k + 1
    const Float8 x3 = third_points(x, x9), y3 = third_points(y, y9);  // the point k + 3
    const Float8 side_i = x * y1 - y * x1;                            // from k to k + 1
    const Float8 side_j = x * y3 - y * x3;                            // from k to k + 3
    const Float8 across = x1 * y3 - y1 * x3;                          // from k + 1 to k + 3
    const Float8 zero = all8(0);
    const unsigned i_left = sign_bits(side_i >= zero), i_right = sign_bits(side_i <= zero);
    const unsigned j_left = sign_bits(side_j >= zero), j_right = sign_bits(side_j <= zero);
    const unsigned a_left = sign_bits(across >= zero), a_right = sign_bits(across <= zero);
    lower = (i_left & a_left & j_right) ^ (i_right & a_right & j_left);
    upper = ((i_right >> 3) & a_right & (j_left >> 1)) ^ ((i_left >> 3) & a_left & (j_right >> 1));
  }

  unsigned lower, upper;

 private:
  static Float8 next_points(Float8 a, float ninth) {
    return __builtin_shufflevector(a, all8(ninth), 1, 2, 3, 4, 5, 6, 7, 8);
  }
  static Float8 third_points(Float8 a, float ninth) {
    return __builtin_shufflevector(a, all8(ninth), 3, 4, 5, 6, 7, 8, 8, 8);
  }
};

constexpr float k_no_length = 1e-30f;  // keeps directions that cancel out from giving NaN

template <typename Sample>
inline void displaced_point(const Place& p, const HeightMap<Sample>& map, float* position) {
  const float height = map.height(map.bilinear_one(p[k_texel_x], p[k_texel_y]));
  const float square = (p[4] * p[4] + p[5] * p[5]) + p[6] * p[6];
  const float factor = height / __builtin_sqrtf(square > k_no_length ? square : k_no_length);
  for (int axis = 0; axis < 3; ++axis) position[axis] = p[axis] + p[k_direction + axis] * factor;
}

// Nine points, each as `displaced_point` gives it.
template <typename Sample>
inline void displace_leaf(const LeafPlaces& places, const HeightMap<Sample>& map, LeafPoints& points) {
  // Lanes are points 0 to 3 in the lower halves and 4 to 7 in the upper ones.
  Float8 a = places.at[0], b = places.at[1], c = places.at[2], d = places.at[3];
  Float8 e = places.at[4], f = places.at[5], g = places.at[6], h = places.at[7];
  transpose(a, b, c, d);
  transpose(e, f, g, h);
  const auto lower = [](Float8 p, Float8 q) { return join(lower_half(p), lower_half(q)); };
  const auto upper = [](Float8 p, Float8 q) { return join(upper_half(p), upper_half(q)); };
  const Float8 height = map.heights(map.bilinear(lower(d, h), upper(d, h)));
  const Float8 direction[3] = {upper(a, e), upper(b, f), upper(c, g)};
  const Float8 square =
      (direction[0] * direction[0] + direction[1] * direction[1]) + direction[2] * direction[2];
  const Float8 factor = height / square_root(largest(square, all8(k_no_length)));
  points.eight[0] = lower(a, e) + direction[0] * factor;
  points.eight[1] = lower(b, f) + direction[1] * factor;
  points.eight[2] = lower(c, g) + direction[2] * factor;
  displaced_point(places.at[8], map, points.ninth);
}

}  // namespace
}  // namespace recede::detail
