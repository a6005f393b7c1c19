#include <recede/render/detail/billboard_look.h>
#include <recede/render/detail/displaced_look.h>
#include <recede/render/detail/surface_point.h>
#include <recede/render/detail/volume_look.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace recede::detail {

namespace {

/// Two unit vectors that complete a unit vector to a right-handed frame (Duff et al. 2017, "Building an
/// Orthonormal Basis, Revisited").
std::array<Vec3, 2> tangents_of(const Vec3& normal) {
  const double sign = std::copysign(1.0, normal.z());
  const double a = -1 / (sign + normal.z()), b = normal.x() * normal.y() * a;
  return {Vec3(1 + sign * normal.x() * normal.x() * a, sign * b, -sign * normal.x()),
          Vec3(b, sign + normal.y() * normal.y() * a, -normal.y())};
}

/// How far a ray's origin must lie off a triangle so that rounding puts it on no wrong side of it or of its
/// neighbours. With the largest coordinate m, the longest side s around and the unit e = 2^-24 of rounding:
/// - the origin is rounded to float, by e m in each coordinate, sqrt(3) e m along a normal;
/// - Embree takes the corners relative to the origin (e s at most, as both are near), the normal from
///   products of sides (2 e s^2 in each coordinate, over the normal's own length of about s^2) and the
///   distance as a sum of three products (3 e s): less than 16 e s together, with sqrt(3) for three
///   coordinates.
/// Flat triangles can be off by more, since their normal is short; but no ray meets the one it starts on.
double rounding_bound(const MeshData& mesh, std::uint32_t triangle, const Vec3& position) {
  constexpr double k_unit = 0x1p-24;
  double side = 0;
  for (const std::uint32_t vertex : mesh.triangles[triangle])
    side = std::max(side, static_cast<double>(mesh.longest_sides[vertex]));
  return k_unit * (2 * position.cwiseAbs().maxCoeff() + 16 * side);
}

}  // namespace

namespace {

/// A surface with appearances, by the method that `shares` say. Backs have none but the bump map.
void set_appearance(const DisplacedLook& look, const Hit& base_hit, const Vec3f& direction,
                    const MethodShares& shares, SurfaceLook& seen) {
  const AppearanceLook& appearances = *look.appearance;
  const double u = static_cast<double>(base_hit.u), v = static_cast<double>(base_hit.v);
  const SurfaceFrame frame = appearances.frame_at(base_hit.part.primitive, {1 - u - v, u, v});
  const bool is_front = base_hit.front.dot(direction) <= 0;
  const Vec3 toward_viewer = frame.to_local(-direction.cast<double>());
  if (shares.displaced < 1 && is_front)
    seen.method = {&appearances.appearance(), shares, frame, toward_viewer};
  if (!(seen.method.appearance != nullptr && shares.table == 1)) {
    Vec3 normal = appearances.bump_normal(frame.uv, look.surface.map);
    if (shares.displaced < 1 && is_front)
      normal = appearances.appearance().bump_normal(normal, toward_viewer, shares.displaced);
    seen.normal = frame.to_world(normal).cast<float>();
  } else {
    seen.normal = frame.normal.cast<float>();
  }
}

SurfaceLook look_of_billboard(const BillboardLook& billboards, const Hit& hit, const Vec3f& direction) {
  SurfaceLook look{billboards.normal_at(hit), billboards.color_at(hit)};
  if (hit.front.dot(direction) > 0) look.normal = -look.normal;
  if (billboards.has_reflectance()) {
    look.billboard = billboards.view_of(hit, direction);
    look.albedo = look.billboard.albedo();
  }
  return look;
}

SurfaceLook look_of_volume(const VolumeLook& volume, const Hit& hit, const Vec3f& direction) {
  const float length = hit.front.norm();
  SurfaceLook look{length > 0 ? Vec3f(hit.front / length) : Vec3f(-direction),
                   volume.color_at(hit, direction), std::min(length, 1.0f)};
  if (look.normal.dot(direction) > 0) look.normal = -look.normal;
  return look;
}

}  // namespace

