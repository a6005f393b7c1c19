#include <recede/geometry/detail/teapot_data.h>
#include <recede/geometry/error.h>
#include <recede/geometry/sample_models.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace recede {
namespace {

using Curve = std::array<Vec3, 4>;

bool lexicographically_less(const Vec3& a, const Vec3& b) {
  return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end());
}

/// Point of a cubic Bezier curve at i/n. Evaluated from the lower end on, so that a curve and its reverse
/// give the same bits.
Vec3 evaluate(Curve c, std::size_t i, std::size_t n) {
  // A side that has shrunk to a point is that point, to the bit.
  if (c[0] == c[1] && c[0] == c[2] && c[0] == c[3]) return c[0];
  if (lexicographically_less(c[3], c[0])) {
    std::reverse(c.begin(), c.end());
    i = n - i;
  }
  const double t = static_cast<double>(i) / static_cast<double>(n);
  const double s = static_cast<double>(n - i) / static_cast<double>(n);
  return s * s * s * c[0] + 3 * s * s * t * c[1] + 3 * s * t * t * c[2] + t * t * t * c[3];
}

struct Patch {
  std::array<Vec3, 16> points;

  Curve row(std::size_t i) const {
    return {points[4 * i], points[4 * i + 1], points[4 * i + 2], points[4 * i + 3]};
  }
  Curve column(std::size_t j) const { return {points[j], points[4 + j], points[8 + j], points[12 + j]}; }
  Vec3 at(std::size_t i, std::size_t j, std::size_t n) const {
    // Borders by their own four control points alone.
    if (i == 0 || i == n) return evaluate(row(i == 0 ? 0 : 3), j, n);
    if (j == 0 || j == n) return evaluate(column(j == 0 ? 0 : 3), i, n);
    return evaluate({evaluate(column(0), i, n), evaluate(column(1), i, n), evaluate(column(2), i, n),
                     evaluate(column(3), i, n)},
                    j, n);
  }
};

Patch teapot_patch(std::size_t number) {
  Patch patch;
  for (std::size_t i = 0; i < 16; ++i) {
    const auto& p = detail::k_teapot_points[detail::k_teapot_patches[number][i]];
    patch.points[i] = {p[0], p[1], p[2]};
  }
  return patch;
}

/// Sum of the vector areas of the faces around each vertex, normalised.
std::vector<Vec3> vertex_normals(const PolygonSoup& soup) {
  std::vector<Vec3> normals(soup.positions.size(), Vec3::Zero());
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    const Vec3 area = vector_area(soup, f);
    for (const Index v : soup.face(f)) normals[v] += area;
  }
  for (Vec3& n : normals) n.normalize();
  return normals;
}

/// Smooth, between -1 and 1, about `frequency` waves per unit.
double relief_noise(const Vec3& p, double frequency) {
  const Vec3 q = 2 * std::numbers::pi * frequency * p;
  return (std::sin(q.x() + 0.7 * std::sin(1.7 * q.y())) + std::sin(q.y() + 0.7 * std::sin(1.7 * q.z())) +
          std::sin(q.z() + 0.7 * std::sin(1.7 * q.x()))) /
         3;
}

}  // namespace

PolygonSoup make_teapot(std::size_t quads_per_side, double relief) {
  if (quads_per_side == 0) throw OptionError("the teapot needs at least one quad per side of a patch");
  const std::size_t n = quads_per_side;
  PolygonSoup soup;
  for (std::size_t number = 0; number < detail::k_teapot_patches.size(); ++number) {
    const Patch patch = teapot_patch(number);
    const std::size_t base = soup.positions.size();
    for (std::size_t i = 0; i <= n; ++i) {
      for (std::size_t j = 0; j <= n; ++j) soup.positions.push_back(patch.at(i, j, n));
    }
    const auto vertex = [&](std::size_t i, std::size_t j) {
      return static_cast<Index>(base + i * (n + 1) + j);
    };
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        soup.add_face(std::array{vertex(i, j), vertex(i, j + 1), vertex(i + 1, j + 1), vertex(i + 1, j)});
      }
    }
  }
  merge_identical_vertices(soup);
  remove_degenerate_faces(soup);
  const std::vector<Vec3> normals = vertex_normals(soup);
  for (std::size_t v = 0; v < normals.size(); ++v) {
    const Vec3& p = soup.positions[v];
    soup.positions[v] = p + relief * (0.7 * relief_noise(p, 1.5) + 0.3 * relief_noise(p, 5)) * normals[v];
  }
  remove_unreferenced_vertices(soup);
  return soup;
}

namespace {

double ridges(const Vec3& p) {
  double height = 0, amplitude = 0.05, frequency = 3;
  for (int octave = 0; octave < 6; ++octave) {
    height += amplitude * std::abs(std::sin(frequency * p.x() + 1.3 * octave) *
                                   std::sin(frequency * p.y() + 2.1 * octave) *
                                   std::sin(frequency * p.z() + 0.7 * octave));
    amplitude *= 0.55;
    frequency *= 1.9;
  }
  return height;
}

}  // namespace

PolygonSoup make_displaced_sphere(std::size_t faces, bool triangles) {
  const double per_cell = triangles ? 12 : 6;
  const auto n =
      static_cast<Index>(std::max(1.0, std::ceil(std::sqrt(static_cast<double>(faces) / per_cell))));
  PolygonSoup soup;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2, sign = side % 2 == 0 ? 1 : -1;
    const auto base = static_cast<Index>(soup.positions.size());
    for (Index i = 0; i <= n; ++i) {
      for (Index j = 0; j <= n; ++j) {
        // Lattice coordinates are whole numbers, so neighbours on two sides of the cube are bit-equal.
        Vec3 p;
        p[axis] = sign * static_cast<double>(n);
        p[(axis + 1) % 3] = 2.0 * i - n;
        p[(axis + 2) % 3] = 2.0 * j - n;
        p.normalize();
        soup.positions.push_back((1 + ridges(p)) * p);
      }
    }
    for (Index i = 0; i < n; ++i) {
      for (Index j = 0; j < n; ++j) {
        const Index a = base + i * (n + 1) + j, b = a + n + 1;
        std::array<Index, 4> quad{a, b, b + 1, a + 1};
        if (sign < 0) std::reverse(quad.begin(), quad.end());
        if (triangles) {
          soup.add_face(std::array{quad[0], quad[1], quad[2]});
          soup.add_face(std::array{quad[0], quad[2], quad[3]});
        } else {
          soup.add_face(quad);
        }
      }
    }
  }
  merge_identical_vertices(soup);
  return soup;
}

}  // namespace recede
