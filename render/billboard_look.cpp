#include <recede/geometry/error.h>
#include <recede/lod/octahedral_impostor.h>
#include <recede/render/detail/billboard_look.h>
#include <recede/render/detail/tracing.h>

#include <algorithm>
#include <cmath>

namespace recede::detail {

using Vec3f = Eigen::Vector3f;

// In texels: x to the right, y down, both from the billboard's upper left corner; in object units z to the
// front.
struct BillboardLook::LocalRay {
  Vec3 origin, direction;
};

namespace {

// What shows less lets rays pass.
constexpr float k_least_opacity = 0.5f;

}  // namespace

Vec3 BillboardLook::Frame::toward_viewer(const LocalRay& ray) const {
  return {-ray.direction.x() * texel_u, ray.direction.y() * texel_v, -ray.direction.z()};
}

BillboardLook::BillboardLook(const PlacedBillboards& placed, const Vec3& center, double scale) {
  const BillboardTextures& textures = *placed.textures;
  row_ = static_cast<std::size_t>(textures.color.width);
  model_texel_ = textures.texel;
  range_ = textures.height_range;
  if (textures.is_impostor)
    views_ = static_cast<int>(std::lround(std::sqrt(static_cast<double>(textures.billboards.size()))));
  for (std::size_t b = 0; b < textures.billboards.size(); ++b) {
    const Billboard& billboard = textures.billboards[b];
    const BillboardPlace& place = textures.places[b];
    frames_.push_back({billboard.center, billboard.axis_u, billboard.axis_v, billboard.normal(),
                       2 * billboard.half_sizes.x() / place.width,
                       2 * billboard.half_sizes.y() / place.height, place.width, place.height,
                       static_cast<std::size_t>(place.y) * row_ + static_cast<std::size_t>(place.x)});
  }
  const std::size_t n = textures.height.samples.size();
  for (std::size_t i = 0; i < n; ++i) {
    const float share = static_cast<float>(textures.height.samples[i]) / 255.0f;
    heights_.push_back((2 * share - 1) * static_cast<float>(range_));
    opacity_.push_back(static_cast<float>(textures.color.samples[4 * i + 3]) / 255.0f);
    auto& color = colors_.emplace_back();
    auto& normal = normals_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      color[k] = static_cast<std::uint8_t>(textures.color.samples[4 * i + k]);
      normal[k] = static_cast<std::uint8_t>(textures.normal.samples[3 * i + k]);
    }
  }
  if (placed.reflectance) {
    if (placed.reflectance->width != textures.color.width ||
        placed.reflectance->height != textures.color.height)
      throw InputError("the reflectance isn't one of these billboards");
    tables_.emplace(placed.reflectance);
  }
  const Eigen::Affine3d scene = Eigen::Scaling(scale) * Eigen::Translation3d(-center);
  for (const Eigen::Affine3d& placement : placed.placements) {
    if (!placement.matrix().allFinite() || !(std::abs(placement.linear().determinant()) > 0))
      throw InputError("placements of billboards must be such that they can be undone");
    to_scene_.push_back(scene * placement);
    to_model_.push_back(to_scene_.back().inverse());
    texel_sizes_.push_back(model_texel_ * to_scene_.back().linear().colwise().norm().maxCoeff());
  }
}

Box3 BillboardLook::bounds(std::uint32_t primitive) const {
  const Frame& frame = frame_of(primitive);
  const Eigen::Affine3d& to_scene = to_scene_[primitive / frames_.size()];
  const Vec3 u = 0.5 * frame.width * frame.texel_u * frame.axis_u,
             v = 0.5 * frame.height * frame.texel_v * frame.axis_v, n = k_height_room * range_ * frame.normal;
  Box3 box;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner = frame.center + ((k & 1) != 0 ? u : Vec3(-u)) + ((k & 2) != 0 ? v : Vec3(-v)) +
                        ((k & 4) != 0 ? n : Vec3(-n));
    box.extend(to_scene * corner);
  }
  return box;
}

std::size_t BillboardLook::texel_at(const Frame& frame, int x, int y) const {
  return frame.first + static_cast<std::size_t>(std::clamp(y, 0, frame.height - 1)) * row_ +
         static_cast<std::size_t>(std::clamp(x, 0, frame.width - 1));
}

