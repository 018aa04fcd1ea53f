// Images of one scene with several seeds, for statistics over independent images.
#pragma once

#include <gtest/gtest.h>

#include "render/session.h"
#include "scene_fixtures.h"

namespace ajar::fixtures {

/// The scene and the integrator's settings are those of the description. The scene is built once.
class Renders {
 public:
  explicit Renders(SceneDescription d) : description_(std::move(d)) {}

  int width() const { return description_.settings.width; }
  std::vector<float> combined(uint32_t seed) {
    RenderSettings settings = description_.settings;
    settings.seed = seed;
    if (is_built_) {
      session_.change_view(description_.camera, settings);
    } else {
      SceneDescription first = description_;
      first.settings = settings;
      session_.start(std::move(first));
    }
    is_built_ = true;
    EXPECT_TRUE(session_.wait(kHang));
    EXPECT_EQ(session_.take_error(), "");
    return session_.snapshot("Combined");
  }
  /// Another pass of the latest image, which the settings must ask for.
  std::vector<float> pass(const std::string& name) const { return session_.snapshot(name); }

 private:
  SceneDescription description_;
  Session session_;
  bool is_built_ = false;
};

inline SceneDescription with(SceneDescription d, const std::string& integrator, int samples, int threads = 2) {
  d.settings.integrator = integrator;
  d.settings.samples = samples;
  d.settings.threads = threads;
  return d;
}

inline std::vector<float> render(SceneDescription d, const std::string& integrator, int samples, uint32_t seed,
                                 int threads = 2) {
  return Renders(with(std::move(d), integrator, samples, threads)).combined(seed);
}

}  // namespace ajar::fixtures
