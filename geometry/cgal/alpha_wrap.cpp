#include <recede/geometry/alpha_wrap.h>
#include <recede/geometry/error.h>

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

constexpr double k_least_alpha = 1e-4;  // of the diagonal

struct WrapLengths {
  double alpha, offset;
};

WrapLengths lengths_of(const AlphaWrapOptions& options, double diagonal) {
  constexpr double k_offset = 30;
  if (!(options.alpha > 0 && std::isfinite(options.alpha))) throw OptionError("a wrap's alpha is above 0");
  if (!(options.alpha >= k_least_alpha * diagonal))
    throw OptionError("a wrap's alpha is at least a ten-thousandth of the diagonal of the model's box");
  if (!(options.offset >= 0 && std::isfinite(options.offset)))
    throw OptionError("a wrap's offset is 0 or more");
  return {options.alpha, options.offset > 0 ? options.offset : options.alpha / k_offset};
}

}  // namespace

bool can_alpha_wrap() { return true; }

PolygonSoup alpha_wrap(const PolygonSoup& soup, const AlphaWrapOptions& options, Progress* progress) {
  validate(soup, "wrap");
  const std::vector<Index> triangles = triangulate(soup);
  const auto has_area = [&](std::size_t t) {
    const Vec3 &a = soup.positions[triangles[t]], &b = soup.positions[triangles[t + 1]],
               &c = soup.positions[triangles[t + 2]];
    return (b - a).cross(c - a).norm() > 0;
  };
  bool is_empty = true;
  for (std::size_t t = 0; t < triangles.size() && is_empty; t += 3) is_empty = !has_area(t);
  if (is_empty) throw InputError("a wrap needs a surface with area");
  // Around the origin and about 1 large, where the library's own constants are right.
  const Box3 box = bounding_box(soup);
  const double diagonal = box.diagonal().norm();
  const auto [alpha, offset] = lengths_of(options, diagonal);
  report_progress(progress, "wrap", 0);
  std::vector<Point> points;
  points.reserve(soup.positions.size());
  for (const Vec3& position : soup.positions) {
    const Vec3 p = (position - box.center()) / diagonal;
    points.emplace_back(p.x(), p.y(), p.z());
  }
  std::vector<std::array<std::size_t, 3>> faces;
  for (std::size_t t = 0; t < triangles.size(); t += 3) {
    if (has_area(t)) faces.push_back({triangles[t], triangles[t + 1], triangles[t + 2]});
  }
  CGAL::Surface_mesh<Point> wrap;
  CGAL::alpha_wrap_3(points, faces, alpha / diagonal, offset / diagonal, wrap);
  PolygonSoup result;
  for (const auto v : wrap.vertices()) {
    const Point& p = wrap.point(v);
    result.positions.push_back(box.center() + diagonal * Vec3(p.x(), p.y(), p.z()));
  }
  for (const auto f : wrap.faces()) {
    std::array<Index, 3> corners{};
    std::size_t k = 0;
    for (const auto v : CGAL::vertices_around_face(wrap.halfedge(f), wrap)) corners.at(k++) = v.idx();
    result.add_face(corners);
  }
  report_progress(progress, "wrap", 1);
  return result;
}

}  // namespace recede
