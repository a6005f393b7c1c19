// The one Embree device of the process.
#pragma once

#include <embree3/rtcore.h>

#include <string>

namespace recede::detail {

/// Devices are costly to make and hold no state of a scene. Throws `Error` when Embree doesn't start.
RTCDevice embree_device();

/// Throws `Error` when the calling thread's last call to Embree failed; `doing` says what it was.
void throw_on_embree_error(RTCDevice device, const std::string& doing);

}  // namespace recede::detail