BillboardLook::Cell BillboardLook::cell_at(const Frame& frame, float x, float y) const {
  const float s = x - 0.5f, t = y - 0.5f;  // whole at the middles of texels
  const int column = static_cast<int>(std::floor(s)), row = static_cast<int>(std::floor(t));
  return {{texel_at(frame, column, row), texel_at(frame, column + 1, row), texel_at(frame, column, row + 1),
           texel_at(frame, column + 1, row + 1)},
          s - static_cast<float>(column),
          t - static_cast<float>(row)};
}

template <typename Values>
auto BillboardLook::blend(const Cell& cell, const Values& value) {
  const float u = cell.u, v = cell.v;
  return ((1 - v) * ((1 - u) * value(cell.texels[0]) + u * value(cell.texels[1])) +
          v * ((1 - u) * value(cell.texels[2]) + u * value(cell.texels[3])))
      .eval();
}

BillboardLook::LocalRay BillboardLook::local_ray(std::uint32_t primitive, const Vec3f& origin,
                                                 const Vec3f& direction) const {
  const Frame& frame = frame_of(primitive);
  const Eigen::Affine3d& to_model = to_model_[primitive / frames_.size()];
  const Vec3 from = to_model * origin.cast<double>() - frame.center,
             along = to_model.linear() * direction.cast<double>();
  return {{from.dot(frame.axis_u) / frame.texel_u + 0.5 * frame.width,
           0.5 * frame.height - from.dot(frame.axis_v) / frame.texel_v, from.dot(frame.normal)},
          {along.dot(frame.axis_u) / frame.texel_u, -along.dot(frame.axis_v) / frame.texel_v,
           along.dot(frame.normal)}};
}

namespace {

// Narrows an interval to where a coordinate lies between two numbers.
bool clip(double origin, double direction, double low, double high, double& from, double& to) {
  if (direction == 0) return origin >= low && origin <= high;
  const double a = (low - origin) / direction, b = (high - origin) / direction;
  from = std::max(from, std::min(a, b));
  to = std::min(to, std::max(a, b));
  return from <= to;
}

// The distance at which a coordinate leaves a cell.
double exit_of(double origin, double direction, int cell, double never) {
  if (direction == 0) return never;
  return ((direction > 0 ? cell + 1 : cell) + 0.5 - origin) / direction;
}

// Roots of a x^2 + b x + c, rising.
int roots_of(double a, double b, double c, std::array<double, 2>& roots) {
  if (a == 0) {
    if (b == 0) return 0;
    roots[0] = -c / b;
    return 1;
  }
  const double square = b * b - 4 * a * c;
  if (!(square >= 0)) return 0;
  const double q = -0.5 * (b + std::copysign(std::sqrt(square), b));
  roots[0] = q / a;
  if (q == 0) return 1;
  roots[1] = c / q;
  if (roots[0] > roots[1]) std::swap(roots[0], roots[1]);
  return 2;
}

}  // namespace

/// The opacity at a place; `toward_viewer` is along the billboard's axes and normal, of any length.
float BillboardLook::see(const Frame& frame, float x, float y, const Vec3& toward_viewer,
                         BillboardView& view) const {
  const BillboardReflectance& reflectance = *tables_->reflectance;
  const bool is_back = reflectance.is_two_sided && toward_viewer.z() < 0;
  const Vec3 turned =
      is_back ? Vec3(-toward_viewer.x(), toward_viewer.y(), -toward_viewer.z()) : toward_viewer;
  const std::uint32_t* vectors =
      reflectance.vectors.data() + (is_back ? reflectance.vectors.size() / 2 : std::size_t{0});
  const Cell cell = cell_at(frame, x, y);
  const std::array<float, 4> weights{(1 - cell.u) * (1 - cell.v), cell.u * (1 - cell.v),
                                     (1 - cell.u) * cell.v, cell.u * cell.v};
  view.tables = &*tables_;
  view.views = tables_->views.mix(turned.normalized());
  float opacity = 0;
  for (std::size_t t = 0; t < 4; ++t) {
    view.vectors[t] = vectors[cell.texels[t]];
    view.shares[t].fill(0);
    if (view.vectors[t] == BillboardReflectance::k_none) continue;
    for (std::size_t v = 0; v < 4; ++v) {
      const std::uint8_t covered = reflectance.opacity[view.vectors[t] * tables_->views.size() +
                                                       static_cast<std::size_t>(view.views.nodes[v])];
      view.shares[t][v] =
          weights[t] * static_cast<float>(view.views.weights[v]) * static_cast<float>(covered) / 255.0f;
      opacity += view.shares[t][v];
    }
  }
  if (opacity > 0) {
    for (std::array<float, 4>& shares : view.shares) {
      for (float& share : shares) share /= opacity;
    }
  }
  return opacity;
}

