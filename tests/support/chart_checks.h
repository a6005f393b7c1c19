// What must hold for every set of charts and every atlas, checked by other means than those that made them.
#pragma once

#include <recede/geometry/chart_atlas.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <vector>

namespace recede::test {

/// Faces of a soup, glued where exactly two sides run along an edge in opposite directions.
class GluedFaces {
 public:
  explicit GluedFaces(const PolygonSoup& soup) : soup_(soup), opposite_(soup.n_corners(), k_no_index) {
    std::map<std::pair<Index, Index>, std::vector<Index>> edges;
    for (Index f = 0; f < soup.n_faces(); ++f) {
      for (Index i = 0; i < soup.face_size(f); ++i) {
        const Index side = soup.face_offsets[f] + i;
        face_of_.push_back(f);
        after_.push_back(soup.face_offsets[f] + (i + 1) % static_cast<Index>(soup.face_size(f)));
        edges[std::minmax(soup.corner_vertices[side], soup.corner_vertices[after_[side]])].push_back(side);
      }
    }
    for (const auto& [ends, sides] : edges) {
      if (sides.size() != 2 || face_of_[sides[0]] == face_of_[sides[1]]) continue;
      if (soup.corner_vertices[sides[0]] == soup.corner_vertices[sides[1]]) continue;
      opposite_[sides[0]] = sides[1];
      opposite_[sides[1]] = sides[0];
    }
  }

  Index opposite(Index side) const { return opposite_[side]; }
  Index face_of(Index side) const { return face_of_[side]; }

  /// One piece, one border, Euler characteristic 1. `closed` says which sides aren't glued in any case.
  template <class Closed>
  bool is_disk(const std::vector<Index>& faces, const Closed& closed) const {
    const std::set<Index> inside(faces.begin(), faces.end());
    const auto glued = [&](Index side) {
      return opposite_[side] != k_no_index && !closed(side) && inside.contains(face_of_[opposite_[side]]);
    };
    std::map<Index, Index> corner_sets;  // parents
    std::map<Index, Index> face_sets;
    std::size_t n_sides = 0, n_glued = 0;
    for (const Index f : faces) {
      face_sets[f] = f;
      for (Index side = soup_.face_offsets[f]; side < soup_.face_offsets[f + 1]; ++side) {
        corner_sets[side] = side;
      }
    }
    for (const auto& [side, parent] : corner_sets) {
      ++n_sides;
      if (!glued(side)) continue;
      ++n_glued;
      unite(corner_sets, side, after_[opposite_[side]]);
      unite(corner_sets, after_[side], opposite_[side]);
      unite(face_sets, face_of_[side], face_of_[opposite_[side]]);
    }
    std::set<Index> vertices, pieces;
    for (const auto& [side, parent] : corner_sets) vertices.insert(root(corner_sets, side));
    for (const Index f : faces) pieces.insert(root(face_sets, f));
    const auto euler = static_cast<long>(vertices.size()) - static_cast<long>(n_sides - n_glued / 2) +
                       static_cast<long>(faces.size());
    // A connected oriented surface of characteristic 1 has no handle and one border.
    return pieces.size() == 1 && euler == 1;
  }

 private:
  static Index root(std::map<Index, Index>& sets, Index i) {
    for (Index parent = sets[i]; parent != i; parent = sets[i]) i = sets[i] = sets[parent];
    return i;
  }
  static void unite(std::map<Index, Index>& sets, Index a, Index b) { sets[root(sets, a)] = root(sets, b); }

