// Flat maps of surface pieces: mean value coordinates, and how much a map stretches.
#pragma once

#include <recede/geometry/polygon_soup.h>

#include <span>

namespace recede {

/// How much a map from the plane to a surface stretches lengths (Sander, Snyder, Gortler and Hoppe 2001).
/// Both figures are relative to a map that keeps areas on the whole: 1 is best, and only a map without any
/// distortion has 1 in both.
struct Stretch {
  double l2 = 1;          ///< root mean square over all points of the surface and all directions
  double l_infinity = 1;  ///< largest of all points and directions; infinite where a triangle has no area in
                          ///< the plane but some on the surface
};

/// Weights of a vertex's neighbours (Floater 2003, "Mean value coordinates"): for a ring
/// v_0 ... v_(n-1) around v, w_i = (tan(a_(i-1)/2) + tan(a_i/2)) / |v_i - v| with a_i the angle at v between
/// v_i and v_(i+1), divided by their sum. In the plane the weighted mean of the ring is v itself. Positive
/// for every ring: edges of no length and angles of 0 or pi are taken as nearly that.
std::vector<double> mean_value_weights(const Vec3& v, std::span<const Vec3> ring);

/// What the weights of inner vertices are made of.
enum class ParameterizationWeights {
  mean_value,  ///< Floater 2003
  uniform,     ///< all neighbours alike (Tutte 1963)
};

/// The plane's shape of the border.
enum class DiskBorder {
  circle,   ///< the unit circle, by arc length, as in the source
  ellipse,  ///< the affine image of that map which stretches least in the L2 sense, of the same area. Closed
            ///< form, and a map without flips stays one
  natural,  ///< the border as it is, dropped onto the plane of the surface's vector area and then fitted as
            ///< `ellipse` is: a flat surface keeps its shape. Where it crosses itself or lets a triangle
            ///< flip, a border between it and the circle; the ellipse where that stretches less
};

struct ParameterizationOptions {
  ParameterizationWeights weights = ParameterizationWeights::mean_value;
  DiskBorder border = DiskBorder::natural;
  /// Times that the map is solved again with weights divided by the stretch at the neighbour (Yoshizawa,
  /// Belyaev and Seidel 2004, "A fast and simple stretch-minimizing mesh parameterization"), as long as the
  /// L2 stretch falls. 0: the source's map.
  int stretch_rounds = 0;
};

/// A map of a disk to the plane.
struct Parameterization {
  std::vector<Vec2> uvs;  ///< one for each vertex
  /// Those used: uniform ones take over where the numbers of the others flipped a triangle.
  ParameterizationWeights weights = ParameterizationWeights::mean_value;
  DiskBorder border = DiskBorder::natural;  ///< the one taken
  /// Triangles that don't turn counter-clockwise, by exact signs. 0: the map is one-to-one, since its border
  /// doesn't cross itself.
  std::size_t flipped = 0;
  Stretch stretch;
};

/// Maps a disk of triangles (three indices each into `positions`, counter-clockwise) to the plane. The border
/// goes to a circle by arc length; the first border vertex, the one of lowest index, to (1, 0). Every inner
/// vertex is a weighted mean of its neighbours, so that no triangle flips but by rounding (Tutte 1963,
/// Floater 2003). One sparse factorisation serves both coordinates. Throws `InputError` when the triangles
/// are no disk (one piece, one border of at least three vertices, no handle), name vertices out of range, or
/// leave a vertex unused.
Parameterization parameterize_disk(std::span<const Vec3> positions, std::span<const Index> triangles,
                                   const ParameterizationOptions& options = {});

/// The stretch of any map. `uvs` holds one point for each vertex.
Stretch measure_stretch(std::span<const Vec3> positions, std::span<const Vec2> uvs,
                        std::span<const Index> triangles);

/// Triangles that don't turn counter-clockwise in the plane, by exact signs.
std::size_t count_flipped(std::span<const Vec2> uvs, std::span<const Index> triangles);

}  // namespace recede