// With reflectance billboards are flat: its values are by where rays go through the plane.
bool BillboardLook::cross_plane(const Frame& frame, const LocalRay& ray, double least, double most,
                                Crossing& crossing) const {
  const double distance = -ray.origin.z() / ray.direction.z();
  if (!(distance >= least && distance <= most)) return false;  // nor along the plane
  const Vec3 at = ray.origin + distance * ray.direction;
  if (!(at.x() >= 0 && at.x() <= frame.width && at.y() >= 0 && at.y() <= frame.height)) return false;
  crossing.distance = distance;
  crossing.u = static_cast<float>(at.x());
  crossing.v = static_cast<float>(at.y());
  crossing.front = frame.normal.cast<float>();
  BillboardView view;
  return see(frame, crossing.u, crossing.v, frame.toward_viewer(ray), view) >= k_least_opacity;
}

BillboardView BillboardLook::view_of(const Hit& hit, const Vec3f& direction) const {
  const Frame& frame = frame_of(hit.part.primitive);
  const Vec3 viewer = frame.toward_viewer(local_ray(hit.part.primitive, hit.origin, direction));
  BillboardView view;
  see(frame, hit.u, hit.v, viewer, view);
  const double sign = tables_->reflectance->is_two_sided && viewer.z() < 0 ? -1 : 1;
  Eigen::Matrix3d axes;
  axes << sign * frame.axis_u, frame.axis_v, sign * frame.normal;
  view.to_side = axes.transpose() * to_model_[hit.part.primitive / frames_.size()].linear();
  return view;
}

bool BillboardLook::cross_cell(const Frame& frame, const LocalRay& ray, int column, int row, double from,
                               double to, Crossing& crossing) const {
  // Beyond the outer middles heights go on as before them: surfaces of neighbours meet there.
  column = std::clamp(column, 0, std::max(0, frame.width - 2));
  row = std::clamp(row, 0, std::max(0, frame.height - 2));
  const std::array<std::size_t, 4> texels{texel_at(frame, column, row), texel_at(frame, column + 1, row),
                                          texel_at(frame, column, row + 1),
                                          texel_at(frame, column + 1, row + 1)};
  std::array<float, 4> share;
  for (std::size_t k = 0; k < 4; ++k) share[k] = opacity_[texels[k]];
  if (std::max({share[0], share[1], share[2], share[3]}) < k_least_opacity) return false;
  // The surface is a + b s + c t + d s t over the cell.
  const double a = static_cast<double>(heights_[texels[0]]), b = static_cast<double>(heights_[texels[1]]) - a,
               c = static_cast<double>(heights_[texels[2]]) - a,
               d = static_cast<double>(heights_[texels[3]]) - a - b - c;
  const Vec3 at = ray.origin + from * ray.direction;
  const double s = at.x() - 0.5 - column, t = at.y() - 0.5 - row;
  const double ds = ray.direction.x(), dt = ray.direction.y(), dz = ray.direction.z();
  std::array<double, 2> roots{};
  const int n = roots_of(-d * ds * dt, dz - b * ds - c * dt - d * (s * dt + t * ds),
                         at.z() - a - b * s - c * t - d * s * t, roots);
  // Cells meet a little beyond their sides, so that no ray slips between them.
  const double room = 1e-9 * (1 + std::abs(to));
  for (int k = 0; k < n; ++k) {
    const double along = roots[static_cast<std::size_t>(k)];
    if (along < -room || along > to - from + room) continue;
    const auto u = static_cast<float>(s + along * ds), v = static_cast<float>(t + along * dt);
    const float within_u = std::clamp(u, 0.0f, 1.0f), within_v = std::clamp(v, 0.0f, 1.0f);
    const float here = (1 - within_v) * ((1 - within_u) * share[0] + within_u * share[1]) +
                       within_v * ((1 - within_u) * share[2] + within_u * share[3]);
    if (here < k_least_opacity) continue;
    crossing.distance = from + along;
    crossing.u = u + 0.5f + static_cast<float>(column);
    crossing.v = v + 0.5f + static_cast<float>(row);
    const Vec3 slope(b + d * static_cast<double>(v), c + d * static_cast<double>(u), 0);
    crossing.front =
        (frame.normal - slope.x() / frame.texel_u * frame.axis_u + slope.y() / frame.texel_v * frame.axis_v)
            .cast<float>();
    return true;
  }
  return false;
}

