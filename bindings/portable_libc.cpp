// A function of a newer glibc that the static libstdc++ of the compiler needs and an extension must not require.
#include <sys/random.h>

#include <cstdint>

/// glibc has it since 2.36. std::random_device calls it.
extern "C" __attribute__((visibility("hidden"))) uint32_t arc4random() noexcept {
  uint32_t number = 0;
  while (getrandom(&number, sizeof number, 0) != sizeof number) {
  }
  return number;
}
