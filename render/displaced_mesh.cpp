#include <recede/geometry/error.h>
#include <recede/lod/detail/embree_device.h>
#include <recede/render/detail/displaced_data.h>
#include <recede/render/displaced_mesh.h>

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace recede {

using detail::DisplacedPatch;
using detail::k_most_level;
using detail::PatchArrays;
using detail::PatchRayQuery;
using detail::RayContext;

namespace {

/// Texels that the triangles cover, with those covered twice counted twice.
double covered_texels(const PolygonSoup& base, const std::vector<Index>& corners,
                      const DisplacementMap& map) {
  double area = 0;  // of the unit square, doubled
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const Vec2 a = base.corner_uvs[corners[t + 1]] - base.corner_uvs[corners[t]];
    const Vec2 b = base.corner_uvs[corners[t + 2]] - base.corner_uvs[corners[t]];
    area += std::abs(a.x() * b.y() - a.y() * b.x());
  }
  return 0.5 * area * map.columns() * map.rows();
}

int level_for_texels(const PolygonSoup& base, const std::vector<Index>& corners, const DisplacementMap& map) {
  const double wanted = 2 * covered_texels(base, corners, map);
  const auto triangles = static_cast<double>(corners.size() / 3);
  int level = 0;
  while (level < k_most_level && triangles * std::pow(4.0, level) < wanted) ++level;
  return level;
}

std::vector<std::uint8_t> levels_of(const PolygonSoup& base, const DisplacementMap& map,
                                    const DisplacedMeshOptions& options) {
  std::vector<Index> faces, corners;
  triangulate(base, &faces, &corners);
  if (options.triangle_levels.empty()) {
    const int level = options.level ? *options.level : level_for_texels(base, corners, map);
    if (level < 0 || level > k_most_level) throw OptionError("levels of subdivision lie between 0 and 14");
    return std::vector<std::uint8_t>(faces.size(), static_cast<std::uint8_t>(level));
  }
  if (options.triangle_levels.size() != faces.size()) {
    throw OptionError("there are " + std::to_string(options.triangle_levels.size()) + " levels for " +
                      std::to_string(faces.size()) + " triangles");
  }
  for (const std::uint8_t level : options.triangle_levels) {
    if (level > k_most_level) throw OptionError("levels of subdivision lie between 0 and 14");
  }
  return options.triangle_levels;
}

/// Texel coordinates are floats: beyond some millions they no longer tell texels apart. Numbers of texels are
/// whole ones of 32 bits.
void check(const PolygonSoup& base, const DisplacementMap& map) {
  validate(base, "displaced surface");
  if (base.n_faces() == 0) throw InputError("a displaced surface needs a base with faces");
  if (base.corner_uvs.empty()) throw InputError("a displaced surface needs texture coordinates");
  if (static_cast<double>(map.columns()) * map.rows() >= 0x1p31)
    throw InputError("a displaced surface can't take 2^31 texels");
  constexpr double k_most_texels = 1 << 22;
  for (std::size_t c = 0; c < base.corner_uvs.size(); ++c) {
    const Vec2& uv = base.corner_uvs[c];
    if (std::abs(uv.x()) * map.columns() > k_most_texels || std::abs(uv.y()) * map.rows() > k_most_texels) {
      throw InputError("the texture coordinate of corner " + std::to_string(c) +
                       " lies more than 4194304 texels away");
    }
  }
}

/// Maps of one column or row get a second one, the same: the kernel reads texels in pairs.
DisplacementMap at_least_two(DisplacementMap map) {
  if (map.columns() > 1 && map.rows() > 1) return map;
  const int columns = std::max(map.columns(), 2), rows = std::max(map.rows(), 2);
  std::vector<float> heights;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      heights.push_back(
          static_cast<float>(map.texel(std::min(x, map.columns() - 1), std::min(y, map.rows() - 1))));
    }
  }
  return DisplacementMap(columns, rows, std::move(heights), map.border());
}

/// The range of all heights.
HeightRange range_of(const HeightBounds& bounds) { return bounds.node(bounds.levels() - 1, 0, 0); }

double largest_height(const HeightBounds& bounds) {
  const HeightRange range = range_of(bounds);
  return std::max(range.max, -range.min);
}

