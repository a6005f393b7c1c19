// Billboards, texels, and whether they keep their error.
#include "billboard_models.h"
#include "billboard_run.h"
#include "cloud_check.h"
#include "hough_billboards.h"
#include "measurement.h"
#include "plot_sheet.h"
#include <recede/lod/billboard_mipmaps.h>
#include <recede/lod/detail/plane_cover.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace recede::bench {
namespace {

constexpr std::array<double, 4> k_shares{0.04, 0.02, 0.01, 0.005};

struct Construction {
  const char* name;
  double largest_deviation;  // radians
  std::vector<BillboardCloud> clouds;
};

std::vector<BillboardCloud> clouds_by(const BillboardModel& model, BillboardMethod method) {
  BillboardOptions options;
  options.method = method;
  options.is_two_sided = model.is_two_sided;
  for (auto share = k_shares.rbegin(); share != k_shares.rend(); ++share)
    options.errors.push_back(*share * model.size());
  std::vector<BillboardCloud> clouds = build_billboard_clouds(model.soup, options);
  std::reverse(clouds.begin(), clouds.end());
  return clouds;
}

std::vector<Construction> constructions_of(const BillboardModel& model) {
  constexpr double k_any = std::numbers::pi;
  const double limit = BillboardOptions{}.largest_deviation;
  std::vector<BillboardCloud> hough;
  for (const double share : k_shares) hough.push_back(hough_billboards(model.soup, share * model.size()));
  return {{"Hough", k_any, std::move(hough)},
          {"planes", k_any, clouds_by(model, BillboardMethod::plane_cover)},
          {"clusters", limit, clouds_by(model, BillboardMethod::face_clustering)},
          {"simplification", limit, clouds_by(model, BillboardMethod::simplification)}};
}

std::string in_short(std::size_t n) {
  const auto number = static_cast<double>(n);
  if (n >= 1'000'000) return fmt::format("{:.1f} M", 1e-6 * number);
  return n >= 10'000 ? fmt::format("{:.0f} k", 1e-3 * number) : fmt::format("{}", n);
}

std::size_t count_planes(const BillboardModel& model, double share, std::size_t repeats, double& seconds) {
  const detail::BillboardFaces faces = detail::billboard_faces_of(model.soup);
  std::size_t n = 0;
  seconds = median_seconds(
      repeats, [&] { n = detail::cover_by_planes(faces, share * model.diagonal() / model.size()).size(); });
  return n;
}

// The share of an atlas in which opacity, bilinear between texels, is a half and more: at 8 x 8 places of
// each texel.
double drawn_share(const Raster& color) {
  constexpr int k_places = 8;
  const auto opacity = [&](int x, int y) {
    return color.at(std::clamp(x, 0, color.width - 1), std::clamp(y, 0, color.height - 1), 3) / 255.0;
  };
  std::size_t drawn = 0;
  for (int j = 0; j < k_places * color.height; ++j) {
    for (int i = 0; i < k_places * color.width; ++i) {
      const double x = (i + 0.5) / k_places - 0.5, y = (j + 0.5) / k_places - 0.5;
      const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
      const double u = x - column, v = y - row;
      const double above = (1 - u) * opacity(column, row) + u * opacity(column + 1, row),
                   below = (1 - u) * opacity(column, row + 1) + u * opacity(column + 1, row + 1);
      drawn += (1 - v) * above + v * below >= 0.5 ? 1 : 0;
    }
  }
  return static_cast<double>(drawn) / (k_places * k_places * static_cast<double>(color.width) * color.height);
}

}  // namespace

