// Tests of the pictures that a session makes for a view. A library with the interface of Open Image Denoise makes blue
// images.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "denoise/open_image_denoise.h"
#include "render/session.h"
#include "scene_fixtures.h"
#include "transport_scenes.h"

namespace ajar::test_session_view {

using namespace fixtures;

namespace {

SceneDescription scene(int width, int height, int samples) {
  SceneDescription d;
  add_object(d, plane(3.0f), add_diffuse(d, Color(0.5f)));
  d.lights.push_back(point_light(Vec3(1, -1, 4), 300.0f, 0.2f));
  set_camera(d, Vec3(0, -6, 4), Vec3(0), 24);
  d.settings.width = width;
  d.settings.height = height;
  d.settings.region = {0, 0, width, height};
  d.settings.samples = samples;
  d.settings.threads = 2;
  return d;
}

/// All pictures of the render until its end.
std::vector<ViewPicture> pictures(Session& session) {
  std::vector<ViewPicture> found;
  for (bool over = false; !over;) {
    over = session.wait(0.0005);
    while (auto picture = session.take_picture()) found.push_back(std::move(*picture));
  }
  EXPECT_EQ(session.take_error(), "");
  return found;
}

ViewPicture next_picture(Session& session) {
  for (;;) {
    if (auto picture = session.take_picture()) return std::move(*picture);
    if (session.wait(0.0005)) {
      ADD_FAILURE() << "the render is over";
      return {};
    }
  }
}

bool is_blue(const ViewPicture& picture) {
  for (size_t i = 0; i < picture.rgba.size(); i += 4)
    if (picture.rgba[i] != 0.0f || picture.rgba[i + 1] != 0.0f || picture.rgba[i + 2] <= 0.0f) return false;
  return !picture.rgba.empty();
}

/// An environment variable while it exists.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { set(value); }
  ~Variable() { set(""); }

 private:
  /// An empty text removes it.
  void set(const char* value) {
#ifdef _WIN32
    _putenv_s(name_, value);
#else
    *value ? setenv(name_, value, 1) : unsetenv(name_);
#endif
  }
  const char* name_;
};

void load_stand_in() {
  OpenImageDenoise::load(AJAR_STAND_IN_DENOISER);
  ASSERT_EQ(OpenImageDenoise::version(), "2.2.2");
}

}  // namespace

// This must be the first test of the file: a library cannot be unloaded.
TEST(SessionView, without_a_denoiser_pictures_are_noisy_and_say_why) {
  if (!OpenImageDenoise::version().empty()) GTEST_SKIP() << "a denoiser is loaded";
  Session session;
  session.show_pictures(true);
  session.update(scene(64, 40, 4));
  const auto found = pictures(session);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.back().not_denoised, "The view is not denoised: Open Image Denoise is not loaded.");
  EXPECT_EQ(found.back().rgba, session.snapshot("Combined"));
  ASSERT_FALSE(session.diagnostics().empty());
  EXPECT_EQ(session.diagnostics().back().message, found.back().not_denoised);
}

TEST(SessionView, a_session_makes_pictures_only_when_asked) {
  load_stand_in();
  Session session;
  session.update(scene(64, 40, 4));
  EXPECT_TRUE(pictures(session).empty());
  session.show_pictures(true);
  EXPECT_TRUE(pictures(session).empty());
  const SceneDescription d = scene(64, 40, 4);
  const uint64_t render = session.change_view(d.camera, d.settings);
  const auto found = pictures(session);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.back().render, render);
  EXPECT_EQ(found.back().samples, 4.0);
  EXPECT_EQ(found.back().iteration, session.progress().iteration);
  EXPECT_TRUE(is_blue(found.back()));
  session.show_pictures(false);
  session.change_view(d.camera, d.settings);
  EXPECT_TRUE(pictures(session).empty());
  session.show_pictures(true);
  session.start(scene(64, 40, 4));
  EXPECT_TRUE(pictures(session).empty());
}

TEST(SessionView, pictures_go_from_coarse_to_fine_and_appear_from_the_second_sample_on) {
  load_stand_in();
  const Variable slow("AJAR_STAND_IN_SECONDS", "0.02");
  Session session;
  session.show_pictures(true);
  const uint64_t render = session.update(scene(640, 400, 6));
  const auto found = pictures(session);
  ASSERT_GE(found.size(), 3u);
  EXPECT_GT(found.front().divider, 1);
  std::vector<double> full;
  for (size_t i = 0; i < found.size(); ++i) {
    const ViewPicture& picture = found[i];
    EXPECT_EQ(picture.render, render);
    EXPECT_EQ(picture.not_denoised, "");
    EXPECT_EQ(picture.width, (640 + picture.divider - 1) / picture.divider);
    EXPECT_EQ(picture.height, (400 + picture.divider - 1) / picture.divider);
    EXPECT_EQ(picture.rgba.size(), size_t(4 * picture.width * picture.height));
    if (i > 0) {
      EXPECT_LE(picture.divider, found[i - 1].divider);
    }
    if (picture.divider == 1 && !picture.coarse_light) full.push_back(picture.samples);
  }
  // A picture that is not taken in time is replaced by the next one.
  ASSERT_FALSE(full.empty());
  EXPECT_LE(full.front(), 2.0);
  EXPECT_EQ(full.back(), 6.0);
  for (const double samples : full) EXPECT_TRUE(samples == 1 || samples == 2 || samples == 4 || samples == 6);
  EXPECT_EQ(session.snapshot("Combined").size(), size_t(4 * 640 * 400));
}

