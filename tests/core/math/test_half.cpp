// The portable floats of 16 bits are those of the processor.
#include <gtest/gtest.h>

#include <bit>

#include "math/half.h"

namespace ajar::test_half {

TEST(Half, all_65536_values_become_the_same_floats_and_come_back) {
  for (uint32_t bits = 0; bits < 65536; ++bits) {
    const float value = float(std::bit_cast<PortableHalf>(uint16_t(bits))),
                native = float(std::bit_cast<Half>(uint16_t(bits)));
    ASSERT_EQ(std::isnan(value), std::isnan(native));
    if (std::isnan(value)) continue;
    ASSERT_EQ(value, native) << bits;
    ASSERT_EQ(std::bit_cast<uint16_t>(PortableHalf(value)), bits);
  }
}

TEST(Half, floats_are_rounded_as_by_the_processor) {
  for (uint64_t bits = 0; bits < (uint64_t(1) << 32); bits += 4093) {
    const float value = std::bit_cast<float>(uint32_t(bits));
    if (std::isnan(value)) continue;
    ASSERT_EQ(std::bit_cast<uint16_t>(PortableHalf(value)), std::bit_cast<uint16_t>(Half(value))) << value;
  }
}

}  // namespace ajar::test_half
