#include <recede/render/detail/displaced_look.h>
#include <recede/render/detail/seen_surfaces.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace recede::detail {
namespace {

bool needs_displacement(const RenderingTransition& transition) {
  return transition.method == RenderingMethod::displacement ||
         transition.method == RenderingMethod::bump_to_displacement;
}

/// For what has no heights to show.
void keep_on_base(SeenSurface& surface) {
  if (!surface.transition || !needs_displacement(*surface.transition)) return;
  surface.transition = {RenderingMethod::bump, 0};
  surface.shares = shares_of(*surface.transition);
}

/// An eye on the surface itself has no distance.
double value_at(double distance, double cosine, const TransitionOptions& options) {
  return transition_value(std::max(distance, 1e-300), cosine, options);
}

}  // namespace

/// Some lanes of a packet.
struct SeenSurfaces::Lanes {
  std::array<bool, k_lanes> chosen{};

  static Lanes all() {
    Lanes lanes;
    lanes.chosen.fill(true);
    return lanes;
  }
  bool any() const { return std::find(chosen.begin(), chosen.end(), true) != chosen.end(); }
  bool operator[](int lane) const { return chosen[static_cast<std::size_t>(lane)]; }
  void choose(int lane) { chosen[static_cast<std::size_t>(lane)] = true; }
  /// The packet with these alone.
  RayPacket of(const RayPacket& packet) const {
    RayPacket own = packet;
    for (int lane = 0; lane < k_lanes; ++lane) {
      if (!(*this)[lane]) own.active[lane] = 0;
    }
    return own;
  }
};

SeenSurfaces::SeenSurfaces(const SceneData& scene, const CameraFrame& frame, const RenderOptions& options)
    : scene_(scene), representation_(options.representation) {
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    const std::shared_ptr<const DisplacedLook>& displaced = scene.meshes[i].displaced;
    if (!displaced || !displaced->appearance) continue;
    look_ = &*displaced->appearance;
    object_ = static_cast<std::uint32_t>(i);
    span_ = static_cast<float>(displaced->surface.height_span());
    transition_ = options.transition
                      ? *options.transition
                      : transition_for_wavelength(look_->appearance().wavelength(), frame.pixel);
    near_ = transition_distance(k_transition_values[3], 1, transition_);
    far_ = transition_distance(k_transition_values[2], 0, transition_);
  }
}

void SeenSurfaces::find(const RayPacket& packet, Block& seen) const {
  seen.fill({});
  if (look_ == nullptr || representation_ == Representation::displacement)
    return find_displaced(packet, Lanes::all(), {}, seen);
  if (representation_ != Representation::automatic) return find_on_base(packet, Lanes::all(), seen);
  float nearest = std::numeric_limits<float>::infinity(), farthest = 0;
  for (int lane = 0; lane < k_lanes; ++lane) {
    if (packet.active[lane] == 0) continue;
    nearest = std::min(nearest, packet.entry[lane]);
    farthest = std::max(farthest, packet.entry[lane]);
  }
  if (static_cast<double>(nearest) >= far_ * scene_.scale) {
    find_on_base(packet, Lanes::all(), seen);
    for (SeenSurface& surface : seen) keep_on_base(surface);
    return;
  }
  if (static_cast<double>(farthest) + 2 * scene_.radius <= near_ * scene_.scale)
    return find_displaced(packet, Lanes::all(), {}, seen);
  find_by_method(packet, seen);
}

/// By the base, or by the envelope.
RenderingTransition SeenSurfaces::transition_at(const Hit& hit, const Vec3f& direction,
                                                double to_origin) const {
  if (representation_ == Representation::brdf) return {RenderingMethod::brdf, 0};
  if (representation_ == Representation::bump) return {RenderingMethod::bump, 0};
  // Behind the envelope: the eye lies inside of it, or sees the back of an open surface.
  if (hit.front.dot(direction) > 0) return {};
  const std::uint32_t triangle = scene_.appearances->base_triangle(hit.part.primitive);
  Vec3 weights = Vec3::Constant(1.0 / 3);  // for a strip at a border, the middle of its triangle
  if (triangle == hit.part.primitive) {
    const double u = static_cast<double>(hit.u), v = static_cast<double>(hit.v);
    weights = {1 - u - v, u, v};
  }
  const double cosine = std::min(1.0, -look_->normal_at(triangle, weights).dot(direction.cast<double>()));
  const double distance = (to_origin + static_cast<double>(hit.distance)) / scene_.scale;
  RenderingTransition transition = rendering_transition(value_at(distance, cosine, transition_));
  // In steps too small to be seen, so that neighbouring rays may go together.
  constexpr double k_steps = 32;
  if (transition.method == RenderingMethod::bump_to_displacement)
    transition.progress = std::max(1.0, std::round(transition.progress * k_steps)) / k_steps;
  return transition;
}

