// The heap memory of instances, which includes objects that Embree does not count.
#include <gtest/gtest.h>
#include <malloc.h>

#include "render/memory_estimate.h"
#include "scene_fixtures.h"

using namespace ajar;
using namespace ajar::fixtures;

namespace {

/// The bytes in use in the main arena. MALLOC_ARENA_MAX must be 1, so that it contains the allocations of all threads.
double allocated() {
  const struct mallinfo2 info = mallinfo2();
  return double(info.uordblks) + double(info.hblkhd);
}

}  // namespace

TEST(MemoryEstimate, of_instances_is_close_to_their_memory) {
  constexpr int kCount = 20000;
  const SceneDescription d = many_instances(kCount);
  double estimated = 0.0;
  for (const MemoryPart& part : estimate_memory(d).parts)
    if (part.what == "instances") estimated = double(part.bytes) / kCount;
  const double before = allocated();
  const auto scene = build(d);
  // Embree allocates its trees from the system. They are in its own count and not on the heap.
  const double heap = (allocated() - before) / kCount, counted = double(scene->statistics().accel_bytes) / kCount;
  RecordProperty("heap_bytes", int(heap));
  EXPECT_GT(estimated, heap) << counted;
  EXPECT_LT(estimated, 1.1 * (heap + counted)) << counted;
}
