#include <recede/geometry/bilinear_patch.h>
#include <recede/geometry/raster.h>
#include <recede/render/detail/tracing.h>
#include <recede/render/detail/volume_look.h>
#include <recede/shells/detail/matter_path.h>
#include <recede/shells/detail/shell_pieces.h>
#include <recede/shells/detail/volume_sampler.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace recede {

VolumeView volume_view(const Camera& camera) { return {camera.position, frame_of(camera).pixel}; }

namespace detail {

using Vec3f = Eigen::Vector3f;
using Matrix3 = Eigen::Matrix3d;

namespace {

// A number in [0, 1) that differs from ray to ray.
double lot(std::uint64_t key, std::uint64_t which) {
  std::uint64_t h = key + which * 0x9e3779b97f4a7c15ull;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ull;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebull;
  h ^= h >> 31;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

std::uint64_t key_of(const Vec3f& origin, const Vec3f& direction) {
  std::uint64_t key = 0;
  for (int k = 0; k < 3; ++k) {
    key = (key ^ std::bit_cast<std::uint32_t>(origin[k])) * 0x100000001b3ull;
    key = (key ^ std::bit_cast<std::uint32_t>(direction[k])) * 0x100000001b3ull;
    key ^= key >> 29;
  }
  return key;
}

// Texels farther along an axis whose opacity differs most.
Vec3 steepest_slopes(const VolumeTexture& texture) {
  std::array<int, 3> most{0, 0, 0};
  for (int k = 0; k < texture.size[2]; ++k) {
    for (int j = 0; j < texture.size[1]; ++j) {
      for (int i = 0; i < texture.size[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        const int here = texture.opacity[texture.texel(i, j, k)];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          std::array<int, 3> next = at;
          if (++next[axis] == texture.size[axis]) {
            if (axis == 2 || !texture.is_periodic) continue;
            next[axis] = 0;
          }
          const int there = texture.opacity[texture.texel(next[0], next[1], next[2])];
          most[axis] = std::max(most[axis], std::abs(there - here));
        }
      }
    }
  }
  return Vec3(most[0], most[1], most[2]) / 255;
}

}  // namespace

struct VolumeLook::Ray {
  Vec3 origin, direction;
  std::uint64_t key;

  Vec3 at(double distance) const { return origin + distance * direction; }
};

// Weights of the second and third corner, and the height from 0 to 1.
struct VolumeLook::Place {
  double u = 0, v = 0, height = 0;
};

struct VolumeLook::Prism {
  std::uint32_t primitive;
  std::array<std::uint32_t, 3> vertices;
  std::array<Vec3, 3> bottoms, directors;
  Vec2 st, st_u, st_v;  // at the first corner, and from there to the others

