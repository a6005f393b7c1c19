// subdivision_surface PICTURE.png: a control mesh of 30 quads, its limit surface, and that surface displaced
// by a map, side by side.
#include <recede/geometry/error.h>
#include <recede/geometry/subdivision_surface.h>
#include <recede/render/displaced_mesh.h>
#include <recede/render/renderer.h>

#include <array>
#include <cmath>
#include <iostream>
#include <map>
#include <numbers>
#include <set>
#include <vector>

namespace {

using namespace recede;

constexpr int k_charts = 6;  // in a row of the unit square; the map has 6 x 6

/// A cube with a cube on each of its six sides: every face is a chart of its own.
PolygonSoup make_jack() {
  using Cell = std::array<int, 3>;
  std::set<Cell> cells{{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  PolygonSoup soup;
  std::map<Cell, Index> corners;
  for (const Cell& cell : cells) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 1}) {
        Cell beyond = cell;
        beyond[axis] += side;
        if (cells.contains(beyond)) continue;
        const std::size_t first = (axis + (side > 0 ? 1 : 2)) % 3, second = (axis + (side > 0 ? 2 : 1)) % 3;
        std::vector<Index> face;
        for (const auto& [a, b] : {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
          Cell corner = cell;
          corner[axis] += side > 0 ? 1 : 0;
          corner[first] += a;
          corner[second] += b;
          const auto [place, is_new] = corners.try_emplace(corner, static_cast<Index>(soup.positions.size()));
          if (is_new) soup.positions.emplace_back(corner[0] - 0.5, corner[1] - 0.5, corner[2] - 0.5);
          face.push_back(place->second);
          const auto chart = static_cast<int>(soup.n_faces());
          soup.corner_uvs.push_back(
              Vec2(chart % k_charts + 0.05 + 0.9 * a, chart / k_charts + 0.05 + 0.9 * b) / k_charts);
        }
        soup.add_face(face);
      }
    }
  }
  return soup;
}

/// A quilt: three by three cushions in every chart, sewn down along its border.
DisplacementMap make_quilt(int size) {
  std::vector<float> heights;
  const auto along = [](double x) {
    const double within = (x * k_charts - std::floor(x * k_charts) - 0.05) / 0.9;
    return std::abs(std::sin(3 * std::numbers::pi * std::clamp(within, 0.0, 1.0)));
  };
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double height = along((x + 0.5) / size) * along(1 - (y + 0.5) / size);
      heights.push_back(static_cast<float>(0.07 * std::sqrt(height)));
    }
  }
  return DisplacementMap(size, size, std::move(heights));
}

Image picture_of(const PolygonSoup& soup, const PolygonSoup& framed, const Vec4& color, bool wireframe) {
  PolygonSoup painted = soup;
  painted.materials = {{"", color, ""}};
  painted.face_materials.assign(painted.n_faces(), 0);
  const Camera camera = frame_points(framed.positions, {0.5, 0.45, 1}, Vec3::UnitY(), 0.4, 300, 0.04);
  RenderOptions options;
  options.samples_per_pixel = 9;
  if (wireframe) options.wireframe.emplace();
  return render(Scene(painted), camera, options);
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: subdivision_surface PICTURE.png\n";
    return 2;
  }
  const recede::PolygonSoup control = make_jack();
  std::vector<recede::SubdivisionCrease> creases;
  for (const recede::Index v : {0u, 1u, 2u, 3u})
    creases.push_back({control.face(0)[v], control.face(0)[(v + 1) % 4], 10});

  recede::SubdivisionOptions options;
  options.error = 0.005;  // units of the control mesh
  options.creases = creases;
  const recede::SubdivisionResult base = recede::subdivide(control, options);
  std::cout << control.n_faces() << " faces became " << base.soup.n_faces() << " at level " << base.level
            << ", off by about " << base.error_estimate << '\n';

  const recede::DisplacedMesh quilted(base.soup, make_quilt(1024));
  std::cout << quilted.small_triangles() << " small triangles for rays, none of them stored\n";

  recede::SubdivisionOptions fine = options;
  fine.error = 0.0005;
  recede::write_png(
      argv[1], recede::side_by_side(std::array{
                   picture_of(control, control, {0.75, 0.75, 0.75, 1}, true),
                   picture_of(recede::subdivide(control, fine).soup, control, {0.55, 0.65, 0.8, 1}, false),
                   picture_of(quilted.tessellate(), control, {0.8, 0.55, 0.4, 1}, false)}));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
