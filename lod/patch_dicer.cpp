#include <recede/geometry/error.h>
#include <recede/lod/detail/patch_dicer.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {
namespace {

/// A direction of length 1; opposite ones that cancel out move nothing.
Vec3 unit_of(const Vec3& direction) {
  const double length = direction.norm();
  constexpr double k_vanishing = 1e-9;
  return length > k_vanishing ? Vec3(direction / length) : Vec3(Vec3::Zero());
}

/// A step no larger than a box, to which `DisplacedBase::Triangle::reach` holds.
Vec2 no_larger(const Vec2& step, const Vec2& box) { return step.cwiseMin(box).cwiseMax(-box); }

double twice_area(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

/// What the two ends count at the vertices of an edge: as linear on the screen as perspective is.
struct PatchDicer::EdgeWeights {
  double pieces, from, to;  // of the ends: inverse depths

  EdgeWeights(const ViewEdge& edge, const std::vector<ViewPoint>& views)
      : pieces(edge.pieces), from(1 / views[edge.from].depth), to(1 / views[edge.to].depth) {}
  template <typename Value>
  Value at(double i, const Value& a, const Value& b) const {
    const double first = (pieces - i) * from, second = i * to;
    return (first * a + second * b) / (first + second);
  }
  /// How much of the difference of both ends a step makes.
  double step(double i) const {
    const double sum = (pieces - i) * from + i * to;
    return pieces * from * to / (sum * sum);
  }
};

Vec3 PatchDicer::moved(const Vec3& position, const Vec3& unit, double height, double& largest_move) const {
  largest_move = std::max(largest_move, std::abs(height));
  return position + height * unit;
}

double PatchDicer::facing(const Vec3& position, const Vec3& unit) const {
  const Vec3 to_eye = space_.eye() - position;
  const double distance = to_eye.norm();
  return distance > 0 ? unit.dot(to_eye) / distance : 0;
}

/// Side of a voxel at a point in texels of level 0, which are as dense as in the mean of the triangles
/// around.
double PatchDicer::texels_at(std::size_t point) const {
  double sum = 0;
  std::size_t n = 0;
  for (const auto& [t, k] : patches_.uses_of_point(point)) {
    const ViewPatch& patch = patches_.patches[t];
    const Vec3& a = patches_.positions[patch.points[0]];
    const Vec3 ab = patches_.positions[patch.points[1]] - a, ac = patches_.positions[patch.points[2]] - a;
    const Vec2 uv_ab = (patch.uvs[1] - patch.uvs[0]).cwiseProduct(map_size_),
               uv_ac = (patch.uvs[2] - patch.uvs[0]).cwiseProduct(map_size_);
    const double area = ab.cross(ac).stableNorm();  // its square may overflow
    const double density = std::sqrt(std::abs(twice_area(uv_ab, uv_ac)) / area);
    if (!std::isfinite(density)) continue;
    sum += density;
    ++n;
  }
  if (n == 0) return 0;
  return sum / static_cast<double>(n) * space_.voxel_size(patches_.views[point].depth);
}

/// The longest side of a patch in the map, texels of level 0.
double PatchDicer::longest_side(const ViewPatch& patch) const {
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k)
    longest = std::max(longest, (patch.uvs[(k + 1) % 3] - patch.uvs[k]).cwiseProduct(map_size_).norm());
  return longest;
}

void PatchDicer::place_corner(std::size_t point, double& largest_move) const {
  const Vec3& position = patches_.positions[point];
  const Vec3 unit = unit_of(patches_.directions[point]);
  const double texels = texels_at(point), front = facing(position, unit);
  const auto uses = patches_.uses_of_point(point);
  const auto uv_of = [&](const ViewPatches::Use& use) -> const Vec2& {
    return patches_.patches[use.patch].uvs[use.k];
  };
  double sum = 0, n = 0;
  for (auto use = uses.begin(); use != uses.end(); ++use) {
    const Vec2& uv = uv_of(*use);
    if (std::any_of(uses.begin(), use, [&](const auto& before) { return uv_of(before) == uv; })) continue;
    // No larger than the triangles on this side of a seam, as `no_larger` has it.
    double longest = 0;
    for (auto same = use; same != uses.end(); ++same) {
      if (uv_of(*same) == uv) longest = std::max(longest, longest_side(patches_.patches[same->patch]));
    }
    sum += heights_.at_corner(uv, std::min(texels, longest), front);
    ++n;
  }
  mesh_.positions[mesh_.corner_vertices[point]] = moved(position, unit, sum / n, largest_move);
}

void PatchDicer::place_edge(std::size_t number, double& largest_move) const {
  const ViewEdge& edge = patches_.edges[number];
  const EdgeWeights weights(edge, patches_.views);
  // Texture coordinates at both ends, on each side of a seam.
  constexpr std::size_t k_most_sides = 8;  // more touch only where the surface is no manifold
  std::array<std::pair<Vec2, Vec2>, k_most_sides> sides;
  std::size_t n_sides = 0;
  for (const auto& [t, k] : patches_.uses_of_edge(number)) {
    const ViewPatch& patch = patches_.patches[t];
    std::pair<Vec2, Vec2> side(patch.uvs[k], patch.uvs[(k + 1) % 3]);
    if (patch.points[k] != edge.from) std::swap(side.first, side.second);
    const auto end = sides.begin() + static_cast<std::ptrdiff_t>(n_sides);
    if (n_sides < k_most_sides && std::find(sides.begin(), end, side) == end) sides[n_sides++] = side;
  }
  const auto &positions = patches_.positions, &directions = patches_.directions;
  for (std::uint32_t i = 1; i < edge.pieces; ++i) {
    const Vec3 position = weights.at(i, positions[edge.from], positions[edge.to]);
    const Vec3 unit = unit_of(weights.at(i, directions[edge.from], directions[edge.to]));
    const double front = facing(position, unit);
    double sum = 0;
    for (std::size_t s = 0; s < n_sides; ++s) {
      const auto& [from, to] = sides[s];
      const Vec2 whole = to - from, step = no_larger(weights.step(i) * whole, whole.cwiseAbs());
      sum += heights_.on_edge(weights.at(i, from, to), step, front);
    }
    mesh_.positions[edge.first_vertex + i - 1] =
        moved(position, unit, sum / static_cast<double>(n_sides), largest_move);
  }
}

void PatchDicer::load_border(const ViewPatch& patch, Workspace& work) const {
  const GridSweep& sweep = work.sweep;
  for (std::size_t k = 0; k < 3; ++k) {
    work.vertices[k] = static_cast<Index>(mesh_.corner_vertices[patch.points[k]]);
    work.uvs[k] = patch.uvs[k];
    const ViewEdge& edge = patches_.edges[patch.edges[k]];
    const EdgeWeights weights(edge, patches_.views);
    const bool forwards = edge.from == patch.points[k];
    const Vec2 &from = patch.uvs[forwards ? k : (k + 1) % 3], &to = patch.uvs[forwards ? (k + 1) % 3 : k];
    const std::size_t n = sweep.n_on_edge(k), first = sweep.first_on_edge(k);
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t i = forwards ? j : n - 1 - j;  // along the edge, without its end
      work.vertices[first + j] = static_cast<Index>(edge.first_vertex + i);
      work.uvs[first + j] = weights.at(static_cast<double>(i + 1), from, to);
    }
  }
  for (std::size_t v = 0; v < sweep.n_border(); ++v) work.positions[v] = mesh_.positions[work.vertices[v]];
}