  Vec3 corner(std::size_t k, double height) const { return bottoms[k] + height * directors[k]; }
  Vec3 point(const Place& place) const {
    const double first = 1 - place.u - place.v;
    return first * corner(0, place.height) + place.u * corner(1, place.height) +
           place.v * corner(2, place.height);
  }
  Matrix3 jacobian(const Place& place) const {
    const Vec3 origin = corner(0, place.height);
    Matrix3 columns;
    columns << corner(1, place.height) - origin, corner(2, place.height) - origin,
        (1 - place.u - place.v) * directors[0] + place.u * directors[1] + place.v * directors[2];
    return columns;
  }
  Vec3 texture(const Place& place) const {
    const Vec2 at = st + place.u * st_u + place.v * st_v;
    return {at.x(), at.y(), place.height};
  }
  Vec3 texture_step(const Vec3& step) const {
    const Vec2 along = step.x() * st_u + step.y() * st_v;
    return {along.x(), along.y(), step.z()};
  }
  // Moves a place to where a ray is, and says how it goes on.
  Vec3 follow(const Ray& ray, double distance, Place& place) const {
    constexpr double k_exact = 1e-6;  // of the triangle's sides and the height
    const Vec3 target = ray.at(distance);
    Matrix3 inverse = jacobian(place).inverse();
    for (int round = 0; round < 4; ++round) {
      const Vec3 off = inverse * (target - point(place));
      if (!off.allFinite()) break;
      // Far from the solution a full step may leave the prism by much.
      const double damping = std::min(1.0, 0.5 / std::max(off.cwiseAbs().maxCoeff(), 1e-300));
      place.u += damping * off.x();
      place.v += damping * off.y();
      place.height += damping * off.z();
      inverse = jacobian(place).inverse();
      if (off.cwiseAbs().maxCoeff() < k_exact) break;
    }
    return inverse * ray.direction;
  }
};

// A part of a ray inside of a prism.
struct VolumeLook::Passage {
  double from = 0, to = 0;
  Place start;
  enum class Side { wall, border, bottom, top } side = Side::wall;  // through which it comes in
};

// What a ray sees of the texture.
struct VolumeLook::Choice {
  bool is_matter;
  int level;
};

VolumeLook::VolumeLook(const PlacedVolume& placed, const Vec3& center, double scale)
    : texture_(placed.textured.texture),
      is_inward_(placed.textured.side == ShellSide::interior),
      color_(placed.color),
      view_(placed.view) {
  const ShellLayer& layer = placed.textured.layer();
  const PolygonSoup& base = placed.textured.shell->base;
  for (std::size_t v = 0; v < base.positions.size(); ++v) {
    bottoms_.push_back((base.positions[v] - center) * scale);
    directors_.push_back((layer.tops[v] - base.positions[v]) * scale);
  }
  triangles_ = base.corner_vertices;
  for (const Vec2& uv : base.corner_uvs) places_.push_back(placed.textured.coordinates.of(uv));
  borders_.resize(n_primitives());
  for (const Index corner : find_open_sides(base.positions.size(), triangles_))
    borders_[corner / 3] = static_cast<std::uint8_t>(borders_[corner / 3] | (1u << (corner % 3)));
  for (const VolumeTexture& level : texture_->surfaces) slopes_.push_back(steepest_slopes(level));
  if (view_) view_->eye = (view_->eye - center) * scale;
  set_frames();
  set_texels();
}

void VolumeLook::Frame::add(float weight, const Frame& other) {
  bottom_s += weight * other.bottom_s;
  bottom_t += weight * other.bottom_t;
  top_s += weight * other.top_s;
  top_t += weight * other.top_t;
}

void VolumeLook::Frame::scale(float factor) {
  for (Vec3f* column : {&bottom_s, &bottom_t, &top_s, &top_t}) *column *= factor;
}

// Of sums with these weights.
bool VolumeLook::is_alike(const Frame& a, float weight_a, const Frame& b, float weight_b) {
  constexpr float k_share = 0.3f;  // of the length
  const auto near = [&](const Vec3f& x, const Vec3f& y) {
    return (x / weight_a - y / weight_b).norm() <= k_share * (x / weight_a).norm();
  };
  return weight_a > 0 && weight_b > 0 && near(a.bottom_s, b.bottom_s) && near(a.bottom_t, b.bottom_t);
}

void VolumeLook::set_frames() {
  // Corners of a vertex with the same texture coordinates share a frame: the mean of their triangles' by
  // area.
  std::vector<std::uint32_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t c) { return std::tuple(triangles_[c], places_[c].x(), places_[c].y()); };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::tuple(key(a), a) < std::tuple(key(b), b); });
  std::vector<Frame> of_triangles(n_primitives());
  std::vector<float> areas(n_primitives());
  for (std::uint32_t t = 0; t < n_primitives(); ++t) {
    const Prism prism = this->prism(t);
    const double det = prism.st_u.x() * prism.st_v.y() - prism.st_u.y() * prism.st_v.x();
    if (det == 0) continue;
    const auto along = [&](double height, int axis) {
      const Vec3 u = prism.corner(1, height) - prism.corner(0, height),
                 v = prism.corner(2, height) - prism.corner(0, height);
      return axis == 0 ? Vec3((prism.st_v.y() * u - prism.st_u.y() * v) / det)
                       : Vec3((prism.st_u.x() * v - prism.st_v.x() * u) / det);
    };
    of_triangles[t] = {along(0, 0).cast<float>(), along(0, 1).cast<float>(), along(1, 0).cast<float>(),
                       along(1, 1).cast<float>()};
    areas[t] = static_cast<float>(
        (prism.bottoms[1] - prism.bottoms[0]).cross(prism.bottoms[2] - prism.bottoms[0]).norm());
  }
  // Groups of a vertex, one after the other.
  struct Group {
    std::size_t first, last;  // in `order`
    Frame sum;
    float weight = 0;
  };
  std::vector<Group> groups;
  frames_.resize(triangles_.size());
  for (std::size_t first = 0, last = 0; first < order.size(); first = last) {
    groups.clear();
    const std::uint32_t vertex = triangles_[order[first]];
    for (; last < order.size() && triangles_[order[last]] == vertex; ++last) {
      if (groups.empty() || key(order[groups.back().first]) != key(order[last]))
        groups.push_back({last, last, {}});
      const std::uint32_t t = order[last] / 3;
      groups.back().sum.add(areas[t], of_triangles[t]);
      groups.back().weight += areas[t];
      groups.back().last = last + 1;
    }
    for (const Group& group : groups) {
      Frame frame = group.sum;
      float weight = group.weight;
      for (const Group& other : groups) {
        // A seam that the texture goes on across, as where it closes around a body.
        if (&other == &group || !is_alike(group.sum, group.weight, other.sum, other.weight)) continue;
        frame.add(1, other.sum);
        weight += other.weight;
      }
      if (weight > 0) frame.scale(1 / weight);
      for (std::size_t i = group.first; i < group.last; ++i) frames_[order[i]] = frame;
    }
  }
}

