#include "appearance_run.h"
#include "reliefs.h"
#include "tiled_surfaces.h"
#include <recede/render/appearance.h>
#include <recede/render/hemisphere_square.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

namespace recede::bench {
namespace {

constexpr double k_pi = std::numbers::pi;
constexpr int k_rays = 1 << 16;
constexpr std::array k_views = {15.0, 45.0, 60.0, 70.0, 80.0};  // degrees

/// In the viewer's frame: behind the surface, on the viewer's side, aside, low, and above.
const std::vector<Vec3>& lights() {
  static const std::vector<Vec3> lights{Vec3(-.6, .3, .7).normalized(), Vec3(.6, .3, .7).normalized(),
                                        Vec3(0, -.8, .6), Vec3(.9, 0, .35).normalized(), Vec3(0, 0, 1)};
  return lights;
}

Vec3 turned(const Vec3& v, double azimuth) {
  const double c = std::cos(azimuth), s = std::sin(azimuth);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
}

/// The distribution of normals that a viewer sees, and the mean light of each of the lights.
struct Seen {
  std::vector<double> shares = std::vector<double>(31 * 31, 0.0);
  std::array<double, 5> light{};
  double count = 0;

  void add(const Vec3& normal) {
    const Vec2 place = 31 * hemisphere_to_square(normal);
    shares[static_cast<std::size_t>(std::min(static_cast<int>(place.x()), 30) * 31 +
                                    std::min(static_cast<int>(place.y()), 30))] += 1;
    for (std::size_t i = 0; i < light.size(); ++i) light[i] += std::max(0.0, lights()[i].dot(normal));
    ++count;
  }
  Seen mean() const {
    Seen result = *this;
    for (double& share : result.shares) share /= count;
    for (double& value : result.light) value /= count;
    return result;
  }
};

/// A place on the plane and an azimuth of the viewer, evenly spread; other points than those of the tables.
template <class Use>
void for_places(const Use& use) {
  const auto fraction = [](double number) { return number - std::floor(number); };
  for (int k = 0; k < k_rays; ++k) {
    use(Vec2(fraction(0.5 + k * 0.7548776662466927), fraction(0.5 + k * 0.5698402909980532)),
        2 * k_pi * (k + 0.5) / k_rays);
  }
}

Seen seen_displaced(const DisplacedPlane& plane, double view) {
  Seen seen;
  for_places([&](const Vec2& place, double azimuth) {
    const Vec3 viewer = turned({std::sin(view), 0, std::cos(view)}, azimuth);
    const Vec3 start = Vec3(place.x(), place.y(), plane.heights().max) + 0.01 * viewer;
    if (const auto hit = plane.first_hit(start, -viewer)) seen.add(turned(hit->normal, -azimuth));
  });
  return seen.mean();
}

/// The flat surface whose bump normals go through `move`, both in the frame of the surface.
using Move = std::function<Vec3(const Vec3& normal, const Vec3& viewer)>;
Seen seen_flat(const DisplacedPlane& plane, double view, const Move& move) {
  Seen seen;
  for_places([&](const Vec2& place, double azimuth) {
    const Vec3 viewer = turned({std::sin(view), 0, std::cos(view)}, azimuth);
    seen.add(turned(move(plane.normal_at(place), viewer), -azimuth));
  });
  return seen.mean();
}

/// The largest over all views and lights.
struct Worst {
  double variation = 0, brightness = 0;

  void add(const Seen& seen, const Seen& displaced) {
    variation = std::max(variation, total_variation(seen.shares, displaced.shares));
    for (std::size_t i = 0; i < seen.light.size(); ++i)
      brightness = std::max(brightness, std::abs(seen.light[i] / displaced.light[i] - 1));
  }
};

struct Method {
  const char* name;
  Worst worst{};
};

std::string text_of(const Worst& worst, bool has_normals) {
  return has_normals ? fmt::format(" {:.3f} ; {:.2f} |", worst.variation, 100 * worst.brightness)
                     : fmt::format(" {:.2f} |", 100 * worst.brightness);
}

}  // namespace

AppearanceSection measure_agreement(const BenchOptions& options) {
  AppearanceSection section;
  std::string rows;
  for (const Relief& relief : wanted_reliefs(options)) {
    const auto appearance = make_appearance(test::tiled_square(2), relief.map, {.shading = false});
    const DisplacedPlane plane(relief.map, appearance->stretch().sides, PlaneNormals::smooth);
    const VisibleNormals& normals = appearance->normals();
    const RedistributedBump bump(normals), literal(normals, {.literal = true}),
        undivided(normals, {.conditional = false});
    Method plain{"bump map"}, printed{"printed direction"}, without{"rows not divided"},
        ours{"redistributed"}, corrected{"with its factor"}, tabled{"table"};
    for (const double degrees : k_views) {
      const double view = degrees * k_pi / 180;
      const Seen displaced = seen_displaced(plane, view);
      const auto through = [&](const RedistributedBump& moves) {
        return seen_flat(plane, view,
                         [&](const Vec3& n, const Vec3& viewer) { return moves.normal_for_view(n, viewer); });
      };
      plain.worst.add(seen_flat(plane, view, [](const Vec3& n, const Vec3&) { return n; }), displaced);
      printed.worst.add(through(literal), displaced);
      without.worst.add(through(undivided), displaced);
      Seen seen = through(bump), by_table = displaced;
      ours.worst.add(seen, displaced);
      const Vec3 viewer(std::sin(view), 0, std::cos(view));
      for (std::size_t i = 0; i < by_table.light.size(); ++i) {
        by_table.light[i] = appearance->table().value(viewer, lights()[i]);
        seen.light[i] *= appearance->bump_factor(viewer, lights()[i]);
      }
      corrected.worst.add(seen, displaced);
      tabled.worst.add(by_table, displaced);
    }
    rows += fmt::format("| {} |", relief.name);
    for (const Method& method : {plain, printed, without, ours, corrected, tabled}) {
      rows += text_of(method.worst, method.name != tabled.name && method.name != corrected.name);
      section.csv += fmt::format(
          "agreement,{},{},total variation,{:.6g}\nagreement,{},{},brightness,{:.6g}\n", relief.name,
          method.name, method.worst.variation, relief.name, method.name, method.worst.brightness);
    }
    rows += "\n";
    fmt::print(stderr, "{} agrees\n", relief.name);
  }
  section.markdown =
      "## Agreement\n\nThe largest over views of 15 to 80 degrees: total variation from the normals that are "
      "seen ; error of "
      "brightness under five lights, %.\n\n"
      "| | bump map | printed direction | rows not divided | redistributed | **with its factor** | **table** "
      "|\n"
      "|---|---|---|---|---|---|---|\n" +
      rows;
  return section;
}

}  // namespace recede::bench
