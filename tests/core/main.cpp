// Runs the tests. Prints a line of progress for each five per cent of them, and their counts at the end. AJAR_THREADS=N
// runs everything with N threads, including scenes that are built outside of sessions.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace {

class Progress : public testing::EmptyTestEventListener {
  void OnTestProgramStart(const testing::UnitTest& all) override { count_ = all.test_to_run_count(); }
  void OnTestEnd(const testing::TestInfo& test) override {
    const int before = 100 * done_ / count_, now = 100 * ++done_ / count_;
    if (now / kStep > before / kStep)
      std::printf("[%3d %%] %d of %d, %s\n", now, done_, count_, test.test_suite_name());
    std::fflush(stdout);
  }
  void OnTestProgramEnd(const testing::UnitTest& all) override {
    std::printf("core: %d passed, %d failed, %d skipped\n", all.successful_test_count(), all.failed_test_count(),
                all.skipped_test_count());
  }

  static constexpr int kStep = 5;  // per cent
  int done_ = 0, count_ = 1;
};

}  // namespace

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  testing::UnitTest::GetInstance()->listeners().Append(new Progress);
  const char* named = std::getenv("AJAR_THREADS");
  const int threads = named ? std::atoi(named) : 0;
  if (threads <= 0) return RUN_ALL_TESTS();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, size_t(std::max(2, threads)));
  return tbb::task_arena(threads).execute([] { return RUN_ALL_TESTS(); });
}