bool BillboardLook::faces_best(std::uint32_t primitive, const Vec3f& direction) const {
  const Vec3 toward = -(to_model_[primitive / frames_.size()].linear() * direction.cast<double>());
  return octahedral_view(toward, views_) == primitive % frames_.size();
}

void BillboardLook::turn_to_scene(std::uint32_t primitive, Vec3f& normal) const {
  const Eigen::Matrix3d turn = to_model_[primitive / frames_.size()].linear().transpose();
  normal = turn.cast<float>() * normal;
}

bool BillboardLook::first_crossing(std::uint32_t primitive, const CrossingQuery& query,
                                   Crossing& crossing) const {
  if (query.starts_here && is_passed(query.start, primitive)) return false;
  if (views_ > 0 && !faces_best(primitive, query.direction)) return false;
  const Frame& frame = frame_of(primitive);
  const LocalRay ray = local_ray(primitive, query.origin, query.direction);
  if (tables_) {
    if (!cross_plane(frame, ray, query.least, query.most, crossing)) return false;
    turn_to_scene(primitive, crossing.front);
    return true;
  }
  const double reach = k_height_room * range_;
  double from = query.least, to = query.most;
  if (!clip(ray.origin.z(), ray.direction.z(), -reach, reach, from, to) ||
      !clip(ray.origin.x(), ray.direction.x(), 0, frame.width, from, to) ||
      !clip(ray.origin.y(), ray.direction.y(), 0, frame.height, from, to))
    return false;
  const Vec3 at = ray.origin + from * ray.direction;
  // Cells lie between the middles of texels.
  int column = std::clamp(static_cast<int>(std::floor(at.x() - 0.5)), -1, frame.width - 1),
      row = std::clamp(static_cast<int>(std::floor(at.y() - 0.5)), -1, frame.height - 1);
  const int right = ray.direction.x() > 0 ? 1 : -1, down = ray.direction.y() > 0 ? 1 : -1;
  while (column >= -1 && column < frame.width && row >= -1 && row < frame.height) {
    const double over_x = exit_of(ray.origin.x(), ray.direction.x(), column, to),
                 over_y = exit_of(ray.origin.y(), ray.direction.y(), row, to);
    const double end = std::max(from, std::min({over_x, over_y, to}));
    if (cross_cell(frame, ray, column, row, from, end, crossing)) {
      turn_to_scene(primitive, crossing.front);
      return true;
    }
    if (end >= to) return false;
    if (over_x <= over_y) {
      column += right;
    } else {
      row += down;
    }
    from = end;
  }
  return false;
}

Rgb BillboardLook::color_at(const Hit& hit) const {
  const Cell cell = cell_at(frame_of(hit.part.primitive), hit.u, hit.v);
  return blend(cell, [&](std::size_t texel) {
    const auto& bytes = colors_[texel];
    static const std::array<float, 256> k_linear = [] {
      std::array<float, 256> linear{};
      for (std::size_t i = 0; i < linear.size(); ++i) linear[i] = decode_srgb(static_cast<float>(i) / 255.0f);
      return linear;
    }();
    return Rgb(k_linear[bytes[0]], k_linear[bytes[1]], k_linear[bytes[2]]);
  });
}

Vec3f BillboardLook::normal_at(const Hit& hit) const {
  const Frame& frame = frame_of(hit.part.primitive);
  const Cell cell = cell_at(frame, hit.u, hit.v);
  const Vec3f local = blend(cell, [&](std::size_t texel) {
    const auto& bytes = normals_[texel];
    return Vec3f(Vec3f(bytes[0], bytes[1], bytes[2]) * (2 / 255.0f) - Vec3f::Ones());
  });
  const Vec3 normal = static_cast<double>(local.x()) * frame.axis_u +
                      static_cast<double>(local.y()) * frame.axis_v +
                      static_cast<double>(local.z()) * frame.normal;
  const Eigen::Matrix3d turn = to_model_[hit.part.primitive / frames_.size()].linear().transpose();
  return (turn * normal).stableNormalized().cast<float>();
}

RTCGeometry billboard_geometry(RTCDevice device, const BillboardLook& look) {
  return UserGeometry<BillboardLook>::make(device, look);
}

}  // namespace recede::detail