void PatchDicer::place_inside(const ViewPatch& patch, const PatchPlace& place, Workspace& work) const {
  const SweepPlan& plan = work.sweep.plan();
  const std::array<std::size_t, 3> k{plan.a, plan.b, plan.c};
  std::array<double, 3> q{};
  std::array<Vec3, 3> position, direction;
  std::array<Vec2, 3> uv;
  for (std::size_t i = 0; i < 3; ++i) {
    const Index p = patch.points[k[i]];
    q[i] = 1 / patches_.views[p].depth;
    position[i] = q[i] * patches_.positions[p];
    direction[i] = q[i] * patches_.directions[p];
    uv[i] = q[i] * patch.uvs[k[i]];
  }
  const GridSweep::Steps steps = work.sweep.steps();
  const auto change = [&](const auto& values, double b, double c) {
    return (b * (values[1] - values[0]) + c * (values[2] - values[0])).eval();
  };
  const Vec2 uv_sweep = change(uv, steps.b_sweep, steps.c_sweep),
             uv_side = change(uv, steps.b_side, steps.c_side);
  const double q_sweep = steps.b_sweep * (q[1] - q[0]) + steps.c_sweep * (q[2] - q[0]);
  const double q_side = steps.b_side * (q[1] - q[0]) + steps.c_side * (q[2] - q[0]);
  const auto& uvs = patch.uvs;
  const Vec2 box = uvs[0].cwiseMax(uvs[1]).cwiseMax(uvs[2]) - uvs[0].cwiseMin(uvs[1]).cwiseMin(uvs[2]);

  for (std::size_t v = work.sweep.n_border(), i = 0; i < place.n_inside; ++v, ++i) {
    GridSweep::Weights w = work.sweep.weights(work.sweep.node(v));
    // Rounded edges may leave a vertex a little outside of the triangle, which perspective must not enlarge.
    if (w.a < 0 || w.b < 0 || w.c < 0) {
      w = {std::max(w.a, 0.0), std::max(w.b, 0.0), std::max(w.c, 0.0)};
      const double sum = w.a + w.b + w.c;
      w = {w.a / sum, w.b / sum, w.c / sum};
    }
    const double depth = 1 / (w.a * q[0] + w.b * q[1] + w.c * q[2]);
    const Vec3 at = depth * (w.a * position[0] + w.b * position[1] + w.c * position[2]);
    const Vec3 unit = unit_of(depth * (w.a * direction[0] + w.b * direction[1] + w.c * direction[2]));
    const Vec2 place_in_map = depth * (w.a * uv[0] + w.b * uv[1] + w.c * uv[2]);
    const Vec2 side = no_larger(depth * (uv_sweep - q_sweep * place_in_map), box),
               other_side = no_larger(depth * (uv_side - q_side * place_in_map), box);
    const double height = heights_.inside(place_in_map, side, other_side, facing(at, unit));
    work.positions[v] = moved(at, unit, height, work.largest_move);
    work.uvs[v] = place_in_map;
    work.vertices[v] = static_cast<Index>(place.first_vertex + i);
    mesh_.positions[place.first_vertex + i] = work.positions[v];
  }
}

