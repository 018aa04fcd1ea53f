// A file that appears under its name only when it is complete.
//
// It is written beside that name, under a name of its own, so that several processes and machines may write the same file: the last
// one that finishes wins, and a reader sees one of them whole. An interruption, a full disk or an exception leaves the file that was there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>

namespace ajar {

class AtomicFile {
 public:
  explicit AtomicFile(const std::string& path);
  ~AtomicFile();  ///< without `commit`: removes what was written
  AtomicFile(const AtomicFile&) = delete;

  void write(const void* bytes, size_t count);
  /// Returns an empty text if the file is complete and on the disk, otherwise the reason why it is not.
  std::string commit();

 private:
  void fail();
  std::string path_, unfinished_, error_;
  std::FILE* file_ = nullptr;
};

/// The same for a library that writes a file by its name: it writes `unfinished()`.
class AtomicPath {
 public:
  explicit AtomicPath(const std::string& path);
  ~AtomicPath();  ///< without `commit`: removes what was written
  AtomicPath(const AtomicPath&) = delete;

  /// Makes the empty file. Returns why that failed, or an empty text.
  std::string start();
  const std::string& unfinished() const { return unfinished_; }
  /// As AtomicFile::commit. The library has closed the file.
  std::string commit();

 private:
  std::string path_, unfinished_;
  bool started_ = false;
};

/// A checksum of 64 bits over several blocks, against damage and not against forgery. It depends on where blocks end.
class Checksum {
 public:
  void add(const void* bytes, size_t count);
  uint64_t value() const { return state_; }

 private:
  uint64_t state_ = 0x9e3779b97f4a7c15u;
};

}  // namespace ajar