void VolumeLook::set_texels() {
  const std::array<int, 3>& size = texture_->surfaces.front().size;
  for (std::uint32_t t = 0; t < n_primitives(); ++t) {
    const Prism prism = this->prism(t);
    const double area =
        (prism.bottoms[1] - prism.bottoms[0]).cross(prism.bottoms[2] - prism.bottoms[0]).norm();
    const double texels =
        std::abs(prism.st_u.x() * prism.st_v.y() - prism.st_u.y() * prism.st_v.x()) * size[0] * size[1];
    const double side = texels > 0 ? std::sqrt(area / texels) : std::sqrt(area);
    double height = 0;
    for (const Vec3& director : prism.directors) height += director.norm() / 3;
    footprints_.push_back(static_cast<float>(side));
    texels_.push_back(static_cast<float>(std::min(side, height / size[2])));
  }
}

VolumeLook::Prism VolumeLook::prism(std::uint32_t primitive) const {
  Prism prism;
  prism.primitive = primitive;
  for (std::size_t k = 0; k < 3; ++k) {
    prism.vertices[k] = triangles_[3 * primitive + k];
    prism.bottoms[k] = bottoms_[prism.vertices[k]];
    prism.directors[k] = directors_[prism.vertices[k]];
  }
  prism.st = places_[3 * primitive];
  prism.st_u = places_[3 * primitive + 1] - prism.st;
  prism.st_v = places_[3 * primitive + 2] - prism.st;
  return prism;
}

Box3 VolumeLook::bounds(std::uint32_t primitive) const {
  const Prism prism = this->prism(primitive);
  Box3 box;
  for (std::size_t k = 0; k < 3; ++k) box.extend(prism.corner(k, 0)).extend(prism.corner(k, 1));
  return box;
}

