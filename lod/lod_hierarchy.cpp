#include <recede/geometry/error.h>
#include <recede/lod/detail/hierarchy_options.h>
#include <recede/lod/detail/switch_distances.h>

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace recede {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void require(bool condition, const std::string& text) {
  if (!condition) throw OptionError(text);
}

template <typename Value, typename InOrder>
void check_list(const std::vector<Value>& values, const char* name, InOrder in_order, const char* order) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    require(std::isfinite(static_cast<double>(values[i])) && values[i] > 0,
            fmt::format("{} must be positive", name));
    require(i == 0 || in_order(values[i - 1], values[i]), fmt::format("{} must {}", name, order));
  }
}

}  // namespace

void detail::check(const ViewSettings& view) {
  require(view.image_height >= 1 && std::isfinite(view.image_height),
          "the image height must be at least one pixel");
  require(view.field_of_view > 0 && view.field_of_view < 3.14159,
          "the field of view must lie between 0 and 180 degrees");
  require(view.pixel_error > 0 && std::isfinite(view.pixel_error), "the pixel error must be positive");
}

void detail::check(const HierarchyOptions& options) {
  const int ways = int(!options.faces.empty()) + int(!options.ratios.empty()) + int(!options.errors.empty()) +
                   int(!options.relative_errors.empty()) + int(!options.distances.empty());
  require(ways <= 1, "levels are chosen by one of faces, ratios, errors, relative errors and distances");
  check_list(options.faces, "faces", std::greater<>(), "decrease");
  check_list(options.ratios, "ratios", std::greater<>(), "decrease");
  check_list(options.errors, "errors", std::less<>(), "increase");
  check_list(options.relative_errors, "relative errors", std::less<>(), "increase");
  check_list(options.distances, "distances", std::less<>(), "increase");
  require(options.ratios.empty() || options.ratios.front() < 1, "ratios must be below 1");
  check(options.view);
  require(options.measure.bound_tolerance.has_value(), "a hierarchy needs a certified bound");
}

namespace {

/// Passes progress on with the level's name in front.
class LevelProgress final : public Progress {
 public:
  LevelProgress(Progress* to, std::string level) : to_(to), level_(std::move(level)) {}
  void update(std::string_view stage, double fraction) override {
    report_progress(to_, fmt::format("{}: {}", level_, stage), fraction);
  }
  bool cancel_requested() const override { return to_ != nullptr && to_->cancel_requested(); }

 private:
  Progress* to_;
  std::string level_;
};

class HierarchyBuilder {
 public:
  HierarchyBuilder(const PolygonMesh& mesh, const HierarchyOptions& options, Progress* progress)
      : mesh_(mesh), input_(to_soup(mesh)), meter_(input_), options_(options), progress_(progress) {}

  LodHierarchy build(const std::string& name) {
    hierarchy_.name = name;
    hierarchy_.view = options_.view;
    detail::set_bounding_sphere(hierarchy_, input_.positions);
    hierarchy_.levels.push_back({.mesh = mesh_});
    const std::vector<SimplifyTarget> by_error = error_targets();
    if (by_error.empty()) {
      add_levels(size_targets(), false);  // what is measured goes into the report with more than the bound
    } else {
      add_levels(by_error, true);
    }
    detail::set_switch_distances(hierarchy_);
    if (options_.maps) add_maps();
    return std::move(hierarchy_);
  }

 private:
  std::vector<SimplifyTarget> size_targets() const {
    std::vector<SimplifyTarget> targets;
    for (const std::size_t faces : options_.faces) targets.push_back({.faces = faces});
    for (const double ratio : options_.ratios) targets.push_back({.ratio = ratio});
    if (!targets.empty()) return targets;
    for (const double ratio : detail::k_default_ratios) targets.push_back({.ratio = ratio});
    return targets;
  }

