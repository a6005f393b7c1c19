#include <recede/geometry/error.h>
#include <recede/shells/texture_repeat.h>

#include <algorithm>
#include <cmath>

namespace recede {
namespace {

// Over vertices with triangles: others have no director.
double mean_thickness(const PolygonSoup& base, const ShellLayer& layer) {
  std::vector<unsigned char> is_used(base.positions.size(), 0);
  for (const Index v : base.corner_vertices) is_used[v] = 1;
  double sum = 0, n = 0;
  for (std::size_t v = 0; v < base.positions.size(); ++v) {
    if (is_used[v] == 0) continue;
    sum += (layer.tops[v] - base.positions[v]).norm();
    ++n;
  }
  return sum / n;
}

// Lengths on the surface of steps of 1 in u and in v: geometric means by area, on which a few slivers have
// little weight.
Vec2 lengths_of_coordinates(const PolygonSoup& base) {
  Vec2 sum = Vec2::Zero();
  double area = 0;
  for (std::size_t c = 0; c + 2 < base.corner_vertices.size(); c += 3) {
    const auto edge = [&](std::size_t k) -> Vec3 {
      return base.positions[base.corner_vertices[c + k]] - base.positions[base.corner_vertices[c]];
    };
    const Vec3 a = edge(1), b = edge(2);
    const Vec2 s = base.corner_uvs[c + 1] - base.corner_uvs[c],
               t = base.corner_uvs[c + 2] - base.corner_uvs[c];
    const double det = s.x() * t.y() - s.y() * t.x(), weight = a.cross(b).norm();
    const Vec2 lengths((t.y() * a - s.y() * b).norm(), (s.x() * b - t.x() * a).norm());
    if (!(weight > 0) || det == 0 || !(lengths.minCoeff() > 0)) continue;
    sum += weight * (lengths.array().log() - std::log(std::abs(det))).matrix();
    area += weight;
  }
  return area > 0 ? Vec2((sum / area).array().exp()) : Vec2(Vec2::Zero());
}

}  // namespace

Vec2 proportionate_repeat(const Shell& shell, ShellSide side, const Vec3& extent) {
  const std::optional<ShellLayer>& layer = side == ShellSide::interior ? shell.interior : shell.exterior;
  if (side == ShellSide::envelope || !layer) throw InputError("the shell has no layer on the texture's side");
  if (shell.base.corner_uvs.empty()) throw InputError("a textured shell needs texture coordinates");
  const double unit = mean_thickness(shell.base, *layer) / extent.z();
  const Vec2 repeat = lengths_of_coordinates(shell.base).cwiseQuotient(unit * extent.head<2>());
  return repeat.array().round().max(1.0);
}

}  // namespace recede