BenchSection measure_billboard_counts(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Billboards and texels\n\nBillboards / texels with sides of the error, a share of the longest "
      "side\n\n"
      "| model | | 4 % | 2 % | 1 % | 0.5 % | farthest, errors ; largest angle "
      "|\n|---|---|---|---|---|---|---|\n";
  for (const BillboardModel& model : billboard_models(options)) {
    Plot plot = log_plot(model.name, "texels with sides of the error", "error / longest side");
    for (const Construction& construction : constructions_of(model)) {
      std::string cells;
      CloudCheck worst;
      bool is_sound = true;
      for (std::size_t i = 0; i < k_shares.size(); ++i) {
        const BillboardCloud& cloud = construction.clouds[i];
        const CloudCheck check = check_cloud(model.soup, cloud, cloud.is_two_sided);
        worst.distance = std::max(worst.distance, check.distance);
        worst.deviation = std::max(worst.deviation, check.deviation);
        is_sound = is_sound && check.is_sound(construction.largest_deviation);
        add_point(plot, construction.name, static_cast<double>(count_texels(cloud)), k_shares[i]);
        cells += fmt::format(" {} / {} |", in_short(cloud.billboards.size()), in_short(count_texels(cloud)));
        section.rows.push_back({{"model", model.name},
                                {"faces", model.soup.n_faces()},
                                {"construction", construction.name},
                                {"error_share", k_shares[i]},
                                {"billboards", cloud.billboards.size()},
                                {"texels", count_texels(cloud)},
                                {"distance_over_error", check.distance},
                                {"deviation", check.deviation},
                                {"bent_faces", check.bent},
                                {"uncovered", check.uncovered},
                                {"repeated", check.repeated}});
      }
      section.markdown +=
          fmt::format("| {}, {} faces | {} |{} {:.6f} ; {:.1f}{} |\n", model.name, model.soup.n_faces(),
                      construction.name, cells, worst.distance, worst.deviation * 180 / std::numbers::pi,
                      is_sound ? "" : ", **not what was promised**");
    }
    section.curves.push_back(plot);
    fmt::print(stderr, "{} is counted\n", model.name);
  }
  return section;
}

BenchSection measure_plane_counts(const BenchOptions& options) {
  BenchSection section;
  section.markdown =
      "## Planes alone\n\nErrors are shares of the diagonal\n\n"
      "| model | 5 % | 3 % | 1 % | processor s |\n|---|---|---|---|---|\n";
  for (const char* name : {"fandisk", "cow", "tree"}) {
    if (!is_wanted(name, options.models)) continue;
    const BillboardModel model = billboard_model(options, name);
    std::string cells, times;
    for (const double share : {0.05, 0.03, 0.01}) {
      double seconds = 0;
      const std::size_t n = count_planes(model, share, options.repeats, seconds);
      cells += fmt::format(" {} |", n);
      times += fmt::format("{}{:.2f}", times.empty() ? "" : " ; ", seconds);
      section.rows.push_back({{"model", name},
                              {"faces", model.soup.n_faces()},
                              {"error_over_diagonal", share},
                              {"planes", n},
                              {"processor_seconds", seconds}});
    }
    section.markdown += fmt::format("| {}, {} faces |{} {} |\n", name, model.soup.n_faces(), cells, times);
  }
  return section;
}

BenchSection measure_atlases(const BenchOptions& options) {
  constexpr double k_share = 0.01;
  constexpr std::size_t k_few_levels = 4, k_levels = 6;
  BenchSection section;
  section.markdown =
      "## Atlas\n\nAt 1 % of the longest side; the last column is the largest change of the drawn area over "
      "4 "
      "and over 6 smaller versions\n\n| model | | texels per error | atlas | taken by billboards, % | drawn, "
      "% | "
      "smaller "
      "versions off by, % |\n|---|---|---|---|---|---|---|\n";
  for (const BillboardModel& model : billboard_models(options)) {
    for (const auto& [construction, texels_per_error, textures] : textured_clouds(model, k_share)) {
      const double drawn = drawn_share(textures.color);
      std::array<double, k_levels + 1> changes{};  // over so many smaller versions
      const std::vector<BillboardMipmap> smaller = billboard_mipmaps(textures, k_levels);
      for (std::size_t i = 0; i < k_levels; ++i) {
        const double here = i < smaller.size() ? std::abs(drawn_share(smaller[i].color) / drawn - 1) : 0;
        changes[i + 1] = std::max(changes[i], here);
      }
      section.markdown += fmt::format("| {} | {} | {:g} | {} x {} | {:.1f} | {:.1f} | {:.2f} ; {:.2f} |\n",
                                      model.name, construction, texels_per_error, textures.color.width,
                                      textures.color.height, 100 * textures.packed, 100 * drawn,
                                      100 * changes[k_few_levels], 100 * changes[k_levels]);
      section.rows.push_back({{"model", model.name},
                              {"construction", construction},
                              {"texels_per_error", texels_per_error},
                              {"width", textures.color.width},
                              {"height", textures.color.height},
                              {"packed", textures.packed},
                              {"drawn", drawn},
                              {"texels_drawn", textures.covered},
                              {"change_of_4_smaller_versions", changes[k_few_levels]},
                              {"change_of_6_smaller_versions", changes[k_levels]}});
    }
  }
  return section;
}

}  // namespace recede::bench