  std::vector<SimplifyTarget> error_targets() const {
    std::vector<SimplifyTarget> targets;
    for (const double error : options_.errors) targets.push_back({.error = error});
    for (const double share : options_.relative_errors) targets.push_back({.relative_error = share});
    for (const double distance : options_.distances) {
      targets.push_back({.error = options_.view.pixel_error * pixel_footprint(distance, options_.view)});
    }
    return targets;
  }

  void add_levels(const std::vector<SimplifyTarget>& targets, bool prove_error) {
    SimplifyOptions options = options_.simplify;
    options.prove_error = prove_error;
    for (SimplifyResult& result : simplify_levels(mesh_, targets, options, progress_))
      add_level(std::move(result));
  }

  LodLevel measured_level(SimplifyResult result, Progress* progress) {
    LodLevel level;
    level.simplify_seconds = result.seconds + result.proof_seconds;
    level.stop_reason = to_string(result.stop_reason);
    const auto start = Clock::now();
    DistanceOptions measure = options_.measure;
    if (result.error_bound) measure.bound_tolerance.reset();  // it is proved already
    const MeshDistance distance = meter_.to(to_soup(result.mesh), measure, progress);
    level.measure_seconds = seconds_since(start);
    const double bound = result.error_bound ? *result.error_bound : *distance.max_bound;
    // A sample may come out above a bound of zero by rounding.
    level.error = {distance.max, distance.rms, std::max(bound, distance.max)};
    level.mesh = std::move(result.mesh);
    return level;
  }

  void add_level(SimplifyResult result) {
    LevelProgress progress(progress_, fmt::format("level {}", hierarchy_.levels.size()));
    hierarchy_.levels.push_back(measured_level(std::move(result), &progress));
  }

  void add_maps() {
    for (std::size_t i = 1; i < hierarchy_.levels.size(); ++i) {
      LodLevel& level = hierarchy_.levels[i];
      LevelProgress progress(progress_, fmt::format("level {}", i));
      MapOptions options = *options_.maps;
      if (!options.search_distance && level.error.bound > 0)
        options.search_distance = MapOptions::k_reach * level.error.bound;
      level.maps = bake_maps(input_, to_soup(level.mesh), options, &progress);
      if (options.displacement) level.map_accuracy = measure_maps(input_, *level.maps, &progress);
    }
  }

  const PolygonMesh& mesh_;
  PolygonSoup input_;
  DistanceMeter meter_;
  const HierarchyOptions& options_;
  Progress* progress_;
  LodHierarchy hierarchy_;
};

}  // namespace

void detail::set_bounding_sphere(LodHierarchy& hierarchy, const std::vector<Vec3>& points) {
  Box3 box;
  for (const Vec3& p : points) box.extend(p);
  hierarchy.center = box.center();
  hierarchy.radius = 0;
  for (const Vec3& p : points) hierarchy.radius = std::max(hierarchy.radius, (p - hierarchy.center).norm());
}

void detail::set_switch_distances(LodHierarchy& hierarchy) {
  double previous = 0;
  for (LodLevel& level : hierarchy.levels) {
    level.switch_distance = std::max(previous, switch_distance(level.error.bound, hierarchy.view));
    previous = level.switch_distance;
    const double to_center = level.switch_distance + hierarchy.radius;
    const double half_height = to_center * std::tan(hierarchy.view.field_of_view / 2);
    level.screen_coverage = half_height > 0 ? std::min(1.0, hierarchy.radius / half_height) : 1;
  }
  // From everywhere: there is no finer one.
  hierarchy.levels.front().switch_distance = 0;
  hierarchy.levels.front().screen_coverage = 1;
}

LodHierarchy build_hierarchy(const PolygonMesh& mesh, const std::string& name,
                             const HierarchyOptions& options, Progress* progress) {
  detail::check(options);
  if (mesh.n_faces() == 0) throw InputError(name + ": a hierarchy needs a mesh with faces");
  return HierarchyBuilder(mesh, options, progress).build(name);
}

}  // namespace recede
