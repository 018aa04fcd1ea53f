// Learned data that one frame of an animation passes to the next. It reduces the noise of the image and must not change
// its expectation.
#include "agreement.h"

#include <nlohmann/json.hpp>

#include "integrators/learned.h"

namespace ajar::test_learned {

namespace {

using namespace fixtures;
using namespace statistical;

struct Frame {
  std::vector<float> image;
  std::shared_ptr<const Learned> learned;
  nlohmann::json statistics;
};

Frame frame(SceneDescription d, std::shared_ptr<const Learned> before, uint32_t seed, int threads = 2) {
  d.settings.seed = seed;
  d.settings.threads = threads;
  Session session;
  session.begin_with(std::move(before));
  session.start(std::move(d));
  EXPECT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  return {session.snapshot("Combined"), session.learned(), nlohmann::json::parse(session.statistics_json())};
}

/// The plan's entries for learned data: for each part "used", or the reason why it is not used.
std::map<std::string, std::string> parts(const Frame& f) {
  const std::string prefix = "learned in the frame before";
  std::map<std::string, std::string> found;
  for (const auto& step : f.statistics["plan"]) {
    const std::string name = step["step"];
    if (name.starts_with(prefix))
      found[name == prefix ? "" : name.substr(prefix.size() + 2)] = step["used"] ? "used" : std::string(step["reason"]);
  }
  return found;
}

/// A room that is lit only by the wall at which its lamp points.
SceneDescription screened_room(int size, Vec3 lamp = Vec3(0.9f, 0.0f, 0.5f), Vec3 towards = Vec3(1, 0, 0)) {
  SceneDescription d = grey_room(size);
  add_object(d, sphere(8), add_half_diffuse(d, "ShaderNodeBsdfGlossy", 0.3f), moved(Vec3(0.2f, 0.3f, -0.4f), 0.4f));
  d.lights.push_back(area_lamp(lamp, towards, 0.2f, 20.0f));
  d.settings.integrator = "path";
  d.settings.guiding = Guiding::On;
  d.settings.samples = 8;
  return d;
}

/// Four lamps, some of which a screen occludes for most of the room. The choice of lights is learned.
SceneDescription four_lamps(int size, Vec3 screen, Vec3 towards) {
  SceneDescription d = grey_room(size);
  for (const float x : {-0.8f, 0.8f})
    for (const float z : {-0.8f, 0.8f})
      d.lights.push_back(point_light(Vec3(x, 0.6f, z), x > 0.0f ? 8.0f : 3.0f, 0.05f));
  add_object(d, plane(0.7f), add_diffuse(d, Color(0.5f)), shining(screen, towards));
  d.settings.integrator = "path";
  d.settings.direct = DirectMethod::PmcHi;
  d.settings.samples = 8;
  d.settings.bounces = {2, 2, 2, 2, 2, 0};
  return d;
}
SceneDescription four_lamps(int size) { return four_lamps(size, Vec3(0.6f, 0.4f, 0.0f), Vec3(1, 0, 0)); }

SceneDescription wrongly_lit_room(int size) { return screened_room(size, Vec3(-0.9f, 0.2f, -0.5f), Vec3(-1, 0, 0)); }

/// Means of blocks of the image, over frames that start with the data learned in a frame of `teacher`.
std::vector<RunningMoments> taught_blocks(const SceneDescription& d, const SceneDescription& teacher, int frames,
                                          uint32_t first_seed, const std::string& part) {
  std::vector<RunningMoments> moments(kValues);
  const int size = d.settings.width;
  for (uint32_t seed = first_seed; seed < first_seed + uint32_t(frames); ++seed) {
    // Both frames have the same seed, as in an animation.
    const Frame taught = frame(d, frame(teacher, nullptr, seed).learned, seed);
    EXPECT_EQ(parts(taught)[part], "used");
    std::vector<double> sums(kValues, 0.0);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x)
        for (int c = 0; c < 4; ++c)
          sums[size_t((y * kBlocks / size * kBlocks + x * kBlocks / size) * 4 + c)] += double(
              taught.image[size_t((y * size + x) * 4 + c)]);
    for (int i = 0; i < kValues; ++i) moments[size_t(i)].add(sums[size_t(i)] * kBlocks * kBlocks / (size * size));
  }
  return moments;
}

void expect_same_means(const std::vector<RunningMoments>& expected, const std::vector<RunningMoments>& actual,
                       const std::string& what, int tests) {
  for (int i = 0; i < kValues; ++i) {
    if (i % 4 == 3) continue;  // alpha is 1
    EXPECT_TRUE(means_agree(expected[size_t(i)], actual[size_t(i)], {0.01, kValues * tests}))
        << what << ", block " << i / 4 << ", channel " << i % 4;
  }
}

TEST(Learned, path_guide_of_the_previous_frame_keeps_the_means_also_with_another_light) {
  const SceneDescription d = screened_room(12);
  SceneDescription plain = d;
  plain.settings.guiding = Guiding::Off;
  const auto expected = blocks(plain, "path", 64, 16, 100);
  expect_same_means(expected, taught_blocks(d, d, 40, 200, "path guide"), "same scene", 2);
  expect_same_means(expected, taught_blocks(d, wrongly_lit_room(12), 40, 300, "path guide"), "another light", 2);
}

TEST(Learned, choice_of_lights_keeps_the_means_also_with_other_occluders) {
  const SceneDescription d = four_lamps(12);
  SceneDescription plain = d;
  plain.settings.direct = DirectMethod::Mis;
  const auto expected = blocks(plain, "path", 64, 16, 100);
  expect_same_means(expected, taught_blocks(d, d, 40, 200, "choice of lights"), "same screen", 2);
  expect_same_means(
      expected, taught_blocks(d, four_lamps(12, Vec3(-0.6f, 0.4f, 0.0f), Vec3(1, 0, 0)), 40, 300, "choice of lights"),
      "another screen", 2);
}

TEST(Learned, importance_of_another_image_keeps_the_means_of_populations) {
  SceneDescription d = screened_room(12);
  d.settings.guiding = Guiding::Off;
  d.settings.vertex_merging = Merging::Off;
  const auto expected = blocks(d, "path", 64, 16, 100);
  d.settings.integrator = "pmc_pt";
  SceneDescription other = wrongly_lit_room(12);
  other.settings.integrator = "pmc_pt";
  other.settings.vertex_merging = Merging::Off;
  const std::string part = "shares of mutations, importance of the film";
  // Many frames are needed: few populations find the brightest paths, so that the mean and the error of few frames are
  // too small.
  expect_same_means(expected, taught_blocks(d, d, 100, 1000, part), "same scene", 2);
  expect_same_means(expected, taught_blocks(d, other, 100, 2000, part), "another light", 2);
}

TEST(Learned, choice_of_lights_is_kept_with_the_same_lights_and_a_near_camera) {
  SceneDescription d = four_lamps(16);
  const Frame first = frame(d, nullptr, 1);
  const auto why_not = [&](const SceneDescription& next) {
    return parts(frame(next, first.learned, 1))["choice of lights"];
  };
  EXPECT_EQ(why_not(d), "used");
  SceneDescription other = d;
  other.lights[2].energy *= 1.5f;
  EXPECT_EQ(why_not(other), "the lights have changed");
  other = d;
  other.lights[0].world_from_light = rows(moved(Vec3(-0.7f, 0.6f, -0.8f)));
  EXPECT_EQ(why_not(other), "the lights have changed");
  other = d;
  set_camera(other, Vec3(0.1f, 0.4f, 0.1f), Vec3(0.0f, 0.9f, -0.25f), 16, 0.7f);
  EXPECT_NE(why_not(other).find("the camera has moved"), std::string::npos);
  other = d;
  other.settings.direct = DirectMethod::Mis;
  EXPECT_EQ(why_not(other), "lights are not learned");
  // The pilot is shorter than without learned data.
  EXPECT_LT(double(frame(d, first.learned, 1).statistics["pilot_rays"]), 0.7 * double(first.statistics["pilot_rays"]));
}

TEST(Learned, consecutive_frames_do_not_depend_on_the_number_of_threads) {
  const auto rows = [](SceneDescription d, const char* integrator, int threads) {
    d.settings.integrator = integrator;
    std::vector<std::vector<float>> images;
    std::shared_ptr<const Learned> learned;
    for (int i = 0; i < 3; ++i) {
      set_camera(d, Vec3(0.1f + 0.05f * float(i), -0.9f, 0.1f), Vec3(0.0f, 0.5f, -0.25f), 20, 0.7f);
      Frame f = frame(d, learned, 7, threads);
      if (i > 0) {
        EXPECT_EQ(parts(f).begin()->second, "used") << integrator;
      }
      EXPECT_EQ(f.statistics["frames_before"], i);
      images.push_back(std::move(f.image));
      learned = f.learned;
    }
    return images;
  };
  const auto check = [&](const SceneDescription& d, const char* integrator) {
    const auto one = rows(d, integrator, 1), two = rows(d, integrator, 2);
    EXPECT_EQ(one, two) << integrator << ", " << name_of(d.settings.direct) << " " << d.settings.direct_samples;
    EXPECT_NE(one[0], one[1]) << integrator;
  };
  for (const char* integrator : {"path", "photon_map", "mps"}) {
    SceneDescription d = screened_room(20);
    d.settings.samples = 3;
    check(d, integrator);
  }
  SceneDescription longer = screened_room(20);
  longer.settings.samples = 8;
  check(longer, "pmc_pt");
  for (const int direct_samples : {1, 4}) {
    SceneDescription d = four_lamps(20);
    d.settings.direct_samples = direct_samples;
    check(d, "path");
  }
}

TEST(Learned, a_frame_with_learned_data_has_less_noise) {
  const SceneDescription d = screened_room(24);
  Frame before = frame(d, nullptr, 1);
  for (uint32_t i = 0; i < 3; ++i) before = frame(d, before.learned, 1);
  std::vector<RunningMoments> cold, warm;
  for (uint32_t seed = 10; seed < 18; ++seed) {
    const auto add = [&](std::vector<RunningMoments>& pixels, const std::vector<float>& image) {
      pixels.resize(image.size() / 4);
      for (size_t i = 0; i < pixels.size(); ++i) pixels[i].add(double(image[4 * i + 1]));
    };
    add(cold, frame(d, nullptr, seed).image);
    add(warm, frame(d, before.learned, seed).image);
  }
  double sum_cold = 0.0, sum_warm = 0.0;
  for (size_t i = 0; i < cold.size(); ++i)
    sum_cold += cold[i].variance_of_mean(), sum_warm += warm[i].variance_of_mean();
  EXPECT_LT(sum_warm, 0.8 * sum_cold);
}

TEST(Learned, unsuitable_data_are_ignored_and_reported) {
  SceneDescription d = screened_room(12);
  const Frame first = frame(d, nullptr, 1);
  EXPECT_TRUE(parts(first).empty());
  SceneDescription other = d;
  other.settings.integrator = "photon_map";
  EXPECT_NE(parts(frame(other, first.learned, 1))[""].find("Path Tracing"), std::string::npos);
  SceneDescription far = d;
  add_object(far, plane(50.0f), 0);
  EXPECT_NE(parts(frame(far, first.learned, 1))[""].find("another size"), std::string::npos);
  SceneDescription unguided = d;
  unguided.settings.guiding = Guiding::Off;
  EXPECT_EQ(parts(frame(unguided, first.learned, 1))["path guide"], "paths are not guided");
  unguided.settings.integrator = "bdpt";
  EXPECT_NE(parts(frame(unguided, frame(unguided, nullptr, 1).learned, 1))[""].find("nothing is learned"),
            std::string::npos);
  // If no data are used, the image depends only on the random numbers of the frame, and the next frame has other random
  // numbers.
  const Frame a = frame(other, first.learned, 1), b = frame(other, a.learned, 1);
  EXPECT_NE(a.image, b.image);
}

TEST(Learned, technique_is_chosen_again_only_if_the_view_has_changed) {
  SceneDescription d = screened_room(32);
  d.settings.integrator = "auto";
  d.settings.guiding = Guiding::Off;
  d.settings.samples = 4096;       // enough samples for a pilot
  d.settings.target_error = 1e6f;  // reached after 16 samples
  const auto trials = [](const Frame& f) {
    int count = 0;
    for (const auto& step : f.statistics["plan"]) count += std::string(step["step"]).starts_with("trial") ? 1 : 0;
    return count;
  };
  const Frame first = frame(d, nullptr, 1);
  EXPECT_GT(trials(first), 0);
  const Frame second = frame(d, first.learned, 1);
  EXPECT_EQ(trials(second), 0);
  EXPECT_EQ(second.statistics["integrator"], first.statistics["integrator"]);
  set_camera(d, Vec3(0.1f, -0.9f, 0.1f), Vec3(0.9f, -0.5f, -0.25f), 32, 0.7f);
  EXPECT_GT(trials(frame(d, second.learned, 1)), 0);
}

TEST(Learned, automatic_guiding_is_measured_again_after_eight_frames) {
  SceneDescription d = screened_room(24);
  d.settings.guiding = Guiding::Auto;
  d.settings.samples = 24;
  Frame f = frame(d, nullptr, 1);
  const double gain = f.statistics["guide_measured_gain"];
  EXPECT_GT(gain, 0.0);
  for (uint32_t i = 1; i <= PathGuide::kMaxAge + 1; ++i) {
    f = frame(d, f.learned, 1);
    EXPECT_EQ(parts(f)["path guide"], "used");
    EXPECT_EQ(f.statistics.contains("guide_measured_gain"), i == PathGuide::kMaxAge + 1) << i;
  }
}

}  // namespace

}  // namespace ajar::test_learned
