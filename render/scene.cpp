#include <recede/geometry/error.h>
#include <recede/lod/detail/embree_device.h>
#include <recede/lod/displaced_base.h>
#include <recede/render/detail/billboard_look.h>
#include <recede/render/detail/displaced_look.h>
#include <recede/render/detail/ground_disc.h>
#include <recede/render/detail/scene_data.h>
#include <recede/render/detail/surface_look.h>
#include <recede/render/detail/volume_look.h>
#include <recede/render/scene.h>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

namespace {

using detail::DisplacedLook;
using detail::drawn_normals;
using detail::embree_device;
using detail::face_color;
using detail::MeshData;
using detail::MeshTextures;
using detail::SceneData;
using detail::SurfaceShape;
using detail::throw_on_embree_error;

// From the models alone: a floor that reaches far must not cost them detail.
void place_scene(const Box3& box, SceneData& data) {
  const double extent = box.sizes().maxCoeff();
  data.center = box.center();
  data.scale = extent > 0 ? 1 / extent : 1;
}

// Object space.
Box3 box_of(const PlacedBillboards& billboards) {
  Box3 box;
  for (const Billboard& billboard : billboards.textures->billboards) {
    const Vec3 u = billboard.half_sizes.x() * billboard.axis_u,
               v = billboard.half_sizes.y() * billboard.axis_v,
               n = detail::BillboardLook::k_height_room * billboards.textures->height_range *
                   billboard.normal();
    for (int k = 0; k < 8; ++k) {
      const Vec3 corner = billboard.center + ((k & 1) != 0 ? u : Vec3(-u)) + ((k & 2) != 0 ? v : Vec3(-v)) +
                          ((k & 4) != 0 ? n : Vec3(-n));
      for (const Eigen::Affine3d& placement : billboards.placements) box.extend(placement * corner);
    }
  }
  return box;
}

Box3 box_of(const PlacedVolume& volume) {
  const ShellLayer& layer = volume.textured.layer();
  Box3 box = bounding_box(volume.textured.shell->base);
  for (const Vec3& top : layer.tops) box.extend(top);
  return box;
}

using BoxCorners = std::array<Vec3, 8>;

BoxCorners corners_of(const Box3& box) {
  BoxCorners corners;
  for (std::size_t k = 0; k < corners.size(); ++k) corners[k] = box.corner(static_cast<Box3::CornerType>(k));
  return corners;
}

void extend_radius(double radius, SceneData& data) {
  // Room for the rounding to float, so that a ray that misses the sphere misses the surface.
  constexpr double k_rounding_room = 1e-5;
  data.radius = std::max(data.radius, radius * (1 + k_rounding_room) + k_rounding_room);
}

std::vector<std::array<float, 4>> scaled_positions(const PolygonSoup& soup, SceneData& data) {
  std::vector<std::array<float, 4>> positions(soup.positions.size());
  double squared_radius = 0;
  for (std::size_t v = 0; v < soup.positions.size(); ++v) {
    const Vec3 scaled = data.scaled(soup.positions[v]);
    squared_radius = std::max(squared_radius, scaled.squaredNorm());
    positions[v] = {static_cast<float>(scaled.x()), static_cast<float>(scaled.y()),
                    static_cast<float>(scaled.z()), 0.0f};
  }
  extend_radius(std::sqrt(squared_radius), data);
  return positions;
}

bool is_polygon_side(const PolygonSoup& soup, Index face, Index from, Index to) {
  const Index first = soup.face_offsets[face], last = soup.face_offsets[face + 1] - 1;
  const auto follows = [&](Index a, Index b) { return b == (a == last ? first : a + 1); };
  return follows(from, to) || follows(to, from);
}

void copy_triangles(const PolygonSoup& soup, double scale, double crease_angle, MeshData& mesh) {
  std::vector<Index> faces, corners;
  triangulate(soup, &faces, &corners);
  const std::size_t count = faces.size();
  const std::vector<Vec3> normals = drawn_normals(soup, crease_angle);
  mesh.triangles.resize(count);
  mesh.corner_normals.resize(3 * count);
  mesh.triangle_colors.resize(count);
  mesh.polygon_sides.resize(count);
  mesh.polygon_areas.resize(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t t) {
    const Index face = faces[t];
    unsigned sides = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index corner = corners[3 * t + k], next = corners[3 * t + (k + 1) % 3];
      mesh.triangles[t][k] = soup.corner_vertices[corner];
      if (is_polygon_side(soup, face, corner, next)) sides |= 1u << k;
      mesh.corner_normals[3 * t + k] = normals[corner].cast<float>();
    }
    mesh.polygon_sides[t] = static_cast<std::uint8_t>(sides);
    mesh.polygon_areas[t] = static_cast<float>(vector_area(soup, face).norm() * scale * scale);
    mesh.triangle_colors[t] = face_color(soup, face);
  });
}

