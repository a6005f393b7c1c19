#include "hard_cases.h"

#include "simple_soups.h"
#include <recede/geometry/sample_models.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <limits>
#include <numbers>
#include <numeric>
#include <ostream>
#include <random>

namespace recede::test {

void append(PolygonSoup& to, const PolygonSoup& part) {
  const auto first = static_cast<Index>(to.positions.size());
  to.positions.insert(to.positions.end(), part.positions.begin(), part.positions.end());
  for (std::size_t f = 0; f < part.n_faces(); ++f) {
    std::vector<Index> face(part.face(f).begin(), part.face(f).end());
    for (Index& v : face) v += first;
    to.add_face(face);
  }
}

PolygonSoup transformed(PolygonSoup soup, double scale, const Vec3& offset) {
  for (Vec3& p : soup.positions) p = scale * p + offset;
  return soup;
}

PolygonSoup unwelded(const PolygonSoup& soup) {
  PolygonSoup result;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    std::vector<Index> face;
    for (const Index v : soup.face(f)) {
      face.push_back(static_cast<Index>(result.positions.size()));
      result.positions.push_back(soup.positions[v]);
    }
    result.add_face(face);
  }
  return result;
}

PolygonSoup with_duplicates(PolygonSoup soup) {
  const std::size_t n = soup.n_faces();
  for (std::size_t f = 0; f < n; f += 7) {
    const std::vector<Index> face(soup.face(f).begin(), soup.face(f).end());
    soup.add_face(face);
  }
  return soup;
}

PolygonSoup with_caps(PolygonSoup soup) {
  const std::size_t n = soup.n_faces();
  for (std::size_t f = 0; f < n; f += 11) {
    const Index a = soup.face(f)[0], b = soup.face(f)[1];
    soup.positions.push_back(0.5 * (soup.positions[a] + soup.positions[b]));
    soup.add_face(std::vector<Index>{a, b, static_cast<Index>(soup.positions.size() - 1)});
  }
  return soup;
}

PolygonSoup with_fins(PolygonSoup soup) {
  const std::size_t n = soup.n_faces();
  for (std::size_t f = 0; f < n; f += 50) {
    const Index a = soup.face(f)[0], b = soup.face(f)[1];
    soup.positions.push_back(1.2 * soup.positions[a]);
    soup.add_face(std::vector<Index>{a, b, static_cast<Index>(soup.positions.size() - 1)});
  }
  return soup;
}

PolygonSoup with_holes(const PolygonSoup& soup) {
  PolygonSoup result;
  result.positions = soup.positions;
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    if (f % 37 != 0) result.add_face(soup.face(f));
  }
  return result;
}

