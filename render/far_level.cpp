#include <recede/geometry/error.h>
#include <recede/lod/billboard_level.h>
#include <recede/render/far_level.h>
#include <recede/render/renderer.h>
#include <recede/render/sphere_directions.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

namespace {

void check(const LodHierarchy& hierarchy, const FarLevelOptions& options) {
  if (hierarchy.levels.empty() || hierarchy.levels[0].mesh.n_faces() == 0)
    throw InputError("a level far away needs a model with faces");
  double last = 0;
  for (const double error : options.relative_errors) {
    if (!(error > last && std::isfinite(error)))
      throw OptionError("errors of far levels are above 0 and increase");
    last = error;
  }
  if (options.views < 6 || options.views > 4096)
    throw OptionError("far levels are compared in 6 to 4096 views");
}

double area_of(const PolygonSoup& model) {
  double area = 0;
  for (std::size_t face = 0; face < model.n_faces(); ++face) area += vector_area(model, face).norm();
  return area;
}

// Leaves and other sheets have more borders than closed bodies.
bool is_of_sheets(const PolygonMesh& mesh) {
  constexpr double k_share = 0.1;
  std::size_t n_borders = 0;
  for (const auto edge : mesh.edges())
    if (mesh.is_boundary(edge)) ++n_borders;
  return static_cast<double>(n_borders) > k_share * static_cast<double>(mesh.n_edges());
}

// As many triangles as some bytes hold; parts are dropped where else they don't become that few.
PolygonMesh simplified_to_bytes(const PolygonMesh& mesh, std::size_t bytes, Progress* progress) {
  if (mesh_bytes(mesh) <= bytes) return mesh;
  SimplifyOptions options;
  options.prove_error = false;
  double faces = static_cast<double>(mesh.n_faces());
  PolygonMesh result = mesh;
  constexpr int k_attempts = 12;
  for (int attempt = 0; attempt < k_attempts && mesh_bytes(result) > bytes; ++attempt) {
    // What the last attempt missed by, and a little.
    constexpr double k_less = 0.98;
    faces *= std::min(k_less, k_less * static_cast<double>(bytes) / static_cast<double>(mesh_bytes(result)));
    options.target.faces = static_cast<std::size_t>(std::max(1.0, faces));
    SimplifyResult reached = simplify(mesh, options, progress);
    if (!options.drop_parts && reached.stop_reason == StopReason::no_collapse_left) {
      options.drop_parts = true;
      reached = simplify(mesh, options, progress);
    }
    result = std::move(reached.mesh);
  }
  return result;
}

std::size_t n_triangles(const PolygonMesh& mesh) {
  std::size_t n = 0;
  for (const auto face : mesh.faces()) n += mesh.valence(face) - 2;
  return n;
}

// Pictures of the model, and how far others are from them.
class FarPictures {
 public:
  FarPictures(const Scene& model, const LodHierarchy& hierarchy, double distance, int n_views) {
    const Vec3 up = Vec3::UnitY();
    for (const Vec3& direction : spread_directions(n_views).directions) {
      const Camera whole =
          look_at(hierarchy.center, direction, distance + hierarchy.radius, up, hierarchy.view);
      int side = std::min(whole.height, static_cast<int>(projected_diameter(whole, hierarchy.radius)) + 4);
      side += (whole.height - side) % 2;
      cameras_.push_back(crop_to_middle(whole, side, side));
      pictures_.push_back(render(model, cameras_.back(), options_));
    }
    for (const Image& picture : pictures_) {
      for (const Rgb& pixel : picture.pixels)
        if (pixel != options_.background) ++n_pixels_;
    }
  }

  double difference(const Scene& scene) const {
    double squares = 0;
    for (std::size_t view = 0; view < cameras_.size(); ++view) {
      const Image picture = render(scene, cameras_[view], options_);
      for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          const float step = encode_srgb(picture.pixels[i][k]) - encode_srgb(pictures_[view].pixels[i][k]);
          squares += static_cast<double>(step * step) / 3;
        }
      }
    }
    return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, n_pixels_)));
  }

 private:
  RenderOptions options_{.samples_per_pixel = 16};
  std::vector<Camera> cameras_;
  std::vector<Image> pictures_;
  std::size_t n_pixels_ = 0;  // that the model is in
};

class FarLevels {
 public:
  FarLevels(const LodHierarchy& hierarchy, const FarLevelOptions& options, Progress* progress)
      : hierarchy_(hierarchy),
        options_(options),
        progress_(progress),
        model_(to_soup(hierarchy.levels[0].mesh)),
        area_(area_of(model_)) {
    for (const LodLevel& level : hierarchy.levels)
      level_bytes_.push_back(level.billboards ? 0 : mesh_bytes(level.mesh));
  }

