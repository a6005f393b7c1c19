#include <recede/lod/detail/billboard_rays.h>
#include <recede/lod/detail/embree_device.h>

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

namespace {

// What Embree carries along with a ray.
struct FaceChoice {
  RTCIntersectContext embree;  // first, as Embree sees no more than this
  const std::vector<Index>* billboard_of = nullptr;
  const std::vector<Vec3>* normals = nullptr;
  Index billboard = 0;
  Vec3 front = Vec3::UnitZ();
  double least_cosine = -1;
  bool is_two_sided = false;
  bool takes_all = false;

  bool takes(std::uint32_t triangle) const {
    if (takes_all || (*billboard_of)[triangle] == billboard) return true;
    const double cosine = (*normals)[triangle].dot(front);
    return (is_two_sided ? std::abs(cosine) : cosine) >= least_cosine;
  }
};

void choose_face(const RTCFilterFunctionNArguments* arguments) {
  const auto& choice = *reinterpret_cast<const FaceChoice*>(arguments->context);
  for (unsigned i = 0; i < arguments->N; ++i) {
    if (arguments->valid[i] != 0 && !choice.takes(RTCHitN_primID(arguments->hit, arguments->N, i)))
      arguments->valid[i] = 0;
  }
}

}  // namespace

BillboardRays::BillboardRays(const PolygonSoup& model, const BillboardCloud& cloud, double spacing)
    : model_(model), cloud_(cloud), spacing_(spacing), attributes_(model) {
  const Box3 box = bounding_box(model);
  center_ = box.center();
  scale_ = box.sizes().maxCoeff() > 0 ? 1 / box.sizes().maxCoeff() : 1;
  for (const Vec3& position : model.positions) {
    const Eigen::Vector3f scaled = ((position - center_) * scale_).cast<float>();
    positions_.push_back({scaled.x(), scaled.y(), scaled.z(), 0});
  }
  std::vector<Index> of_faces(model.n_faces(), k_no_index);
  for (std::size_t b = 0; b < cloud.billboards.size(); ++b) {
    for (const Index face : cloud.billboards[b].faces) of_faces[face] = static_cast<Index>(b);
  }
  const std::vector<Index>& triangles = attributes_.triangles();
  for (std::size_t t = 0; 3 * t < triangles.size(); ++t) {
    billboard_of_.push_back(of_faces[attributes_.face_of(static_cast<Index>(t))]);
    const Vec3 &a = model.positions[triangles[3 * t]], &b = model.positions[triangles[3 * t + 1]],
               &c = model.positions[triangles[3 * t + 2]];
    normals_.push_back((b - a).cross(c - a).stableNormalized());
  }
  const RTCDevice device = embree_device();
  scene_.reset(rtcNewScene(device));
  rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions_.data(), 0,
                             sizeof(positions_[0]), positions_.size());
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                             3 * sizeof(Index), triangles.size() / 3);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_.get(), geometry);
  rtcReleaseGeometry(geometry);
  // The tree that several threads build depends on their number, and with it which of two equal hits counts.
  tbb::task_arena(1).execute([this] { rtcCommitScene(scene_.get()); });
  throw_on_embree_error(device, "build the tree of a billboard cloud");
}

std::optional<BillboardSample> BillboardRays::sample(std::size_t number, const Vec2& at) const {
  return sample_towards(number, at, cloud_.billboards[number].normal());
}

std::optional<BillboardSample> BillboardRays::sample_towards(std::size_t number, const Vec2& at,
                                                             const Vec3& viewer) const {
  // Room for the rounding to float, where faces lie in the plane itself.
  constexpr double k_room = 1e-5;
  const Billboard& billboard = cloud_.billboards[number];
  const Vec3 front = billboard.normal();
  const double rise = front.dot(viewer);  // by which a ray leaves the plane
  const double reach = (std::max(cloud_.error, billboard.error) * scale_ + k_room) / std::abs(rise);
  const Vec3 place =
      (billboard.center + at.x() * billboard.axis_u + at.y() * billboard.axis_v - center_) * scale_;
  const Eigen::Vector3f origin = (place + reach * viewer).cast<float>(), direction = (-viewer).cast<float>();
  FaceChoice choice;
  rtcInitIntersectContext(&choice.embree);
  choice.embree.filter = choose_face;
  choice.billboard_of = &billboard_of_;
  choice.normals = &normals_;
  choice.billboard = static_cast<Index>(number);
  choice.front = front;
  choice.least_cosine = std::cos(cloud_.largest_deviation);
  choice.is_two_sided = cloud_.is_two_sided;
  choice.takes_all = cloud_.is_impostor;
  RTCRayHit ray{};
  ray.ray.org_x = origin.x();
  ray.ray.org_y = origin.y();
  ray.ray.org_z = origin.z();
  ray.ray.dir_x = direction.x();
  ray.ray.dir_y = direction.y();
  ray.ray.dir_z = direction.z();
  ray.ray.tfar = static_cast<float>(2 * reach);
  ray.ray.mask = 0xffffffffu;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene_.get(), &choice.embree, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const double u = static_cast<double>(ray.hit.u), v = static_cast<double>(ray.hit.v);
  const TrianglePlace hit{ray.hit.primID, Vec3(1 - u - v, u, v)};
  BillboardSample sample;
  sample.is_own = cloud_.is_impostor || billboard_of_[hit.triangle] == number;
  sample.place = hit;
  sample.height = (reach - static_cast<double>(ray.ray.tfar)) * rise / scale_;
  sample.color = attributes_.color_at(hit, spacing_);
  sample.normal = attributes_.normal_at(hit);
  // Both sides look alike; normals of the soup need not be on the front of their face.
  const Vec3 face =
      normals_[hit.triangle].dot(viewer) < 0 ? Vec3(-normals_[hit.triangle]) : normals_[hit.triangle];
  if (sample.normal.dot(face) < 0) sample.normal = -sample.normal;
  return sample;
}

}  // namespace recede::detail
