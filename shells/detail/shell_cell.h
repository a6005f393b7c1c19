// Faces of the cells that a layer is made of: prisms over triangles, hexahedra over quads.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <array>
#include <cstddef>
#include <span>

namespace recede::detail {

/// A place over a face: of a triangle, the weights of its second and third corner; of a quad, 0 to 1 along
/// its first side and along its last one.
struct FacePlace {
  double u = 0, v = 0;
};

/// How much each corner counts; three or four of them, in their order around the face.
using FaceWeights = std::array<double, 4>;

inline FaceWeights weights_at(std::size_t n_corners, const FacePlace& place) {
  const double u = place.u, v = place.v;
  if (n_corners == 3) return {1 - u - v, u, v, 0};
  return {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v};
}

/// Their change for a step of 1 in u, and in v.
inline std::array<FaceWeights, 2> weight_steps_at(std::size_t n_corners, const FacePlace& place) {
  const double u = place.u, v = place.v;
  if (n_corners == 3) return {{{-1, 1, 0, 0}, {-1, 0, 1, 0}}};
  return {{{v - 1, 1 - v, v, -v}, {u - 1, -u, u, 1 - u}}};
}

inline FacePlace corner_place(std::size_t n_corners, std::size_t k) {
  constexpr std::array<FacePlace, 3> k_triangle{{{0, 0}, {1, 0}, {0, 1}}};
  constexpr std::array<FacePlace, 4> k_quad{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  return n_corners == 3 ? k_triangle[k] : k_quad[k];
}

/// Corners of a list of triangles that are those of the quad of which triangle `first` and the next one are
/// the halves, in their order around it.
std::array<Index, 4> quad_corners(std::span<const Index> triangles, Index first);

/// Whether that triangle and the next one are on both sides of one side, with four vertices in all.
bool is_quad(std::span<const Index> triangles, Index first);

}  // namespace recede::detail