  std::vector<FarLevelTrial> run() {
    const double size = bounding_box(model_).sizes().maxCoeff();
    std::vector<FarLevelTrial> trials;
    std::vector<std::size_t> open;  // that pictures decide
    for (const double share : options_.relative_errors) {
      FarLevelTrial& trial = trials.emplace_back();
      trial.error = share * size;
      trial.distance = switch_distance(trial.error, hierarchy_.view);
      if (!triangles_serve(trial)) open.push_back(trials.size() - 1);
    }
    if (open.empty()) return trials;
    std::vector<FarPictures> pictures;
    const Scene model(hierarchy_.levels[0]);
    for (const std::size_t i : open)
      pictures.emplace_back(model, hierarchy_, trials[i].distance, options_.views);
    for (const BillboardMethod method : {BillboardMethod::face_clustering, BillboardMethod::plane_cover}) {
      BillboardOptions clouds;
      clouds.method = method;
      clouds.errors.clear();
      for (const std::size_t i : open) clouds.errors.push_back(trials[i].error);
      clouds.is_two_sided = is_of_sheets(hierarchy_.levels[0].mesh);
      const std::vector<BillboardCloud> built = build_billboard_clouds(model_, clouds, progress_);
      for (std::size_t k = 0; k < open.size(); ++k) {
        FarLevelTrial& best = trials[open[k]];
        FarLevelTrial trial{.error = best.error, .method = method, .distance = best.distance};
        compare(built[k], pictures[k], trial);
        if (!best.cloud || advantage_of(trial) > advantage_of(best)) best = std::move(trial);
      }
    }
    return trials;
  }

 private:
  // More texels than errors ask for show leaves better than as many bytes of triangles.
  static constexpr double k_texels_per_error = 2;

  // Above 1: billboards are nearer to the model.
  static double advantage_of(const FarLevelTrial& trial) {
    return trial.triangle_difference / std::max(trial.billboard_difference, 1e-9);
  }

  // The level that takes the least of what is more than some bytes; the finest if none does.
  std::size_t level_above(std::size_t bytes) const {
    for (std::size_t i = level_bytes_.size(); i-- > 1;) {
      if (level_bytes_[i] > bytes) return i;
    }
    return 0;
  }

  bool triangles_serve(FarLevelTrial& trial) const {
    const double texel = trial.error / k_texels_per_error;
    const auto texture_bytes = static_cast<std::size_t>(8 * area_ / (texel * texel));
    for (std::size_t i = 0; i < hierarchy_.levels.size(); ++i) {
      const LodLevel& level = hierarchy_.levels[i];
      if (level.billboards || level.error.bound > trial.error / 2 || level_bytes_[i] > texture_bytes)
        continue;
      take_triangles(trial, level.mesh, level_bytes_[i]);
      return true;
    }
    const PolygonMesh mesh =
        simplified_to_bytes(hierarchy_.levels[level_above(texture_bytes)].mesh, texture_bytes, progress_);
    const std::size_t bytes = mesh_bytes(mesh);
    if (bytes <= texture_bytes && mesh.n_faces() > 0 && bound_of(mesh) <= trial.error / 2) {
      take_triangles(trial, mesh, bytes);
      return true;
    }
    if (model_.n_faces() > options_.most_faces) {
      trial.reason = fmt::format("triangles: {} faces are too many to merge", model_.n_faces());
      return true;
    }
    return false;
  }

