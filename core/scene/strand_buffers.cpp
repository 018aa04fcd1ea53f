#include "scene/strand_buffers.h"

#include <algorithm>

namespace ajar {

void set_keys(RTCGeometry geometry, const std::vector<Vec4>& still, const std::vector<std::vector<Vec4>>& motion,
              size_t skipped) {
  if (!motion.empty()) rtcSetGeometryTimeStepCount(geometry, unsigned(motion.size()));
  for (unsigned key = 0; key < std::max<size_t>(motion.size(), 1); ++key) {
    const std::vector<Vec4>& keys = motion.empty() ? still : motion[key];
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT4, keys.data(),
                               skipped * sizeof(Vec4), sizeof(Vec4), keys.size() - skipped);
  }
}

void mark_joints(RTCGeometry geometry, const Strands& strands) {
  const size_t count = strands.segment_count();
  auto* const joints = static_cast<uint8_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_FLAGS, 0, RTC_FORMAT_UCHAR, sizeof(uint8_t), count));
  if (!joints) return;  // reported by the device
  for (size_t i = 0; i < count; ++i) {
    const bool before = i > 0 && strands.first_key[i - 1] + 1 == strands.first_key[i];
    const bool after = i + 1 < count && strands.first_key[i] + 1 == strands.first_key[i + 1];
    joints[i] = uint8_t((before ? RTC_CURVE_FLAG_NEIGHBOR_LEFT : 0) | (after ? RTC_CURVE_FLAG_NEIGHBOR_RIGHT : 0));
  }
}

}  // namespace ajar
