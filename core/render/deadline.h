// A flag that is set at a given time.
#pragma once

#include <atomic>
#include <thread>

#include "render/clock.h"
#include "render/session_state.h"
#include "render/synchronized.h"

namespace ajar {

/// Sets a flag at a given time, or when the render is stopped before that. It uses a thread, so that code that reads
/// the flag need not read a clock.
class Deadline {
 public:
  /// `state` must be notified whenever `stop` is set.
  Deadline(Clock::time_point at, const Synchronized<SessionState>& state, const std::atomic<bool>& stop)
      : state_(state), thread_([this, at, &stop] {
          state_.lock().wait_until(at, [&](const SessionState&) { return over_.load() || stop.load(); });
          passed_.store(true);
        }) {}
  Deadline(const Deadline&) = delete;
  ~Deadline() {
    {
      const auto state = state_.lock();
      over_.store(true);
      state.notify();
    }
    thread_.join();
  }
  const std::atomic<bool>& passed() const { return passed_; }

 private:
  const Synchronized<SessionState>& state_;
  std::atomic<bool> over_{false}, passed_{false};
  std::thread thread_;
};

}  // namespace ajar