/// Rays stay within about the unit box, heights included.
detail::SceneFrame frame_of(const PolygonSoup& base, const HeightBounds& bounds) {
  const Box3 box = bounding_box(base);
  const double extent = std::max(box.sizes().maxCoeff(), largest_height(bounds));
  return {box.center(), extent > 0 ? 1 / extent : 1};
}

template <typename Sample>
void set_nodes(const HeightBounds& bounds, detail::HeightMapView& view) {
  for (int level = 1; level < bounds.levels(); ++level)
    view.nodes[level] = bounds.stored_nodes<Sample>(level);
}

/// Largest difference between samples of neighbouring texels.
template <typename Sample>
Sample steepest_step(const std::vector<Sample>& samples, const DisplacementMap& map) {
  const auto columns = static_cast<std::size_t>(map.columns());
  const auto row = [&](int y) { return samples.data() + static_cast<std::size_t>(map.row(y)) * columns; };
  constexpr int k_rows_of_a_task = 64;
  return tbb::parallel_reduce(
      tbb::blocked_range<int>(0, map.rows(), k_rows_of_a_task), Sample{0},
      [&](const tbb::blocked_range<int>& rows, Sample most) {
        const auto step = [&](Sample a, Sample b) {
          most = std::max(most, static_cast<Sample>(std::max(a, b) - std::min(a, b)));
        };
        for (int y = rows.begin(); y != rows.end(); ++y) {
          const Sample *here = row(y), *below = row(y + 1);
          for (std::size_t x = 0; x < columns; ++x) step(here[x], below[x]);
          for (std::size_t x = 0; x + 1 < columns; ++x) step(here[x], here[x + 1]);
          step(here[columns - 1], here[map.column(map.columns())]);
        }
        return most;
      },
      [](Sample a, Sample b) { return std::max(a, b); });
}

/// Texel coordinates in bounds and in points are sums and middles, each off by half a step of float for each
/// level; heights change by no more than the steepest step along both axes.
float height_room(const DisplacementMap& map, double steepest, double height_scale) {
  constexpr double k_half_step = 5.9604645e-8, k_roundings = 8 + 3 * k_most_level;
  const double texels = std::max(map.columns(), map.rows()) * k_half_step * k_roundings;
  return static_cast<float>(2 * texels * steepest * std::abs(height_scale));
}

detail::HeightMapView view_of(const HeightBounds& bounds, double scene_scale) {
  const DisplacementMap& map = bounds.map();
  detail::HeightMapView view;
  double steepest = 0;
  if (map.whole_samples().empty()) {
    view.floats = map.float_samples().data();
    steepest = steepest_step(map.float_samples(), map);
    set_nodes<float>(bounds, view);
  } else {
    view.whole = map.whole_samples().data();
    steepest = steepest_step(map.whole_samples(), map);
    set_nodes<std::uint16_t>(bounds, view);
  }
  view.columns = map.columns();
  view.rows = map.rows();
  view.is_periodic = map.border() == MapBorder::periodic;
  view.levels = bounds.levels();
  for (int level = 0; level < view.levels; ++level) view.node_columns[level] = bounds.columns(level);
  view.offset = static_cast<float>(map.height_of(0) * scene_scale);
  const double scale = (map.height_of(1) - map.height_of(0)) * scene_scale;
  view.scale = static_cast<float>(scale);
  view.height_room = height_room(map, steepest, scale);
  return view;
}

void bound_part(const RTCBoundsFunctionArguments* arguments) {
  const auto& data = *static_cast<const DisplacedMesh::Data*>(arguments->geometryUserPtr);
  const detail::PatchBox box =
      detail::displaced_kernel().bounds(data.arrays(), arguments->primID, data.partial);
  // Rays find hits in float, at points that may lie a little outside; the search pads its own boxes likewise.
  constexpr float k_pad = 2e-6f;
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = box.lower[0] - k_pad;
  bounds.lower_y = box.lower[1] - k_pad;
  bounds.lower_z = box.lower[2] - k_pad;
  bounds.upper_x = box.upper[0] + k_pad;
  bounds.upper_y = box.upper[1] + k_pad;
  bounds.upper_z = box.upper[2] + k_pad;
}

