#include "appearance_run.h"
#include "plot_sheet.h"
#include "reflectance_filters.h"
#include "reliefs.h"
#include <recede/render/displaced_plane.h>
#include <recede/render/image.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

constexpr int k_pairs = 400, k_rays_aside = 64;
constexpr double k_least_height = 0.26;  ///< of directions: 75 degrees

struct NamedMaterial {
  const char* name;
  FacetMaterial material;
};
constexpr NamedMaterial k_materials[] = {
    {"albedo 0.5 and alpha 0.2", {.albedo = 0.5, .roughness = 0.2}},
    {"alpha 0.1 alone", {.albedo = 0, .roughness = 0.1}},
};
constexpr std::size_t k_material_count = std::size(k_materials), k_glossy = 1;

Vec3 direction(double height, double azimuth) {
  const double level = std::sqrt(1 - height * height);
  return {level * std::cos(azimuth), level * std::sin(azimuth), height};
}

struct Pair {
  Vec3 toward_viewer, toward_light;
};
std::vector<Pair> random_pairs() {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(0, 1);
  const auto draw = [&] {
    const double height = k_least_height + (1 - k_least_height) * number(random);
    return direction(height, 2 * std::numbers::pi * number(random));
  };
  std::vector<Pair> pairs(k_pairs);
  for (Pair& pair : pairs) {
    pair.toward_viewer = draw();
    pair.toward_light = draw();
  }
  return pairs;
}

/// Sums over rays from the viewer: what is lit by the light, with rays for shadows, and without these.
struct Traced {
  std::array<double, k_material_count> lit{}, unshaded{};
  /// Of `lit`, of the rays on the black squares of a board.
  std::array<double, k_material_count> first_half{};
};

Traced trace(const DisplacedPlane& plane, const Pair& pair, unsigned seed, int rays_aside) {
  const auto& [v, l] = pair;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(0, 1);
  const double share = 1.0 / (rays_aside * rays_aside);
  Traced traced;
  for (int ray = 0; ray < rays_aside * rays_aside; ++ray) {
    const double x = (ray % rays_aside + number(random)) / rays_aside;
    const double y = (ray / rays_aside + number(random)) / rays_aside;
    const Vec3 start = Vec3(x, y, plane.heights().max) + 1e-6 * v;
    const auto hit = plane.first_hit(start, -v);
    if (!hit || !(hit->normal.dot(l) > 0)) continue;
    const bool is_shaded = plane.first_hit(start - hit->t * v + 1e-6 * hit->normal, l).has_value();
    for (std::size_t m = 0; m < k_material_count; ++m) {
      const double radiance =
          share * facet_reflectance(hit->normal, v, l, k_materials[m].material) * hit->normal.dot(l);
      traced.unshaded[m] += radiance;
      if (is_shaded) continue;
      traced.lit[m] += radiance;
      if ((ray % rays_aside + ray / rays_aside) % 2 == 0) traced.first_half[m] += 2 * radiance;
    }
  }
  return traced;
}

/// Mean absolute error over the mean, for each filter, and for the rays without shadows; and noise of the
/// rays.
struct Errors {
  std::vector<double> filters;
  double unshaded = 0, noise = 0;
};

Errors errors_of(std::size_t m, const std::vector<ReflectanceFilter>& filters, const std::vector<Pair>& pairs,
                 const std::vector<Traced>& traced) {
  Errors errors{.filters = std::vector<double>(filters.size())};
  double sum = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    sum += traced[k].lit[m];
    errors.unshaded += std::abs(traced[k].unshaded[m] - traced[k].lit[m]);
    errors.noise += std::abs(traced[k].first_half[m] - traced[k].lit[m]);
  }
  tbb::parallel_for(std::size_t{0}, filters.size(), [&](std::size_t f) {
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const auto& [v, l] = pairs[k];
      errors.filters[f] += std::abs(filters[f].radiance(v, l, k_materials[m].material) - traced[k].lit[m]);
    }
    errors.filters[f] /= sum;
  });
  errors.unshaded /= sum;
  errors.noise /= sum;
  return errors;
}