std::shared_ptr<const MeshTextures> textures_of(const PolygonSoup& soup) {
  if (soup.corner_uvs.empty() || soup.face_materials.empty()) return nullptr;
  auto result = std::make_shared<MeshTextures>(MeshTextures{{}, {}, BaseColorTextures(soup.materials)});
  if (result->textures.empty()) return nullptr;
  std::vector<Index> faces, corners;
  triangulate(soup, &faces, &corners);
  for (const Index face : faces) result->triangle_materials.push_back(soup.face_materials[face]);
  for (const Index corner : corners) result->corner_uvs.emplace_back(soup.corner_uvs[corner].cast<float>());
  return result;
}

void find_longest_sides(MeshData& mesh) {
  mesh.longest_sides.assign(mesh.positions.size(), 0.0f);
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    std::array<Eigen::Vector3f, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = Eigen::Vector3f(mesh.positions[triangle[k]].data());
    const float squared =
        std::max({(corners[1] - corners[0]).squaredNorm(), (corners[2] - corners[1]).squaredNorm(),
                  (corners[0] - corners[2]).squaredNorm()});
    const float longest = std::sqrt(squared);
    for (const std::uint32_t vertex : triangle)
      mesh.longest_sides[vertex] = std::max(mesh.longest_sides[vertex], longest);
  }
}

void add_mesh(const PolygonSoup& soup, double crease_angle, SceneData& data) {
  MeshData& mesh = data.meshes.emplace_back();
  mesh.positions = scaled_positions(soup, data);
  copy_triangles(soup, data.scale, crease_angle, mesh);
  find_longest_sides(mesh);
  mesh.textures = textures_of(soup);
  mesh.vertex_colors.reserve(soup.vertex_colors.size());
  for (const Vec4& color : soup.vertex_colors) mesh.vertex_colors.emplace_back(color.head<3>().cast<float>());
}

using Positions = std::vector<std::array<float, 4>>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

RTCGeometry triangle_geometry(RTCDevice device, const Positions& positions, const Triangles& triangles) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions.data(), 0,
                             sizeof(positions[0]), positions.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                             sizeof(triangles[0]), triangles.size());
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCGeometry geometry_of(RTCDevice device, const SceneData& data, const MeshData& mesh, SurfaceShape shape) {
  if (mesh.billboards) return detail::billboard_geometry(device, *mesh.billboards);
  if (mesh.volume) return detail::volume_geometry(device, *mesh.volume);
  if (!mesh.displaced || shape == SurfaceShape::base)
    return triangle_geometry(device, mesh.positions, mesh.triangles);
  if (shape == SurfaceShape::displaced) return detail::displaced_geometry(device, mesh.displaced->surface);
  return triangle_geometry(device, data.appearances->envelope_positions,
                           data.appearances->envelope_triangles);
}

