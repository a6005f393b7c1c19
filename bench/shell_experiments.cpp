// Shapes for which it is known what layers should do: the source's figures without its models.
#include "experiment_shapes.h"
#include "shell_run.h"
#include "shell_shapes.h"
#include "work_timer.h"
#include <recede/geometry/closest_point.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

constexpr double k_pi = std::numbers::pi;

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / k_pi;
}

/// Two specks of surface at -1 and 1: their distance along the line between them is known.
void add_two_points(BenchSection& section) {
  section.markdown +=
      "### Two points\n\nAveraged distance on the line between two specks of surface at -1 and 1; in "
      "brackets that of points\n\n| p | at 0 | 0.25 | 0.5 | 0.75 |\n|---|---|---|---|---|\n";
  PolygonSoup specks;
  constexpr double k_speck = 1e-3;
  for (const double x : {-1.0, 1.0}) {
    const auto first = static_cast<Index>(specks.positions.size());
    for (int corner = 0; corner < 3; ++corner) {
      const double angle = corner * 2 * k_pi / 3;
      specks.positions.emplace_back(x, k_speck * std::cos(angle), k_speck * std::sin(angle));
    }
    specks.add_face(std::array<Index, 3>{first, first + 1, first + 2});
  }
  for (const double p : {1.5, 2.0, 3.0, 4.0, 8.0, 16.0, 64.0}) {
    const LpDistance field(specks, {.p = p, .form = LpForm::averaged});
    section.markdown += fmt::format("| {} |", p);
    for (const double x : {0.0, 0.25, 0.5, 0.75}) {
      const double found = field.at({x, 0, 0}).distance,
                   exact = std::pow((std::pow(1 - x, -p) + std::pow(1 + x, -p)) / 2, -1 / p);
      section.markdown += fmt::format(" {:.4f} ({:.4f}) |", found, exact);
      section.rows.push_back(
          {{"experiment", "two points"}, {"p", p}, {"x", x}, {"distance", found}, {"exact", exact}});
    }
    section.markdown += '\n';
  }
}

void add_powers_in_a_cube(BenchSection& section) {
  section.markdown +=
      "\n### Powers in a cube\n\nCube from -1 to 1, at 400 random places inside it: angles between the "
      "gradients of the averaged and the exact distance, degrees, and lengths of gradients, of which that of "
      "the exact one is 1\n\n| p | angle, mean | largest | length, mean | least |\n|---|---|---|---|---|\n";
  const PolygonSoup cube = test::cube(2);
  const ClosestPointTree tree(cube.positions, triangulate(cube));
  std::mt19937 random(1);
  std::uniform_real_distribution<double> inside(-0.98, 0.98);
  std::vector<Vec3> points(400);
  for (Vec3& point : points) point = Vec3(inside(random), inside(random), inside(random));
  for (const double p : {2.5, 3.0, 4.0, 8.0, 16.0, 64.0}) {
    const std::vector<LpValue> values = LpDistance(cube, {.p = p}).at(points);
    double sum = 0, largest = 0, lengths = 0, least = 1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double angle = degrees_between(values[i].gradient, extended_gradient(tree, points[i])),
                   length = values[i].gradient.norm();
      sum += angle;
      largest = std::max(largest, angle);
      lengths += length;
      least = std::min(least, length);
    }
    const auto n = static_cast<double>(points.size());
    section.markdown +=
        fmt::format("| {} | {:.1f} | {:.1f} | {:.3f} | {:.3f} |\n", p, sum / n, largest, lengths / n, least);
    section.rows.push_back({{"experiment", "powers in a cube"},
                            {"p", p},
                            {"mean_degrees", sum / n},
                            {"largest_degrees", largest},
                            {"mean_length", lengths / n},
                            {"least_length", least}});
  }
}

Shell traced(const PolygonSoup& surface, ShellOptions options) {
  options.repair = false;
  options.at_least_normals = false;
  return build_shell(surface, options);
}

/// Of what closed triangles enclose, by their orientation.
double volume_of(const PolygonSoup& surface, const std::vector<Vec3>& positions) {
  double sum = 0;
  for (std::size_t f = 0; f < surface.n_faces(); ++f) {
    const auto corners = surface.face(f);
    const auto at = [&](std::size_t i) { return positions[static_cast<std::size_t>(corners[i])]; };
    sum += at(0).dot(at(1).cross(at(2))) / 6;
  }
  return sum;
}

