// shell_section MODEL THICKNESS OUTPUT.svg: a cut through a surface and its envelope, with the layers
// between: along normals, along the gradient of the averaged distance, and the same after repair. MODEL is a
// mesh file or `notch`, a block with a groove; THICKNESS is a share of the longest side of its box.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/shells/shell.h>

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace recede;

// A bar along z whose outline is a block with a narrow groove from above.
PolygonSoup make_notch() {
  std::vector<Vec2> outline;
  const std::vector<Vec2> corners{{-1, -0.6}, {1, -0.6},    {1, 0.6}, {0.25, 0.6},
                                  {0, -0.2},  {-0.25, 0.6}, {-1, 0.6}};
  constexpr int k_parts = 12, k_slices = 30;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 &from = corners[i], &to = corners[(i + 1) % corners.size()];
    for (int k = 0; k < k_parts; ++k) outline.push_back(from + (to - from) * k / k_parts);
  }
  const auto n = static_cast<Index>(outline.size());
  PolygonSoup soup;
  for (int slice = 0; slice <= k_slices; ++slice) {
    for (const Vec2& point : outline)
      soup.positions.emplace_back(point.x(), point.y(), 3.0 * slice / k_slices - 1.5);
  }
  for (Index slice = 0; slice < k_slices; ++slice) {
    for (Index i = 0; i < n; ++i) {
      const Index a = slice * n + i, b = slice * n + (i + 1) % n;
      soup.add_face(std::array<Index, 4>{a, b, b + n, a + n});
    }
  }
  return soup;
}

// The lines in which triangles meet the plane z = `height`.
std::string cut(const std::vector<Vec3>& positions, const std::vector<Index>& triangles, double height) {
  std::string path;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    std::vector<Vec3> ends;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 &a = positions[triangles[t + k]], &b = positions[triangles[t + (k + 1) % 3]];
      if ((a.z() < height) == (b.z() < height)) continue;
      ends.push_back(a + (height - a.z()) / (b.z() - a.z()) * (b - a));
    }
    if (ends.size() != 2) continue;
    path += fmt::format("M{:.3f} {:.3f}L{:.3f} {:.3f}", ends[0].x(), -ends[0].y(), ends[1].x(), -ends[1].y());
  }
  return path;
}

std::string drawn(const Shell& shell, const Box3& box, double width) {
  constexpr int k_layers = 4;
  const double height = box.center().z();
  const auto line = [&](const std::vector<Vec3>& positions, const char* color, double share) {
    return fmt::format("<path fill=\"none\" stroke=\"{}\" stroke-width=\"{:.4g}\" d=\"{}\"/>\n", color,
                       share * width, cut(positions, shell.base.corner_vertices, height));
  };
  std::string svg;
  for (const auto* layer : {&*shell.exterior, &*shell.interior}) {
    for (int k = 1; k <= k_layers; ++k) {
      std::vector<Vec3> positions = shell.base.positions;
      for (std::size_t v = 0; v < positions.size(); ++v)
        positions[v] += (layer->tops[v] - positions[v]) * k / k_layers;
      svg += line(positions, layer == &*shell.exterior ? "#3b76af" : "#c65d2e", 0.5);
    }
  }
  return svg + line(shell.base.positions, "#111", 1);
}

void draw(const std::string& model, double share, const std::string& output) {
  PolygonSoup surface = model == "notch" ? make_notch() : read_soup(model);
  merge_identical_vertices(surface);
  const Box3 box = bounding_box(surface);
  const double size = box.sizes().maxCoeff(), border = 1.15 * share * size;
  ShellOptions options;
  options.thickness = share * size;
  options.side = ShellSide::envelope;
  options.repair = false;
  options.method = DirectorMethod::normals;
  std::vector<Shell> shells{build_shell(surface, options)};
  options.method = DirectorMethod::averaged_distance;
  shells.push_back(build_shell(surface, options));
  options.repair = true;
  shells.push_back(build_shell(surface, options));
  const double step = box.sizes().x() + 2 * border;
  std::ofstream file(output);
  file << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"" << box.min().x() - border << ' '
       << -box.max().y() - border << ' ' << step * static_cast<double>(shells.size()) << ' '
       << box.sizes().y() + 2 * border
       << "\">\n<rect x=\"-1e6\" y=\"-1e6\" width=\"2e6\" height=\"2e6\" fill=\"white\"/>\n";
  for (std::size_t i = 0; i < shells.size(); ++i) {
    file << "<g transform=\"translate(" << step * static_cast<double>(i) << " 0)\">\n"
         << drawn(shells[i], box, 0.004 * size) << "</g>\n";
    const ShellThickness outside = reached_thickness(shells[i], *shells[i].exterior),
                         inside = reached_thickness(shells[i], *shells[i].interior);
    std::cout << (shells[i].is_valid() ? "valid" : "not valid") << ", " << 100 * outside.mean
              << " % outside, " << 100 * inside.mean << " % inside\n";
  }
  file << "</svg>\n";
  if (!file.flush()) throw InputError::in_file(output, "can't be written");
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::cerr << "usage: shell_section MODEL THICKNESS OUTPUT.svg\n";
    return 2;
  }
  draw(argv[1], std::stod(argv[2]), argv[3]);
} catch (const std::logic_error&) {
  std::cerr << "shell_section: THICKNESS is a number\n";
  return 2;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
