// A value with the lock that guards it. Only code that holds the lock can access the value.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace ajar {

template <class T>
class Synchronized {
 public:
  /// Access to the value while it is locked.
  class Access {
   public:
    Access(T& value, std::mutex& mutex, std::condition_variable& changed)
        : value_(value), lock_(mutex), changed_(changed) {}
    T* operator->() const { return &value_; }
    T& operator*() const { return value_; }
    /// Wakes all threads that wait for a change of the value.
    void notify() const { changed_.notify_all(); }
    /// Releases the lock and waits until `done(value)`. The versions with a time end at that time as well.
    template <class Done>
    void wait(Done&& done) {
      changed_.wait(lock_, [&] { return done(value_); });
    }
    /// Returns whether `done(value)`.
    template <class Done>
    bool wait_for(double seconds, Done&& done) {
      return changed_.wait_for(lock_, std::chrono::duration<double>(seconds), [&] { return done(value_); });
    }
    template <class Done>
    void wait_until(std::chrono::steady_clock::time_point end, Done&& done) {
      changed_.wait_until(lock_, end, [&] { return done(value_); });
    }

   private:
    T& value_;
    std::unique_lock<std::mutex> lock_;
    std::condition_variable& changed_;
  };

  Access lock() const { return Access(value_, mutex_, changed_); }

 private:
  mutable T value_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
};

}  // namespace ajar
