// Checkpoints are saved, loaded and resumed. Checkpoints of one frame with different seeds are merged.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "math/statistics.h"
#include "platform/platform.h"
#include "render/session.h"
#include "statistical.h"
#include "transport_scenes.h"

namespace ajar::test_checkpoint {

namespace {

using namespace fixtures;

class CheckpointFile : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::temp_directory_path() / ("ajar_checkpoint_" + std::to_string(platform::process_id())))
                .string();
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::string path_;
};

SceneDescription lit_room(uint32_t seed, int samples) {
  SceneDescription d = grey_room(16);
  d.lights.push_back(area_lamp(Vec3(0, 0, 0.9f), Vec3(0, 0, -1), 0.5f, 20.0f));
  d.settings.seed = seed;
  d.settings.samples = samples;
  d.settings.threads = 1;
  d.settings.passes = {"Combined", "Normal"};
  return d;
}

Checkpoint rendered(uint32_t seed, int samples) {
  Session session;
  session.start(lit_room(seed, samples));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  return session.checkpoint().value();
}
std::string failure(const std::function<void()>& act) {
  try {
    act();
  } catch (const SceneError& error) {
    return error.what();
  }
  return "";
}

TEST_F(CheckpointFile, stores_all_data) {
  Checkpoint c = rendered(3, 4);
  c.scene = 0x123456789abcdef0u;
  save_checkpoint(c, path_);
  const Checkpoint read = load_checkpoint(path_);
  EXPECT_EQ(read.frame, c.frame);
  EXPECT_EQ(read.region, c.region);
  EXPECT_EQ(read.scene, c.scene);
  EXPECT_EQ(read.seeds, c.seeds);
  EXPECT_EQ(read.integrators, c.integrators);
  EXPECT_EQ(read.samples, 4.0);
  EXPECT_EQ(read.rays, c.rays);
  EXPECT_EQ(read.relmse, c.relmse);
  EXPECT_EQ(read.passes, c.passes);
  EXPECT_EQ(read.passes.size(), 4u) << "Combined, Normal, Sample Count, Variance";
}

TEST_F(CheckpointFile, damaged_files_are_refused_without_a_crash) {
  save_checkpoint(rendered(3, 1), path_);
  std::ifstream in(path_, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  EXPECT_NE(failure([&] { load_checkpoint(path_ + "_none"); }).find("cannot be read"), std::string::npos);
  for (size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 97) {
    std::ofstream(path_, std::ios::binary).write(bytes.data(), std::streamsize(length));
    EXPECT_NE(failure([&] { load_checkpoint(path_); }), "") << length;
  }
  for (size_t at = 0; at < 200; ++at) {  // bytes of the header
    std::string changed = bytes;
    changed[at] = char(changed[at] ^ 0x15);
    std::ofstream(path_, std::ios::binary).write(changed.data(), std::streamsize(changed.size()));
    failure([&] { load_checkpoint(path_); });
  }
}

TEST(Checkpoint, merging_weights_by_samples) {
  const Checkpoint a = rendered(1, 2), b = rendered(2, 6), c = merge(a, b);
  EXPECT_EQ(c.samples, 8.0);
  EXPECT_EQ(c.seeds, (std::vector<uint32_t>{1, 2}));
  for (size_t i = 0; i < c.passes.at("Combined").size(); ++i)
    ASSERT_NEAR(c.passes.at("Combined")[i], 0.25f * a.passes.at("Combined")[i] + 0.75f * b.passes.at("Combined")[i],
                1e-5f);
  EXPECT_EQ(c.passes.at("Sample Count")[0], 8.0f);
  EXPECT_NEAR(c.passes.at("Variance")[40],
              a.passes.at("Variance")[40] / 16.0f + b.passes.at("Variance")[40] * 9.0f / 16.0f, 1e-6f);
}

TEST(Checkpoint, checkpoints_of_different_frames_are_refused_with_the_reason) {
  const Checkpoint a = rendered(1, 1);
  EXPECT_NE(failure([&] { merge(a, a); }).find("seed 1"), std::string::npos) << "the samples are the same";
  Checkpoint b = rendered(2, 1);
  b.region[2] -= 1;
  EXPECT_NE(failure([&] { merge(a, b); }).find("pixels"), std::string::npos);
  b = rendered(2, 1);
  b.exposure = 2.0f;
  EXPECT_NE(failure([&] { merge(a, b); }).find("exposure"), std::string::npos);
  Checkpoint known = a;
  known.scene = 5;
  b = rendered(2, 1);
  b.scene = 6;
  EXPECT_NE(failure([&] { merge(known, b); }).find("different scenes"), std::string::npos);
}

TEST(Checkpoint, a_resumed_render_continues_with_new_samples) {
  const Checkpoint first = rendered(9, 3);
  Session session;
  session.resume(first);
  session.start(lit_room(9, 8));
  EXPECT_TRUE(session.wait(kHang));
  ASSERT_EQ(session.take_error(), "");
  const Checkpoint all = session.checkpoint().value();
  EXPECT_EQ(all.samples, 8.0) << "three resumed samples and five new ones";
  ASSERT_EQ(all.seeds.size(), 2u);
  EXPECT_NE(all.seeds[0], all.seeds[1]);
  EXPECT_EQ(session.snapshot("Combined"), all.passes.at("Combined"));
  // The five samples are not the first five of the same seed.
  Session alone;
  alone.start(lit_room(9, 5));
  EXPECT_TRUE(alone.wait(kHang));
  EXPECT_NE(merge_pass("Combined", first.passes.at("Combined"), 3.0, alone.snapshot("Combined"), 5.0),
            all.passes.at("Combined"));
  EXPECT_EQ(session.progress().samples, 8.0);
}

TEST(Checkpoint, resumed_renders_have_the_mean_of_uninterrupted_ones) {
  RunningMoments whole, resumed;
  const auto mean_of = [](const std::vector<float>& image) {
    double sum = 0.0;
    for (size_t i = 0; i < image.size(); ++i) sum += i % 4 != 3 ? double(image[i]) : 0.0;
    return sum / double(image.size());
  };
  for (uint32_t seed = 0; seed < 24; ++seed) {
    whole.add(mean_of(rendered(100 + seed, 8).passes.at("Combined")));
    Session session;
    session.resume(rendered(500 + seed, 3));
    session.start(lit_room(500 + seed, 8));
    EXPECT_TRUE(session.wait(kHang));
    resumed.add(mean_of(session.snapshot("Combined")));
  }
  EXPECT_TRUE(statistical::means_agree(whole, resumed, {0.01, 1}));
  EXPECT_LT(std::sqrt(whole.variance_of_mean() + resumed.variance_of_mean()), 0.01 * whole.mean())
      << "too noisy for the test";
}

TEST(Checkpoint, a_checkpoint_of_another_scene_stops_the_render_with_the_reason) {
  Checkpoint other = rendered(1, 1);
  other.scene = 7;
  Session session;
  session.resume(other, 8);
  session.start(lit_room(2, 2));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_NE(session.take_error().find("different scenes"), std::string::npos);
}

}  // namespace

}  // namespace ajar::test_checkpoint