SurfaceLook look_of(const SceneData& scene, const Hit& any_hit, const Vec3f& direction,
                    const MethodShares& shares) {
  const MeshData& mesh = scene.meshes[any_hit.part.object];
  if (mesh.billboards) return look_of_billboard(*mesh.billboards, any_hit, direction);
  if (mesh.volume) return look_of_volume(*mesh.volume, any_hit, direction);
  const Hit hit = mesh.displaced ? hit_of_base(*mesh.displaced, any_hit) : any_hit;
  const std::uint32_t triangle = hit.part.primitive;
  const Vec3f weights(1 - hit.u - hit.v, hit.u, hit.v);
  SurfaceLook look{Vec3f::Zero(), mesh.triangle_colors[triangle]};
  if (mesh.displaced && mesh.displaced->appearance) {
    set_appearance(*mesh.displaced, hit, direction, shares, look);
  } else if (mesh.displaced) {
    look.normal = displaced_normal(*mesh.displaced, any_hit).cast<float>();
  } else {
    for (std::size_t k = 0; k < 3; ++k)
      look.normal += weights[static_cast<int>(k)] * mesh.corner_normals[3 * triangle + k];
  }
  // Those of the corners are unit, or nothing.
  const float squared = look.normal.squaredNorm();
  look.normal =
      squared < 1e-12f ? Vec3f(hit.front.stableNormalized()) : Vec3f(look.normal / std::sqrt(squared));
  if (hit.front.dot(direction) > 0) look.normal = -look.normal;
  if (mesh.textures) look.albedo = look.albedo.cwiseProduct(mesh.textures->color_at(triangle, weights));
  if (!mesh.vertex_colors.empty()) {
    Rgb factor = Rgb::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      factor += weights[static_cast<int>(k)] * mesh.vertex_colors[mesh.triangles[triangle][k]];
    look.albedo = look.albedo.cwiseProduct(factor);
  }
  return look;
}

namespace {

/// The mean of max(0, N.L) over normals whose mean has this length and this cosine with L over it. A length
/// of 2/3 is that of a ball as it is seen, for which the mean is Lambert's phase function; between that and a
/// plane it is taken as linear.
double mean_cosine(double cosine, double length) {
  const double plane = std::max(0.0, cosine);
  if (length >= 1) return plane;
  const double bounded = std::clamp(cosine, -1.0, 1.0), angle = std::acos(bounded);
  const double ball = (std::sin(angle) + (std::numbers::pi - angle) * bounded) / std::numbers::pi;
  const double share = std::min(1.0, 3 * (1 - length));
  return length * ((1 - share) * plane + share * ball);
}

}  // namespace

double facing(const SurfaceLook& look, const Vec3& toward_light) {
  if (look.billboard.tables != nullptr) {
    // Over the albedo, of all colours together.
    const double all = static_cast<double>(look.albedo.sum());
    return all > 0 ? std::numbers::pi * static_cast<double>(look.billboard.value(toward_light).sum()) / all
                   : 0;
  }
  const double by_normal =
      mean_cosine(look.normal.cast<double>().dot(toward_light), static_cast<double>(look.normal_length));
  const MethodLook& method = look.method;
  if (method.appearance == nullptr) return by_normal;
  const Vec3 light = method.frame.to_local(toward_light);
  const double share = method.shares.table;
  double value = 0;
  if (share < 1) {
    value = (1 - share) * by_normal *
            method.appearance->bump_factor(method.toward_viewer, light, method.shares.displaced);
  }
  if (share > 0) value += share * method.appearance->unshadowed(method.toward_viewer, light);
  return value;
}

Vec3 mean_normal(const SurfaceLook& look) {
  const MethodLook& method = look.method;
  const double share = method.shares.table;
  if (method.appearance == nullptr || share == 0) return (look.normal_length * look.normal).cast<double>();
  return (1 - share) * look.normal.cast<double>() +
         share * method.frame.to_world(method.appearance->mean_normal(method.toward_viewer));
}

