// make_atlas INPUT OUTPUT.obj PICTURE.png: texture coordinates for a mesh that has none, and a picture of the
// charts on the surface and in the atlas.
#include <recede/geometry/chart_atlas.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/render/renderer.h>

#include <array>
#include <cmath>
#include <iostream>

namespace {

using namespace recede;

/// Neighbouring numbers get hues far from each other.
Vec4 chart_color(std::size_t chart, bool dark) {
  const double hue = 6.283185307 * std::fmod(0.618034 * static_cast<double>(chart), 1.0);
  const Vec3 light(0.5 + 0.4 * std::cos(hue), 0.5 + 0.4 * std::cos(hue - 2.1),
                   0.5 + 0.4 * std::cos(hue + 2.1));
  const Vec3 color = dark ? Vec3(0.45 * light) : light;
  return {color.x(), color.y(), color.z(), 1};
}

/// A material for every chart in two tones, by the squares of a checkerboard of 40 x 40 over the atlas.
void paint(PolygonSoup& soup, const AtlasResult& atlas) {
  soup.materials.clear();
  soup.face_materials.clear();
  for (std::size_t chart = 0; chart < atlas.charts.size(); ++chart) {
    for (const bool dark : {false, true}) soup.materials.push_back({"", chart_color(chart, dark), ""});
  }
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    Vec2 middle = Vec2::Zero();
    const Index first = soup.face_offsets[f];
    for (Index c = first; c < soup.face_offsets[f + 1]; ++c) middle += atlas.soup.corner_uvs[c];
    middle *= 40.0 / static_cast<double>(soup.face_size(f));
    const bool dark = std::fmod(std::floor(middle.x()) + std::floor(middle.y()), 2.0) > 0.5;
    soup.face_materials.push_back(2 * atlas.face_charts[f] + (dark ? 1 : 0));
  }
}

/// The atlas as a surface in the plane z = 0.
PolygonSoup flat(const AtlasResult& atlas) {
  PolygonSoup soup;
  soup.face_offsets = atlas.soup.face_offsets;
  for (const Vec2& uv : atlas.soup.corner_uvs) {
    soup.corner_vertices.push_back(static_cast<Index>(soup.positions.size()));
    soup.positions.emplace_back(uv.x(), uv.y(), 0);
  }
  return soup;
}

Image picture_of(const AtlasResult& atlas) {
  constexpr int k_size = 300;
  PolygonSoup surface = atlas.soup, plane = flat(atlas);
  surface.corner_normals.clear();
  paint(surface, atlas);
  paint(plane, atlas);
  const Camera camera = frame_points(surface.positions, {0.3, 0.35, 1}, Vec3::UnitY(), 0.4, k_size, 0.05);
  const std::vector<Vec3> square = {{0, 0, 0}, {1, 1, 0}};
  const Camera above = frame_points(square, Vec3::UnitZ(), Vec3::UnitY(), 0.05, k_size, 0.05);
  RenderOptions options;
  options.samples_per_pixel = 9;
  return side_by_side(
      std::array{render(Scene(surface), camera, options), render(Scene(plane), above, options)});
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::cerr << "usage: make_atlas INPUT OUTPUT.obj PICTURE.png\n";
    return 2;
  }
  recede::PolygonSoup soup = recede::read_soup(argv[1]);
  recede::merge_identical_vertices(soup);

  recede::AtlasOptions options;
  options.packing.resolution = 2048;
  const recede::AtlasResult atlas = recede::make_atlas(soup, options);
  std::cout << atlas.charts.size() << " charts, stretch " << atlas.stretch.l2 << ", " << atlas.flipped
            << " triangles flipped, " << 100 * atlas.occupancy << " % of the atlas used\n";

  recede::write_soup(argv[2], atlas.soup);
  recede::write_png(argv[3], picture_of(atlas));
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
