#include <recede/geometry/error.h>
#include <recede/geometry/shading_normals.h>
#include <recede/render/detail/embree_device.h>
#include <recede/render/detail/scene_data.h>
#include <recede/render/scene.h>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace recede {

namespace {

using detail::embree_device;
using detail::SceneData;
using detail::throw_on_embree_error;

void copy_positions(const PolygonSoup& soup, SceneData& data) {
  const Box3 box = bounding_box(soup);
  const double extent = box.sizes().maxCoeff();
  data.center = box.center();
  data.scale = extent > 0 ? 1 / extent : 1;
  data.positions.resize(soup.positions.size());
  double squared_radius = 0;
  for (std::size_t v = 0; v < soup.positions.size(); ++v) {
    const Vec3 scaled = (soup.positions[v] - data.center) * data.scale;
    squared_radius = std::max(squared_radius, scaled.squaredNorm());
    data.positions[v] = {static_cast<float>(scaled.x()), static_cast<float>(scaled.y()),
                         static_cast<float>(scaled.z()), 0.0f};
  }
  // Room for the rounding to float, so that a ray that misses the sphere misses the surface.
  constexpr double k_rounding_room = 1e-5;
  data.radius = std::sqrt(squared_radius) + k_rounding_room;
}

bool is_polygon_side(const PolygonSoup& soup, Index face, Index from, Index to) {
  const Index first = soup.face_offsets[face], last = soup.face_offsets[face + 1] - 1;
  const auto follows = [&](Index a, Index b) { return b == (a == last ? first : a + 1); };
  return follows(from, to) || follows(to, from);
}

// Light grey for faces without a material, as `Material` has it; white under vertex colours, which then say
// it all.
Rgb face_color(const PolygonSoup& soup, Index face) {
  const Index material = soup.face_materials.empty() ? k_no_index : soup.face_materials[face];
  if (material == k_no_index) {
    return soup.vertex_colors.empty() ? Rgb(Material{}.base_color.head<3>().cast<float>()) : Rgb(Rgb::Ones());
  }
  return soup.materials[material].base_color.head<3>().cast<float>();
}

void copy_triangles(const PolygonSoup& soup, SceneData& data, const std::vector<Index>& faces,
                    const std::vector<Index>& corners, const SceneOptions& options) {
  const std::size_t count = faces.size();
  const std::vector<Vec3> computed = shading_normals(soup, options.crease_angle);
  data.triangles.resize(count);
  data.corner_normals.resize(3 * count);
  data.triangle_colors.resize(count);
  data.polygon_sides.resize(count);
  data.polygon_areas.resize(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
    const Index face = faces[t];
    const Vec3 area = vector_area(soup, face);
    unsigned sides = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index corner = corners[3 * t + k], next = corners[3 * t + (k + 1) % 3];
      data.triangles[t][k] = soup.corner_vertices[corner];
      if (is_polygon_side(soup, face, corner, next)) sides |= 1u << k;
      Vec3 normal = computed[corner];
      if (!soup.corner_normals.empty() && !soup.corner_normals[corner].isZero(0))
        normal = soup.corner_normals[corner];
      // Shading turns normals by the side of the triangle that is seen, so all must be on its front.
      if (normal.dot(area) < 0) normal = -normal;
      data.corner_normals[3 * t + k] = normal.stableNormalized().cast<float>();
    }
    data.polygon_sides[t] = static_cast<std::uint8_t>(sides);
    data.polygon_areas[t] = static_cast<float>(area.norm() * data.scale * data.scale);
    data.triangle_colors[t] = face_color(soup, face);
  });
}

void build_embree_scene(SceneData& data) {
  const RTCDevice device = embree_device();
  data.scene = rtcNewScene(device);
  throw_on_embree_error(device, "make a scene");
  rtcSetSceneFlags(data.scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, data.positions.data(), 0,
                             sizeof(data.positions[0]), data.positions.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, data.triangles.data(), 0,
                             sizeof(data.triangles[0]), data.triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(data.scene, geometry);
  rtcReleaseGeometry(geometry);
  throw_on_embree_error(device, "set a geometry");
  // The tree that several threads build depends on their number, and with it which of two triangles a ray on
  // their common edge hits. One thread builds 2 million triangles a second, which is enough here.
  tbb::task_arena(1).execute([&data] { rtcCommitScene(data.scene); });
  throw_on_embree_error(device, "build the tree");
}

}  // namespace

namespace detail {

SceneData::~SceneData() {
  if (scene != nullptr) rtcReleaseScene(scene);
}

}  // namespace detail

Scene::Scene(const PolygonSoup& soup, const SceneOptions& options)
    : data_(std::make_unique<detail::SceneData>()) {
  if (soup.n_faces() == 0) throw InputError("a surface without faces can't be drawn");
  std::vector<Index> faces, corners;
  triangulate(soup, &faces, &corners);
  copy_positions(soup, *data_);
  copy_triangles(soup, *data_, faces, corners, options);
  data_->vertex_colors.reserve(soup.vertex_colors.size());
  for (const Vec4& color : soup.vertex_colors)
    data_->vertex_colors.emplace_back(color.head<3>().cast<float>());
  build_embree_scene(*data_);
}

Scene::Scene(const PolygonMesh& mesh, const SceneOptions& options) : Scene(to_soup(mesh), options) {}

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

}  // namespace recede
