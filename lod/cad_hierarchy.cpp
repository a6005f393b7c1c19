#include <recede/geometry/closest_point.h>
#include <recede/geometry/error.h>
#include <recede/lod/cad_hierarchy.h>
#include <recede/lod/detail/hierarchy_options.h>
#include <recede/lod/detail/switch_distances.h>

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

namespace recede {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::array<double, 5> k_default_errors{3e-4, 1e-3, 3e-3, 0.01, 0.03};  // of the diagonal

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// The largest factor by which a placement makes lengths longer.
double scale_of(const Eigen::Affine3d& placement) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(placement.linear().transpose() *
                                                              placement.linear());
  return std::sqrt(solver.eigenvalues().maxCoeff());
}

// Whether glTF's nodes can hold the placement: they have no shear.
bool is_without_shear(const Eigen::Affine3d& placement) {
  constexpr double k_right_angle = 1e-9;  // cosine
  const Eigen::Matrix3d axes = placement.linear().colwise().normalized();
  return (axes.transpose() * axes - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < k_right_angle;
}

// Adds an instance of a part's triangles.
void append(const PolygonSoup& part, const CadInstance& instance, PolygonSoup& model) {
  const auto first = static_cast<Index>(model.positions.size());
  const Eigen::Matrix3d linear = instance.placement.linear(), for_normals = linear.inverse().transpose();
  const bool is_mirrored = linear.determinant() < 0;
  for (const Vec3& point : part.positions) model.positions.push_back(instance.placement * point);
  for (std::size_t face = 0; face < part.n_faces(); ++face) {
    std::array<std::size_t, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = part.face_offsets[face] + k;
    if (is_mirrored) std::swap(corners[1], corners[2]);
    std::array<Index, 3> vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      vertices[k] = first + part.corner_vertices[corners[k]];
      const Vec3 normal = for_normals * part.corner_normals[corners[k]];
      model.corner_normals.push_back(normal.isZero(0) ? normal : Vec3(normal.normalized()));
    }
    model.add_face(vertices);
    const Index material = part.face_materials[face];
    model.face_materials.push_back(material == k_no_index ? instance.material : material);
  }
}

class CadLevels {
 public:
  CadLevels(const CadModel& model, const CadHierarchyOptions& options, Progress* progress)
      : model_(model),
        options_(options),
        progress_(progress),
        scales_(model.parts.size(), 0.0),
        squared_scales_(model.parts.size(), 0.0),
        uses_(model.parts.size(), 0) {
    for (const CadInstance& instance : model.instances) {
      const double scale = scale_of(instance.placement);
      scales_[instance.part] = std::max(scales_[instance.part], scale);
      squared_scales_[instance.part] += scale * scale;
      ++uses_[instance.part];
    }
  }

  CadHierarchy run(const std::string& name) {
    result_.diagonal = cad_diagonal(model_);
    choose_errors();
    prepare();
    result_.hierarchy.name = name;
    result_.hierarchy.view = options_.view;
    if (is_assembly()) {
      result_.hierarchy.instances = model_.instances;
      for (const CadPart& part : model_.parts) result_.hierarchy.part_names.push_back(part.name);
    }
    for (const double error : errors_) add_level(error);
    measure();
    detail::set_switch_distances(result_.hierarchy);
    return std::move(result_);
  }

 private:
  void choose_errors() {
    const int ways = int(!options_.errors.empty()) + int(!options_.relative_errors.empty()) +
                     int(!options_.distances.empty());
    if (ways > 1) throw OptionError("levels are chosen by one of errors, relative errors and distances");
    errors_ = options_.errors;
    for (const double share : options_.relative_errors) errors_.push_back(share * result_.diagonal);
    for (const double distance : options_.distances)
      errors_.push_back(options_.view.pixel_error * pixel_footprint(distance, options_.view));
    if (errors_.empty()) {
      for (const double share : k_default_errors) errors_.push_back(share * result_.diagonal);
    }
    for (std::size_t i = 0; i < errors_.size(); ++i) {
      if (!(errors_[i] > 0 && std::isfinite(errors_[i]))) throw OptionError("errors must be positive");
      if (i > 0 && !(errors_[i] > errors_[i - 1])) throw OptionError("errors must increase");
    }
  }

  bool is_assembly() const {
    return model_.instances.size() > 1 &&
           std::all_of(model_.instances.begin(), model_.instances.end(),
                       [](const CadInstance& instance) { return is_without_shear(instance.placement); });
  }

  void prepare() {
    models_.reserve(model_.parts.size());
    for (std::size_t i = 0; i < model_.parts.size(); ++i) {
      const CadPart& part = model_.parts[i];
      report_progress(progress_, "parts", static_cast<double>(i) / static_cast<double>(model_.parts.size()));
      SeamModelOptions options;
      options.seams.tolerance = errors_.front() / scales_[i];
      options.seams.gap = options_.gap / scales_[i];
      options.seams.use_connectivity = options_.use_connectivity;
      options.hierarchy.largest_error = errors_.back() / scales_[i];
      models_.push_back(build_seam_model(part, options));
      const SeamModel& made = models_.back();
      result_.parts.push_back(
          {part.name, made.graph.report, part.patches.size(), made.graph.positions.size(), made.turned});
      result_.patches += part.patches.size() * uses_[i];
    }
    for (const SeamModel& model : models_) tessellations_.emplace_back(model);
  }