PatchRayQuery query_of(const RTCRayN* rays, unsigned count, unsigned k) {
  PatchRayQuery query;
  query.origin[0] = RTCRayN_org_x(const_cast<RTCRayN*>(rays), count, k);
  query.origin[1] = RTCRayN_org_y(const_cast<RTCRayN*>(rays), count, k);
  query.origin[2] = RTCRayN_org_z(const_cast<RTCRayN*>(rays), count, k);
  query.direction[0] = RTCRayN_dir_x(const_cast<RTCRayN*>(rays), count, k);
  query.direction[1] = RTCRayN_dir_y(const_cast<RTCRayN*>(rays), count, k);
  query.direction[2] = RTCRayN_dir_z(const_cast<RTCRayN*>(rays), count, k);
  query.t_min = RTCRayN_tnear(const_cast<RTCRayN*>(rays), count, k);
  query.t_max = RTCRayN_tfar(const_cast<RTCRayN*>(rays), count, k);
  return query;
}

/// The rays of a call from Embree that are valid, and which they are.
template <unsigned k_most>
struct ValidRays {
  ValidRays(const int* valid, const RTCRayN* rays, unsigned n, const RayContext& context,
            const detail::SurfacePart& part) {
    const bool starts_here = context.from.object == part.object && context.from.primitive == part.primitive;
    for (unsigned k = 0; k < n; ++k) {
      if (valid[k] == 0) continue;
      queries[count] = query_of(rays, n, k);
      queries[count].fraction = context.fraction;
      queries[count].left_out = starts_here ? context.from.small : detail::SurfacePart::k_none;
      numbers[count++] = k;
    }
  }

  unsigned count = 0;
  std::array<PatchRayQuery, k_most> queries;
  std::array<unsigned, k_most> numbers;
};

template <unsigned k_most>
void intersect_rays(const RTCIntersectFunctionNArguments* arguments) {
  const auto& data = *static_cast<const DisplacedMesh::Data*>(arguments->geometryUserPtr);
  auto& context = *reinterpret_cast<RayContext*>(arguments->context);
  const unsigned n = arguments->N;
  RTCRayN* all_rays = RTCRayHitN_RayN(arguments->rayhit, n);
  RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, n);
  ValidRays<k_most> rays(arguments->valid, all_rays, n, context, {arguments->geomID, arguments->primID});
  for (unsigned r = 0; r < rays.count; ++r) {
    // Of parts that are met at one distance, that of the least number counts, whichever comes first.
    const unsigned k = rays.numbers[r];
    rays.queries[r].accepts_equal =
        RTCHitN_geomID(hits, n, k) == RTC_INVALID_GEOMETRY_ID ||
        (RTCHitN_geomID(hits, n, k) == arguments->geomID && RTCHitN_primID(hits, n, k) > arguments->primID);
  }
  const detail::DisplacedKernel& kernel = detail::displaced_kernel();
  if (rays.count == 1) {
    kernel.first_hit(data.arrays(), arguments->primID, rays.queries[0]);
  } else if (rays.count > 1) {
    kernel.first_hits(data.arrays(), arguments->primID, rays.queries.data(), rays.count);
  }
  for (unsigned r = 0; r < rays.count; ++r) {
    const PatchRayQuery& query = rays.queries[r];
    if (!query.is_met) continue;
    const unsigned k = rays.numbers[r];
    RTCRayN_tfar(all_rays, n, k) = query.t_max;
    RTCHitN_u(hits, n, k) = query.u;
    RTCHitN_v(hits, n, k) = query.v;
    RTCHitN_primID(hits, n, k) = arguments->primID;
    RTCHitN_geomID(hits, n, k) = arguments->geomID;
    RTCHitN_instID(hits, n, k, 0) = arguments->context->instID[0];
    RTCHitN_Ng_x(hits, n, k) = query.normal[0];
    RTCHitN_Ng_y(hits, n, k) = query.normal[1];
    RTCHitN_Ng_z(hits, n, k) = query.normal[2];
    context.small[RTCRayN_id(all_rays, n, k) % context.small.size()] = query.triangle;
  }
}