/// What rays meet that leave other surfaces: the heights where they would be seen as such at that distance.
MethodShares SeenSurfaces::shares_beside(double distance) const {
  if (look_ == nullptr || representation_ == Representation::displacement) return {};
  const bool is_near = representation_ == Representation::automatic &&
                       value_at(distance, 1, transition_) > k_transition_values[2];
  return {.table = 0, .displaced = is_near ? 1.0 : 0.0};
}

/// Replaces what `seen` has of these lanes by the hits of their rays.
void SeenSurfaces::find_hits(const RayPacket& packet, const Lanes& lanes, const RayTarget& target,
                             Block& seen) const {
  RayPacket own = lanes.of(packet);
  nearest_hits(scene_, own, target);
  for (int lane = 0; lane < k_lanes; ++lane) {
    if (!lanes[lane]) continue;
    SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    surface = {};
    surface.is_there = own.hits(lane);
    if (surface.is_there) surface.hit = own.hit(lane);
  }
}

/// The heights, or the part of them that `transition` says.
void SeenSurfaces::find_displaced(const RayPacket& packet, const Lanes& lanes,
                                  const RenderingTransition& transition, Block& seen) const {
  const MethodShares shares = shares_of(transition);
  find_hits(packet, lanes, {.fraction = static_cast<float>(shares.displaced)}, seen);
  for (int lane = 0; lane < k_lanes; ++lane) {
    SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    if (!lanes[lane] || !surface.is_there) continue;
    surface.shares = shares;
    if (is_appearance(surface.hit)) surface.transition = transition;
  }
}

void SeenSurfaces::find_on_base(const RayPacket& packet, const Lanes& lanes, Block& seen) const {
  find_hits(packet, lanes, {.shape = SurfaceShape::base}, seen);
  for (int lane = 0; lane < k_lanes; ++lane) {
    SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    if (!lanes[lane] || !surface.is_there) continue;
    const auto to_origin = static_cast<double>(packet.entry[lane]);
    if (!is_appearance(surface.hit)) {
      surface.shares = shares_beside((to_origin + static_cast<double>(surface.hit.distance)) / scene_.scale);
      continue;
    }
    surface.transition = transition_at(surface.hit, packet.directions[lane], to_origin);
    surface.shares = shares_of(*surface.transition);
  }
}

void SeenSurfaces::find_by_method(const RayPacket& packet, Block& seen) const {
  find_on_base(packet, Lanes::all(), seen);
  Lanes open;
  Distances entries;  // no farther than that the ray is in the envelope
  for (int lane = 0; lane < k_lanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    const SeenSurface& surface = seen[i];
    entries[i] = surface.is_there ? surface.hit.distance : std::numeric_limits<float>::infinity();
    // What lies before it is nearer still.
    const bool is_displaced =
        surface.transition && surface.transition->method == RenderingMethod::displacement;
    if (packet.active[lane] != 0 && !is_displaced) open.choose(lane);
  }
  if (open.any()) choose_by_envelope(packet, open, seen, entries);
  Lanes displaced, growing;
  for (int lane = 0; lane < k_lanes; ++lane) {
    const SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    if (!surface.transition || !needs_displacement(*surface.transition)) continue;
    (surface.transition->method == RenderingMethod::displacement ? displaced : growing).choose(lane);
  }
  if (displaced.any()) find_displaced(packet, displaced, {}, seen);
  if (growing.any()) find_growing(packet, growing, seen);
  // A ray that goes much farther than heights are deep may have come out again, and met another part of the
  // surface, which has a method of its own.
  constexpr float k_deep = 8;
  for (int lane = 0; lane < k_lanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    if ((displaced[lane] || growing[lane]) && seen[i].hit.distance > entries[i] + k_deep * span_)
      follow(packet, lane, seen[i]);
  }
}

