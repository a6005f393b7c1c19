// Where rays meet what is in a cell.
#include <recede/geometry/bilinear_patch.h>
#include <recede/geometry/detail/hashed_number.h>
#include <recede/render/detail/volume_look.h>
#include <recede/shells/detail/matter_path.h>
#include <recede/shells/detail/volume_sampler.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace recede::detail {

using Vec3f = Eigen::Vector3f;
using Matrix3 = Eigen::Matrix3d;

Vec3 LayerCell::follow(const VolumeRay& ray, double distance, CellPlace& place) const {
  constexpr double k_exact = 1e-6;  // of the face's sides and the height
  const Vec3 target = ray.at(distance);
  Matrix3 inverse = jacobian(place).inverse();
  for (int round = 0; round < 4; ++round) {
    const Vec3 off = inverse * (target - point(place));
    if (!off.allFinite()) break;
    // Far from the solution a full step may leave the cell by much.
    const double damping = std::min(1.0, 0.5 / std::max(off.cwiseAbs().maxCoeff(), 1e-300));
    place.u += damping * off.x();
    place.v += damping * off.y();
    place.height += damping * off.z();
    inverse = jacobian(place).inverse();
    if (off.cwiseAbs().maxCoeff() < k_exact) break;
  }
  return inverse * ray.direction;
}

int VolumeLook::find_passages(const LayerCell& cell, const VolumeRay& ray, CellPassages& passages) const {
  struct Meeting {
    double distance;
    bool enters;
    CellPlace place;
    CellPassage::Side side;
  };
  std::array<Meeting, 12> meetings;
  std::size_t n = 0;
  const PatchRay line(ray.origin, ray.direction);
  const double turned = is_inward_ ? -1 : 1;
  const auto add = [&](const BilinearPatch& patch, double outwards, CellPassage::Side side, auto&& place_of) {
    const PatchHits hits = line.all_hits(patch);
    for (int h = 0; h < hits.count; ++h) {
      const PatchHit& hit = hits.hits[static_cast<std::size_t>(h)];
      const Vec3 normal = patch.derivative_u(hit.v).cross(patch.derivative_v(hit.u));
      meetings[n++] = {hit.t, outwards * turned * normal.dot(ray.direction) < 0, place_of(hit), side};
    }
  };
  for (std::size_t k = 0; k < cell.n_corners; ++k) {
    // From the lower to the higher vertex, so that both cells at a wall see the same one.
    const std::size_t next = (k + 1) % cell.n_corners;
    const bool is_along = cell.vertices[k] < cell.vertices[next];
    const std::size_t low = is_along ? k : next, high = is_along ? next : k;
    const BilinearPatch wall{cell.corner(low, 0), cell.corner(high, 0), cell.corner(low, 1),
                             cell.corner(high, 1)};
    const bool is_border = ((borders_[cell.primitive] >> k) & 1) != 0;
    const FacePlace from = corner_place(cell.n_corners, low), to = corner_place(cell.n_corners, high);
    add(wall, is_along ? 1 : -1, is_border ? CellPassage::Side::border : CellPassage::Side::wall,
        [&](const PatchHit& hit) {
          const double left = 1 - hit.u;
          return CellPlace{{left * from.u + hit.u * to.u, left * from.v + hit.u * to.v}, hit.v};
        });
  }
  // A triangle is a patch whose last side has no length.
  const bool is_triangle = cell.n_corners == 3;
  for (const double height : {0.0, 1.0}) {
    const BilinearPatch end{cell.corner(0, height), cell.corner(1, height),
                            cell.corner(is_triangle ? 2 : 3, height), cell.corner(2, height)};
    add(end, height > 0 ? 1 : -1, height > 0 ? CellPassage::Side::top : CellPassage::Side::bottom,
        [&](const PatchHit& hit) {
          return CellPlace{{is_triangle ? (1 - hit.v) * hit.u : hit.u, hit.v}, height};
        });
  }
  std::sort(meetings.begin(), meetings.begin() + static_cast<std::ptrdiff_t>(n),
            [](const Meeting& a, const Meeting& b) {
              return std::tuple(a.distance, !a.enters) < std::tuple(b.distance, !b.enters);
            });
  int count = 0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (!meetings[i].enters || meetings[i + 1].enters) continue;
    passages[static_cast<std::size_t>(count++)] = {meetings[i].distance, meetings[i + 1].distance,
                                                   meetings[i].place, meetings[i].side};
  }
  return count;
}