int VolumeLook::find_passages(const Prism& prism, const Ray& ray, std::array<Passage, 6>& passages) const {
  struct Meeting {
    double distance;
    bool enters;
    Place place;
    Passage::Side side;
  };
  std::array<Meeting, 10> meetings;
  std::size_t n = 0;
  const PatchRay line(ray.origin, ray.direction);
  const double turned = is_inward_ ? -1 : 1;
  const auto add = [&](const BilinearPatch& patch, double outwards, Passage::Side side, auto&& place_of) {
    const PatchHits hits = line.all_hits(patch);
    for (int h = 0; h < hits.count; ++h) {
      const PatchHit& hit = hits.hits[static_cast<std::size_t>(h)];
      const Vec3 normal = patch.derivative_u(hit.v).cross(patch.derivative_v(hit.u));
      meetings[n++] = {hit.t, outwards * turned * normal.dot(ray.direction) < 0, place_of(hit), side};
    }
  };
  for (std::size_t k = 0; k < 3; ++k) {
    // From the lower to the higher vertex, so that both prisms at a wall see the same one.
    const std::size_t next = (k + 1) % 3;
    const bool is_along = prism.vertices[k] < prism.vertices[next];
    const std::size_t low = is_along ? k : next, high = is_along ? next : k;
    const BilinearPatch wall{prism.corner(low, 0), prism.corner(high, 0), prism.corner(low, 1),
                             prism.corner(high, 1)};
    const bool is_border = ((borders_[prism.primitive] >> k) & 1) != 0;
    add(wall, is_along ? 1 : -1, is_border ? Passage::Side::border : Passage::Side::wall,
        [&](const PatchHit& hit) {
          std::array<double, 3> weights{0, 0, 0};
          weights[low] = 1 - hit.u;
          weights[high] = hit.u;
          return Place{weights[1], weights[2], hit.v};
        });
  }
  for (const double height : {0.0, 1.0}) {
    const BilinearPatch end{prism.corner(0, height), prism.corner(1, height), prism.corner(2, height),
                            prism.corner(2, height)};
    add(end, height > 0 ? 1 : -1, height > 0 ? Passage::Side::top : Passage::Side::bottom,
        [&](const PatchHit& hit) {
          return Place{(1 - hit.v) * hit.u, hit.v, height};
        });
  }
  std::sort(meetings.begin(), meetings.begin() + static_cast<std::ptrdiff_t>(n),
            [](const Meeting& a, const Meeting& b) {
              return std::tuple(a.distance, !a.enters) < std::tuple(b.distance, !b.enters);
            });
  int count = 0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!meetings[i].enters || meetings[i + 1].enters) continue;
    if (count < 6)
      passages[static_cast<std::size_t>(count++)] = {meetings[i].distance, meetings[i + 1].distance,
                                                     meetings[i].place, meetings[i].side};
  }
  return count;
}

VolumeLook::Choice VolumeLook::choose(std::uint32_t primitive, const Ray& ray, double distance) const {
  if (!view_) return {false, 0};
  const double pixel = view_->pixel_angle * (ray.at(distance) - view_->eye).norm();
  const double level =
      std::log2(std::max(pixel, 1e-30) / std::max(static_cast<double>(footprints_[primitive]), 1e-30)) +
      lot(ray.key, 1);
  const int whole = static_cast<int>(std::floor(std::clamp(level, 0.0, 64.0)));
  if (whole < texture_->first_transparent()) return {false, whole};
  return {true, std::min(whole - texture_->first_transparent(),
                         static_cast<int>(texture_->transparent.size()) - 1)};
}

Matrix3 VolumeLook::smooth_frame(const Prism& prism, const Place& place) const {
  const std::array<double, 3> weights{1 - place.u - place.v, place.u, place.v};
  Matrix3 frame = Matrix3::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Frame& corner = frames_[3 * prism.primitive + k];
    frame.col(0) += weights[k] * ((1 - place.height) * corner.bottom_s.cast<double>() +
                                  place.height * corner.top_s.cast<double>());
    frame.col(1) += weights[k] * ((1 - place.height) * corner.bottom_t.cast<double>() +
                                  place.height * corner.top_t.cast<double>());
    frame.col(2) += weights[k] * prism.directors[k];
  }
  return frame;
}

namespace {

// Of a function of places with this gradient, in space: any length.
Vec3 turned_to_space(const Matrix3& frame, const Vec3& gradient) {
  const Vec3 s = frame.col(0), t = frame.col(1), r = frame.col(2);
  const Vec3 sum = gradient.x() * t.cross(r) + gradient.y() * r.cross(s) + gradient.z() * s.cross(t);
  return s.dot(t.cross(r)) < 0 ? Vec3(-sum) : sum;
}

}  // namespace

Vec3f VolumeLook::outward(const Prism& prism, const Place& place, const Vec3& gradient) const {
  Vec3 normal = -turned_to_space(smooth_frame(prism, place), gradient);
  if (!(normal.squaredNorm() > 0)) return end_normal(prism, place, 1);
  return normal.stableNormalized().cast<float>();
}

// Of the layer's end at the surface or the tops.
Vec3f VolumeLook::end_normal(const Prism& prism, const Place& place, double height) const {
  const Matrix3 frame = smooth_frame(prism, {place.u, place.v, height});
  Vec3 normal = frame.col(0).cross(frame.col(1));
  const Vec3 flat = (prism.corner(1, height) - prism.corner(0, height))
                        .cross(prism.corner(2, height) - prism.corner(0, height));
  if (!(normal.squaredNorm() > 0)) normal = flat;
  // Texture coordinates may be mirrored; the triangle never is.
  if (normal.dot(flat) < 0) normal = -normal;
  const bool is_outside = (height > 0) != is_inward_;
  return (is_outside ? normal : Vec3(-normal)).stableNormalized().cast<float>();
}