TEST(SessionView, a_region_gives_pictures_of_the_region) {
  load_stand_in();
  Session session;
  session.show_pictures(true);
  SceneDescription d = scene(301, 203, 2);
  d.settings.region = {11, 50, 262, 151};
  session.update(d);
  const auto found = pictures(session);
  ASSERT_FALSE(found.empty());
  for (const ViewPicture& picture : found) {
    const ViewSize size = divided(301, 203, d.settings.region, picture.divider);
    EXPECT_EQ(picture.width, size.region[2] - size.region[0]);
    EXPECT_EQ(picture.height, size.region[3] - size.region[1]);
  }
}

TEST(SessionView, a_cancelled_render_delivers_nothing_more) {
  load_stand_in();
  const Variable slow("AJAR_STAND_IN_SECONDS", "0.05");
  Session session;
  session.show_pictures(true);
  for (const double seconds : {0.0, 0.02, 0.06, 0.2}) {
    session.update(scene(320, 200, 1 << 20));
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    session.cancel();
    EXPECT_FALSE(session.take_picture());
    ASSERT_TRUE(session.wait(kHang));
    EXPECT_FALSE(session.take_picture());
    EXPECT_EQ(session.progress().phase, Progress::Phase::Cancelled);
  }
}

TEST(SessionView, a_picture_of_an_old_camera_is_never_delivered) {
  load_stand_in();
  const Variable slow("AJAR_STAND_IN_SECONDS", "0.004");
  Session session;
  session.show_pictures(true);
  SceneDescription d = scene(160, 100, 1 << 20);
  uint64_t render = session.update(d);
  for (int i = 0; i < 60; ++i) {
    if (i % 3 == 0) {
      EXPECT_EQ(next_picture(session).render, render);
    }
    d.settings.width = 160 + i;
    d.settings.region = {0, 0, 160 + i, 100};
    render = session.change_view(d.camera, d.settings);
    if (const auto picture = session.take_picture()) {
      EXPECT_EQ(picture->render, render);
    }
  }
  EXPECT_EQ(next_picture(session).render, render);
}

TEST(SessionView, a_paused_view_gets_the_full_picture_of_a_sample) {
  load_stand_in();
  const Variable slow("AJAR_STAND_IN_SECONDS", "0.02");
  Session session;
  session.show_pictures(true);
  session.pause(true);
  session.update(scene(640, 400, 64));
  ViewPicture picture;
  do {
    picture = next_picture(session);
  } while (picture.divider > 1 || picture.coarse_light);
  EXPECT_EQ(picture.samples, 1.0);
  EXPECT_FALSE(session.wait(0.3));
  EXPECT_FALSE(session.take_picture());
  session.pause(false);
  EXPECT_EQ(next_picture(session).samples, 2.0);
}

TEST(SessionView, a_denoiser_that_fails_leaves_noisy_pictures) {
  load_stand_in();
  Session session;
  session.show_pictures(true);
  {
    const Variable fails("AJAR_STAND_IN_FAILS", "1");
    session.update(scene(64, 40, 4));
    const auto found = pictures(session);
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found.back().not_denoised, "The view is not denoised: Open Image Denoise: the stand-in fails");
    EXPECT_EQ(found.back().rgba, session.snapshot("Combined"));
  }
  const SceneDescription d = scene(64, 40, 4);
  session.change_view(d.camera, d.settings);
  EXPECT_EQ(pictures(session).back().not_denoised, "");
}

// While the artist navigates, the view is path traced. The first picture of the other technique follows later.
TEST(SessionView, a_still_view_of_hidden_light_is_rendered_by_the_technique_of_a_pilot) {
  load_stand_in();
  Session session;
  session.show_pictures(true);
  SceneDescription d = hidden_lamp();
  d.settings.width = d.settings.height = 96;
  d.settings.region = {0, 0, 96, 96};
  d.settings.integrator = "auto";
  d.settings.samples = 1 << 20;
  d.settings.threads = 2;
  const SceneDescription same = d;
  session.update(std::move(d));
  const auto is_path_traced = [&] {
    return session.statistics_json().find("\"integrator\": \"auto\"") != std::string::npos;
  };
  EXPECT_EQ(next_picture(session).samples, 1.0);
  EXPECT_TRUE(is_path_traced());
  double most = 0.0;
  while (is_path_traced()) {
    if (const auto picture = session.take_picture()) most = std::max(most, picture->samples);
    ASSERT_FALSE(session.wait(0.01));
  }
  EXPECT_GE(most, 2.0);
  const ViewPicture changed = next_picture(session);
  EXPECT_NE(session.statistics_json().find("trial of photon mapping"), std::string::npos);
  EXPECT_EQ(changed.not_denoised, "");
  EXPECT_EQ(changed.divider, 1);
  // The choice is remembered, and navigation is path traced again.
  CameraDescription moved_a_little = same.camera;
  moved_a_little.world_from_camera[3] += 0.01f;
  session.change_view(moved_a_little, same.settings);
  next_picture(session);
  EXPECT_TRUE(is_path_traced());
  while (is_path_traced()) ASSERT_FALSE(session.wait(0.01));
  session.cancel();
  ASSERT_TRUE(session.wait(kHang));
}

TEST(SessionView, the_image_below_the_pictures_is_that_of_a_view_without_them) {
  load_stand_in();
  Session noisy, clean;
  clean.show_pictures(true);
  noisy.update(scene(200, 120, 8));
  clean.update(scene(200, 120, 8));
  ASSERT_TRUE(noisy.wait(kHang));
  ASSERT_TRUE(clean.wait(kHang));
  EXPECT_EQ(noisy.snapshot("Combined"), clean.snapshot("Combined"));
}

}  // namespace ajar::test_session_view