constexpr int k_lobe_side = 64;  // pixels

/// Light from 45 degrees; the viewer all over the hemisphere, seen from above, up to 75 degrees at the rim.
template <class Radiance>
Image lobe(const Radiance& radiance, double scale, const Rgb& background) {
  constexpr int k_side = k_lobe_side;
  Image image(k_side, k_side, background);
  const Vec3 light = direction(std::numbers::sqrt2 / 2, std::numbers::pi);
  tbb::parallel_for(0, k_side * k_side, [&](int at) {
    const Vec2 place(2 * (at % k_side + 0.5) / k_side - 1, 1 - 2 * (at / k_side + 0.5) / k_side);
    if (place.norm() > 1) return;
    const double height = 1 - (1 - k_least_height) * place.squaredNorm();
    const double value = scale * radiance(Pair{direction(height, std::atan2(place.y(), place.x())), light});
    image.at(at % k_side, at / k_side) = Rgb::Constant(static_cast<float>(value));
  });
  return image;
}

/// Rows of one relief: traced, ours, and the others but the mean normal.
Image lobes(const DisplacedPlane& plane, const std::vector<ReflectanceFilter>& filters) {
  constexpr int k_rays = 24;
  const auto traced = [&](const Pair& pair) { return trace(plane, pair, 1, k_rays).lit[k_glossy]; };
  // A quarter of white in the mean, which looks half as bright.
  double sum = 0;
  for (const Rgb& pixel : lobe(traced, 1, Rgb::Zero()).pixels) sum += static_cast<double>(pixel.x());
  const double scale = 0.25 * std::numbers::pi / 4 * k_lobe_side * k_lobe_side / sum;
  std::vector<Image> images{lobe(traced, scale, Rgb::Ones())};
  for (const std::string name : {"**64 bytes**", "8 x 8 slopes", "Gaussian (LEADR)", "Toksvig"}) {
    for (const ReflectanceFilter& filter : filters) {
      if (filter.name != name) continue;
      images.push_back(lobe(
          [&](const Pair& pair) {
            return filter.radiance(pair.toward_viewer, pair.toward_light, k_materials[k_glossy].material);
          },
          scale, Rgb::Ones()));
    }
  }
  return side_by_side(images);
}

/// Seconds of a processor.
struct Costs {
  double whole = 0;       ///< one distribution
  double levels = 0;      ///< all levels
  double lookup = 0;      ///< one pair of directions
  std::size_t bytes = 0;  ///< of all levels
};

Costs costs_of(const DisplacementMap& map, const std::vector<Pair>& pairs, std::size_t repeats) {
  Costs costs;
  costs.whole = median_seconds(repeats, [&] { facets_of(map); });
  costs.levels = median_seconds(repeats, [&] { costs.bytes = FacetLevels(map).bytes(); });
  const FacetDistribution facets = PackedFacets(facets_of(map)).unpacked();
  constexpr int k_rounds = 50;
  double sum = 0;
  costs.lookup = median_seconds(repeats,
                                [&] {
                                  for (int round = 0; round < k_rounds; ++round) {
                                    for (const auto& [v, l] : pairs)
                                      sum += filtered_reflectance(facets, v, l, k_materials[0].material);
                                  }
                                }) /
                 (k_rounds * static_cast<double>(pairs.size()));
  return std::isfinite(sum) ? costs : Costs{};
}