template <unsigned k_most>
void occlude_rays(const RTCOccludedFunctionNArguments* arguments) {
  const auto& data = *static_cast<const DisplacedMesh::Data*>(arguments->geometryUserPtr);
  const auto& context = *reinterpret_cast<const RayContext*>(arguments->context);
  ValidRays<k_most> rays(arguments->valid, arguments->ray, arguments->N, context,
                         {arguments->geomID, arguments->primID});
  const detail::DisplacedKernel& kernel = detail::displaced_kernel();
  if (rays.count == 1) {
    kernel.is_hit(data.arrays(), arguments->primID, rays.queries[0]);
  } else if (rays.count > 1) {
    kernel.are_hit(data.arrays(), arguments->primID, rays.queries.data(), rays.count);
  }
  for (unsigned r = 0; r < rays.count; ++r) {
    if (rays.queries[r].is_met)
      RTCRayN_tfar(arguments->ray, arguments->N, rays.numbers[r]) = -std::numeric_limits<float>::infinity();
  }
}

void intersect_part(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->N == 1) return intersect_rays<1>(arguments);
  intersect_rays<detail::k_most_rays>(arguments);
}

void occlude_part(const RTCOccludedFunctionNArguments* arguments) {
  if (arguments->N == 1) return occlude_rays<1>(arguments);
  occlude_rays<detail::k_most_rays>(arguments);
}

}  // namespace

namespace detail {

RTCGeometry displaced_geometry(RTCDevice device, const DisplacedMesh::Data& data) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(data.n_parts()));
  rtcSetGeometryUserData(geometry, const_cast<DisplacedMesh::Data*>(&data));
  rtcSetGeometryBoundsFunction(geometry, bound_part, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_part);
  rtcSetGeometryOccludedFunction(geometry, occlude_part);
  rtcCommitGeometry(geometry);
  return geometry;
}

void save_memory(RTCScene scene, RTCSceneFlags flags, const DisplacedMesh::Data& data) {
  // The compact flag keeps a third of the memory and costs no speed here.
  rtcSetSceneFlags(scene, static_cast<RTCSceneFlags>(flags | RTC_SCENE_FLAG_COMPACT));
  // Of very many parts, boxes would outweigh the rest. Rougher ones take a third of the memory, and rays a
  // sixth more time.
  constexpr std::size_t k_many_parts = 1 << 17;
  if (data.n_parts() > k_many_parts) rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
}

}  // namespace detail

DisplacedMesh::Data::Data(const PolygonSoup& base, DisplacementMap heights,
                          const DisplacedMeshOptions& options)
    : map(at_least_two(std::move(heights))), partial(options.partial) {
  check(base, map);
  bounds.emplace(map);
  frame = frame_of(base, *bounds);
  patches =
      detail::make_displaced_patches(base, frame, map.columns(), map.rows(), levels_of(base, map, options));
  detail::divide_into_parts(patches);
  view = view_of(*bounds, frame.scale);
}

void DisplacedMesh::Data::build_scene() {
  const RTCDevice device = detail::embree_device();
  scene.reset(rtcNewScene(device));
  detail::save_memory(scene.get(), RTC_SCENE_FLAG_ROBUST, *this);
  const RTCGeometry geometry = detail::displaced_geometry(device, *this);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  detail::throw_on_embree_error(device, "build a displaced surface");
}

double DisplacedMesh::Data::height_span() const {
  const HeightRange range = range_of(*bounds);
  return (range.max - range.min) * frame.scale;
}

void DisplacedMesh::Data::take_map(DisplacementMap heights) {
  DisplacementMap other = at_least_two(std::move(heights));
  if (other.columns() != map.columns() || other.rows() != map.rows())
    throw OptionError("a displaced surface keeps the size of its map");
  map = std::move(other);
  bounds.emplace(map);
  if (const double most = largest_height(*bounds) * frame.scale; most > 1) {
    frame.scale /= most;
    for (detail::DisplacedVertex& vertex : patches.vertices) {
      for (float& coordinate : vertex.position) coordinate /= static_cast<float>(most);
    }
  }
  view = view_of(*bounds, frame.scale);
  const RTCGeometry geometry = rtcGetGeometry(scene.get(), 0);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene.get());
  detail::throw_on_embree_error(detail::embree_device(), "build a displaced surface");
}

