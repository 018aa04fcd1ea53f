// Embree's device, which the structures of consecutive scenes share. It counts the memory of these structures and keeps the
// first error.
#pragma once

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <string>

#include "description/diagnostics.h"
#include "scene/embree.h"

namespace ajar {

/// The options of Embree's device. AJAR_EMBREE adds to them, for example "isa=sse4.2" or "verbose=1"
/// (docs/developer/robustness.md).
inline std::string device_options(bool compact) {
  std::string options = "start_threads=0,set_affinity=0";
  if (compact) options += ",tri_accel=qbvh4.triangle4i";
  if (const char* more = std::getenv("AJAR_EMBREE")) options.append(",").append(more);
  return options;
}

struct Device {
  RTCDevice handle = nullptr;
  const bool compact;
  std::atomic<int64_t> bytes{0};
  std::mutex error_mutex;
  std::string error;

  explicit Device(bool is_compact = false) : compact(is_compact) {
    handle = rtcNewDevice(device_options(compact).c_str());
    if (!handle) throw SceneError("Embree could not be started on this machine.");
    rtcSetDeviceErrorFunction(
        handle,
        [](void* self, RTCError code, const char* text) {
          if (code == RTC_ERROR_CANCELLED) return;
          Device& device = *static_cast<Device*>(self);
          std::lock_guard lock(device.error_mutex);
          if (device.error.empty()) device.error = text ? text : "unknown Embree error";
        },
        this);
    rtcSetDeviceMemoryMonitorFunction(
        handle,
        [](void* self, ssize_t change, bool) {
          static_cast<Device*>(self)->bytes += change;
          return true;
        },
        this);
  }
  Device(const Device&) = delete;
  ~Device() { rtcReleaseDevice(handle); }
};

}  // namespace ajar
