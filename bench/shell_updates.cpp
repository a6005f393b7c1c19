// Shells that are edited and animated: what one change takes, beside building everything anew.
#include "measurement.h"
#include "shell_run.h"
#include "uv_sheet.h"
#include <recede/shells/procedural_volumes.h>
#include <recede/shells/shell_edit.h>
#include <recede/shells/subdivided_shell.h>

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <numeric>

namespace recede::bench {
namespace {

constexpr int k_runs = 5;

/// Median of the milliseconds on the clock that `work` takes; it gets the number of the run.
double waited(const std::function<void(int)>& work) {
  int run = 0;
  return 1e3 * median_wall_seconds(k_runs, [&] { work(run++); });
}

class Updates {
 public:
  explicit Updates(BenchSection& section) : section_(section) {}

  /// Milliseconds; `anew` below 0 where there is nothing to compare with.
  void add(const std::string& change, const std::string& size, double changed, double anew,
           const std::string& remark = {}) {
    section_.markdown += fmt::format("| {} | {} | {:.3g} | {} | {} |\n", change, size, changed,
                                     anew < 0 ? "" : fmt::format("{:.3g}", anew), remark);
    section_.rows.push_back({{"change", change},
                             {"size", size},
                             {"milliseconds", changed},
                             {"milliseconds_anew", anew},
                             {"remark", remark}});
  }

