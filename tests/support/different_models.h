// Ten models of different kinds, and a simplification of each to the last byte.
#pragma once

#include <recede/geometry/mesh_io.h>
#include <recede/geometry/sample_models.h>
#include <recede/lod/simplify.h>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace recede::test {

struct DifferentModel {
  std::string name, kind;
  std::function<PolygonSoup(const std::filesystem::path& data)> load;  ///< `data`: the folder of `./dev data`
  bool small = false;  ///< `normal_deviation`, which is slower, fits into a test
};

inline std::vector<DifferentModel> different_models() {
  const auto file = [](const char* name) {
    return [name](const std::filesystem::path& data) { return read_soup(data / name); };
  };
  const auto sphere = [](std::size_t faces, bool triangles) {
    return [=](const std::filesystem::path&) { return make_displaced_sphere(faces, triangles); };
  };
  return {
      {"bunny00", "closed scan", file("meshes/bunny00.off")},
      {"lion_head", "open scan", file("meshes/lion-head.off"), true},
      {"fandisk", "closed CAD part", file("meshes/fandisk.off"), true},
      {"TR12J_OCC64K", "CAD part with borders and many handles", file("cad/stl/TR12J_OCC64K.stl")},
      {"motor", "CAD assembly of 27 parts", file("cad/stl/motor.stl"), true},
      {"head", "edges of more than two faces", file("cad/stl/head.stl")},
      {"boeing", "polygons made by hand", file("meshes/boeing.off"), true},
      {"sphere", "triangles made by code", sphere(50'000, true)},
      {"quad_sphere", "quads made by code", sphere(10'000, false), true},
      {"teapot", "quads over patches", [](const std::filesystem::path&) { return make_teapot(); }},
  };
}

/// The polygons of a result and all its figures but the seconds.
inline std::string bytes_of(const SimplifySoupResult& result) {
  std::string bytes;
  const auto put = [&](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  const auto put_list = [&](const auto& values) {
    put(values.size());
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  const PolygonSoup& soup = result.soup;
  put_list(soup.positions);
  put_list(soup.face_offsets);
  put_list(soup.corner_vertices);
  put_list(soup.corner_uvs);
  put_list(soup.corner_normals);
  put_list(soup.vertex_colors);
  put_list(soup.face_materials);
  put_list(soup.feature_edges);
  put_list(result.refused.counts);
  for (const std::size_t count : {result.faces_before, result.faces_after, result.vertices_before,
                                  result.vertices_after, result.collapses, result.interior_collapses,
                                  result.removed_faces, result.lost_sides, result.passes}) {
    put(count);
  }
  put(result.error_estimate);
  put(result.error_bound.value_or(-1));
  put(result.error_lower);
  put(result.stop_reason);
  return bytes;
}

}  // namespace recede::test
