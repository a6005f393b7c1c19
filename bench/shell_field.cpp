// The averaged distance: errors by opening, and what an evaluation takes.
#include "billboard_models.h"
#include "measurement.h"
#include "plot_sheet.h"
#include "shell_run.h"
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace recede::bench {
namespace {

/// In front of random faces, `nearest` to `farthest` diagonals away, evenly by logarithms.
std::vector<Vec3> points_near(const PolygonSoup& surface, std::size_t n, double nearest, double farthest) {
  const double diagonal = bounding_box(surface).diagonal().norm();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Vec3> points;
  while (points.size() < n) {
    const std::size_t f = random() % surface.n_faces();
    const Vec3 area = vector_area(surface, f);
    if (!(area.norm() > 0)) continue;
    const double away = diagonal * nearest * std::pow(farthest / nearest, share(random));
    points.push_back(surface.positions[surface.face(f)[0]] + away * area.normalized());
  }
  return points;
}

struct FieldErrors {
  double distance = 0, gradient = 0, gradient_of_99 = 0;  ///< relative
  double seconds = 0;                                     ///< of a processor, an evaluation
};

FieldErrors errors_of(const PolygonSoup& surface, std::span<const Vec3> points,
                      std::span<const LpValue> exact, const LpDistanceOptions& options, std::size_t repeats) {
  const LpDistance field(surface, options);
  std::vector<LpValue> values;
  FieldErrors errors;
  errors.seconds =
      median_seconds(repeats, [&] { values = field.at(points); }) / static_cast<double>(points.size());
  std::vector<double> of_gradients;
  for (std::size_t i = 0; i < points.size(); ++i) {
    errors.distance = std::max(errors.distance, std::abs(values[i].distance / exact[i].distance - 1));
    of_gradients.push_back((values[i].gradient - exact[i].gradient).norm() / exact[i].gradient.norm());
  }
  std::sort(of_gradients.begin(), of_gradients.end());
  errors.gradient = of_gradients.back();
  errors.gradient_of_99 = of_gradients[of_gradients.size() * 99 / 100];
  return errors;
}

void add_openings(const BenchOptions& options, BenchSection& section) {
  const BillboardModel model = billboard_model(options, "bunny00");
  const std::vector<Vec3> points = points_near(model.soup, 4000, 0.005, 0.1);
  const std::vector<LpValue> exact =
      LpDistance(model.soup, {.opening = std::numeric_limits<double>::infinity()}).at(points);
  section.markdown += fmt::format(
      "## Field\n\n{}, {} triangles; {} points from 0.5 to 10 % of the diagonal in front of faces. Relative "
      "errors; microseconds of a processor\n\n| far parts | opening | distance, largest | gradient, largest "
      "| "
      "99 % of gradients below | us |\n|---|---|---|---|---|---|\n",
      model.name, model.soup.n_faces(), points.size());
  Plot plot = log_plot("The field by its opening, " + model.name, "microseconds of an evaluation",
                       "error of 99 % of the gradients");
  for (const LpExpansion expansion : {LpExpansion::monopole, LpExpansion::quadrupole}) {
    const char* name = expansion == LpExpansion::monopole ? "points" : "with second moments";
    for (const double opening : {0.7, 1.0, 1.25, 1.5, 2.0, 2.5, 5.0}) {
      const FieldErrors errors =
          errors_of(model.soup, points, exact, {.expansion = expansion, .opening = opening}, options.repeats);
      section.markdown +=
          fmt::format("| {} | {} | {:.2g} | {:.2g} | {:.2g} | {:.3g} |\n", name, opening, errors.distance,
                      errors.gradient, errors.gradient_of_99, 1e6 * errors.seconds);
      section.rows.push_back({{"model", model.name},
                              {"expansion", name},
                              {"opening", opening},
                              {"distance_error", errors.distance},
                              {"gradient_error", errors.gradient},
                              {"gradient_error_of_99", errors.gradient_of_99},
                              {"microseconds", 1e6 * errors.seconds}});
      add_point(plot, name, 1e6 * errors.seconds, errors.gradient_of_99);
    }
  }
  section.curves.push_back(plot);
}

void add_growth(std::size_t repeats, BenchSection& section) {
  section.markdown +=
      "\nGrowing balls with ridges, microseconds of a processor for an evaluation, and over the number's "
      "binary logarithm; a finite support is 10 % of the diameter\n\n| triangles | triangles, no support | / "
      "log2 n | triangles, support | / log2 n | vertices as points | / log2 n "
      "|\n|---|---|---|---|---|---|---|\n";
  Plot plot = log_plot("Growing balls with ridges", "triangles", "microseconds of an evaluation");
  for (const std::size_t thousands : {1u, 3u, 10u, 30u, 100u, 300u}) {
    const PolygonSoup ball = make_displaced_sphere(1000 * thousands, true);
    const std::vector<Vec3> points = points_near(ball, 4000, 0.005, 0.1);
    const double logarithm = std::log2(static_cast<double>(ball.n_faces()));
    nlohmann::json row = {{"triangles", ball.n_faces()}};
    section.markdown += fmt::format("| {} |", ball.n_faces());
    for (const auto& [name, field] : {std::pair("triangles", LpDistanceOptions{}),
                                      std::pair("support", LpDistanceOptions{.support = 0.2}),
                                      std::pair("points", LpDistanceOptions{.source = LpSource::points})}) {
      const LpDistance distance(ball, field);
      const double microseconds =
          1e6 * median_seconds(repeats, [&] { distance.at(points); }) / static_cast<double>(points.size());
      section.markdown += fmt::format(" {:.3g} | {:.3g} |", microseconds, microseconds / logarithm);
      row[name] = microseconds;
      add_point(plot, name, static_cast<double>(ball.n_faces()), microseconds);
    }
    section.markdown += '\n';
    section.rows.push_back(std::move(row));
  }
  section.curves.push_back(plot);
}

}  // namespace

BenchSection measure_shell_field(const BenchOptions& options) {
  BenchSection section;
  add_openings(options, section);
  add_growth(options.repeats, section);
  return section;
}

}  // namespace recede::bench