 private:
  BenchSection& section_;
};

double largest_difference(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, (a[v] - b[v]).norm());
  return largest;
}

void add_control_points(Updates& updates) {
  PolygonSoup control = test::uv_sheet(24);
  for (Vec3& p : control.positions) p.z() = 0.1 * std::sin(3 * p.x()) * std::cos(2 * p.y());
  const Index middle = 12 * 25 + 12;
  for (const int interpolated : {0, 1, 2}) {
    SubdividedShellOptions options{.interpolated_levels = interpolated};
    options.subdivision.level = 3;
    options.shell = {.thickness = 0.04, .at_least_normals = false};
    SubdividedShell shell = build_subdivided_shell(control, options);
    PolygonSoup moved = control;
    const double milliseconds = waited([&](int run) {
      moved.positions[static_cast<std::size_t>(middle)].z() += 0.01 * (run + 1);
      update_subdivided_shell(shell, moved, options);
    });
    SubdividedShell anew;
    const double all = waited([&](int) { anew = build_subdivided_shell(moved, options); });
    updates.add(fmt::format("a control point is dragged, directors of {} levels interpolated", interpolated),
                fmt::format("{} vertices, {} traced of {}", shell.shell.base.positions.size(), shell.traced,
                            anew.traced),
                milliseconds, all,
                fmt::format("tops differ by {:.1g} of the thickness, {}",
                            largest_difference(shell.shell.exterior->tops, anew.shell.exterior->tops) /
                                options.shell.thickness,
                            shell.shell.is_valid() ? "valid" : "not valid"));
  }
}

/// A flag in the wind: all vertices move.
void add_flag(Updates& updates) {
  const PolygonSoup rest = test::uv_sheet(96);
  const ShellOptions options{.thickness = 0.04, .at_least_normals = false};
  Shell shell = build_shell(rest, options);
  std::vector<Index> all(rest.positions.size());
  std::iota(all.begin(), all.end(), Index{0});
  const auto frame = [&](PolygonSoup waving, int time) {
    waving.positions = rest.positions;
    for (Vec3& p : waving.positions) p.z() = 0.15 * (p.x() + 1) * std::sin(4 * p.x() + p.y() - time);
    return waving;
  };
  bool is_valid = true;
  const double milliseconds = waited([&](int run) {
    update_shell(shell, frame(shell.base, run), all, options);
    is_valid = is_valid && shell.is_valid();
  });
  const double anew = waited([&](int run) { build_shell(frame(rest, run), options); });
  updates.add("a flag waves", fmt::format("{} triangles", shell.base.n_faces()), milliseconds, anew,
              is_valid ? "valid in each frame" : "not valid");
}

void add_edits(Updates& updates) {
  PolygonSoup base = test::uv_sheet(64, 0.05, 0.95);
  for (Vec3& p : base.positions) p.z() = 0.2 * std::sin(2 * p.x()) * std::sin(2 * p.y());
  const auto shell = std::make_shared<const Shell>(build_shell(base, {.thickness = 0.1}));
  constexpr std::array<int, 3> k_size{512, 512, 24};
  const std::string size = fmt::format("{} x {} x {} texels", k_size[0], k_size[1], k_size[2]);
  std::unique_ptr<LayerGrid> grid;
  const double placing =
      waited([&](int) { grid = std::make_unique<LayerGrid>(shell, ShellSide::exterior, k_size); });
  updates.add("places of the texels", size, placing, -1);
  VolumeTexture texture = make_uniform_volume(*grid, 0);
  for (const double x : {-0.6, 0.0, 0.6})
    combine(texture, *grid, ball_body({x, 0, 0.05}, 0.12), {.operation = VolumeOperation::unite});
  const auto edit = [&](const std::string& change, const auto& work) {
    std::vector<VolumeTexture> copies(k_runs, texture);
    std::string remark;
    const double milliseconds =
        waited([&](int run) { remark = work(copies[static_cast<std::size_t>(run)]); });
    updates.add(change, size, milliseconds, -1, remark);
  };
  const auto changed = [](const EditReport& report) {
    return fmt::format("{} texels changed", report.changed);
  };
  edit("a ball is carved", [&](VolumeTexture& of) {
    return changed(combine(of, *grid, ball_body({0.1, 0, 0.1}, 0.1)));
  });
  edit("a ball is united", [&](VolumeTexture& of) {
    return changed(
        combine(of, *grid, ball_body({-0.3, 0.2, 0.1}, 0.1), {.operation = VolumeOperation::unite}));
  });
  edit("a hole is cut", [&](VolumeTexture& of) {
    return changed(
        cut(of, *grid, [](const Vec3&, const Vec3& at) { return std::hypot(at.x(), at.y()) < 0.1; }));
  });
  edit("matter is moved", [&](VolumeTexture& of) {
    const MoveReport report = move_matter(of, *grid,
                                          {.from = nearest_place(*shell, {-0.6, 0, 0.05}),
                                           .to = nearest_place(*shell, {0.3, 0.4, 0.05}),
                                           .radius = 0.25});
    return fmt::format("{}, stretch {:.3f}", changed(report.edit), report.stretch);
  });
  VolumeMipmap mipmap;
  updates.add("smaller versions for the next picture", size,
              waited([&](int) { mipmap = make_mipmap(texture); }), -1);
}

void add_frames(Updates& updates) {
  const auto add = [&](const std::string& change, int texels,
                       const std::function<ProceduralVolume(int)>& frame) {
    VolumeTexture texture;
    const double milliseconds = waited([&](int run) { texture = make_volume(frame(run), texels); });
    VolumeMipmap mipmap;
    const double levels = waited([&](int) { mipmap = make_mipmap(texture); });
    updates.add(change, fmt::format("{} x {} x {} texels", texture.size[0], texture.size[1], texture.size[2]),
                milliseconds, -1, fmt::format("and {:.3g} for smaller versions", levels));
  };
  add("bubbles rise", 64, [](int run) { return bubbles({.time = 0.1 * run}); });
  add("bushes grow", 128, [](int run) { return bushes({.growth = 0.2 * (run + 1)}); });
}

}  // namespace

BenchSection measure_shell_updates(const BenchOptions&) {
  BenchSection section;
  section.markdown =
      "## Changes\n\nMilliseconds on the clock, median of five; all is built anew beside what changed "
      "only\n\n| change | size | changed | anew | |\n|---|---|---|---|---|\n";
  Updates updates(section);
  add_control_points(updates);
  add_flag(updates);
  add_edits(updates);
  add_frames(updates);
  return section;
}

}  // namespace recede::bench