namespace {

constexpr double k_nan = std::numeric_limits<double>::quiet_NaN();
constexpr double k_infinity = std::numeric_limits<double>::infinity();

PolygonSoup cube(const Vec3& corner, double size) {
  PolygonSoup soup;
  for (int i = 0; i < 8; ++i) soup.positions.push_back(corner + size * Vec3(i & 1, i >> 1 & 1, i >> 2));
  for (const auto& q : std::vector<std::vector<Index>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    soup.add_face(std::vector<Index>{q[0], q[1], q[2]});
    soup.add_face(std::vector<Index>{q[0], q[2], q[3]});
  }
  return soup;
}

/// A comb of concave polygons, bent out of the plane.
PolygonSoup concave_polygons() {
  PolygonSoup soup;
  constexpr Index k_teeth = 40;
  const auto height = [](double x, double y) { return 0.05 * std::sin(3 * x) * std::cos(5 * y); };
  for (Index row = 0; row < 10; ++row) {
    std::vector<Index> face;
    for (Index i = 0; i <= 2 * k_teeth; ++i) {
      const double x = 0.1 * i, y = row + (i % 2 == 0 ? 0.0 : 0.8);
      face.push_back(static_cast<Index>(soup.positions.size()));
      soup.positions.emplace_back(x, y, height(x, y));
    }
    face.push_back(static_cast<Index>(soup.positions.size()));
    soup.positions.emplace_back(0.2 * k_teeth, row - 0.2, height(8, row));
    face.push_back(static_cast<Index>(soup.positions.size()));
    soup.positions.emplace_back(0, row - 0.2, height(0, row));
    std::reverse(face.begin(), face.end());
    soup.add_face(face);
  }
  return soup;
}

/// Two spheres that meet in one vertex.
PolygonSoup bow_tie() {
  PolygonSoup soup = make_displaced_sphere(500, true), other = soup;
  const Vec3 shift = 2 * soup.positions[0];
  for (Vec3& p : other.positions) p = shift - p;
  append(soup, other);
  return soup;
}

PolygonSoup with_coordinate(PolygonSoup soup, double value) {
  soup.positions[soup.positions.size() / 2].y() = value;
  return soup;
}

PolygonSoup with_unused_vertices(PolygonSoup soup) {
  for (int i = 0; i < 100; ++i) soup.positions.emplace_back(10 + i, 0, 0);
  return soup;
}

PolygonSoup turned_grid() {
  PolygonSoup soup = grid(40, true);
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  for (Vec3& p : soup.positions) p = turn * p;
  return soup;
}

/// A sheet 1 wide with waves 0.1 high.
PolygonSoup wavy_sheet(Index n) {
  PolygonSoup soup = grid(n, true);
  for (Vec3& p : soup.positions) p.z() = 0.1 * std::sin(5 * p.x()) * std::sin(4 * p.y());
  return soup;
}

PolygonSoup fan(Index n) {
  PolygonSoup soup;
  soup.positions.emplace_back(0, 0, 0.3);
  for (Index i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    soup.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  for (Index i = 0; i < n; ++i) soup.add_face(std::vector<Index>{0, 1 + i, 1 + (i + 1) % n});
  return soup;
}

}  // namespace

PolygonSoup sliver_strip(Index n) {
  PolygonSoup soup;
  for (Index i = 0; i <= n; ++i) {
    const double x = static_cast<double>(i) / n;
    soup.positions.emplace_back(x, 0, std::sin(3 * x));
    soup.positions.emplace_back(x, 1e-9, std::sin(3 * x));
  }
  for (Index i = 0; i < n; ++i) {
    soup.add_face(std::vector<Index>{2 * i, 2 * i + 2, 2 * i + 3});
    soup.add_face(std::vector<Index>{2 * i, 2 * i + 3, 2 * i + 1});
  }
  return soup;
}

PolygonSoup collapsed_grid(Index n) {
  PolygonSoup soup = grid(n, true);
  for (Vec3& p : soup.positions) {
    for (int axis = 0; axis < 2; ++axis) p[axis] = std::floor(p[axis] * n / 5) * 5 / n;
  }
  return soup;
}

PolygonSoup book_of_sheets(Index sheets, Index n) {
  PolygonSoup soup;
  for (Index s = 0; s < sheets; ++s) {
    PolygonSoup sheet = grid(n, true);
    const double angle = 0.5 * s;
    for (Vec3& p : sheet.positions) {
      p = {p.x() * std::cos(angle), p.y(),
           p.x() * std::sin(angle) + 0.1 * p.x() * p.x() * std::sin(6 * p.y())};
    }
    append(soup, sheet);
  }
  merge_identical_vertices(soup);
  return soup;
}

PolygonSoup loose_cubes(Index n) {
  PolygonSoup soup;
  for (Index i = 0; i < n; ++i) {
    append(soup, cube(Vec3(i % 12, i / 12 % 12, i / 144), 0.3 + 0.3 * (i % 7) / 7));
  }
  return soup;
}

PolygonSoup wound_wrong(const PolygonSoup& soup, Index seed) {
  PolygonSoup result;
  result.positions = soup.positions;
  std::mt19937 random(seed);
  for (std::size_t f = 0; f < soup.n_faces(); ++f) {
    std::vector<Index> face(soup.face(f).begin(), soup.face(f).end());
    if (random() % 3 == 0) std::reverse(face.begin(), face.end());
    result.add_face(face);
  }
  return result;
}

PolygonSoup double_sided_sheet(Index n) {
  PolygonSoup soup = wavy_sheet(n);
  const std::size_t faces = soup.n_faces();
  for (std::size_t f = 0; f < faces; ++f) {
    std::vector<Index> face(soup.face(f).rbegin(), soup.face(f).rend());
    soup.add_face(face);
  }
  return soup;
}

PolygonSoup touching_boxes() {
  // Each box of a 6 x 6 x 6 grid's surface; the second stands wall to wall with the first.
  PolygonSoup box;
  constexpr Index k_cells = 6;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      PolygonSoup wall = grid(k_cells, true);
      for (Vec3& p : wall.positions) {
        Vec3 q;
        q[axis] = side;
        q[(axis + 1) % 3] = side == 1 ? p.x() : p.y();
        q[(axis + 2) % 3] = side == 1 ? p.y() : p.x();
        p = q;
      }
      append(box, wall);
    }
  }
  PolygonSoup both = box;
  append(both, transformed(box, 1, Vec3(1, 0, 0)));
  merge_identical_vertices(both);
  return both;
}