  const PolygonSoup& soup_;
  std::vector<Index> opposite_, face_of_, after_;
};

inline std::vector<std::vector<Index>> faces_of_charts(const std::vector<Index>& face_charts) {
  std::vector<std::vector<Index>> faces;
  for (Index f = 0; f < face_charts.size(); ++f) {
    if (face_charts[f] >= faces.size()) faces.resize(face_charts[f] + 1);
    faces[face_charts[f]].push_back(f);
  }
  return faces;
}

/// Every chart is a disk, and there is no number without one.
inline void expect_disks(const PolygonSoup& soup, const std::vector<Index>& face_charts) {
  ASSERT_EQ(face_charts.size(), soup.n_faces());
  const GluedFaces glued(soup);
  const auto charts = faces_of_charts(face_charts);
  for (std::size_t c = 0; c < charts.size(); ++c) {
    ASSERT_FALSE(charts[c].empty()) << "chart " << c << " of " << charts.size();
    EXPECT_TRUE(glued.is_disk(charts[c], [](Index) { return false; })) << "chart " << c;
  }
}

/// Whether a triangle and an axis-aligned square have a common point, by separating axes.
inline bool triangle_meets_square(const Vec2 (&t)[3], const Vec2& lower, double side) {
  for (int axis = 0; axis < 2; ++axis) {
    if (std::max({t[0][axis], t[1][axis], t[2][axis]}) <= lower[axis] ||
        std::min({t[0][axis], t[1][axis], t[2][axis]}) >= lower[axis] + side) {
      return false;
    }
  }
  for (int i = 0; i < 3; ++i) {
    const Vec2 along = t[(i + 1) % 3] - t[i], normal(along.y(), -along.x());
    const double low =
        (lower - t[i]).dot(normal) + side * (std::min(normal.x(), 0.0) + std::min(normal.y(), 0.0));
    if (low >= 0) return false;  // counter-clockwise: the normal points outside
  }
  return true;
}

/// The chart that touches each texel of an atlas; no two touch the same.
inline std::vector<Index> rasterise(const AtlasResult& atlas) {
  const int n = atlas.resolution;
  const auto at = [n](int x, int y) { return static_cast<std::size_t>(y) * std::size_t(n) + std::size_t(x); };
  std::vector<Index> owner(at(0, n), k_no_index), triangle_faces, corners;
  triangulate(atlas.soup, &triangle_faces, &corners);
  std::size_t shared = 0;
  for (std::size_t t = 0; t < triangle_faces.size(); ++t) {
    Vec2 uv[3];
    for (std::size_t i = 0; i < 3; ++i) uv[i] = n * atlas.soup.corner_uvs[corners[3 * t + i]];
    Eigen::AlignedBox2d box(uv[0]);
    box.extend(uv[1]).extend(uv[2]);
    const Index chart = atlas.face_charts[triangle_faces[t]];
    for (int y = int(box.min().y()); y <= std::min(int(box.max().y()), n - 1); ++y) {
      for (int x = int(box.min().x()); x <= std::min(int(box.max().x()), n - 1); ++x) {
        if (!triangle_meets_square(uv, Vec2(x, y), 1)) continue;
        Index& texel = owner[at(x, y)];
        if (texel != k_no_index && texel != chart) ++shared;
        texel = chart;
      }
    }
  }
  EXPECT_EQ(shared, 0u) << "texels of two charts";
  return owner;
}

/// Different charts are at least `gutter` whole texels apart.
inline void expect_gutter(const AtlasResult& atlas, int gutter) {
  const std::vector<Index> owner = rasterise(atlas);
  const int n = atlas.resolution;
  std::size_t too_near = 0;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const Index chart = owner[std::size_t(y) * std::size_t(n) + std::size_t(x)];
      const auto at = [&](int px, int py) {
        return px < 0 || px >= n || py < 0 || py >= n
                   ? k_no_index
                   : owner[std::size_t(py) * std::size_t(n) + std::size_t(px)];
      };
      const bool inside =
          at(x - 1, y) == chart && at(x + 1, y) == chart && at(x, y - 1) == chart && at(x, y + 1) == chart;
      if (chart == k_no_index || inside) continue;
      for (int dy = 0; dy <= std::min(gutter, n - 1 - y); ++dy) {
        for (int dx = -std::min(gutter, x); dx <= std::min(gutter, n - 1 - x); ++dx) {
          const Index other = owner[std::size_t(y + dy) * std::size_t(n) + std::size_t(x + dx)];
          if (other != k_no_index && other != chart) ++too_near;
        }
      }
    }
  }
  EXPECT_EQ(too_near, 0u);
}

/// Everything an atlas promises but the gutter, which takes longest.
inline void expect_sound(const PolygonSoup& input, const AtlasResult& atlas,
                         const AtlasOptions& options = {}) {
  ASSERT_EQ(atlas.soup.positions, input.positions);
  ASSERT_EQ(atlas.soup.corner_vertices, input.corner_vertices);
  ASSERT_EQ(atlas.soup.corner_uvs.size(), input.n_corners());
  for (const Vec2& uv : atlas.soup.corner_uvs) {
    ASSERT_TRUE(uv.allFinite());
    ASSERT_GE(uv.minCoeff(), 0);
    ASSERT_LE(uv.maxCoeff(), 1);
  }
  EXPECT_EQ(atlas.flipped, 0u);
  expect_disks(input, atlas.face_charts);
  EXPECT_EQ(atlas.charts.size(), atlas.report.charts);
  std::size_t faces = 0;
  for (std::size_t c = 0; c < atlas.charts.size(); ++c) {
    const AtlasChart& chart = atlas.charts[c];
    faces += chart.faces;
    EXPECT_GE(chart.stretch.l2, 1 - 1e-9) << "chart " << c;
    EXPECT_GE(chart.stretch.l_infinity, chart.stretch.l2 * (1 - 1e-9)) << "chart " << c;
    if (chart.faces > 1) {
      EXPECT_LE(chart.stretch.l2, options.stretch_limit) << "chart " << c;
    }
  }
  EXPECT_EQ(faces, input.n_faces());
  EXPECT_GE(atlas.occupancy, 0);
  EXPECT_LE(atlas.occupancy, 1);
}

}  // namespace recede::test