Matrix3 VolumeLook::smooth_frame(const LayerCell& cell, const CellPlace& place) const {
  const FaceWeights weights = weights_at(cell.n_corners, place);
  Matrix3 frame = Matrix3::Zero();
  for (std::size_t k = 0; k < cell.n_corners; ++k) {
    const Frame& corner = frames_[cells_[cell.primitive].corners[k]];
    frame.col(0) += weights[k] * ((1 - place.height) * corner.bottom_s.cast<double>() +
                                  place.height * corner.top_s.cast<double>());
    frame.col(1) += weights[k] * ((1 - place.height) * corner.bottom_t.cast<double>() +
                                  place.height * corner.top_t.cast<double>());
    frame.col(2) += weights[k] * cell.directors[k];
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

Vec3f VolumeLook::outward(const LayerCell& cell, const CellPlace& place, const Vec3& gradient) const {
  Vec3 normal = -turned_to_space(smooth_frame(cell, place), gradient);
  if (!(normal.squaredNorm() > 0)) return end_normal(cell, place, 1);
  return normal.stableNormalized().cast<float>();
}

// Of the layer's end at the surface or the tops.
Vec3f VolumeLook::end_normal(const LayerCell& cell, const CellPlace& place, double height) const {
  const Matrix3 frame = smooth_frame(cell, {{place.u, place.v}, height});
  Vec3 normal = frame.col(0).cross(frame.col(1));
  const Vec3 flat = cell.normal(height);
  if (!(normal.squaredNorm() > 0)) normal = flat;
  // Texture coordinates may be mirrored; the face never is.
  if (normal.dot(flat) < 0) normal = -normal;
  const bool is_outside = (height > 0) != is_inward_;
  return (is_outside ? normal : Vec3(-normal)).stableNormalized().cast<float>();
}

void VolumeLook::set_crossing(const CellPlace& place, double distance, Crossing& crossing) const {
  crossing.distance = distance;
  crossing.u = static_cast<float>(place.u);
  crossing.v = static_cast<float>(place.v);
}

namespace {

struct OpacityOnRay {
  double distance, opacity;
};

/// Regula falsi (Illinois) between a place outside and one inside: the distance of the surface, and its
/// place.
double narrow(const LayerCell& cell, const VolumeRay& ray, const VolumeTexture& texture, OpacityOnRay outside,
              OpacityOnRay inside, CellPlace& place) {
  constexpr int k_rounds = 5;
  constexpr double k_exact = 1e-4;  // a fortieth of a step of opacity
  double distance = inside.distance, below = outside.opacity - 0.5, above = inside.opacity - 0.5;
  for (int round = 0; round < k_rounds && above > 0; ++round) {
    distance = outside.distance + (inside.distance - outside.distance) * below / (below - above);
    cell.follow(ray, distance, place);
    const double off = sampled_opacity(texture, cell.texture(place)) - 0.5;
    if (off >= 0) {
      inside.distance = distance;
      above = off;
      below /= 2;
    } else {
      outside.distance = distance;
      below = off;
      above /= 2;
    }
    if (std::abs(off) < k_exact) break;
  }
  return distance;
}

}  // namespace

// Where a ray comes in, matter may reach the cell's side: the layer ends there, or goes on in the cell
// beside.
Vec3f VolumeLook::entry_normal(const LayerCell& cell, const VolumeRay& ray, CellPassage::Side side,
                               const VolumeTexture& texture, const CellPlace& place) const {
  switch (side) {
    case CellPassage::Side::bottom:
      return end_normal(cell, place, 0);
    case CellPassage::Side::top:
      return end_normal(cell, place, 1);
    case CellPassage::Side::border:
      return -ray.direction.cast<float>();
    case CellPassage::Side::wall:
      break;
  }
  return outward(cell, place, opacity_gradient(texture, cell.texture(place)));
}

bool VolumeLook::meet_surface(const LayerCell& cell, const VolumeRay& ray, const CellPassage& passage,
                              int level, double least, double most, Crossing& crossing) const {
  const VolumeTexture& texture = texture_->surfaces[static_cast<std::size_t>(level)];
  const Vec3& slopes = slopes_[static_cast<std::size_t>(level)];
  const EmptyRegions& empty = empty_[static_cast<std::size_t>(level)];
  const Vec3 size(texture.size[0], texture.size[1], texture.size[2]);
  // A ray that starts inside starts at a surface, which it mustn't meet at once.
  const bool starts_inside = passage.from < least;
  double distance = std::max(passage.from, least);
  CellPlace place = passage.start;
  Vec3 step = cell.follow(ray, distance, place);
  bool was_outside = false;
  double before = distance, opacity_before = 0;
  constexpr int k_most_steps = 100'000;
  for (int n = 0; n < k_most_steps; ++n) {
    const double opacity = sampled_opacity(texture, cell.texture(place));
    if (opacity >= 0.5 && was_outside) {
      distance = narrow(cell, ray, texture, {before, opacity_before}, {distance, opacity}, place);
      if (distance >= most) return false;
      set_crossing(place, distance, crossing);
      crossing.front = outward(cell, place, opacity_gradient(texture, cell.texture(place)));
      return true;
    }
    if (opacity >= 0.5 && n == 0 && !starts_inside) {
      if (distance >= most) return false;
      set_crossing(place, distance, crossing);
      crossing.front = entry_normal(cell, ray, passage.side, texture, place);
      return true;
    }
    if (opacity < 0.5) was_outside = true;
    if (distance >= passage.to || distance >= most) return false;
    const Vec3 move = cell.texture_step(place, step), texels = move.cwiseProduct(size).cwiseAbs();
    const double fastest = texels.maxCoeff(), rate = texels.dot(slopes);
    double length = fastest > 0 ? 0.5 / fastest : passage.to - distance;
    // As far as opacity needs to get to a half with the steepest slope that there is.
    if (opacity < 0.5 && rate > 0) length = std::max(length, (0.5 - opacity) / rate);
    if (opacity < 0.5 && rate == 0) length = passage.to - distance;
    // Near to matter there is seldom an empty cube.
    if (opacity < 0.25 && length < passage.to - distance)
      length = std::max(length, empty.free_length(cell.texture(place), move));
    before = distance;
    opacity_before = opacity;
    const bool is_last = !(length < passage.to - distance);
    if (is_last) length = passage.to - distance;
    distance = is_last ? passage.to : distance + length;
    place.u += length * step.x();
    place.v += length * step.y();
    place.height += length * step.z();
    step = cell.follow(ray, distance, place);
  }
  return false;
}

bool VolumeLook::meet_matter(const LayerCell& cell, const VolumeRay& ray, const CellPassage& passage,
                             const Choice& choice, double least, double most, Crossing& crossing) const {
  const TransparentVolume& matter = texture_->transparent[static_cast<std::size_t>(choice.level)];
  const VolumeTexture& finest = texture_->surfaces.front();
  const Vec3 size(matter.size[0], matter.size[1], matter.size[2]);
  // Where between texels a ray passes is drawn by lot, which means are linear between texels for.
  const Vec3 shift((hashed_number(ray.key, 1) - 0.5) / size.x(), (hashed_number(ray.key, 2) - 0.5) / size.y(),
                   0);
  const double stop = hashed_number(ray.key, 3 + std::uint64_t{cell.primitive});
  double distance = std::max(passage.from, least);
  CellPlace place = passage.start;
  Vec3 step = cell.follow(ray, distance, place);
  MatterPath path(matter, finest);
  constexpr int k_most_steps = 100'000;
  for (int n = 0; n < k_most_steps && distance < passage.to && distance < most; ++n) {
    const Vec3 texture_step = cell.texture_step(place, step), texels = texture_step.cwiseProduct(size);
    const double rate = texels.norm();
    const bool is_last = !(MatterPath::k_step < rate * (passage.to - distance));
    const double length = is_last ? passage.to - distance : MatterPath::k_step / rate;
    // The middle of the step stands for it.
    distance += length / 2;
    place.u += length / 2 * step.x();
    place.v += length / 2 * step.y();
    place.height += length / 2 * step.z();
    step = cell.follow(ray, distance, place);
    const double stopped = path.advance(cell.texture(place) + shift, length * texture_step);
    const MatterCorrection correction = matter.correction_along(path.direction());
    if (1 - std::pow(1 - stopped, correction.density) > stop) {
      if (distance >= most) return false;
      set_crossing(place, distance, crossing);
      const Vec3 mean = correction.normal +
                        mean_normal_along(normal_matrix(matter.normals.at(path.texel())), path.direction());
      const Vec3 normal = turned_to_space(smooth_frame(cell, place), mean.cwiseProduct(finest.extent));
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

bool VolumeLook::first_crossing(std::uint32_t primitive, const CrossingQuery& query,
                                Crossing& crossing) const {
  const LayerCell cell = this->cell(primitive);
  const VolumeRay ray(query.origin, query.direction);
  const double least = query.least, most = query.most;
  CellPassages passages;
  const int count = find_passages(cell, ray, passages);
  for (int p = 0; p < count; ++p) {
    const CellPassage& passage = passages[static_cast<std::size_t>(p)];
    if (passage.to <= least || passage.from >= most) continue;
    const Choice choice = choose(primitive, ray, std::max(passage.from, least));
    if (choice.is_matter ? meet_matter(cell, ray, passage, choice, least, most, crossing)
                         : meet_surface(cell, ray, passage, choice.level, least, most, crossing))
      return true;
  }
  return false;
}

}  // namespace recede::detail