void add_filled_cube(BenchSection& section) {
  section.markdown +=
      "\n### A cube is filled\n\nInterior layers of a cube from -1 to 1, 3072 triangles, by thickness, in "
      "precise steps. Share of the cube's volume: directors as they are traced (and inverted prisms), and "
      "repaired. Along the extended gradient of the exact distance: mean distance of the ends from the "
      "diagonal planes and middle planes where several points are nearest, over the thickness\n\n| thickness "
      "| traced | inverted | repaired | exact: ends from the medial axis |\n|---|---|---|---|---|\n";
  const PolygonSoup cube = test::cube(16);
  for (const double thickness : {0.25, 0.5, 1.0, 2.0, 3.4}) {
    ShellOptions options{.thickness = thickness, .side = ShellSide::interior, .step = 0.125};
    const Shell shell = traced(cube, options);
    const ShellLayer& layer = only_layer(shell);
    const auto filled = [&](const Shell& of) {
      return 1 - volume_of(of.base, only_layer(of).tops) / volume_of(of.base, of.base.positions);
    };
    options.at_least_normals = false;
    const Shell repaired = build_shell(cube, options);
    options.method = DirectorMethod::exact_distance;
    const Shell exact = traced(cube, options);
    double away = 0;
    for (const Vec3& top : only_layer(exact).tops) {
      std::array<double, 3> depths{1 - std::abs(top.x()), 1 - std::abs(top.y()), 1 - std::abs(top.z())};
      std::sort(depths.begin(), depths.end());
      away += depths[1] - depths[0];  // the nearest two sides are as far
    }
    away /= thickness * static_cast<double>(cube.positions.size());
    section.markdown += fmt::format("| {} | {:.3f} | {} | {:.3f} | {:.3f} |\n", thickness, filled(shell),
                                    layer.inverted_before, filled(repaired), away);
    section.rows.push_back({{"experiment", "filled cube"},
                            {"thickness", thickness},
                            {"filled", filled(shell)},
                            {"inverted", layer.inverted_before},
                            {"filled_after_repair", filled(repaired)},
                            {"exact_from_medial_axis", away}});
  }
}

void add_bent_strip(BenchSection& section) {
  section.markdown +=
      "\n### A strip is bent\n\nExterior layers 0.3 thick in the fold of a strip that turns by an angle, "
      "sharp and round: length of the directors in the fold over the thickness, with inverted prisms where "
      "there are any\n\n| turning | sharp | radius 0.15 | radius 0.3 |\n|---|---|---|---|\n";
  for (const int degrees : {0, 30, 60, 90, 120, 150}) {
    section.markdown += fmt::format("| {} |", degrees);
    for (const double radius : {0.0, 0.15, 0.3}) {
      const PolygonSoup strip = bent_strip(degrees * k_pi / 180, radius);
      const Shell shell = traced(strip, {.thickness = 0.3, .step = 0.125});
      const ShellLayer& layer = only_layer(shell);
      constexpr std::size_t k_middle = k_strip_rows / 2 * (k_strip_sides + 1) + k_strip_sides / 2;
      const double length = (layer.tops[k_middle] - strip.positions[k_middle]).norm() / 0.3;
      section.markdown +=
          fmt::format(" {:.3f}{} |", length,
                      layer.inverted_before > 0 ? fmt::format(" ({})", layer.inverted_before) : "");
      section.rows.push_back({{"experiment", "bent strip"},
                              {"turning", degrees},
                              {"radius", radius},
                              {"length", length},
                              {"inverted", layer.inverted_before}});
    }
    section.markdown += '\n';
  }
}

void add_squeezed_ball(BenchSection& section) {
  section.markdown +=
      "\n### A ball is squeezed\n\nInterior layers 0.3 thick in a ball of radius 1 whose waist gets "
      "narrower: inverted prisms and contacts along normals and along the averaged distance before repair, "
      "and lengths of the latter over the thickness\n\n| radius of the waist | normals | averaged | least | "
      "mean |\n|---|---|---|---|---|\n";
  for (const double squeeze : {0.0, 0.2, 0.4, 0.6, 0.8}) {
    PolygonSoup body = test::ball(16);
    for (Vec3& p : body.positions) {
      const double narrower = 1 - squeeze * std::exp(-p.z() * p.z() / 0.1);
      p.x() *= narrower;
      p.y() *= narrower;
    }
    const ShellOptions options{.thickness = 0.3, .side = ShellSide::interior, .step = 0.125};
    ShellOptions along_normals = options;
    along_normals.method = DirectorMethod::normals;
    const Shell shell = traced(body, options), normals = traced(body, along_normals);
    const ShellLayer &layer = only_layer(shell), &of_normals = only_layer(normals);
    const ShellThickness reached = reached_thickness(shell, layer);
    section.markdown +=
        fmt::format("| {:.1f} | {}, {} | {}, {} | {:.3f} | {:.3f} |\n", 1 - squeeze,
                    of_normals.inverted_before, of_normals.contacts_before, layer.inverted_before,
                    layer.contacts_before, reached.least, reached.mean);
    section.rows.push_back({{"experiment", "squeezed ball"},
                            {"waist", 1 - squeeze},
                            {"normals_inverted", of_normals.inverted_before},
                            {"normals_contacts", of_normals.contacts_before},
                            {"inverted", layer.inverted_before},
                            {"contacts", layer.contacts_before},
                            {"least", reached.least},
                            {"mean", reached.mean}});
  }
}

