#include <recede/lod/detail/lattice_seeds.h>

#include <array>
#include <cmath>

namespace recede::detail {

namespace {

constexpr int k_most_halvings = 24;
constexpr double k_worth_halving = 1.3;  // times as many points without as with it

// Sides of a lattice's triangles: w along u, h across. With second derivatives as a metric, an equilateral
// triangle of side s deviates by s^2 / 6, half of its circle's squared radius.
Vec2 spacing_for(const DerivativeBounds& most, const ParameterBox& part, double tolerance) {
  const Vec2 sizes = part.sizes();
  Vec2 spacing(INFINITY, INFINITY);
  // The mixed derivative goes to both, by the shape that the lattice will have.
  double of_u = most.uu, of_v = most.vv;
  for (int round = 0; round < 3; ++round) {
    const double side = std::sqrt(6 * tolerance);
    spacing.x() = of_u > 0 ? side / std::sqrt(of_u) : INFINITY;
    spacing.y() = of_v > 0 ? std::sqrt(0.75) * side / std::sqrt(of_v) : INFINITY;
    const double width = std::min(spacing.x(), sizes.x()), height = std::min(spacing.y(), sizes.y());
    if (!(width > 0 && height > 0)) break;
    of_u = most.uu + most.uv * height / width;
    of_v = most.vv + most.uv * width / height;
  }
  // Where one row of triangles reaches across, it is made of triangles with right angles: s^2 / 8 each way.
  if (spacing.x() >= sizes.x() || spacing.y() >= sizes.y()) spacing *= std::sqrt(8.0 / 6.0);
  return spacing;
}

// What is the same for all cells.
struct Lattice {
  const SurfaceBounds& bounds;
  Vec2 whole;  // the rectangle's sides
  double tolerance;
  const std::function<void(const Vec2&, const Vec2&)>& visit;
};

double n_points(const ParameterBox& part, const Vec2& spacing) {
  return (1 + part.sizes().x() / spacing.x()) * (1 + part.sizes().y() / spacing.y());
}

void fill(const ParameterBox& part, const Vec2& spacing,
          const std::function<void(const Vec2&, const Vec2&)>& visit) {
  const Vec2 sizes = part.sizes();
  const double columns = std::ceil(sizes.x() / spacing.x()), rows = std::ceil(sizes.y() / spacing.y());
  const Vec2 step(sizes.x() / std::max(columns, 1.0), sizes.y() / std::max(rows, 1.0));
  // Half a step from the border, every other row moved by a fourth of a step to both sides.
  for (double row = 0; row < std::max(rows, 1.0); ++row) {
    const double shift = std::fmod(row, 2) == 0 ? -0.25 : 0.25;
    for (double column = 0; column < std::max(columns, 1.0); ++column) {
      visit(part.min() + Vec2(column + 0.5 + (columns > 1 ? shift : 0.0), row + 0.5).cwiseProduct(step),
            step);
    }
  }
}

void visit_cell(const Lattice& lattice, const ParameterBox& cell, int halvings_left) {
  const DerivativeBounds most = lattice.bounds.derivatives(cell);
  const Vec2 sizes = cell.sizes();
  const double whole = (sizes.x() * sizes.x() * most.uu + 2 * sizes.x() * sizes.y() * most.uv +
                        sizes.y() * sizes.y() * most.vv) /
                       8;
  if (whole <= lattice.tolerance) return;
  const Vec2 spacing = spacing_for(most, cell, lattice.tolerance);
  const int axis = sizes.x() / spacing.x() >= sizes.y() / spacing.y() ? 0 : 1;
  // Small cells aren't worth a look: a few points more or less.
  if (halvings_left > 0 && n_points(cell, spacing) > 8) {
    std::array<ParameterBox, 2> parts{cell, cell};
    parts[0].max()[axis] = parts[1].min()[axis] = cell.center()[axis];
    double with = 0;
    // Two levels of halves, as one alone may be as bad by chance.
    for (const ParameterBox& part : parts) {
      std::array<ParameterBox, 2> quarters{part, part};
      const int other = 1 - axis;
      quarters[0].max()[other] = quarters[1].min()[other] = part.center()[other];
      for (const ParameterBox& quarter : quarters) {
        const Vec2 here = spacing_for(lattice.bounds.derivatives(quarter), quarter, lattice.tolerance);
        with += quarter.sizes().x() / here.x() * quarter.sizes().y() / here.y();
      }
    }
    const double without = sizes.x() / spacing.x() * sizes.y() / spacing.y();
    if (without > k_worth_halving * with) {
      for (const ParameterBox& part : parts) visit_cell(lattice, part, halvings_left - 1);
      return;
    }
  }
  // From border to border no point is needed in between.
  if (spacing.x() < lattice.whole.x() && spacing.y() < lattice.whole.y()) fill(cell, spacing, lattice.visit);
}

}  // namespace

void each_lattice_seed(const SurfaceBounds& bounds, const ParameterBox& part, double tolerance,
                       const std::function<void(const Vec2& uv, const Vec2& spacing)>& visit) {
  visit_cell({bounds, part.sizes(), tolerance, visit}, part, k_most_halvings);
}

}  // namespace recede::detail
