// What instances take of the heap, where Embree keeps objects that it does not count.
#include <gtest/gtest.h>
#include <malloc.h>

#include "render/memory_estimate.h"
#include "scene_fixtures.h"

using namespace ajar;
using namespace ajar::fixtures;

namespace {

/// Bytes of the main arena in use. Set MALLOC_ARENA_MAX=1, so that it holds what all threads allocate.
double allocated() {
  const struct mallinfo2 info = mallinfo2();
  return double(info.uordblks) + double(info.hblkhd);
}

}  // namespace

TEST(MemoryEstimate, of_instances_is_what_they_take) {
  constexpr int kCount = 20000;
  const SceneDescription d = many_instances(kCount);
  double estimated = 0.0;
  for (const MemoryPart& part : estimate_memory(d).parts)
    if (part.what == "instances") estimated = double(part.bytes) / kCount;
  const double before = allocated();
  const auto scene = build(d);
  // Embree has its trees from the system: they are in its own count, not on the heap.
  const double heap = (allocated() - before) / kCount, counted = double(scene->statistics().accel_bytes) / kCount;
  RecordProperty("heap_bytes", int(heap));
  EXPECT_GT(estimated, heap) << counted;
  EXPECT_LT(estimated, 1.1 * (heap + counted)) << counted;
}
