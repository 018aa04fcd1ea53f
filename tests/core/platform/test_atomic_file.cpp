// Files that appear when they are complete, and their checksum.
#include <filesystem>
#include <fstream>
#include <thread>

#include <gtest/gtest.h>

#include "platform/atomic_file.h"
#include "platform/platform.h"

namespace ajar::test_atomic_file {

namespace {

namespace fs = std::filesystem;

class AtomicFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("ajar_atomic_" + std::to_string(platform::process_id()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  std::string path() const { return (folder_ / "file").string(); }
  std::string content() const {
    std::ifstream in(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  size_t count() const { return size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator())); }
  fs::path folder_;
};

TEST_F(AtomicFiles, a_file_that_is_not_committed_leaves_the_one_that_was_there) {
  AtomicFile first(path());
  first.write("first", 5);
  EXPECT_FALSE(fs::exists(path()));
  EXPECT_EQ(first.commit(), "");
  {
    AtomicFile second(path());
    second.write("second", 6);
    EXPECT_EQ(content(), "first");
  }
  EXPECT_EQ(content(), "first");
  EXPECT_EQ(count(), 1u) << "nothing else is left in the folder";
}

TEST_F(AtomicFiles, a_folder_that_is_missing_is_an_error_with_its_reason) {
  AtomicFile file((folder_ / "none" / "file").string());
  file.write("x", 1);
  EXPECT_NE(file.commit(), "");
}

TEST_F(AtomicFiles, removing_says_whether_the_name_is_free) {
  std::ofstream(path()) << "content";
  EXPECT_TRUE(platform::remove_file(path()));
  EXPECT_FALSE(fs::exists(path()));
  EXPECT_TRUE(platform::remove_file(path())) << "nothing is left of what was not there";
  fs::create_directories(fs::path(path()) / "inner");
  EXPECT_FALSE(platform::remove_file(path())) << "a folder that is not empty stays";
}

TEST_F(AtomicFiles, of_several_writers_one_file_arrives_whole) {
  std::vector<std::thread> writers;
  for (char name = 'a'; name < 'a' + 8; ++name)
    writers.emplace_back([this, name] {
      for (int i = 0; i < 20; ++i) {
        AtomicFile file(path());
        const std::string text(50000, name);
        file.write(text.data(), 25000);
        file.write(text.data(), 25000);
        EXPECT_EQ(file.commit(), "");
      }
    });
  for (std::thread& writer : writers) writer.join();
  EXPECT_EQ(content(), std::string(50000, content().at(0)));
  EXPECT_EQ(count(), 1u);
}

TEST(Checksum, every_bit_of_every_length_changes_it) {
  for (size_t length = 1; length < 100; ++length) {
    std::string text(length, 'x');
    const auto of = [](const std::string& bytes) {
      Checksum sum;
      sum.add(bytes.data(), bytes.size());
      return sum.value();
    };
    const uint64_t before = of(text);
    EXPECT_NE(before, of(text + std::string(1, '\0')));
    for (size_t bit = 0; bit < 8 * length; ++bit) {
      text[bit / 8] = char(text[bit / 8] ^ (1 << (bit % 8)));
      EXPECT_NE(of(text), before);
      text[bit / 8] = char(text[bit / 8] ^ (1 << (bit % 8)));
    }
  }
}

TEST(Platform, knows_the_memory_of_the_machine_and_of_the_process) {
  EXPECT_GT(platform::memory_bytes(), uint64_t(1) << 28);
  EXPECT_GT(platform::peak_memory_bytes(), uint64_t(1) << 20);
  EXPECT_LT(platform::peak_memory_bytes(), platform::memory_bytes());
  EXPECT_THROW(platform::load_library("/none/of/that/name"), std::runtime_error);
}

}  // namespace

}  // namespace ajar::test_atomic_file