struct Source {
  const char* name;
  ShellOptions options;
};

std::vector<Source> all_sources() {
  return {{"normals", {.method = DirectorMethod::normals}},
          {"exact distance", {.method = DirectorMethod::exact_distance}},
          {"vertices as points", {.field = {.source = LpSource::points}}},
          {"triangles", {}}};
}

/// Layers of a body at a share of its longest side by what they follow.
void add_sources(const std::string& name, const PolygonSoup& body, ShellSide side, double share,
                 BenchSection& section) {
  const double size = bounding_box(body).sizes().maxCoeff();
  section.markdown +=
      fmt::format("| {}, {} | {} {:.0f} % |", name, body.n_faces(), name_of(side), 100 * share);
  for (Source source : all_sources()) {
    source.options.thickness = share * size;
    source.options.side = side;
    const Shell before = traced(body, source.options);
    source.options.at_least_normals = false;
    const WorkTimer timer;
    const Shell shell = build_shell(body, source.options);
    const double seconds = timer.wall();
    const ShellLayer &layer = only_layer(shell), &first = only_layer(before);
    const double evaluations =
        static_cast<double>(layer.evaluations) / static_cast<double>(body.positions.size());
    const ShellThickness reached = reached_thickness(shell, layer);
    section.markdown += fmt::format(" {}, {} ; {:.3f} ; {} |", first.inverted_before, first.contacts_before,
                                    reached.mean, verdict_of(layer));
    section.rows.push_back({{"experiment", name},
                            {"triangles", body.n_faces()},
                            {"side", name_of(side)},
                            {"thickness_share", share},
                            {"source", source.name},
                            {"inverted", first.inverted_before},
                            {"contacts", first.contacts_before},
                            {"mean_after_repair", reached.mean},
                            {"least_after_repair", reached.least},
                            {"verdict", verdict_of(layer)},
                            {"evaluations", evaluations},
                            {"seconds", seconds}});
  }
  section.markdown += '\n';
}

void add_spikes_and_ears(BenchSection& section) {
  section.markdown +=
      "\n### Spikes, and thin ears\n\nA ball with sharp spikes and notches, and one with two thin ears, at "
      "shares of their longest sides. By what directors follow: inverted prisms and contacts before repair; "
      "mean length over the thickness after it; whether the layer is valid then\n\n| body, triangles | layer "
      "| normals | exact distance | averaged, vertices as points | averaged, triangles "
      "|\n|---|---|---|---|---|---|\n";
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    for (const double share : {0.02, 0.05, 0.1}) add_sources("spikes", spiky_ball(64), side, share, section);
  }
  for (const int n : {16, 32, 64}) {
    const PolygonSoup body = eared_ball(n);
    add_sources("ears", body, ShellSide::exterior, 0.1, section);
    add_sources("ears", body, ShellSide::interior, 0.05, section);
  }
}

void add_hook(BenchSection& section) {
  const PolygonSoup body = hook();
  const double size = bounding_box(body).sizes().maxCoeff();
  section.markdown += fmt::format(
      "\n### A hook\n\nA tube of diameter 0.5 along 5/6 of a circle of diameter 2, {} triangles. Thickness "
      "over the longest side up to which nothing is inverted, and up to which nothing meets either, before "
      "repair (to 2 %, at most 1), and the mean length over the thickness of the repaired layer of 1\n\n| "
      "side | by | nothing inverted | nothing meets either | repaired: mean | valid "
      "|\n|---|---|---|---|---|---|\n",
      body.n_faces());
  for (const ShellSide side : {ShellSide::exterior, ShellSide::interior}) {
    for (Source source : all_sources()) {
      source.options.side = side;
      source.options.at_least_normals = false;
      // Up to which share of the size `fits` holds; assumed to hold below, if anywhere.
      const auto largest = [&](const auto& fits) {
        double good = 0.01, bad = 1;
        const auto at = [&](double share) {
          source.options.thickness = share * size;
          const Shell shell = traced(body, source.options);
          return fits(only_layer(shell));
        };
        if (at(bad)) return bad;
        if (!at(good)) return 0.0;
        while (bad / good > 1.02) {
          const double middle = std::sqrt(good * bad);
          (at(middle) ? good : bad) = middle;
        }
        return good;
      };
      const double upright = largest([](const ShellLayer&layer) { return layer.inverted_before == 0; }),
                   valid = largest([](const ShellLayer&layer) {
                     return layer.inverted_before == 0 && layer.contacts_before == 0;
                   });
      source.options.thickness = size;
      const Shell shell = build_shell(body, source.options);
      const ShellLayer& layer = only_layer(shell);
      const double mean = reached_thickness(shell, layer).mean;
      section.markdown += fmt::format("| {} | {} | {:.2f} | {:.2f} | {:.3f} | {} |\n", name_of(side),
                                      source.name, upright, valid, mean, verdict_of(layer));
      section.rows.push_back({{"experiment", "hook"},
                              {"side", name_of(side)},
                              {"source", source.name},
                              {"nothing_inverted_to", upright},
                              {"valid_to", valid},
                              {"mean_after_repair", mean},
                              {"verdict", verdict_of(layer)}});
    }
  }
}

