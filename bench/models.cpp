#include "models.h"

#include "child_process.h"
#include <recede/geometry/detail/format_io.h>
#include <recede/geometry/error.h>
#include <recede/geometry/mesh_io.h>
#include <recede/geometry/polygon_mesh.h>
#include <recede/geometry/sample_models.h>

#include <fmt/format.h>

namespace recede::bench {
namespace {

constexpr unsigned k_load_seconds = 600;

ModelSource sphere(const std::string& name, std::size_t faces, bool triangles) {
  return {
      .name = name, .polygons = !triangles, .load = [=] { return make_displaced_sphere(faces, triangles); }};
}

void round_to_float(PolygonSoup& soup) {
  for (Vec3& p : soup.positions) p = p.unaryExpr(&detail::rounded_to_float);
}

}  // namespace

ModelSource model_file(const std::filesystem::path& data, const std::string& name) {
  const std::filesystem::path path = data / (name + ".off");
  return {.name = name, .file = path, .load = [path] { return read_soup(path); }};
}

std::vector<ModelSource> all_models(const std::filesystem::path& data, bool quick) {
  std::vector<ModelSource> models;
  for (const char* name : {"fandisk_large", "armadillo", "bunny00", "refined_elephant"}) {
    models.push_back(model_file(data, name));
  }
  models.push_back(sphere("sphere 250k", 250'000, true));
  if (!quick) models.push_back(sphere("sphere 1M", 1'000'000, true));
  models.push_back(sphere("quad sphere 25k", 25'000, false));
  models.push_back({.name = "teapot", .polygons = true, .load = [] { return make_teapot(); }});
  return models;
}

std::vector<ModelSource> growing_models(bool quick) {
  std::vector<ModelSource> models;
  for (const std::size_t thousands : {10u, 30u, 100u, 300u, 1000u, 2000u, 4000u, 10000u}) {
    if (quick && thousands > 300) break;
    models.push_back(sphere(fmt::format("sphere {}k", thousands), thousands * 1000, true));
  }
  return models;
}

void require_file(const ModelSource& source) {
  if (source.file.empty() || std::filesystem::exists(source.file)) return;
  throw InputError(fmt::format("{} is missing; `./dev data` fetches it", source.file.string()));
}

PolygonSoup load_model(const ModelSource& source) {
  const ChildAnswer answer = run_in_child(
      [&] {
        PolygonSoup soup = source.load();
        round_to_float(soup);
        merge_identical_vertices(soup);
        remove_degenerate_faces(soup);
        remove_unreferenced_vertices(soup);
        split_non_manifold(soup);
        return as_bytes(soup);
      },
      k_load_seconds);
  if (!answer.succeeded) throw InputError(fmt::format("{}: {}", source.name, answer.failure));
  return ByteReader(answer.bytes).take_soup();
}

}  // namespace recede::bench
