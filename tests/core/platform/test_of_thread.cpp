#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "platform/platform.h"

namespace ajar::test_of_thread {

namespace {

std::atomic<int> alive{0};
std::atomic<bool> was_whole{true};

struct Counted {
  int value = 7;
  Counted() { ++alive; }
  ~Counted() {
    was_whole = was_whole && value == 8;
    --alive;
  }
};

}  // namespace

TEST(OfThread, each_thread_has_one_object_until_it_ends) {
  std::atomic<int> most{0};
  const auto work = [&] {
    Counted& first = platform::of_thread<Counted>();
    ++first.value;
    EXPECT_EQ(&platform::of_thread<Counted>(), &first);
    EXPECT_EQ(first.value, 8);
    most = std::max(most.load(), alive.load());
  };
  std::thread one([&] {
    work();
    std::thread(work).join();
    EXPECT_EQ(alive, 1);
  });
  one.join();
  EXPECT_EQ(most, 2);
  EXPECT_EQ(alive, 0);
  EXPECT_TRUE(was_whole);
}

TEST(OfThread, what_a_thread_registers_is_destroyed_in_reverse_order) {
  static std::string order;
  std::thread([] {
    static const char names[] = {'a', 'b', 'c'};
    for (const char& name : names)
      platform::at_thread_end([](void* own) { order += *static_cast<char*>(own); }, const_cast<char*>(&name));
  }).join();
  EXPECT_EQ(order, "cba");
}

}  // namespace ajar::test_of_thread