/// Embree numbers geometries in the order of the meshes.
detail::OwnedScene embree_scene(const SceneData& data, SurfaceShape shape) {
  const RTCDevice device = embree_device();
  detail::OwnedScene owned(rtcNewScene(device));
  const RTCScene scene = owned.get();
  throw_on_embree_error(device, "make a scene");
  // Rays that leave a surface carry a filter, see tracing.cpp.
  const RTCSceneFlags flags = RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;
  rtcSetSceneFlags(scene, flags);
  for (const MeshData& mesh : data.meshes) {
    if (mesh.displaced && shape == SurfaceShape::displaced)
      detail::save_memory(scene, flags, mesh.displaced->surface);
  }
  for (const MeshData& mesh : data.meshes) {
    const RTCGeometry geometry = geometry_of(device, data, mesh, shape);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  throw_on_embree_error(device, "set a geometry");
  // The tree that several threads build depends on their number, and with it which of two triangles a ray on
  // their common edge hits. One thread builds 2 million triangles a second, which is enough here.
  tbb::task_arena(1).execute([scene] { rtcCommitScene(scene); });
  throw_on_embree_error(device, "build the tree");
  return owned;
}

void build_embree_scenes(SceneData& data) {
  data.scene = embree_scene(data, SurfaceShape::displaced);
  if (!data.appearances) return;
  data.appearances->base = embree_scene(data, SurfaceShape::base);
  data.appearances->envelope = embree_scene(data, SurfaceShape::envelope);
}

void make_envelope(const PolygonSoup& base, const detail::HeightSpan& span, SceneData& data) {
  detail::AppearanceScenes& scenes = *data.appearances;
  // Of all points, so that it holds what stands along unit directions between corners, too.
  const double reach = 1 / detail::least_direction(base);
  const auto at = [&](double height) {
    return detail::raised_base(base, span.mean + reach * (height - span.mean));
  };
  scenes.envelope_positions = scaled_positions(at(span.largest), data);
  std::vector<Index> corners;
  triangulate(base, nullptr, &corners);
  for (std::size_t c = 0; c + 2 < corners.size(); c += 3) {
    scenes.envelope_triangles.push_back({base.corner_vertices[corners[c]],
                                         base.corner_vertices[corners[c + 1]],
                                         base.corner_vertices[corners[c + 2]]});
  }
  const Positions below = scaled_positions(at(span.least), data);
  for (const detail::BorderSide& border : detail::border_sides(base)) {
    const std::array<std::uint32_t, 3> triangle = scenes.envelope_triangles[border.triangle];
    const std::uint32_t a = triangle[border.side], b = triangle[(border.side + 1) % 3];
    const auto below_a = static_cast<std::uint32_t>(scenes.envelope_positions.size());
    scenes.envelope_positions.push_back(below[a]);
    scenes.envelope_positions.push_back(below[b]);
    scenes.envelope_triangles.push_back({a, below_a, b});
    scenes.envelope_triangles.push_back({b, below_a, below_a + 1});
    scenes.strip_owners.insert(scenes.strip_owners.end(), 2, border.triangle);
  }
}

/// Around all heights, object space.
Box3 displaced_box(const DisplacedMesh::Data& surface) {
  const detail::DisplacedKernel& kernel = detail::displaced_kernel();
  Box3 box;
  for (std::uint32_t part = 0; part < surface.n_parts(); ++part) {
    const detail::PatchBox bounds = kernel.bounds(surface.arrays(), part, surface.partial);
    box.extend(surface.frame.to_object(Eigen::Vector3f(bounds.lower).cast<double>()));
    box.extend(surface.frame.to_object(Eigen::Vector3f(bounds.upper).cast<double>()));
  }
  return box;
}

}  // namespace

void Scene::build(std::span<const PolygonSoup> soups, std::span<const PlacedBillboards> billboards,
                  std::span<const PlacedVolume> volumes, const SceneOptions& options) {
  if (soups.empty() && billboards.empty() && volumes.empty()) throw InputError("a scene needs a surface");
  Box3 box;
  for (const PolygonSoup& soup : soups) {
    if (soup.n_faces() == 0) throw InputError("a surface without faces can't be drawn");
    box.extend(bounding_box(soup));
  }
  std::vector<Box3> without_mesh;
  for (const PlacedBillboards& placed : billboards) {
    without_mesh.push_back(box_of(placed));
    if (without_mesh.back().isEmpty()) throw InputError("billboards without any can't be drawn");
  }
  for (const PlacedVolume& placed : volumes) without_mesh.push_back(box_of(placed));
  for (const Box3& around : without_mesh) box.extend(around);
  place_scene(box, *data_);
  for (const PolygonSoup& soup : soups) add_mesh(soup, options.crease_angle, *data_);
  for (const PlacedBillboards& placed : billboards) {
    data_->meshes.emplace_back().billboards =
        std::make_shared<detail::BillboardLook>(placed, data_->center, data_->scale);
  }
  for (const PlacedVolume& placed : volumes) {
    data_->meshes.emplace_back().volume =
        std::make_shared<detail::VolumeLook>(placed, data_->center, data_->scale);
  }
  for (const Box3& around : without_mesh) {
    extend_radius(
        data_->scaled(around.min()).cwiseAbs().cwiseMax(data_->scaled(around.max()).cwiseAbs()).norm(),
        *data_);
  }
  if (options.ground) {
    std::vector<BoxCorners> boxes;
    for (const Box3& around : without_mesh) boxes.push_back(corners_of(around));
    std::vector<std::span<const Vec3>> models(boxes.begin(), boxes.end());
    for (const PolygonSoup& soup : soups) models.emplace_back(soup.positions);
    add_mesh(detail::ground_disc(models, *options.ground), 0, *data_);
  }
  build_embree_scenes(*data_);
}