bool DisplacedMesh::Data::set_ray(const Vec3& origin, const Vec3& direction,
                                  const DisplacedRayOptions& options, RTCRay& ray, RayScale& scale) const {
  if (!(options.fraction >= 0 && options.fraction <= 1))
    throw OptionError("the fraction of a displacement lies between 0 and 1");
  if (options.fraction < 1 && !partial)
    throw OptionError("this surface was not made for partial displacement");
  if (!origin.allFinite() || !direction.allFinite() || direction.isZero(0)) return false;
  // From afar a ray starts near the surface, where float tells its points apart. Base and heights lie within
  // the scene's middle by half its size and one, along each axis.
  constexpr double k_scene_radius = 3;
  const Vec3 unit = direction.stableNormalized(), from = frame.to_scene(origin);
  scale.length = direction.stableNorm() * frame.scale;
  scale.start = std::max(0.0, -from.dot(unit) - k_scene_radius);
  const double from_t = options.t_min * scale.length - scale.start;
  const double to_t = options.t_max * scale.length - scale.start;
  if (!(to_t >= 0)) return false;
  const Vec3 start = from + scale.start * unit;
  ray.org_x = static_cast<float>(start.x());
  ray.org_y = static_cast<float>(start.y());
  ray.org_z = static_cast<float>(start.z());
  ray.dir_x = static_cast<float>(unit.x());
  ray.dir_y = static_cast<float>(unit.y());
  ray.dir_z = static_cast<float>(unit.z());
  ray.tnear = static_cast<float>(std::max(0.0, from_t));
  ray.tfar = static_cast<float>(to_t);
  ray.mask = 0xffffffffu;
  return true;
}

PatchArrays DisplacedMesh::Data::arrays() const {
  return {patches.parts.empty() ? nullptr : patches.parts.data(), patches.patches.data(),
          patches.vertices.data(), patches.exceptions.data(), &view};
}

DisplacedMesh::Data::BasePlace DisplacedMesh::Data::base_place(std::uint32_t part, std::uint32_t small,
                                                               double patch_u, double patch_v) const {
  BasePlace place;
  place.patch = patches.parts.empty() ? part : patches.parts[part].patch;
  const DisplacedPatch& patch = patches.patches[place.patch];
  // On the diagonal, the small triangle tells the side.
  const double sum = patch_u + patch_v;
  place.is_second = patch.is_single == 0 && ((small & 1) != 0 ? sum >= 1 : sum > 1);
  const double u = place.is_second ? 1 - patch_u : patch_u, v = place.is_second ? 1 - patch_v : patch_v;
  place.patch_weights = {1 - u - v, u, v};
  const std::size_t half = place.is_second ? 1 : 0;
  place.triangle = patches.triangles[place.patch][half];
  double x = 0, y = 0;
  const std::array<std::size_t, 3> corners = place.corners();
  for (std::size_t k = 0; k < 3; ++k) {
    const double weight = place.patch_weights[static_cast<Eigen::Index>(k)];
    x += weight * static_cast<double>(patch.x[corners[k]]);
    y += weight * static_cast<double>(patch.y[corners[k]]);
    place.weights[static_cast<Eigen::Index>((patch.first_corner[half] + k) % 3)] = weight;
  }
  place.uv = {(x - 0.5) / map.columns(), 1 - (y - 0.5) / map.rows()};
  return place;
}

DisplacedMesh::DisplacedMesh(const PolygonSoup& base, DisplacementMap map,
                             const DisplacedMeshOptions& options) {
  data_ = std::make_unique<Data>(base, std::move(map), options);
  data_->build_scene();
}
DisplacedMesh::~DisplacedMesh() = default;
DisplacedMesh::DisplacedMesh(DisplacedMesh&&) noexcept = default;
DisplacedMesh& DisplacedMesh::operator=(DisplacedMesh&&) noexcept = default;

void DisplacedMesh::set_map(DisplacementMap map) { data_->take_map(std::move(map)); }

