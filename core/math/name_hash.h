// Hashes of names: the ids of Cryptomatte.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace ajar {

/// MurmurHash3_x86_32 with seed 0 (Appleby, public domain).
inline uint32_t murmur_hash3(std::string_view text) {
  constexpr uint32_t kFirst = 0xcc9e2d51U, kSecond = 0x1b873593U;
  const auto scrambled = [](uint32_t k) { return std::rotl(k * kFirst, 15) * kSecond; };
  uint32_t hash = 0;
  size_t at = 0;
  for (; at + 4 <= text.size(); at += 4) {
    uint32_t word;
    std::memcpy(&word, text.data() + at, 4);
    hash = std::rotl(hash ^ scrambled(word), 13) * 5 + 0xe6546b64U;
  }
  uint32_t tail = 0;
  for (size_t i = text.size(); i > at; --i) tail = tail << 8 | uint8_t(text[i - 1]);
  if (at < text.size()) hash ^= scrambled(tail);
  hash ^= uint32_t(text.size());
  hash = (hash ^ (hash >> 16)) * 0x85ebca6bU;
  hash = (hash ^ (hash >> 13)) * 0xc2b2ae35U;
  return hash ^ (hash >> 16);
}

/// The id of a matte: the hash of its name as a float that is finite and not 0. Its exponent must be neither 0 nor 255;
/// otherwise the lowest bit of the exponent is flipped.
inline float matte_id(std::string_view name) {
  uint32_t hash = murmur_hash3(name);
  const uint32_t exponent = hash >> 23 & 255U;
  if (exponent == 0 || exponent == 255) hash ^= 1U << 23;
  return std::bit_cast<float>(hash);
}

}  // namespace ajar