namespace {

/// Position, geometric normal and start; the normal's side isn't chosen yet.
void place_on_triangle(const MeshData& mesh, const Hit& hit, SurfacePoint& point) {
  const std::array<std::uint32_t, 3>& vertices = mesh.triangles[hit.part.primitive];
  const std::array<Vec3, 3> corners{mesh.position(vertices[0]), mesh.position(vertices[1]),
                                    mesh.position(vertices[2])};
  const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
  const Vec3 first = corners[1] - corners[0], second = corners[2] - corners[0];
  point.position = corners[0] + u * first + v * second;
  point.geometric_normal = first.cross(second).stableNormalized();
}

}  // namespace

SurfacePoint surface_point(const SceneData& scene, const Hit& hit, const Vec3f& direction,
                           const MethodShares& shares) {
  const MeshData& mesh = scene.meshes[hit.part.object];
  const SurfaceLook look = look_of(scene, hit, direction, shares);
  const Vec3 ray = direction.cast<double>();
  SurfacePoint point;
  point.part = hit.part;
  double off = 0;
  if (mesh.billboards) {
    // Neighbours show parts of the same surface, each a little off.
    constexpr double k_texels_off = 1.5;
    point.position = hit.origin.cast<double>() + static_cast<double>(hit.distance) * ray;
    point.geometric_normal = hit.front.cast<double>().stableNormalized();
    if (!mesh.billboards->has_reflectance()) off = k_texels_off * mesh.billboards->texel(hit.part.primitive);
  } else if (mesh.volume) {
    // As far as gradients look.
    point.position = hit.origin.cast<double>() + static_cast<double>(hit.distance) * ray;
    point.geometric_normal = hit.front.cast<double>().stableNormalized();
    off = mesh.volume->texel(hit.part.primitive);
  } else if (mesh.displaced && !is_on_base(hit)) {
    point.position = hit.origin.cast<double>() + static_cast<double>(hit.distance) * ray;
    point.geometric_normal = hit.front.cast<double>().stableNormalized();
    off = displaced_rounding_bound(*mesh.displaced, mesh, hit, point.position);
  } else {
    place_on_triangle(mesh, hit, point);
    off = rounding_bound(mesh, hit.part.primitive, point.position);
  }
  // Of a triangle without area: any normal that is seen.
  if (!(point.geometric_normal.squaredNorm() > 0.5)) point.geometric_normal = -ray.normalized();
  if (point.geometric_normal.dot(ray) > 0) point.geometric_normal = -point.geometric_normal;
  point.normal = look.normal.cast<double>().stableNormalized();
  if (!(point.normal.squaredNorm() > 0.5)) point.normal = point.geometric_normal;
  point.albedo = look.albedo;
  point.normal_length = static_cast<double>(look.normal_length);
  point.method = look.method;
  point.billboard = look.billboard;
  point.target = {shares.is_on_base() ? SurfaceShape::base : SurfaceShape::displaced,
                  static_cast<float>(shares.displaced)};
  point.start = (point.position + off * point.geometric_normal).cast<float>();
  return point;
}

