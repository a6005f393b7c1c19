// What a camera's rays meet, and the method by which each is shaded.
#pragma once

#include <recede/render/camera.h>
#include <recede/render/detail/appearance_look.h>
#include <recede/render/detail/tracing.h>
#include <recede/render/renderer.h>

#include <array>
#include <optional>

namespace recede::detail {

struct SeenSurface {
  bool is_there = false;
  Hit hit = {};
  /// Of a surface with appearances; unset for others.
  std::optional<RenderingTransition> transition = {};
  MethodShares shares = {};
};

/// Rays meet the base first. Those that are so near that heights might be seen as such look for the envelope
/// of all heights before it, which chooses the method: so none that could be hit is missed. Displacement then
/// needs another ray, to the heights. Where all is too far or too near for a choice, the base or the heights
/// are enough.
class SeenSurfaces {
 public:
  /// The scene must live as long as this. Throws `OptionError` for transitions that can't be.
  SeenSurfaces(const SceneData& scene, const CameraFrame& frame, const RenderOptions& options);

  using Block = std::array<SeenSurface, k_lanes>;
  /// The surfaces that the packet's active rays meet.
  void find(const RayPacket& packet, Block& seen) const;

 private:
  struct Lanes;
  RenderingTransition transition_at(const Hit& hit, const Vec3f& direction, double to_origin) const;
  MethodShares shares_beside(double distance) const;
  bool is_appearance(const Hit& hit) const { return look_ != nullptr && hit.part.object == object_; }

  void find_hits(const RayPacket& packet, const Lanes& lanes, const RayTarget& target, Block& seen) const;
  void find_displaced(const RayPacket& packet, const Lanes& lanes, const RenderingTransition& transition,
                      Block& seen) const;
  void find_on_base(const RayPacket& packet, const Lanes& lanes, Block& seen) const;
  void find_by_method(const RayPacket& packet, Block& seen) const;
  using Distances = std::array<float, k_lanes>;
  void choose_by_envelope(const RayPacket& packet, const Lanes& lanes, Block& seen, Distances& entries) const;
  void find_growing(const RayPacket& packet, const Lanes& lanes, Block& seen) const;
  bool next_on_envelope(const Hit& before, const Vec3f& direction, Hit& next) const;
  void follow(const RayPacket& packet, int lane, SeenSurface& surface) const;

  const SceneData& scene_;
  Representation representation_;
  const AppearanceLook* look_ = nullptr;  // of the displaced surface; null: all is drawn as it is
  std::uint32_t object_ = 0;              // its number
  float span_ = 0;                        // of its heights, scaled scene
  TransitionOptions transition_;
  // Nearer than the first all is displaced, and nothing beyond the second; object units.
  double near_ = 0, far_ = 0;
};

}  // namespace recede::detail
