// What differs between operating systems. No other file of the core includes a header that only some systems have.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace ajar::platform {

/// Memory of the machine in bytes; 0: unknown.
uint64_t memory_bytes();
/// The most memory that this process has used, in bytes; 0: unknown.
uint64_t peak_memory_bytes();
/// The CPU time of all threads of this process so far, in seconds.
double cpu_seconds();
/// The number of this process.
uint64_t process_id();
/// The path of a file whose name is UTF-8, as all names in Ajar are. Windows reads plain texts as its own code page.
std::filesystem::path file_path(const std::string& name);
/// As std::fopen, for a name in UTF-8.
std::FILE* open_file(const std::string& name, const char* mode);
/// As std::remove, for a name in UTF-8. Returns whether no such file is left; one that was not there is none. Windows
/// removes no file that is open.
bool remove_file(const std::string& name);
/// As std::filesystem::rename, for names in UTF-8: a file that is there is replaced at once. Returns why it failed.
std::error_code replace_file(const std::string& from, const std::string& to);
/// Keeps the threads of TBB until the process ends, where a thread must not wait for others when it ends.
void keep_task_threads();
/// Calls destroy(object) when this thread ends. With mingw-w64, the memory of thread_local variables is given back before
/// their destructors run, so that only variables without a destructor are safe there.
void at_thread_end(void (*destroy)(void*), void* object);
/// An object of the type that belongs to this thread, from the first call until the thread ends.
template <class T>
T& of_thread() {
  thread_local T* object = nullptr;
  if (!object) [[unlikely]] {
    object = new T;
    at_thread_end([](void* own) { delete static_cast<T*>(own); }, object);
  }
  return *object;
}
/// The arguments of a program in UTF-8, without its name.
std::vector<std::string> arguments(int argc, char** argv);
/// Writes what the system holds back of a file to the disk. Returns false if that fails, with the reason in errno.
bool flush_to_disk(std::FILE* file);
/// Writes a file with a new name, with this ending, in the folder for temporary files. Returns its path; empty: failed.
std::string write_temporary(const void* bytes, size_t count, const std::string& ending);
/// Loads a library without making its symbols visible to others. Throws std::runtime_error with the reason.
void* load_library(const std::string& file);
/// The address of a function of a library; null: it has none of that name.
void* find_function(void* library, const char* name);

}  // namespace ajar::platform
