// A flag that is raised at a moment.
#pragma once

#include <atomic>
#include <thread>

#include "render/clock.h"
#include "render/session_state.h"
#include "render/synchronized.h"

namespace ajar {

/// Raises a flag at a moment, or when the render is stopped before. Needs a thread, so that whoever looks at the flag
/// need not look at a clock.
class Deadline {
 public:
  /// `state` is notified whenever `stop` is raised.
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
