// Renders of ranges of samples: merged, they are one render bit for bit. What cannot be divided so has seeds of its own.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "math/statistics.h"
#include "platform/platform.h"
#include "render/session.h"
#include "statistical.h"
#include "transport_scenes.h"

namespace ajar::test_ranges {

namespace {

using namespace fixtures;

SceneDescription lit_room(const std::string& integrator, int samples, int threads = 2) {
  SceneDescription d = grey_room(16);
  d.lights.push_back(area_lamp(Vec3(0, 0, 0.9f), Vec3(0, 0, -1), 0.5f, 20.0f));
  d.settings.integrator = integrator;
  d.settings.seed = 5;
  d.settings.samples = samples;
  d.settings.threads = threads;
  d.settings.passes = {"Combined", "Normal", "Depth"};
  return d;
}

Checkpoint rendered(Session& session, SceneDescription scene, std::optional<uint32_t> first) {
  if (first) session.begin_at(*first);
  session.start(std::move(scene));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  return session.checkpoint().value();
}

Checkpoint range(const std::string& integrator, uint32_t first, uint32_t end, int threads = 2) {
  Session session;
  return rendered(session, lit_room(integrator, int(end - first), threads), first);
}

void expect_same_image(const Checkpoint& a, const Checkpoint& b) {
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.ranges, b.ranges);
  EXPECT_TRUE(a.sums == b.sums);
  EXPECT_EQ(a.passes, b.passes);
}

class Ranges : public ::testing::TestWithParam<const char*> {};

TEST_P(Ranges, merge_in_any_order_to_one_render_bit_for_bit) {
  const Checkpoint whole = range(GetParam(), 0, 24);
  std::vector<Checkpoint> parts{range(GetParam(), 0, 5, 1), range(GetParam(), 5, 6), range(GetParam(), 6, 24)};
  EXPECT_EQ(whole.ranges, (std::vector<SampleRange>{{5, 0, 24}}));
  for (int order = 0; order < 3; ++order) {
    CheckpointMerger merger;
    for (const Checkpoint& part : parts) merger.add(part);
    EXPECT_EQ(merger.why_not_exact(), "");
    expect_same_image(merger.finish(), whole);
    std::rotate(parts.begin(), parts.begin() + 1, parts.end());
  }
  EXPECT_NE(parts[0].passes.at("Combined"), parts[1].passes.at("Combined"));
  // A render that is not divided differs from it by the rounding of its sums, if at all.
  Session plain;
  const Checkpoint undivided = rendered(plain, lit_room(GetParam(), 24), std::nullopt);
  for (size_t i = 0; i < undivided.passes.at("Combined").size(); ++i)
    ASSERT_FLOAT_EQ(undivided.passes.at("Combined")[i], whole.passes.at("Combined")[i]);
}

TEST_P(Ranges, an_interrupted_render_continues_as_if_it_had_not_been) {
  const Checkpoint whole = range(GetParam(), 3, 20);
  Session session;
  session.resume(range(GetParam(), 3, 11));
  const Checkpoint continued = rendered(session, lit_room(GetParam(), 17), std::nullopt);
  expect_same_image(continued, whole);
  EXPECT_EQ(session.progress().samples, 17.0);
  EXPECT_EQ(session.snapshot("Combined"), whole.passes.at("Combined"));
  EXPECT_GE(continued.rays, whole.rays);
}

INSTANTIATE_TEST_SUITE_P(Integrators, Ranges, ::testing::Values("path", "bdpt"));

TEST(RangesOfSamples, a_render_that_is_cut_in_an_iteration_continues_at_each_pixel) {
  const Checkpoint whole = range("path", 0, 9);
  // Half of the pixels have a sample more, as after a time limit.
  Checkpoint cut = range("path", 0, 4);
  const Checkpoint more = range("path", 4, 5);
  for (size_t i = 0; i < cut.sums.pixels; i += 2) {
    cut.sums.counts[2 * i] += more.sums.counts[2 * i];
    cut.sums.counts[2 * i + 1] += more.sums.counts[2 * i + 1];
    for (size_t k = 0; k < cut.sums.tables.size(); ++k) {
      FilmSums::Table& table = cut.sums.tables[k];
      for (size_t j = i * table.width; !table.high.empty() && j < (i + 1) * table.width; ++j) {
        add_exactly(table.high[j], table.low[j], more.sums.tables[k].high[j]);
        add_exactly(table.high[j], table.low[j], more.sums.tables[k].low[j]);
      }
    }
  }
  Session session;
  session.resume(cut);
  expect_same_image(rendered(session, lit_room("path", 9), std::nullopt), whole);
}

TEST(RangesOfSamples, what_learns_gets_a_seed_of_its_own_for_each_range) {
  const auto guided = [](uint32_t first) {
    SceneDescription d = lit_room("path", 4);
    d.settings.guiding = Guiding::On;
    Session session;
    const Checkpoint c = rendered(session, std::move(d), first);
    const auto plan = nlohmann::json::parse(session.statistics_json()).at("plan").dump();
    EXPECT_NE(plan.find("samples depend on those before them"), std::string::npos) << plan;
    return c;
  };
  const Checkpoint a = guided(0), b = guided(4);
  EXPECT_EQ(a.seeds, std::vector<uint32_t>{5});
  EXPECT_NE(b.seeds, a.seeds);
  EXPECT_TRUE(a.ranges.empty() && b.ranges.empty() && a.sums.pixels == 0);
  CheckpointMerger merger;
  merger.add(a);
  merger.add(b);
  EXPECT_NE(merger.why_not_exact(), "");
  EXPECT_EQ(merger.finish().samples, 8.0);
}

/// The mean of the colours of an image.
double mean_of(const Checkpoint& c) {
  const std::vector<float>& image = c.passes.at("Combined");
  double sum = 0.0;
  for (size_t i = 0; i < image.size(); ++i) sum += i % 4 != 3 ? double(image[i]) : 0.0;
  return sum / double(image.size());
}

TEST(RangesOfSamples, what_is_divided_by_seeds_has_the_mean_of_undivided_renders) {
  for (const char* integrator : {"path", "metropolis", "photon_map"}) {
    const auto scene = [&](uint32_t seed, int samples) {
      SceneDescription d = lit_room(integrator, samples);
      d.settings.guiding = Guiding::On;
      d.settings.seed = seed;
      return d;
    };
    RunningMoments whole, divided;
    for (uint32_t seed = 0; seed < 12; ++seed) {
      Session undivided;
      whole.add(mean_of(rendered(undivided, scene(100 + seed, 8), std::nullopt)));
      CheckpointMerger merger;
      for (const uint32_t first : {0u, 4u}) {
        Session part;
        merger.add(rendered(part, scene(500 + seed, 4), first));
      }
      divided.add(mean_of(merger.finish()));
    }
    const double error = std::sqrt(whole.variance_of_mean() + divided.variance_of_mean());
    // The radii of photon mapping shrink from pass to pass, so that two renders of four passes have a little more bias
    // than one of eight.
    if (std::string(integrator) == "photon_map")
      EXPECT_NEAR(whole.mean(), divided.mean(), 0.005 * whole.mean() + 3.0 * error);
    else
      EXPECT_TRUE(statistical::means_agree(whole, divided, {0.01, 1})) << integrator;
    EXPECT_LT(error, 0.02 * whole.mean()) << integrator;
  }
}

TEST(RangesOfSamples, only_renders_that_fit_are_merged) {
  const auto failure = [](const Checkpoint& a, const Checkpoint& b) { return reason_against_merging(a, b); };
  const Checkpoint a = range("path", 0, 4);
  EXPECT_EQ(failure(a, range("path", 4, 6)), "");
  EXPECT_NE(failure(a, range("path", 3, 6)).find("sample 3 of seed 5"), std::string::npos);
  Session plain;
  EXPECT_NE(failure(a, rendered(plain, lit_room("path", 2), std::nullopt)).find("seed 5"), std::string::npos)
      << "a render without a range has all samples of its seed";
  Checkpoint other = range("path", 4, 6);
  other.version = "another";
  EXPECT_NE(failure(a, other).find("the other of another"), std::string::npos);
  SceneDescription d = lit_room("path", 2);
  d.settings.bounces.total = 1;
  Session fewer_bounces;
  EXPECT_NE(failure(a, rendered(fewer_bounces, d, 4)).find("settings differ"), std::string::npos);
  d = lit_room("path", 2);
  d.camera.world_from_camera[3] += 0.01f;
  Session moved;
  EXPECT_NE(failure(a, rendered(moved, d, 4)).find("cameras"), std::string::npos);
  // Another technique makes the same image, but not from the same samples.
  const Checkpoint both = range("bdpt", 4, 8);
  EXPECT_EQ(failure(a, both), "");
  EXPECT_NE(reason_against_adding(a, both), "");
  EXPECT_EQ(merge(a, both).sums.pixels, 0u);
}

TEST(RangesOfSamples, a_file_keeps_the_sums_and_any_changed_byte_is_found) {
  const std::string path = (std::filesystem::temp_directory_path() /
                            ("ajar_ranges_" + std::to_string(platform::process_id())))
                               .string();
  const Checkpoint c = range("bdpt", 2, 4);
  save_checkpoint(c, path);
  const Checkpoint read = load_checkpoint(path);
  expect_same_image(read, c);
  EXPECT_EQ(read.view, c.view);
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  const std::string bytes = content.str();
  for (size_t at = 0; at < bytes.size(); at += at < 64 ? 1 : 997) {
    std::string changed = bytes;
    changed[at] = char(changed[at] ^ 0x10);
    std::ofstream(path, std::ios::binary).write(changed.data(), std::streamsize(changed.size()));
    EXPECT_THROW(load_checkpoint(path), SceneError) << at;
  }
  std::ofstream(path, std::ios::binary).write((bytes + "x").data(), std::streamsize(bytes.size() + 1));
  EXPECT_THROW(load_checkpoint(path), SceneError);
  std::filesystem::remove(path);
}

}  // namespace

}  // namespace ajar::test_ranges
