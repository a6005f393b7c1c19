// shell_section MODEL THICKNESS OUTPUT.svg: a cut through a surface and its envelope, with the layers
// between: along normals, along the gradient of the averaged distance, and the same after repair. MODEL is a
// mesh file, `notch`, a block with a groove, `box` or `saddle`; THICKNESS is a share of the longest side of
// its box.
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/shells/shell.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
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

// Of n x n quads over a square.
PolygonSoup make_sheet(Index n, const std::function<Vec3(double, double)>& place) {
  PolygonSoup soup;
  for (Index j = 0; j <= n; ++j) {
    for (Index i = 0; i <= n; ++i) soup.positions.push_back(place(2.0 * i / n - 1, 2.0 * j / n - 1));
  }
  for (Index j = 0; j < n; ++j) {
    for (Index i = 0; i < n; ++i) {
      const Index a = j * (n + 1) + i, above = a + n + 1;
      soup.add_face(std::array<Index, 4>{a, a + 1, above + 1, above});
    }
  }
  return soup;
}

// A power of two, so that sides meet bit by bit.
PolygonSoup make_box() {
  PolygonSoup soup;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const PolygonSoup part = make_sheet(32, [&](double u, double v) {
        Vec3 at;
        at[axis] = side;
        at[(axis + 1) % 3] = side * u;
        at[(axis + 2) % 3] = v;
        return at;
      });
      const auto first = static_cast<Index>(soup.positions.size());
      soup.positions.insert(soup.positions.end(), part.positions.begin(), part.positions.end());
      for (std::size_t f = 0; f < part.n_faces(); ++f) {
        std::vector<Index> face(part.face(f).begin(), part.face(f).end());
        for (Index& v : face) v += first;
        soup.add_face(face);
      }
    }
  }
  return soup;
}

// Its normals meet on both sides.
PolygonSoup make_saddle() {
  return make_sheet(48, [](double u, double v) { return Vec3(u, 0.9 * (u * u - v * v), -v); });
}

PolygonSoup read_model(const std::string& model) {
  if (model == "notch") return make_notch();
  if (model == "box") return make_box();
  if (model == "saddle") return make_saddle();
  return read_soup(model);
}

// The lines in which triangles meet the plane z = `height`: whole ones, as points on sides of triangles.
using Side = std::pair<Index, Index>;
std::vector<std::vector<Side>> cut(const std::vector<Vec3>& positions, const std::vector<Index>& triangles,
                                   double height) {
  std::map<Side, std::vector<Side>> next;  // both ways
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    std::vector<Side> ends;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = triangles[t + k], b = triangles[t + (k + 1) % 3];
      if ((positions[a].z() < height) != (positions[b].z() < height)) ends.push_back(std::minmax(a, b));
    }
    if (ends.size() != 2) continue;
    next[ends[0]].push_back(ends[1]);
    next[ends[1]].push_back(ends[0]);
  }
  std::vector<std::vector<Side>> lines;
  const auto follow = [&](Side at) {
    lines.push_back({at});
    for (std::vector<Side>* ways = &next[at]; !ways->empty(); ways = &next[at]) {
      const Side to = ways->back();
      ways->pop_back();
      std::vector<Side>& back = next[to];
      back.erase(std::find(back.begin(), back.end(), at));
      lines.back().push_back(at = to);
    }
  };
  for (const bool is_closed : {false, true}) {
    for (const auto& [side, ways] : next) {
      if (ways.size() == 1 || (is_closed && !ways.empty())) follow(side);
    }
  }
  return lines;
}

// In whole units of the picture, so that it is small.
constexpr double k_units = 1500;  // for the longest side of a panel

std::string path_of(const std::vector<Vec3>& positions, const std::vector<Index>& triangles, double height,
                    const Vec2& corner, double unit) {
  std::string path;
  for (const std::vector<Side>& line : cut(positions, triangles, height)) {
    Eigen::Vector2i last(0, 0);
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vec3 &a = positions[line[i].first], &b = positions[line[i].second];
      const Vec3 point = a + (height - a.z()) / (b.z() - a.z()) * (b - a);
      const Eigen::Vector2i at(static_cast<int>(std::lround((point.x() - corner.x()) / unit)),
                               static_cast<int>(std::lround((corner.y() - point.y()) / unit)));
      if (i == 0) {
        path += fmt::format("M{} {}l", at.x(), at.y());
      } else if (at != last) {
        path += fmt::format("{}{} {}", path.back() == 'l' ? "" : " ", at.x() - last.x(), at.y() - last.y());
      }
      last = at;
    }
  }
  return path;
}

std::string drawn(const Shell& shell, const Box3& box, double border, double unit) {
  constexpr int k_layers = 4;
  const double height = box.center().z();
  const Vec2 corner(box.min().x() - border, box.max().y() + border);
  const auto line = [&](const std::vector<Vec3>& positions, const char* color, double width) {
    return fmt::format("<path fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" d=\"{}\"/>\n", color, width,
                       path_of(positions, shell.base.corner_vertices, height, corner, unit));
  };
  std::string svg;
  for (const auto* layer : {&*shell.exterior, &*shell.interior}) {
    for (int k = 1; k <= k_layers; ++k) {
      std::vector<Vec3> positions = shell.base.positions;
      for (std::size_t v = 0; v < positions.size(); ++v)
        positions[v] += (layer->tops[v] - positions[v]) * k / k_layers;
      svg += line(positions, layer == &*shell.exterior ? "#3b76af" : "#c65d2e", 3.5);
    }
  }
  return svg + line(shell.base.positions, "#111", 6);
}

void draw(const std::string& model, double share, const std::string& output) {
  PolygonSoup surface = read_model(model);
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
  const Vec2 panel = box.sizes().head<2>() + Vec2::Constant(2 * border);
  const double unit = panel.maxCoeff() / k_units;
  const long width = std::lround(panel.x() / unit), height = std::lround(panel.y() / unit);
  std::ofstream file(output);
  file << fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\">\n", 3 * width, height)
       << "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";
  for (std::size_t i = 0; i < shells.size(); ++i) {
    file << fmt::format("<g transform=\"translate({} 0)\">\n", width * static_cast<long>(i))
         << drawn(shells[i], box, border, unit) << "</g>\n";
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
  std::cerr << "shell_section: THICKNESS isn't a number\n";
  return 2;
} catch (const recede::Error& error) {
  std::cerr << error.what() << '\n';
  return 1;
}
