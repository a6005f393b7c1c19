#include "billboard_models.h"

#include "models.h"
#include <recede/geometry/sample_models.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace recede::bench {
namespace {

BillboardModel from_file(const BenchOptions& options, const std::string& name) {
  const ModelSource source = model_file(options.data, name);
  require_file(source);
  return {.name = name, .soup = source.load()};
}

}  // namespace

BillboardModel billboard_model(const BenchOptions& options, const std::string& name) {
  BillboardModel model = name == "tree"
                             ? BillboardModel{.name = name, .is_two_sided = true, .soup = make_tree()}
                             : from_file(options, name);
  merge_identical_vertices(model.soup);
  model.box = bounding_box(model.soup);
  return model;
}

std::vector<BillboardModel> billboard_models(const BenchOptions& options) {
  std::vector<BillboardModel> models;
  for (const char* name : {"mannequin-devil", "tree", "man", "fandisk"}) {
    if (is_wanted(name, options.models)) models.push_back(billboard_model(options, name));
  }
  return models;
}

PolygonSoup loose_leaves(std::size_t n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  constexpr double k_length = 2;  // over the width
  const double width = std::sqrt(4 * std::numbers::pi / (k_length * static_cast<double>(n)));
  PolygonSoup soup;
  while (soup.n_faces() < n) {
    const Vec3 at(number(random), number(random), number(random));
    const Vec3 turn(number(random), number(random), number(random));
    if (at.norm() > 1 || !(turn.norm() > 0)) continue;
    const Vec3 along = k_length * width / 2 * turn.normalized();
    const Vec3 across = width / 2 * turn.unitOrthogonal();
    const auto first = static_cast<Index>(soup.positions.size());
    for (const Vec2& corner : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1)})
      soup.positions.push_back(at + corner.x() * along + corner.y() * across);
    soup.add_face(std::array<Index, 4>{first, first + 1, first + 2, first + 3});
  }
  return soup;
}

BillboardCloud cloud_of(const BillboardModel& model, BillboardMethod method, double share) {
  BillboardOptions options;
  options.method = method;
  options.errors = {share * model.size()};
  options.is_two_sided = model.is_two_sided;
  return build_billboard_clouds(model.soup, options).front();
}

std::vector<TexturedCloud> textured_clouds(const BillboardModel& model, double share) {
  std::vector<TexturedCloud> clouds;
  for (const auto& [name, method] : {std::pair("clusters", BillboardMethod::face_clustering),
                                     std::pair("planes", BillboardMethod::plane_cover)}) {
    const BillboardCloud cloud = cloud_of(model, method, share);
    for (const double per_error : {1.0, 2.0, 4.0})
      clouds.push_back(
          {name, per_error, texture_billboards(model.soup, cloud, {.texels_per_error = per_error})});
  }
  return clouds;
}

BillboardTextures hough_textures(const BillboardModel& model, const BillboardCloud& cloud,
                                 double texels_per_error) {
  int longest = 1;
  for (const Billboard& billboard : cloud.billboards) {
    const double texels = 2 * billboard.half_sizes.maxCoeff() / cloud.error * texels_per_error;
    longest = std::max(longest, static_cast<int>(std::ceil(texels)));
  }
  return texture_billboards(model.soup, cloud, {.texels_per_error = texels_per_error, .overlap = longest});
}

BillboardTextures flattened(BillboardTextures textures) {
  constexpr std::uint16_t k_middle = 128;
  std::fill(textures.height.samples.begin(), textures.height.samples.end(), k_middle);
  return textures;
}

Scene scene_of(const BillboardTextures& textures) {
  const PlacedBillboards placed{std::make_shared<const BillboardTextures>(textures)};
  return Scene(std::span<const PolygonSoup>{}, std::span<const PlacedBillboards>(&placed, 1));
}

Camera camera_at_pixel(const BillboardModel& model, const Vec3& direction, double pixel) {
  constexpr double k_far = 8;  // diagonals
  constexpr int k_border = 4;  // pixels
  const double distance = k_far * model.diagonal();
  // Not along the view from straight above or below.
  const Vec3 up(0.01, 1, 0.02);
  Camera camera = look_at(model.box.center(), direction, distance, up, {});
  camera.width = camera.height = static_cast<int>(std::ceil(model.diagonal() / pixel)) + k_border;
  camera.field_of_view = 2 * std::atan(0.5 * camera.height * pixel / distance);
  return camera;
}

}  // namespace recede::bench