void VolumeLook::set_crossing(const Place& place, double distance, Crossing& crossing) const {
  crossing.distance = distance;
  crossing.u = static_cast<float>(place.u);
  crossing.v = static_cast<float>(place.v);
}

bool VolumeLook::meet_surface(const Prism& prism, const Ray& ray, const Passage& passage, int level,
                              double least, double most, Crossing& crossing) const {
  const VolumeTexture& texture = texture_->surfaces[static_cast<std::size_t>(level)];
  const Vec3& slopes = slopes_[static_cast<std::size_t>(level)];
  const Vec3 size(texture.size[0], texture.size[1], texture.size[2]);
  // A ray that starts inside starts at a surface, which it mustn't meet at once.
  const bool starts_inside = passage.from < least;
  double distance = std::max(passage.from, least);
  Place place = passage.start;
  Vec3 step = prism.follow(ray, distance, place);
  bool was_outside = false;
  double before = distance, opacity_before = 0;
  constexpr int k_most_steps = 100'000;
  for (int n = 0; n < k_most_steps; ++n) {
    const double opacity = sampled_opacity(texture, prism.texture(place));
    if (opacity >= 0.5 && was_outside) {
      double near = before, far = distance, below = opacity_before - 0.5, above = opacity - 0.5;
      for (int round = 0; round < 5 && above > 0; ++round) {
        distance = near + (far - near) * below / (below - above);
        prism.follow(ray, distance, place);
        const double off = sampled_opacity(texture, prism.texture(place)) - 0.5;
        if (off >= 0) {
          far = distance;
          above = off;
          below /= 2;
        } else {
          near = distance;
          below = off;
          above /= 2;
        }
        if (std::abs(off) < 1e-4) break;
      }
      if (distance >= most) return false;
      set_crossing(place, distance, crossing);
      crossing.front = outward(prism, place, opacity_gradient(texture, prism.texture(place)));
      return true;
    }
    if (opacity >= 0.5 && n == 0 && !starts_inside) {
      if (distance >= most) return false;
      set_crossing(place, distance, crossing);
      if (passage.side == Passage::Side::bottom || passage.side == Passage::Side::top) {
        crossing.front = end_normal(prism, place, passage.side == Passage::Side::top ? 1 : 0);
      } else if (passage.side == Passage::Side::border) {
        crossing.front = -ray.direction.cast<float>();
      } else {
        crossing.front = outward(prism, place, opacity_gradient(texture, prism.texture(place)));
      }
      return true;
    }
    if (opacity < 0.5) was_outside = true;
    if (distance >= passage.to || distance >= most) return false;
    const Vec3 texels = prism.texture_step(step).cwiseProduct(size).cwiseAbs();
    const double fastest = texels.maxCoeff(), rate = texels.dot(slopes);
    double length = fastest > 0 ? 0.5 / fastest : passage.to - distance;
    // As opacity changes by no more, nothing is missed.
    if (opacity < 0.5 && rate > 0) length = std::max(length, (0.5 - opacity) / rate);
    if (opacity < 0.5 && rate == 0) length = passage.to - distance;
    before = distance;
    opacity_before = opacity;
    const bool is_last = !(length < passage.to - distance);
    if (is_last) length = passage.to - distance;
    distance = is_last ? passage.to : distance + length;
    place.u += length * step.x();
    place.v += length * step.y();
    place.height += length * step.z();
    step = prism.follow(ray, distance, place);
  }
  return false;
}