std::optional<DisplacedMesh::Hit> DisplacedMesh::first_hit(const Vec3& origin, const Vec3& direction,
                                                           const DisplacedRayOptions& options) const {
  RTCRayHit ray{};
  Data::RayScale scale;
  if (!data_->set_ray(origin, direction, options, ray.ray, scale)) return std::nullopt;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RayContext context = detail::make_ray_context();
  context.fraction = static_cast<float>(options.fraction);
  rtcIntersect1(data_->scene.get(), &context.embree, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const std::uint32_t part = ray.hit.primID, small = context.small[0];
  const Data::BasePlace place =
      data_->base_place(part, small, static_cast<double>(ray.hit.u), static_cast<double>(ray.hit.v));
  Hit hit;
  hit.t = scale.t_of(ray.ray.tfar);
  hit.face = data_->patches.faces[place.triangle];
  hit.triangle = place.triangle;
  hit.weights = place.weights;
  hit.uv = place.uv;
  hit.normal = Vec3(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z).stableNormalized();
  hit.small = std::uint64_t{part} << 32 | small;
  return hit;
}

bool DisplacedMesh::is_hit(const Vec3& origin, const Vec3& direction,
                           const DisplacedRayOptions& options) const {
  RTCRay ray{};
  Data::RayScale scale;
  if (!data_->set_ray(origin, direction, options, ray, scale)) return false;
  RayContext context = detail::make_ray_context();
  context.fraction = static_cast<float>(options.fraction);
  rtcOccluded1(data_->scene.get(), &context.embree, &ray);
  return ray.tfar < 0;
}

PolygonSoup DisplacedMesh::tessellate(double fraction) const {
  const detail::DisplacedKernel& kernel = detail::displaced_kernel();
  const PatchArrays arrays = data_->arrays();
  const std::vector<DisplacedPatch>& patches = data_->patches.patches;
  std::vector<std::size_t> first_points{0}, first_triangles{0};
  for (const DisplacedPatch& patch : patches) {
    const std::size_t side = std::size_t{1} << patch.level;
    first_points.push_back(first_points.back() + (side + 1) * (side + 1));
    first_triangles.push_back(first_triangles.back() + (patch.is_single ? side * side : 2 * side * side));
  }
  // Vertices and corners have numbers of 32 bits.
  if (std::max(first_points.back(), 3 * first_triangles.back()) > std::numeric_limits<Index>::max())
    throw InputError("a displaced surface of " + std::to_string(first_triangles.back()) +
                     " small triangles can't be tessellated");
  PolygonSoup soup;
  soup.positions.assign(first_points.back(), Vec3::Zero());
  soup.corner_vertices.resize(3 * first_triangles.back());
  soup.face_offsets.resize(first_triangles.back() + 1);
  for (std::size_t f = 0; f < soup.face_offsets.size(); ++f) soup.face_offsets[f] = static_cast<Index>(3 * f);
  tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t number) {
    const DisplacedPatch& patch = patches[number];
    const std::uint32_t side = 1u << patch.level;
    const auto point = [&](std::uint32_t i, std::uint32_t j) {
      return static_cast<Index>(first_points[number] + i + std::size_t{side + 1} * j);
    };
    for (std::uint32_t j = 0; j <= side; ++j) {
      for (std::uint32_t i = 0; i <= (patch.is_single ? side - j : side); ++i) {
        float position[3];
        kernel.point(arrays, static_cast<std::uint32_t>(number), i, j, static_cast<float>(fraction),
                     position);
        soup.positions[point(i, j)] = data_->frame.to_object(Vec3(position[0], position[1], position[2]));
      }
    }
    Index* corner = soup.corner_vertices.data() + 3 * first_triangles[number];
    for (std::uint32_t j = 0; j < side; ++j) {
      for (std::uint32_t i = 0; i < (patch.is_single ? side - j : side); ++i) {
        for (const Index p : {point(i, j), point(i + 1, j), point(i, j + 1)}) *corner++ = p;
        if (patch.is_single && i + j + 2 > side) continue;
        for (const Index p : {point(i + 1, j + 1), point(i, j + 1), point(i + 1, j)}) *corner++ = p;
      }
    }
  });
  return soup;
}

std::size_t DisplacedMesh::small_triangles() const {
  std::size_t count = 0;
  for (const DisplacedPatch& patch : data_->patches.patches)
    count += (patch.is_single ? std::size_t{1} : std::size_t{2}) << (2 * patch.level);
  return count;
}

DisplacedMesh::Memory DisplacedMesh::memory() const {
  const detail::DisplacedPatches& p = data_->patches;
  return {data_->map.bytes(), data_->bounds->bytes(),
          p.parts.size() * sizeof(detail::PatchPart) + p.patches.size() * sizeof(p.patches[0]) +
              p.vertices.size() * sizeof(p.vertices[0]) +
              p.exceptions.size() * sizeof(detail::PatchException) +
              p.triangles.size() * sizeof(p.triangles[0]) + p.faces.size() * sizeof(Index)};
}

}  // namespace recede