class Tables {
 public:
  void add(const Relief& relief, std::size_t m, const std::vector<ReflectanceFilter>& filters,
           const Errors& errors) {
    std::string& rows = rows_[m];
    if (rows.empty()) {
      rows = fmt::format("{}\n\n| |", k_materials[m].name);
      for (const ReflectanceFilter& filter : filters) rows += fmt::format(" {} |", filter.name);
      rows += " seen, unshaded | noise of the rays |\n|---|";
      for (std::size_t k = 0; k < filters.size() + 2; ++k) rows += "---|";
      rows += '\n';
    }
    rows += fmt::format("| {}{} |", relief.name, relief.held_out ? " (held out)" : "");
    for (std::size_t f = 0; f < filters.size(); ++f) {
      rows += fmt::format(" {:.1f} |", 100 * errors.filters[f]);
      add_figure(relief.name, filters[f].name, m, errors.filters[f]);
    }
    rows += fmt::format(" {:.1f} | {:.1f} |\n", 100 * errors.unshaded, 100 * errors.noise);
    add_figure(relief.name, "unshaded", m, errors.unshaded);
    add_figure(relief.name, "noise", m, errors.noise);
    if (m != k_glossy) return;
    // Ours, which is the last, has the first colour.
    for (std::size_t f = filters.size(); f-- > 0;) {
      if (!filters[f].label.empty())
        add_point(curve_, filters[f].label, static_cast<double>(filters[f].bytes), 100 * errors.filters[f]);
    }
  }
  void add(const Relief& relief, const Costs& costs) {
    costs_ += fmt::format("| {} | {:.1f} ms | {:.0f} ms, {} bytes | {:.0f} ns |\n", relief.name,
                          1e3 * costs.whole, 1e3 * costs.levels, costs.bytes, 1e9 * costs.lookup);
    csv_ +=
        fmt::format("filtered reflectance,{},64 bytes,lookup seconds,{:.4g}\n", relief.name, costs.lookup);
  }

  AppearanceSection section() const {
    std::string text = fmt::format(
        "## Filtered reflectance\n\nMean absolute error over {} pairs of directions within 75 degrees, in "
        "per cent of "
        "the mean; {} rays each.\n",
        k_pairs, k_rays_aside * k_rays_aside);
    for (const std::string& rows : rows_) text += '\n' + rows;
    text +=
        "\n| processor time | one distribution | all levels | one pair of directions |\n|---|---|---|---|\n" +
        costs_;
    AppearanceSection section{text, csv_, {curve_}};
    for (PlotSeries& series : section.curves.front().series) series.line = false;
    return section;
  }

 private:
  void add_figure(const std::string& relief, std::string method, std::size_t m, double value) {
    std::erase(method, '*');
    std::erase(method, ',');
    csv_ += fmt::format("filtered reflectance,{},{},error with {},{:.6g}\n", relief, method,
                        k_materials[m].name, value);
  }

  std::array<std::string, k_material_count> rows_;
  std::string costs_, csv_;
  Plot curve_ = log_plot(fmt::format("A dot for each relief, {}", k_materials[k_glossy].name),
                         "bytes of a distribution", "mean error, % of the mean");
};

}  // namespace

AppearanceSection measure_filtered_reflectance(const BenchOptions& options) {
  const std::vector<Pair> pairs = random_pairs();
  Tables tables;
  Image picture;
  for (const Relief& relief : wanted_reliefs(options)) {
    const DisplacedPlane plane(relief.map, {1, 1});
    std::vector<Traced> traced(pairs.size());
    tbb::parallel_for(std::size_t{0}, pairs.size(), [&](std::size_t k) {
      traced[k] = trace(plane, pairs[k], static_cast<unsigned>(k), k_rays_aside);
    });
    const std::vector<ReflectanceFilter> filters = reflectance_filters(relief.map);
    for (std::size_t m = 0; m < k_material_count; ++m)
      tables.add(relief, m, filters, errors_of(m, filters, pairs, traced));
    tables.add(relief, costs_of(relief.map, pairs, options.repeats));
    if (!relief.held_out) {
      const Image row = lobes(plane, filters);
      picture.width = row.width;
      picture.height += row.height;
      picture.pixels.insert(picture.pixels.end(), row.pixels.begin(), row.pixels.end());
    }
    fmt::print(stderr, "{} is done\n", relief.name);
  }
  if (picture.height > 0) write_png(options.out / "appearance-lobes.png", picture);
  return tables.section();
}

}  // namespace recede::bench