void PatchDicer::write_triangles(const PatchPlace& place, Workspace& work) const {
  const bool with_normals = !mesh_.vertex_normals.empty();
  if (with_normals) std::fill(work.normals.begin(), work.normals.end(), Vec3(Vec3::Zero()));
  std::size_t corner = 3 * place.first_triangle;
  const std::size_t end = corner + 3 * place.n_triangles;
  work.sweep.triangulate([&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    if (corner == end) throw Error("a swept triangle has more parts than a disk");  // never seen
    for (const std::uint32_t v : {i, j, k}) {
      mesh_.corners[corner] = work.vertices[v];
      mesh_.corner_uvs[corner++] = work.uvs[v];
    }
    if (!with_normals) return;
    const Vec3& a = work.positions[i];
    const Vec3 normal = (work.positions[j] - a).cross(work.positions[k] - a);
    for (const std::uint32_t v : {i, j, k}) work.normals[v] += normal;
  });
  if (corner != end) throw Error("a swept triangle has fewer parts than a disk");  // never seen
  if (!with_normals) return;
  for (std::size_t v = 0; v < place.n_border; ++v)
    mesh_.border_normals[place.first_border + v] = work.normals[v];
  for (std::size_t i = 0; i < place.n_inside; ++i)
    mesh_.vertex_normals[place.first_vertex + i] = work.normals[place.n_border + i];
}

void PatchDicer::dice(std::size_t number, Workspace& work) const {
  const ViewPatch& patch = patches_.patches[number];
  const PatchPlace& place = mesh_.places[number];
  work.sweep.set(voxels(patch));
  const std::size_t n = work.sweep.n_border() + work.sweep.n_inside();
  work.vertices.resize(n);
  work.uvs.resize(n);
  work.positions.resize(n);
  work.normals.resize(n);
  load_border(patch, work);
  if (place.n_inside > 0) place_inside(patch, place, work);
  write_triangles(place, work);
}

}  // namespace recede::detail