PolygonSoup shuffled(const PolygonSoup& soup, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Index> order(soup.positions.size()), faces(soup.n_faces());
  std::iota(order.begin(), order.end(), Index{0});
  std::iota(faces.begin(), faces.end(), Index{0});
  std::shuffle(order.begin(), order.end(), random);
  std::shuffle(faces.begin(), faces.end(), random);
  PolygonSoup result;
  result.positions.resize(soup.positions.size());
  for (std::size_t v = 0; v < order.size(); ++v) result.positions[order[v]] = soup.positions[v];
  for (const Index f : faces) {
    std::vector<Index> face;
    for (const Index v : soup.face(f)) face.push_back(order[v]);
    std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(random() % face.size()), face.end());
    result.add_face(face);
  }
  return result;
}

std::vector<HardCase> hard_cases() {
  const PolygonSoup ball = make_displaced_sphere(2000, true);
  const PolygonSoup small_ball = make_displaced_sphere(300, true);
  std::vector<HardCase> cases;
  const auto add = [&](const char* name, const char* description, PolygonSoup soup) {
    cases.push_back({name, description, std::move(soup)});
  };
  add("slivers", "strip of triangles of aspect 1e9", sliver_strip(500));
  add("zero_area_caps", "sphere with triangles without area on every eleventh edge", with_caps(ball));
  add("duplicate_polygons", "sphere with every seventh face twice", with_duplicates(ball));
  add("concave_polygons", "combs of 83 corners, bent out of the plane", concave_polygons());
  add("prism_of_large_polygons", "prism over a polygon of 100 sides", prism(100));
  add("three_faces_at_an_edge", "sphere with fins on some edges",
      with_fins(make_displaced_sphere(1000, true)));
  add("bow_tie", "two spheres that meet in one vertex", bow_tie());
  add("wound_wrong", "sphere, a third of the faces flipped",
      wound_wrong(make_displaced_sphere(3000, true), 1));
  add("open_borders", "sphere without every 37th face", with_holes(ball));
  add("triangle_soup", "sphere of faces that share no vertex", unwelded(ball));
  add("double_sided_sheet", "wavy sheet, every face in both orientations", double_sided_sheet(20));
  add("book_of_sheets", "three sheets that share a spine", book_of_sheets(3, 20));
  add("hub", "cone of 3000 triangles around one vertex", fan(3000));
  add("loose_cubes", "100 cubes that don't touch", loose_cubes(100));
  add("far_from_the_origin", "sphere, 1e6 radii away", transformed(ball, 1, Vec3(1e6, -1e6, 1e6)));
  add("very_small", "sphere of radius 1e-9", transformed(ball, 1e-9, Vec3::Zero()));
  add("very_large", "sphere of radius 1e9", transformed(ball, 1e9, Vec3::Zero()));
  add("unreferenced_vertices", "sphere beside 100 vertices that no face uses", with_unused_vertices(ball));
  add("one_triangle", "nothing to collapse", soup_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  const auto add_flat = [&](const char* name, const char* description, PolygonSoup soup) {
    cases.push_back({name, description, std::move(soup), "", true});
  };
  add_flat("flat_grid", "open flat grid", grid(40, true));
  add_flat("turned_flat_grid", "the same, turned in space", turned_grid());
  add_flat("collapsed_grid", "flat grid, 96 % of the faces without area", collapsed_grid(50));
  add_flat("touching_boxes", "two boxes with a common wall", touching_boxes());
  const auto add_refused = [&](const char* name, const char* description, PolygonSoup soup) {
    cases.push_back({name, description, std::move(soup), "isn't finite"});
  };
  add_refused("not_a_number", "sphere with one coordinate NaN", with_coordinate(small_ball, k_nan));
  add_refused("infinite", "sphere with one infinite coordinate", with_coordinate(small_ball, k_infinity));
  add("empty", "no vertices, no faces", {});
  return cases;
}

std::vector<HardCase> large_hard_cases() {
  const PolygonSoup ball = make_displaced_sphere(20'000, true);
  const PolygonSoup far = transformed(ball, 1, Vec3(1e5, -1e5, 1e5));
  return {
      {"large_flat_grid", "open flat grid", grid(150, true), "", true},
      {"large_book_of_sheets", "three sheets that share a spine", book_of_sheets(3, 80)},
      {"large_triangle_soup", "sphere of faces that share no vertex", unwelded(ball)},
      {"far_by_1e5", "sphere, 1e5 radii away", far},
      {"large_not_a_number", "sphere with one coordinate NaN", with_coordinate(ball, k_nan), "isn't finite"},
      {"large_collapsed_grid", "flat grid, 96 % of the faces without area", collapsed_grid(100), "", true},
      {"many_loose_cubes", "1500 cubes that don't touch", loose_cubes(1500)},
      {"large_wound_wrong", "wavy sheet, a third of the faces flipped", wound_wrong(wavy_sheet(60), 1)},
  };
}

void PrintTo(const HardCase& hard_case, std::ostream* out) { *out << hard_case.name; }

}  // namespace recede::test
