#include <recede/geometry/error.h>
#include <recede/lod/detail/embree_device.h>

#include <string_view>

namespace recede::detail {
namespace {

std::string_view embree_reason(RTCError error) {
  switch (error) {
    case RTC_ERROR_NONE:
      return "no error";
    case RTC_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    case RTC_ERROR_INVALID_OPERATION:
      return "invalid operation";
    case RTC_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case RTC_ERROR_UNSUPPORTED_CPU:
      return "this processor lacks SSE2";
    case RTC_ERROR_CANCELLED:
      return "cancelled";
    default:
      return "unknown error";
  }
}

}  // namespace

RTCDevice embree_device() {
  struct Device {
    RTCDevice device = rtcNewDevice(nullptr);
    ~Device() { rtcReleaseDevice(device); }
  };
  static const Device shared;
  if (shared.device == nullptr) throw_on_embree_error(nullptr, "start");
  return shared.device;
}

void throw_on_embree_error(RTCDevice device, const std::string& doing) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE)
    throw Error("Embree can't " + doing + ": " + std::string(embree_reason(error)));
}

}  // namespace recede::detail
