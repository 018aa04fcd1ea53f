// Rooms that light enters through a hole, light hints through this hole, and renders with these hints.
#pragma once

#include <gtest/gtest.h>

#include <limits>

#include <nlohmann/json.hpp>

#include "math/statistics.h"
#include "render/session.h"
#include "transport_scenes.h"

namespace ajar::fixtures {

inline HintDescription hint(const std::string& name, std::vector<Vec3> points, float spread = 0.0872665f) {
  HintDescription h;
  h.name = name;
  h.points = std::move(points);
  h.spread = spread;
  return h;
}

inline SceneDescription scene_named(const std::string& name) {
  for (TransportScene& s : transport_scenes())
    if (s.name == name) return s.description;
  return {};
}

/// A closed room whose lamp is above a floor with a small hole. The part below the floor is lit through the hole,
/// mostly after bounces above the floor. With `dark`, the floor is black on both sides and the lamp illuminates little
/// else, so that all light comes straight through the hole.
inline SceneDescription keyhole(bool dark = false, float half_hole = 0.06f) {
  SceneDescription d = grey_room();
  const int floor = dark ? add_diffuse(d, Color(0.0f)) : 0;
  const auto rectangle = [&](float x0, float x1, float y0, float y1) {
    const Vec3 at(0.5f * (x0 + x1), 0.5f * (y0 + y1), 0.5f);
    add_object(d, plane(1.0f), floor,
               Mat4(Vec4(0.5f * (x1 - x0), 0, 0, 0), Vec4(0, 0.5f * (y1 - y0), 0, 0), Vec4(0, 0, 1, 0), Vec4(at, 1)));
  };
  const float h = half_hole;
  rectangle(-1.0f, -h, -1.0f, 1.0f);
  rectangle(h, 1.0f, -1.0f, 1.0f);
  rectangle(-h, h, -1.0f, -h);
  rectangle(-h, h, h, 1.0f);
  d.lights.push_back(area_lamp(Vec3(-0.6f, 0.0f, 0.9f), Vec3(0.6f, 0, -0.4f), 0.1f, 20.0f));
  if (dark) d.lights[0].spread = 1.0f;
  return d;
}

struct Rendered {
  std::vector<RunningMoments> blocks;   ///< 3 x 3 blocks with three colours
  nlohmann::json statistics;            ///< of the last render
  uint64_t proposed = 0, accepted = 0;  ///< mutations of hints in all renders
};

inline Rendered render_hinted(SceneDescription d, const std::vector<HintDescription>& hints, int seeds,
                              uint32_t first_seed, int samples = 24, const char* integrator = "metropolis") {
  d.hints = hints;
  d.settings.integrator = integrator;
  d.settings.samples = samples;
  d.settings.threads = 2;
  const int size = d.settings.width;
  Rendered r;
  r.blocks.resize(27);
  for (int seed = 0; seed < seeds; ++seed) {
    d.settings.seed = first_seed + uint32_t(seed);
    Session session;
    session.start(d);
    EXPECT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.take_error(), "");
    const auto image = session.snapshot("Combined");
    std::vector<double> sums(27, 0.0);
    for (int i = 0; i < size * size; ++i)
      for (int c = 0; c < 3; ++c)
        sums[size_t(((i / size * 3 / size) * 3 + i % size * 3 / size) * 3 + c)] += double(image[size_t(4 * i + c)]) *
                                                                                   9 / (size * size);
    for (size_t i = 0; i < 27; ++i) r.blocks[i].add(sums[i]);
    r.statistics = nlohmann::json::parse(session.statistics_json());
    for (const auto& h : r.statistics["hints"])
      r.proposed += h["proposed"].get<uint64_t>(), r.accepted += h["accepted"].get<uint64_t>();
  }
  return r;
}

inline const float kNan = std::numeric_limits<float>::quiet_NaN();
inline const Vec3 kLamp(-0.6f, 0.0f, 0.9f);
inline const std::vector<HintDescription> kGood = {
    hint("Through", {kLamp, {1.0f, 0.0f, -0.167f}}, 0.12f),
    hint("Through, then on", {kLamp, {1.0f, 0.0f, -0.167f}, {0.0f, 1.0f, -0.5f}}, 0.4f)};
inline const std::vector<HintDescription> kUseless = {
    hint("Stays above", {kLamp, {1.0f, 0.0f, 0.7f}}, 0.3f),
    hint("Stays above, twice", {kLamp, {1.0f, 0.0f, 0.7f}, {0.0f, 1.0f, 0.8f}}, 0.5f)};
inline const std::vector<HintDescription> kWrong = {
    hint("Everywhere", {kLamp, {0.2f, 0.0f, 0.5f}, {0.0f, 0.0f, 1.0f}}, 3.1f),
    hint("Needle", {kLamp, {1.0f, 0.0f, -0.167f}}, 1e-5f),
    hint("Through the floor", {kLamp, {-0.9f, 0.0f, -0.9f}, {0.0f, 0.0f, 0.0f}}),
    hint("Not a number", {kLamp, {kNan, 0, 0}})};

}  // namespace ajar::fixtures
