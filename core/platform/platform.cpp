#include "platform/platform.h"

#include <cstdlib>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#ifdef _WIN32
#include <windows.h>
// after windows.h
#include <io.h>
#include <psapi.h>
#include <shellapi.h>
#include <tbb/global_control.h>
#else
#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace ajar::platform {

std::filesystem::path file_path(const std::string& name) { return std::u8string(name.begin(), name.end()); }

bool remove_file(const std::string& name) {
  std::error_code error;
  std::filesystem::remove(file_path(name), error);
  return !error;
}

#ifdef _WIN32

namespace {

std::string text_of(const std::filesystem::path& path) {
  const std::u8string text = path.u8string();
  return {text.begin(), text.end()};
}

}  // namespace

std::FILE* open_file(const std::string& name, const char* mode) {
  return _wfopen(file_path(name).c_str(), std::filesystem::path(mode).c_str());
}

std::error_code replace_file(const std::string& from, const std::string& to) {
  // Windows refuses as long as another process replaces or reads the file.
  constexpr int kTries = 200;
  std::error_code error;
  for (int i = 0; i < kTries; ++i) {
    std::filesystem::rename(file_path(from), file_path(to), error);
    if (error != std::errc::permission_denied) break;
    Sleep(10);
  }
  return error;
}

void keep_task_threads() {
  // The last thread that has used TBB waits for TBB's threads when it ends, and those wait for it to end: the system
  // ends one thread at a time.
  static auto* kept = new tbb::task_scheduler_handle(tbb::attach{});
  (void)kept;
}

namespace {

struct AtThreadEnd {
  void (*destroy)(void*);
  void* object;
  AtThreadEnd* next;
};

void CALLBACK end_thread(void* first) {
  for (auto* entry = static_cast<AtThreadEnd*>(first); entry;) {
    entry->destroy(entry->object);
    delete std::exchange(entry, entry->next);
  }
}

}  // namespace

void at_thread_end(void (*destroy)(void*), void* object) {
  static const DWORD slot = FlsAlloc(end_thread);
  FlsSetValue(slot, new AtThreadEnd{destroy, object, static_cast<AtThreadEnd*>(FlsGetValue(slot))});
}

std::vector<std::string> arguments(int, char**) {
  int count = 0;
  wchar_t** texts = CommandLineToArgvW(GetCommandLineW(), &count);
  std::vector<std::string> all;
  for (int i = 1; i < count; ++i) all.push_back(text_of(texts[i]));
  LocalFree(texts);
  return all;
}

uint64_t memory_bytes() {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  return GlobalMemoryStatusEx(&status) ? status.ullTotalPhys : 0;
}

uint64_t peak_memory_bytes() {
  PROCESS_MEMORY_COUNTERS counters{};
  return GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters) ? counters.PeakWorkingSetSize : 0;
}

double cpu_seconds() {
  FILETIME made, ended, kernel, user;
  if (!GetProcessTimes(GetCurrentProcess(), &made, &ended, &kernel, &user)) return 0.0;
  const auto seconds = [](const FILETIME& time) {
    return (4294967296.0 * time.dwHighDateTime + time.dwLowDateTime) * 1e-7;
  };
  return seconds(kernel) + seconds(user);
}

uint64_t process_id() { return GetCurrentProcessId(); }

bool flush_to_disk(std::FILE* file) { return std::fflush(file) == 0 && _commit(_fileno(file)) == 0; }

std::string write_temporary(const void* bytes, size_t count, const std::string& ending) {
  std::random_device random;
  const std::string name = "ajar-" + std::to_string(random()) + std::to_string(random()) + ending;
  const std::string path = text_of(std::filesystem::temp_directory_path() / name);
  std::FILE* file = open_file(path, "wbx");
  if (file == nullptr) return "";
  const bool written = std::fwrite(bytes, 1, count, file) == count;
  if (std::fclose(file) == 0 && written) return path;
  remove_file(path);
  return "";
}

void* load_library(const std::string& file) {
  // With the libraries beside it, if the file is named with its folder.
  const std::filesystem::path path = file_path(file).make_preferred();
  const HMODULE library = LoadLibraryExW(path.c_str(), nullptr, path.is_absolute() ? LOAD_WITH_ALTERED_SEARCH_PATH : 0);
  if (library == nullptr)
    throw std::runtime_error("cannot load " + file + ": error " + std::to_string(GetLastError()) + " of Windows");
  return reinterpret_cast<void*>(library);
}

void* find_function(void* library, const char* name) {
  return reinterpret_cast<void*>(GetProcAddress(reinterpret_cast<HMODULE>(library), name));
}

#else

std::FILE* open_file(const std::string& name, const char* mode) { return std::fopen(name.c_str(), mode); }

std::error_code replace_file(const std::string& from, const std::string& to) {
  std::error_code error;
  std::filesystem::rename(file_path(from), file_path(to), error);
  return error;
}

void keep_task_threads() {}

void at_thread_end(void (*destroy)(void*), void* object) {
  struct Objects {
    std::vector<std::pair<void (*)(void*), void*>> all;
    ~Objects() {
      for (auto entry = all.rbegin(); entry != all.rend(); ++entry) entry->first(entry->second);
    }
  };
  thread_local Objects objects;
  objects.all.emplace_back(destroy, object);
}

std::vector<std::string> arguments(int argc, char** argv) { return {argv + 1, argv + argc}; }

uint64_t memory_bytes() {
  const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
  return pages > 0 && size > 0 ? uint64_t(pages) * uint64_t(size) : 0;
}

uint64_t peak_memory_bytes() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
#ifdef __APPLE__
  return uint64_t(usage.ru_maxrss);
#else
  return uint64_t(usage.ru_maxrss) * 1024;
#endif
}

double cpu_seconds() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0.0;
  return double(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         1e-6 * double(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

uint64_t process_id() { return uint64_t(getpid()); }

bool flush_to_disk(std::FILE* file) { return std::fflush(file) == 0 && fsync(fileno(file)) == 0; }

std::string write_temporary(const void* bytes, size_t count, const std::string& ending) {
  std::string path = (std::filesystem::temp_directory_path() / ("ajar-XXXXXX" + ending)).string();
  const int descriptor = mkstemps(path.data(), int(ending.size()));
  if (descriptor < 0) return "";
  const char* at = static_cast<const char*>(bytes);
  size_t left = count;
  while (left > 0) {
    const ssize_t n = ::write(descriptor, at, left);
    if (n <= 0) break;
    at += n, left -= size_t(n);
  }
  if (::close(descriptor) == 0 && left == 0) return path;
  remove_file(path);
  return "";
}

void* load_library(const std::string& file) {
  void* library = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw std::runtime_error(dlerror());
  return library;
}

void* find_function(void* library, const char* name) { return dlsym(library, name); }

#endif

}  // namespace ajar::platform