bool VolumeLook::meet_matter(const Prism& prism, const Ray& ray, const Passage& passage, const Choice& choice,
                             double least, double most, Crossing& crossing) const {
  const TransparentVolume& matter = texture_->transparent[static_cast<std::size_t>(choice.level)];
  const VolumeTexture& finest = texture_->surfaces.front();
  const Vec3 size(matter.size[0], matter.size[1], matter.size[2]);
  // Where between texels a ray passes is drawn by lot, which means are linear between texels for.
  const Vec3 shift((lot(ray.key, 2) - 0.5) / size.x(), (lot(ray.key, 3) - 0.5) / size.y(), 0);
  const double stop = lot(ray.key, 4 + static_cast<std::uint64_t>(prism.primitive));
  double distance = std::max(passage.from, least);
  Place place = passage.start;
  Vec3 step = prism.follow(ray, distance, place);
  MatterPath path(matter, finest);
  constexpr int k_most_steps = 100'000;
  for (int n = 0; n < k_most_steps && distance < passage.to && distance < most; ++n) {
    const Vec3 texture_step = prism.texture_step(step), texels = texture_step.cwiseProduct(size);
    const double rate = texels.norm();
    const bool is_last = !(MatterPath::k_step < rate * (passage.to - distance));
    const double length = is_last ? passage.to - distance : MatterPath::k_step / rate;
    // The middle of the step stands for it.
    distance += length / 2;
    place.u += length / 2 * step.x();
    place.v += length / 2 * step.y();
    place.height += length / 2 * step.z();
    step = prism.follow(ray, distance, place);
    const double stopped = path.advance(prism.texture(place) + shift, length * texture_step);
    const MatterCorrection correction = matter.correction_along(path.direction());
    if (1 - std::pow(1 - stopped, correction.density) > stop) {
      if (distance >= most) return false;
      set_crossing(place, distance, crossing);
      const Vec3 mean = correction.normal +
                        mean_normal_along(normal_matrix(matter.normals[path.texel()]), path.direction());
      const Vec3 normal = turned_to_space(smooth_frame(prism, place), mean.cwiseProduct(finest.extent));
      if (normal.squaredNorm() > 0)
        crossing.front = (mean.norm() * normal.stableNormalized()).cast<float>();
      else
        crossing.front = -ray.direction.cast<float>();
      return true;
    }
    if (is_last) break;
    distance += length / 2;
    place.u += length / 2 * step.x();
    place.v += length / 2 * step.y();
    place.height += length / 2 * step.z();
  }
  return false;
}

bool VolumeLook::first_crossing(std::uint32_t primitive, const Vec3f& origin, const Vec3f& direction,
                                double least, double most, Crossing& crossing) const {
  const Prism prism = this->prism(primitive);
  const Ray ray{origin.cast<double>(), direction.cast<double>(), key_of(origin, direction)};
  std::array<Passage, 6> passages;
  const int count = find_passages(prism, ray, passages);
  for (int p = 0; p < count; ++p) {
    const Passage& passage = passages[static_cast<std::size_t>(p)];
    if (passage.to <= least || passage.from >= most) continue;
    const Choice choice = choose(primitive, ray, std::max(passage.from, least));
    if (choice.is_matter ? meet_matter(prism, ray, passage, choice, least, most, crossing)
                         : meet_surface(prism, ray, passage, choice.level, least, most, crossing))
      return true;
  }
  return false;
}

namespace {

Rgb linear_color(const Vec3& bytes) {
  return Rgb(bytes
                 .unaryExpr([](double byte) {
                   return static_cast<double>(decode_srgb(static_cast<float>(byte) / 255.0f));
                 })
                 .cast<float>());
}

Vec3 number_of(const std::array<std::uint8_t, 3>& bytes) {
  return {bytes[0] * 1.0, bytes[1] * 1.0, bytes[2] * 1.0};
}

}  // namespace

Rgb VolumeLook::color_at(const Hit& hit, const Vec3f& direction) const {
  const VolumeTexture& finest = texture_->surfaces.front();
  if (finest.colors.empty()) return color_;
  const Prism prism = this->prism(hit.part.primitive);
  const Ray ray{hit.origin.cast<double>(), direction.cast<double>(), key_of(hit.origin, direction)};
  const auto distance = static_cast<double>(hit.distance);
  Place place{static_cast<double>(hit.u), static_cast<double>(hit.v), 0};
  const Vec3 bottom = prism.point(place), director = prism.jacobian(place).col(2);
  place.height = std::clamp((ray.at(distance) - bottom).dot(director) / director.squaredNorm(), 0.0, 1.0);
  const Choice choice = choose(hit.part.primitive, ray, distance);
  if (choice.is_matter) {
    const TransparentVolume& matter = texture_->transparent[static_cast<std::size_t>(choice.level)];
    return linear_color(number_of(matter.colors[matter.texel_at(prism.texture(place), finest.is_periodic)]));
  }
  const VolumeTexture& surface = texture_->surfaces[static_cast<std::size_t>(choice.level)];
  const VolumeCell cell = volume_cell(surface.size, surface.is_periodic, prism.texture(place));
  return linear_color(cell.blend([&](std::size_t texel) { return number_of(surface.colors[texel]); }));
}

