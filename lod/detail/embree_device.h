// The one Embree device of the process.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <string>
#include <type_traits>

namespace recede::detail {

/// Devices are costly to make and hold no state of a scene. Throws `Error` when Embree doesn't start.
RTCDevice embree_device();

struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using OwnedScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

/// Throws `Error` when the calling thread's last call to Embree failed; `doing` says what it was.
void throw_on_embree_error(RTCDevice device, const std::string& doing);

}  // namespace recede::detail
