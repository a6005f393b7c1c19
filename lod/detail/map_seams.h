// Seams of baked maps: heights on both sides of an edge whose triangles lie apart in the atlas.
#pragma once

#include <recede/lod/detail/map_surface.h>

#include <functional>

namespace recede::detail {

/// An edge of the surface as two segments of the atlas. Both run the same way along the edge.
struct Seam {
  std::array<Vec2, 2> here, there;
};

/// All seams. Where an edge has more than two triangles, the first one's side meets each of the others that
/// lie elsewhere.
std::vector<Seam> find_seams(const PolygonSoup& surface);

/// Largest difference between both sides of a seam by bilinear lookup: exact, since it is
/// quadratic in pieces. `height(texel)` gives the heights.
double largest_difference(const std::vector<Seam>& seams, int size,
                          const std::function<double(Index)>& height);

/// Changes heights so that both sides agree better: minimises the sum of squared changes, times `costs` of
/// the texels, and, times `weight`, the squared differences integrated along the seams in texels. One sparse
/// factorisation. A weight of 0 changes nothing.
void close_seams(const std::vector<Seam>& seams, int size, double weight, const std::vector<double>& costs,
                 std::vector<double>& heights);

/// The same with a weight for each piece of a seam, which grows until its differences are below about
/// `tolerance`: nowhere more is given up than that needs.
void close_seams_within(const std::vector<Seam>& seams, int size, double tolerance,
                        const std::vector<double>& costs, std::vector<double>& heights);

/// Moves samples of 16 bits near seams by single units until the sides differ by less than one, as far as
/// that gets.
void repair_samples(const std::vector<Seam>& seams, int size, std::vector<std::uint16_t>& samples);

}  // namespace recede::detail
