// Floats of 16 bits, as in textures. They are stored, and computed as float.
#pragma once

#include <bit>
#include <cstdint>

namespace ajar {

/// IEEE 754 binary16 by integers alone, for compilers without such a type. Rounds to the nearest, ties to even.
class PortableHalf {
 public:
  PortableHalf() = default;
  explicit PortableHalf(float value) : bits_(of(value)) {}
  explicit operator float() const {
    const uint32_t sign = uint32_t(bits_ & 0x8000u) << 16, exponent = (bits_ >> 10) & 31u, mantissa = bits_ & 1023u;
    if (exponent == 0) {  // a multiple of 2^-24
      const float value = float(mantissa) * 0x1p-24f;
      return sign ? -value : value;
    }
    if (exponent == 31) return std::bit_cast<float>(sign | 0x7f800000u | mantissa << 13);
    return std::bit_cast<float>(sign | (exponent + 112u) << 23 | mantissa << 13);
  }

 private:
  static uint16_t of(float value) {
    const uint32_t bits = std::bit_cast<uint32_t>(value), sign = (bits >> 16) & 0x8000u, magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u) return uint16_t(sign | 0x7e00u);   // not a number
    if (magnitude >= 0x477ff000u) return uint16_t(sign | 0x7c00u);  // rounds to infinity
    if (magnitude < 0x38800000u) {                                  // below 2^-14
      // The sum with 1/2 rounds to a multiple of 2^-24, whose number is in the last bits.
      const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
      return uint16_t(sign | (std::bit_cast<uint32_t>(shifted) - 0x3f000000u));
    }
    const uint32_t rounded = magnitude + 0xfffu + ((magnitude >> 13) & 1u);
    return uint16_t(sign | ((rounded - 0x38000000u) >> 13));
  }
  uint16_t bits_ = 0;
};

#if defined(__x86_64__) && defined(__SSE2__)
using Half = _Float16;
#elif defined(__ARM_FP16_FORMAT_IEEE)
using Half = __fp16;  // GCC 12 has _Float16 for ARM in C, but not in C++
#else
using Half = PortableHalf;
#endif
static_assert(sizeof(Half) == 2);

}  // namespace ajar