namespace {

void bound_prism(const RTCBoundsFunctionArguments* arguments) {
  const auto& look = *static_cast<const VolumeLook*>(arguments->geometryUserPtr);
  const Box3 box = look.bounds(arguments->primID);
  constexpr double k_pad = 1e-6;  // for the rounding to float
  const Vec3f low = (box.min().array() - k_pad).cast<float>(),
              high = (box.max().array() + k_pad).cast<float>();
  RTCBounds& bounds = *arguments->bounds_o;
  bounds.lower_x = low.x();
  bounds.lower_y = low.y();
  bounds.lower_z = low.z();
  bounds.upper_x = high.x();
  bounds.upper_y = high.y();
  bounds.upper_z = high.z();
}

bool cross(const VolumeLook& look, unsigned primitive, RTCRayN* rays, unsigned n, unsigned k,
           VolumeLook::Crossing& crossing) {
  const Vec3f origin(RTCRayN_org_x(rays, n, k), RTCRayN_org_y(rays, n, k), RTCRayN_org_z(rays, n, k)),
      direction(RTCRayN_dir_x(rays, n, k), RTCRayN_dir_y(rays, n, k), RTCRayN_dir_z(rays, n, k));
  return look.first_crossing(primitive, origin, direction, static_cast<double>(RTCRayN_tnear(rays, n, k)),
                             static_cast<double>(RTCRayN_tfar(rays, n, k)), crossing);
}

void intersect_prism(const RTCIntersectFunctionNArguments* arguments) {
  const auto& look = *static_cast<const VolumeLook*>(arguments->geometryUserPtr);
  const unsigned n = arguments->N;
  RTCRayN* rays = RTCRayHitN_RayN(arguments->rayhit, n);
  RTCHitN* hits = RTCRayHitN_HitN(arguments->rayhit, n);
  for (unsigned k = 0; k < n; ++k) {
    VolumeLook::Crossing crossing;
    if (arguments->valid[k] == 0 || !cross(look, arguments->primID, rays, n, k, crossing)) continue;
    RTCRayN_tfar(rays, n, k) = static_cast<float>(crossing.distance);
    RTCHitN_u(hits, n, k) = crossing.u;
    RTCHitN_v(hits, n, k) = crossing.v;
    RTCHitN_primID(hits, n, k) = arguments->primID;
    RTCHitN_geomID(hits, n, k) = arguments->geomID;
    RTCHitN_instID(hits, n, k, 0) = arguments->context->instID[0];
    RTCHitN_Ng_x(hits, n, k) = crossing.front.x();
    RTCHitN_Ng_y(hits, n, k) = crossing.front.y();
    RTCHitN_Ng_z(hits, n, k) = crossing.front.z();
  }
}

void occlude_prism(const RTCOccludedFunctionNArguments* arguments) {
  const auto& look = *static_cast<const VolumeLook*>(arguments->geometryUserPtr);
  for (unsigned k = 0; k < arguments->N; ++k) {
    VolumeLook::Crossing crossing;
    if (arguments->valid[k] != 0 && cross(look, arguments->primID, arguments->ray, arguments->N, k, crossing))
      RTCRayN_tfar(arguments->ray, arguments->N, k) = -std::numeric_limits<float>::infinity();
  }
}

}  // namespace

RTCGeometry volume_geometry(RTCDevice device, const VolumeLook& look) {
  const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(look.n_primitives()));
  rtcSetGeometryUserData(geometry, const_cast<VolumeLook*>(&look));
  rtcSetGeometryBoundsFunction(geometry, bound_prism, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_prism);
  rtcSetGeometryOccludedFunction(geometry, occlude_prism);
  rtcCommitGeometry(geometry);
  return geometry;
}

}  // namespace detail

}  // namespace recede