namespace {

double scattered_by_normal(const SurfacePoint& point, const Vec3& toward) {
  return mean_cosine(point.normal.dot(toward), point.normal_length) / std::numbers::pi;
}

double table_share(const SurfacePoint& point) {
  return point.method.appearance == nullptr ? 0 : point.method.shares.table;
}

/// Per radiance that comes from above the geometric horizon, for each channel.
Rgb scattered_light(const SurfacePoint& point, const Vec3& toward) {
  const MethodLook& method = point.method;
  if (method.appearance == nullptr)
    return static_cast<float>(scattered_by_normal(point, toward)) * point.albedo;
  const Vec3 toward_light = method.frame.to_local(toward);
  const double share = method.shares.table;
  double value = 0;
  if (share < 1) {
    value = (1 - share) * scattered_by_normal(point, toward) *
            method.appearance->bump_factor(method.toward_viewer, toward_light, method.shares.displaced);
  }
  if (share > 0)
    value += share * method.appearance->table().value(method.toward_viewer, toward_light) / std::numbers::pi;
  const Rgb shading = method.appearance->shading(point.albedo, method.toward_viewer, toward_light,
                                                 point.passes_on, method.shares.displaced);
  return static_cast<float>(value) * point.albedo.cwiseProduct(shading);
}

/// That of `cosine_direction`.
double cosine_density(const SurfacePoint& point, const Vec3& toward) {
  return std::max(0.0, point.normal.dot(toward)) / std::numbers::pi;
}

/// A disc filled evenly and lifted to the hemisphere has the density of the cosine.
Vec3 cosine_direction(const Vec3& normal, const Vec2& random) {
  const double radius = std::sqrt(random.x()), angle = 2 * std::numbers::pi * random.y();
  const double cosine = std::sqrt(1 - random.x());
  const std::array<Vec3, 2> tangents = tangents_of(normal);
  return (radius * std::cos(angle) * tangents[0] + radius * std::sin(angle) * tangents[1] + cosine * normal)
      .normalized();
}

// For reflectance of billboards, which may be anything.
constexpr double k_sphere_density = 1 / (4 * std::numbers::pi);

Vec3 sphere_direction(const Vec2& random) {
  const double z = 1 - 2 * random.x(), angle = 2 * std::numbers::pi * random.y();
  const double radius = std::sqrt(std::max(0.0, 1 - z * z));
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

}  // namespace

Rgb scattered(const SurfacePoint& point, const Vec3& toward) {
  if (point.billboard.tables != nullptr) return point.billboard.value(toward);
  if (!(point.geometric_normal.dot(toward) > 0)) return Rgb::Zero();
  return scattered_light(point, toward);
}

bool sample_scattering(const SurfacePoint& point, const Vec2& random, ScatterSample& sample) {
  if (point.billboard.tables != nullptr) {
    sample.direction = sphere_direction(random);
    sample.density = k_sphere_density;
    sample.weight = point.billboard.value(sample.direction) / static_cast<float>(k_sphere_density);
    return true;
  }
  const MethodLook& method = point.method;
  const double share = table_share(point);
  if (random.x() < share) {
    const Vec2 rest(random.x() / share, random.y());
    const ReflectanceSampler::Sample drawn = method.appearance->sampler().sample(method.toward_viewer, rest);
    if (!(drawn.density > 0)) return false;
    sample.direction = method.frame.to_world(drawn.toward_light).normalized();
  } else {
    sample.direction = cosine_direction(point.normal, {(random.x() - share) / (1 - share), random.y()});
  }
  if (!(point.geometric_normal.dot(sample.direction) > 0)) return false;
  if (method.appearance == nullptr) {
    sample.density = std::sqrt(1 - random.x()) / std::numbers::pi;
    if (!(sample.density > 0)) return false;
    sample.weight = point.albedo;
    if (point.normal_length < 1) {
      sample.weight *= static_cast<float>(scattered_by_normal(point, sample.direction) / sample.density);
    }
    return true;
  }
  sample.density = scattering_density(point, sample.direction);
  if (!(sample.density > 0)) return false;
  sample.weight = scattered_light(point, sample.direction) / static_cast<float>(sample.density);
  return true;
}

double scattering_density(const SurfacePoint& point, const Vec3& toward) {
  if (point.billboard.tables != nullptr) return k_sphere_density;
  const MethodLook& method = point.method;
  const double share = table_share(point);
  if (share == 0) return cosine_density(point, toward);
  return share * method.appearance->sampler().density(method.toward_viewer, method.frame.to_local(toward)) +
         (1 - share) * cosine_density(point, toward);
}

}  // namespace recede::detail