  void add_level(double error) {
    report_progress(progress_, fmt::format("level {}", soups_.size()), 0);
    const auto start = Clock::now();
    CadLevelReport report;
    LodLevel level;
    std::vector<PolygonSoup> parts;
    for (std::size_t i = 0; i < models_.size(); ++i) {
      const SeamUpdate update = tessellations_[i].update(error / scales_[i]);
      parts.push_back(tessellations_[i].soup());
      report.patches += update.patches * uses_[i];
      report.triangles += update.triangles * uses_[i];
      report.tightened += update.tightened * uses_[i];
      level.error.bound = std::max(level.error.bound, update.error_bound * scales_[i]);
      for (const Index patch : update.refused) {
        const PatchTriangles& triangles = tessellations_[i].triangles_of(patch);
        report.missed.push_back(
            fmt::format("face {} of \"{}\": {}", models_[i].names[patch], model_.parts[i].name,
                        triangles.triangles.empty()
                            ? "no triangles, as its loops cross or go around nothing"
                            : fmt::format("within {:.3g} only", triangles.error_bound * scales_[i])));
      }
    }
    PolygonSoup soup;
    soup.materials = model_.materials;
    for (const CadInstance& instance : model_.instances) append(parts[instance.part], instance, soup);
    report.seconds = seconds_since(start);
    level.simplify_seconds = report.seconds;
    level.stop_reason = report.missed.empty() ? "error reached" : "error not reached everywhere";
    measure_samples(level);
    soups_.push_back(soup);
    level.mesh = repair_to_polygon_mesh(std::move(soup)).mesh;
    if (!result_.hierarchy.instances.empty()) {
      for (PolygonSoup& part : parts) {
        part.materials = model_.materials;
        level.parts.push_back(to_soup(repair_to_polygon_mesh(std::move(part)).mesh));
      }
    }
    result_.hierarchy.levels.push_back(std::move(level));
    result_.levels.push_back(std::move(report));
  }

  void measure_samples(LodLevel& level) const {
    double squares = 0, area = 0;
    for (std::size_t i = 0; i < tessellations_.size(); ++i) {
      const SampledDeviation sampled = tessellations_[i].sampled_deviation();
      level.error.max = std::max(level.error.max, sampled.max * scales_[i]);
      const double of_instances = sampled.area * squared_scales_[i];
      squares += std::pow(sampled.rms * scales_[i], 2) * of_instances;
      area += of_instances;
    }
    level.error.rms = area > 0 ? std::sqrt(squares / area) : 0;
  }

  // What vanished has no triangles to measure it by, but level 0 has points on it.
  void measure() {
    const PolygonSoup& finest = soups_.front();
    LodHierarchy& hierarchy = result_.hierarchy;
    detail::set_bounding_sphere(hierarchy, finest.positions);
    for (std::size_t i = 1; i < soups_.size(); ++i) {
      LodLevel& level = hierarchy.levels[i];
      if (soups_[i].n_faces() == 0 || finest.positions.empty()) continue;
      report_progress(progress_, fmt::format("level {}: measure", i), 0);
      const auto start = Clock::now();
      const ClosestPointTree tree(soups_[i].positions, soups_[i].corner_vertices);
      std::vector<double> squares(finest.positions.size());
      tbb::parallel_for(std::size_t{0}, squares.size(), [&](std::size_t k) {
        squares[k] = tree.closest(finest.positions[k]).squared_distance;
      });
      const double sum = std::accumulate(squares.begin(), squares.end(), 0.0);
      level.error.max =
          std::max(level.error.max, std::sqrt(*std::max_element(squares.begin(), squares.end())));
      level.error.rms = std::max(level.error.rms, std::sqrt(sum / static_cast<double>(squares.size())));
      level.measure_seconds = seconds_since(start);
    }
  }

  const CadModel& model_;
  const CadHierarchyOptions& options_;
  Progress* progress_;
  // By part, of its instances: the largest scale, the sum of their squares, and how many there are.
  std::vector<double> scales_, squared_scales_;
  std::vector<std::size_t> uses_;
  std::vector<double> errors_;
  std::vector<SeamModel> models_;
  std::vector<SeamTessellation> tessellations_;
  std::vector<PolygonSoup> soups_;
  CadHierarchy result_;
};

}  // namespace

Box3 cad_trimming_box(const CadModel& model) {
  constexpr int k_samples = 8;
  Box3 box;
  for (const CadInstance& instance : model.instances) {
    for (const TrimmedPatch& patch : model.parts[instance.part].patches) {
      for (const TrimmingLoop& loop : patch.loops) {
        for (const TrimmingCurve& curve : loop.curves) {
          const ParameterRange range = curve.curve.domain();
          for (int i = 0; i < k_samples; ++i) {
            const Vec2 uv = evaluate(curve.curve, range.begin + range.length() * i / k_samples);
            box.extend(instance.placement * evaluate(patch.surface, uv));
          }
        }
      }
    }
  }
  return box;
}

double cad_diagonal(const CadModel& model) {
  const Box3 box = cad_trimming_box(model);
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

CadHierarchy build_cad_hierarchy(const CadModel& model, const std::string& name,
                                 const CadHierarchyOptions& options, Progress* progress) {
  detail::check(options.view);
  return CadLevels(model, options, progress).run(name);
}

}  // namespace recede