  double bound_of(const PolygonMesh& mesh) const {
    const DistanceOptions measure{.samples = 20'000, .bound_tolerance = 0.1};
    return measure_distance(model_, to_soup(mesh), measure, progress_).max_bound.value();
  }

  static void take_triangles(FarLevelTrial& trial, const PolygonMesh& mesh, std::size_t bytes) {
    trial.triangles = n_triangles(mesh);
    trial.triangle_bytes = bytes;
    trial.reason = fmt::format(
        "triangles: {} of them are off by no more than half of a pixel, in {} bytes; texels take more",
        trial.triangles, bytes);
  }

  void compare(const BillboardCloud& cloud, const FarPictures& pictures, FarLevelTrial& trial) {
    BillboardTextures textures =
        texture_billboards(model_, cloud, {.texels_per_error = k_texels_per_error}, progress_);
    trial.billboards = textures.billboards.size();
    trial.texels = textures.n_texels();
    trial.billboard_bytes = billboard_bytes(textures);
    const PolygonMesh triangles = simplified_to_bytes(
        hierarchy_.levels[level_above(trial.billboard_bytes)].mesh, trial.billboard_bytes, progress_);
    trial.triangles = n_triangles(triangles);
    trial.triangle_bytes = mesh_bytes(triangles);
    report_progress(progress_, "compare far levels", 0);
    trial.triangle_difference = pictures.difference(Scene(triangles));
    const PlacedBillboards placed{std::make_shared<const BillboardTextures>(textures)};
    trial.billboard_difference = pictures.difference(
        Scene(std::span<const PolygonSoup>{}, std::span<const PlacedBillboards>(&placed, 1)));
    trial.takes_billboards = trial.billboard_difference < trial.triangle_difference;
    trial.cloud = std::move(textures);
    trial.reason = fmt::format(
        "{}: pictures of {} billboards are off by {:.3g}, of {} triangles in no more bytes ({}) by {:.3g}",
        trial.takes_billboards ? "billboards" : "triangles", trial.billboards, trial.billboard_difference,
        trial.triangles, trial.billboard_bytes, trial.triangle_difference);
  }

  const LodHierarchy& hierarchy_;
  const FarLevelOptions& options_;
  Progress* progress_;
  PolygonSoup model_;
  double area_;
  std::vector<std::size_t> level_bytes_;  // 0 of billboards
};

}  // namespace

std::size_t mesh_bytes(const PolygonMesh& mesh) {
  std::size_t n_vertices = mesh.n_vertices();
  if (mesh.has_corner_normals() || mesh.has_corner_uvs()) {
    std::vector<std::array<double, 6>> corners;
    corners.reserve(mesh.n_halfedges());
    for (const auto corner : mesh.halfedges()) {
      if (mesh.is_boundary(corner)) continue;
      const Vec3 normal = mesh.has_corner_normals() ? mesh.corner_normal(corner) : Vec3(Vec3::Zero());
      const Vec2 uv = mesh.has_corner_uvs() ? mesh.corner_uv(corner) : Vec2(Vec2::Zero());
      corners.push_back({static_cast<double>(mesh.to_vertex_handle(corner).idx()), normal.x(), normal.y(),
                         normal.z(), uv.x(), uv.y()});
    }
    std::sort(corners.begin(), corners.end());
    n_vertices = static_cast<std::size_t>(std::unique(corners.begin(), corners.end()) - corners.begin());
  }
  constexpr std::size_t k_vertex = 28, k_triangle = 12;
  return k_vertex * n_vertices + k_triangle * n_triangles(mesh);
}

std::size_t billboard_bytes(const BillboardTextures& textures) {
  // Four vertices of positions, normals, tangents and texture coordinates, and two triangles.
  constexpr std::size_t k_rectangle = 4 * (12 + 12 + 16 + 8) + 2 * 12;
  return textures.bytes() + k_rectangle * textures.billboards.size();
}

std::vector<FarLevelTrial> compare_far_levels(const LodHierarchy& hierarchy, const FarLevelOptions& options,
                                              Progress* progress) {
  check(hierarchy, options);
  return FarLevels(hierarchy, options, progress).run();
}

std::size_t append_far_levels(LodHierarchy& hierarchy, std::vector<FarLevelTrial>& trials,
                              Progress* progress) {
  const PolygonSoup model = to_soup(hierarchy.levels[0].mesh);
  std::size_t n = 0;
  for (FarLevelTrial& trial : trials) {
    if (!trial.takes_billboards || !trial.cloud) continue;
    LodLevel level = billboard_level(model, std::move(*trial.cloud), "", progress);
    trial.cloud.reset();
    // Level 0 may be off itself: of a file that is larger than memory.
    const LevelError& of_finest = hierarchy.levels[0].error;
    level.error.max += of_finest.max;
    level.error.rms += of_finest.rms;
    level.error.bound += of_finest.bound;
    // Behind a level that serves from farther away nobody would see it.
    std::size_t n_replaced = 0;
    for (; hierarchy.levels.size() > 1 && hierarchy.levels.back().error.bound > level.error.bound;
         ++n_replaced)
      hierarchy.levels.pop_back();
    if (n_replaced > 0)
      trial.reason += fmt::format("; they replace {} {} for larger distances", n_replaced,
                                  n_replaced == 1 ? "level" : "levels");
    level.stop_reason = trial.reason;
    append_level(hierarchy, std::move(level));
    ++n;
  }
  return n;
}

}  // namespace recede