/// What `seen` has of the base stays, but for rays that need the heights.
void SeenSurfaces::choose_by_envelope(const RayPacket& packet, const Lanes& lanes, Block& seen,
                                      Distances& entries) const {
  RayPacket own = lanes.of(packet);
  const auto far = static_cast<float>(far_ * scene_.scale);
  for (int lane = 0; lane < k_lanes; ++lane) {
    const SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    // Beyond, nothing is displaced.
    float& end = own.rays.ray.tfar[lane];
    end = std::min(end, far - packet.entry[lane]);
    if (surface.is_there) end = std::min(end, surface.hit.distance);
    if (!(end > 0)) own.active[lane] = 0;
  }
  nearest_hits(scene_, own, {.shape = SurfaceShape::envelope});
  for (int lane = 0; lane < k_lanes; ++lane) {
    if (!lanes[lane]) continue;
    SeenSurface& surface = seen[static_cast<std::size_t>(lane)];
    std::optional<RenderingTransition> transition;
    if (own.hits(lane) && is_appearance(own.hit(lane))) {
      entries[static_cast<std::size_t>(lane)] = own.hit(lane).distance;
      transition =
          transition_at(own.hit(lane), packet.directions[lane], static_cast<double>(packet.entry[lane]));
    } else if (!surface.is_there && packet.entry[lane] == 0) {
      // An eye near the surface may lie below the envelope of an open one, and see past it.
      transition.emplace();
    }
    if (transition && needs_displacement(*transition)) {
      surface.transition = transition;
      surface.shares = shares_of(*transition);
    } else {
      keep_on_base(surface);  // by the base it would just begin, by the envelope not yet
    }
  }
}

/// A surface that grows out of its base, as far as `seen` has it. Rays for equal parts go together.
void SeenSurfaces::find_growing(const RayPacket& packet, const Lanes& lanes, Block& seen) const {
  Lanes left = lanes;
  while (left.any()) {
    const auto first = static_cast<std::size_t>(std::find(left.chosen.begin(), left.chosen.end(), true) -
                                                left.chosen.begin());
    const RenderingTransition transition = *seen[first].transition;
    Lanes alike;
    for (int lane = 0; lane < k_lanes; ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      if (!left.chosen[i] || seen[i].transition->progress != transition.progress) continue;
      alike.choose(lane);
      left.chosen[i] = false;
    }
    find_displaced(packet, alike, transition, seen);
  }
}

/// The next hit of the envelope beyond one of it. `distance` and `origin` stay those of the ray.
bool SeenSurfaces::next_on_envelope(const Hit& before, const Vec3f& direction, Hit& next) const {
  const Vec3f place = before.origin + before.distance * direction;
  const Ray ray{.origin = place,
                .direction = direction,
                .from = before.part,
                .target = {.shape = SurfaceShape::envelope}};
  if (!nearest_hit(scene_, ray, next) || !is_appearance(next)) return false;
  next.distance += before.distance;
  next.origin = before.origin;
  return true;
}

/// `surface` is what the heights have along the ray. Where the ray leaves the envelope before that and enters
/// it again, the method is that of the place where it does.
void SeenSurfaces::follow(const RayPacket& packet, int lane, SeenSurface& surface) const {
  constexpr int k_most_entries = 8;
  const Vec3f& direction = packet.directions[lane];
  const RTCRay16& from = packet.rays.ray;
  const auto to_origin = static_cast<double>(packet.entry[lane]);
  const Ray whole{.origin = {from.org_x[lane], from.org_y[lane], from.org_z[lane]},
                  .direction = direction,
                  .target = {.shape = SurfaceShape::envelope}};
  Hit entry, exit, next;
  if (!nearest_hit(scene_, whole, entry) || !is_appearance(entry)) return;
  for (int i = 0; i < k_most_entries && surface.is_there && is_appearance(surface.hit); ++i) {
    if (!next_on_envelope(entry, direction, exit) || surface.hit.distance <= exit.distance) return;
    if (!next_on_envelope(exit, direction, next)) return;
    surface.transition = transition_at(next, direction, to_origin);
    surface.shares = shares_of(*surface.transition);
    if (!needs_displacement(*surface.transition)) {
      Lanes alone;
      alone.choose(lane);
      Block seen;
      find_on_base(packet, alone, seen);
      surface = seen[static_cast<std::size_t>(lane)];
      keep_on_base(surface);
      return;
    }
    const Ray ray{.origin = exit.origin + exit.distance * direction,
                  .direction = direction,
                  .target = {.fraction = static_cast<float>(surface.shares.displaced)}};
    surface.is_there = nearest_hit(scene_, ray, surface.hit);
    surface.hit.distance += exit.distance;
    surface.hit.origin = exit.origin;
    if (!is_appearance(surface.hit)) surface.transition.reset();
    entry = next;
  }
}

}  // namespace recede::detail
