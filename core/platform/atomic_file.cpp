#include "platform/atomic_file.h"

#include <bit>
#include <cerrno>
#include <cstring>
#include <random>
#include <system_error>

#include "platform/platform.h"

namespace ajar {

namespace {

uint64_t mixed(uint64_t x) {
  // The finalizer of MurmurHash3 (Appleby, public domain).
  x = (x ^ (x >> 33)) * 0xff51afd7ed558ccdu;
  x = (x ^ (x >> 33)) * 0xc4ceb9fe1a85ec53u;
  return x ^ (x >> 33);
}

/// Process numbers repeat on other machines that share a folder.
std::string own_name(const std::string& path) {
  std::random_device random;
  char text[64];
  std::snprintf(text, sizeof text, ".part-%llu-%08x%08x", static_cast<unsigned long long>(platform::process_id()),
                unsigned(random()), unsigned(random()));
  return path + text;
}

}  // namespace

AtomicFile::AtomicFile(const std::string& path) : path_(path), unfinished_(own_name(path)) {
  file_ = platform::open_file(unfinished_, "wb");
  if (file_ == nullptr) fail();
}

AtomicFile::~AtomicFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  platform::remove_file(unfinished_);
}

void AtomicFile::fail() {
  if (error_.empty()) error_ = std::generic_category().message(errno);
}

void AtomicFile::write(const void* bytes, size_t count) {
  if (error_.empty() && count > 0 && std::fwrite(bytes, 1, count, file_) != count) fail();
}

std::string AtomicFile::commit() {
  if (error_.empty() && !platform::flush_to_disk(file_)) fail();
  if (file_ == nullptr) return error_;
  if (std::fclose(file_) != 0) fail();
  file_ = nullptr;
  std::error_code error;
  if (error_.empty()) error = platform::replace_file(unfinished_, path_);
  if (error) error_ = error.message();
  if (!error_.empty()) platform::remove_file(unfinished_);
  return error_;
}

AtomicPath::AtomicPath(const std::string& path) : path_(path), unfinished_(own_name(path)) {}

AtomicPath::~AtomicPath() {
  if (started_) platform::remove_file(unfinished_);
}

std::string AtomicPath::start() {
  std::FILE* const file = platform::open_file(unfinished_, "wb");
  if (file == nullptr) return std::generic_category().message(errno);
  started_ = true;
  std::fclose(file);
  return {};
}

std::string AtomicPath::commit() {
  std::FILE* const file = platform::open_file(unfinished_, "r+b");
  if (file == nullptr) return std::generic_category().message(errno);
  const bool flushed = platform::flush_to_disk(file);
  const std::string problem = flushed ? "" : std::generic_category().message(errno);
  std::fclose(file);
  if (!flushed) return problem;
  if (const std::error_code error = platform::replace_file(unfinished_, path_)) return error.message();
  started_ = false;
  return {};
}

void Checksum::add(const void* bytes, size_t count) {
  // Four sums side by side, because each waits for its multiplication.
  const char* at = static_cast<const char*>(bytes);
  uint64_t lanes[4] = {state_, state_ + 1, state_ + 2, state_ + 3};
  size_t left = count;
  for (; left >= 32; left -= 32, at += 32) {
    uint64_t words[4];
    std::memcpy(words, at, sizeof words);
    for (int k = 0; k < 4; ++k) lanes[k] = std::rotl(lanes[k] ^ words[k], 29) * 0x9fb21c651e98df25u;
  }
  for (; left > 0;) {
    uint64_t word = 0;
    const size_t part = left < 8 ? left : 8;
    std::memcpy(&word, at, part);
    lanes[0] = std::rotl(lanes[0] ^ word, 29) * 0x9fb21c651e98df25u;
    left -= part, at += part;
  }
  state_ = mixed(count);
  for (const uint64_t lane : lanes) state_ = mixed(state_ ^ lane);
}

}  // namespace ajar
