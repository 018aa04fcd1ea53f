// Stands for Boost.Thread, of which OpenImageIO uses this class: a pointer for each thread, which is deleted, or given to a function, when the thread ends.
#pragma once

#include <pthread.h>

#include <new>

namespace boost {

template <class T>
class thread_specific_ptr {
 public:
  explicit thread_specific_ptr(void (*cleanup)(T*) = [](T* object) { delete object; }) : cleanup_(cleanup) {
    if (pthread_key_create(&key_, [](void* entry) { end(static_cast<Entry*>(entry)); }) != 0) throw std::bad_alloc();
  }
  ~thread_specific_ptr() {
    end(entry());
    pthread_key_delete(key_);
  }
  thread_specific_ptr(const thread_specific_ptr&) = delete;
  thread_specific_ptr& operator=(const thread_specific_ptr&) = delete;

  T* get() const { return entry() ? entry()->object : nullptr; }
  T* operator->() const { return get(); }
  T& operator*() const { return *get(); }
  void reset(T* object = nullptr) {
    Entry* old = entry();
    if (old && old->object == object) return;
    pthread_setspecific(key_, object ? new Entry{object, cleanup_} : nullptr);
    end(old);
  }

 private:
  struct Entry {
    T* object;
    void (*cleanup)(T*);
  };
  static void end(Entry* entry) {
    if (entry && entry->cleanup) entry->cleanup(entry->object);
    delete entry;
  }
  Entry* entry() const { return static_cast<Entry*>(pthread_getspecific(key_)); }

  pthread_key_t key_;
  void (*cleanup_)(T*);
};

}  // namespace boost
