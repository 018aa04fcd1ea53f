// Stands for Boost.Thread, of which OpenImageIO asks for the number of processors.
#pragma once

#include <thread>

namespace boost {

struct thread {
  static unsigned physical_concurrency() { return std::thread::hardware_concurrency(); }
};

}  // namespace boost