Scene::Scene(std::span<const PolygonSoup> soups, std::span<const PlacedBillboards> billboards,
             const SceneOptions& options)
    : data_(std::make_unique<detail::SceneData>()) {
  build(soups, billboards, {}, options);
}

Scene::Scene(std::span<const PolygonSoup> soups, std::span<const PlacedVolume> volumes,
             const SceneOptions& options)
    : data_(std::make_unique<detail::SceneData>()) {
  build(soups, {}, volumes, options);
}

Scene::Scene(std::span<const PolygonSoup> soups, const SceneOptions& options)
    : Scene(soups, std::span<const PlacedBillboards>{}, options) {}

Scene::Scene(const PolygonSoup& soup, const SceneOptions& options)
    : Scene(std::span<const PolygonSoup>(&soup, 1), options) {}

Scene::Scene(const PolygonMesh& mesh, const SceneOptions& options) : Scene(to_soup(mesh), options) {}

Scene::Scene(const LodLevel& level, const SceneOptions& options)
    : data_(std::make_unique<detail::SceneData>()) {
  if (!level.billboards) {
    *this = Scene(level.mesh, options);
    return;
  }
  const PlacedBillboards placed{std::make_shared<const BillboardTextures>(*level.billboards)};
  *this = Scene(std::span<const PolygonSoup>{}, std::span<const PlacedBillboards>(&placed, 1), options);
}

Scene::Scene(const PolygonSoup& base, const DisplacementMap& heights,
             const DisplacedMeshOptions& displacement, const SceneOptions& options)
    : data_(std::make_unique<detail::SceneData>()) {
  if (options.appearance) {
    build_with_appearance(base, heights, {}, displacement, options);
    return;
  }
  build_displaced(base, std::make_shared<DisplacedLook>(base, heights, displacement), options);
}

Scene::Scene(const BakedMaps& maps, const DisplacedMeshOptions& displacement, const SceneOptions& options)
    : data_(std::make_unique<detail::SceneData>()) {
  if (options.appearance) {
    build_with_appearance(colored_surface(maps), displacement_map_of(maps), maps, displacement, options);
    return;
  }
  build_displaced(colored_surface(maps), std::make_shared<DisplacedLook>(maps, displacement), options);
}

void Scene::build_with_appearance(const PolygonSoup& base, const DisplacementMap& heights,
                                  const BakedMaps& maps, DisplacedMeshOptions displacement,
                                  const SceneOptions& options) {
  const detail::HeightSpan span = detail::span_of(heights);
  const PolygonSoup middle = detail::raised_base(base, span.mean);
  displacement.partial = true;
  auto look = std::make_shared<DisplacedLook>(middle, raise_heights(heights, -span.mean), displacement);
  std::vector<Vec3> normals =
      maps.corner_tangents.empty() ? drawn_normals(base, options.crease_angle) : middle.corner_normals;
  look->appearance.emplace(middle, std::move(normals), maps, options.appearance);
  data_->center = look->surface.frame.center;
  data_->scale = look->surface.frame.scale;
  data_->appearances = std::make_unique<detail::AppearanceScenes>();
  make_envelope(base, span, *data_);
  build_displaced(middle, std::move(look), options);
}

void Scene::build_displaced(const PolygonSoup& base, std::shared_ptr<DisplacedLook> look,
                            const SceneOptions& options) {
  look->is_flat = options.crease_angle == 0;
  data_->center = look->surface.frame.center;
  data_->scale = look->surface.frame.scale;
  add_mesh(base, options.crease_angle, *data_);
  data_->meshes.front().corner_normals = {};  // shading takes the map's or the heights'
  const Box3 box = displaced_box(look->surface);
  data_->meshes.front().displaced = std::move(look);
  const Vec3 farthest = data_->scaled(box.min()).cwiseAbs().cwiseMax(data_->scaled(box.max()).cwiseAbs());
  extend_radius(farthest.norm(), *data_);
  if (options.ground) {
    const BoxCorners corners = corners_of(box);  // around all heights
    add_mesh(detail::ground_disc(std::array{std::span<const Vec3>(corners)}, *options.ground), 0, *data_);
  }
  build_embree_scenes(*data_);
}

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

}  // namespace recede