/// Of the profile in the middle row.
struct ProfileLayer {
  double area = 0, least = 0;
  int turned_back = 0;  ///< directors that point behind the surface
};

ProfileLayer middle_row(const Shell& shell, const ShellLayer& layer, double thickness) {
  const std::size_t n = shell.base.positions.size() / k_notch_rows, first = k_notch_rows / 2 * n;
  ProfileLayer found{.least = 1};
  std::vector<Vec3> normals(n, Vec3::Zero());
  const auto across = [](const Vec3& a, const Vec3& b) { return a.z() * b.x() - a.x() * b.z(); };
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 &a = shell.base.positions[first + i], director = layer.tops[first + i] - a;
    found.least = std::min(found.least, director.norm() / thickness);
    Vec3 normal = Vec3::Zero();
    if (i > 0) normal += (a - shell.base.positions[first + i - 1]).normalized().cross(Vec3::UnitY());
    if (i + 1 < n) normal += (shell.base.positions[first + i + 1] - a).normalized().cross(Vec3::UnitY());
    found.turned_back += director.dot(normal) <= 0 ? 1 : 0;
    if (i + 1 == n) break;
    // Twice the area of the quad between a side and its top.
    const Vec3 &b = shell.base.positions[first + i + 1], &c = layer.tops[first + i + 1],
               &d = layer.tops[first + i];
    found.area += std::abs(across(c - a, d - b)) / 2;
  }
  return found;
}

void add_notch(BenchSection& section) {
  const PolygonSoup body = notch_and_arms();
  constexpr double k_thickness = 0.4;
  section.markdown += fmt::format(
      "\n### A notch between arms\n\nA profile with a gap 0.3 wide between two arms, at its end a sharp "
      "notch, drawn out; layers 0.4 thick. In the middle: area of the layer, least length over the "
      "thickness, directors that point behind the surface; and inverted prisms and contacts of all of it. A "
      "front at one distance from all of the surface meets itself from {:.2f} on\n\n| layer | area | least | "
      "turned back | inverted, contacts |\n|---|---|---|---|---|\n",
      k_notch_gap / 2);
  const auto add = [&](const std::string& name, const ShellOptions& options) {
    const Shell shell = build_shell(body, options);
    const ShellLayer& layer = only_layer(shell);
    const ProfileLayer found = middle_row(shell, layer, k_thickness);
    const std::size_t contacts = layer.validity.top_contacts.size() + layer.validity.layer_contacts.size();
    section.markdown += fmt::format("| {} | {:.3f} | {:.3f} | {} | {}, {} |\n", name, found.area, found.least,
                                    found.turned_back, layer.validity.inverted.size(), contacts);
    section.rows.push_back({{"experiment", "notch and arms"},
                            {"layer", name},
                            {"area", found.area},
                            {"least", found.least},
                            {"turned_back", found.turned_back},
                            {"inverted", layer.validity.inverted.size()},
                            {"contacts", contacts}});
  };
  for (const bool repair : {false, true}) {
    for (Source source : all_sources()) {
      source.options.thickness = k_thickness;
      source.options.step = 0.125;
      source.options.repair = repair;
      source.options.at_least_normals = false;
      add(std::string(source.name) + (repair ? ", repaired" : ""), source.options);
    }
  }
  for (const double p : {1.05, 1.2, 1.5, 2.0, 4.0, 8.0}) {
    ShellOptions options{.thickness = k_thickness, .step = 0.125, .repair = false, .at_least_normals = false};
    options.field = {.p = p, .form = p > 2 ? LpForm::calibrated : LpForm::averaged};
    add(fmt::format("triangles, p = {}{}", p, p > 2 ? "" : ", averaged form"), options);
  }
}

}  // namespace

BenchSection measure_shell_experiments(const BenchOptions&) {
  BenchSection section;
  section.markdown = "## Experiments\n\n";
  add_two_points(section);
  add_powers_in_a_cube(section);
  add_filled_cube(section);
  add_bent_strip(section);
  add_squeezed_ball(section);
  add_spikes_and_ears(section);
  add_hook(section);
  add_notch(section);
  return section;
}

}  // namespace recede::bench
