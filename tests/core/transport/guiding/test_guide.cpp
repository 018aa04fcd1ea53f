// Tests of the learned density of directions, and of the path tracer that uses it.
#include "agreement.h"
#include "feature_scenes.h"

#include "math/frame.h"
#include "math/warps.h"
#include "transport/guiding/guided_bsdf.h"
#include "transport/guiding/path_guide.h"

namespace ajar::test_guide {

namespace {

using namespace fixtures;
using namespace statistical;

/// A known density that is sampled by a uniform one, with importance weights.
struct Teacher {
  struct Lobe {
    Vec3 mean;
    float kappa, weight;
  };
  std::vector<Lobe> lobes;
  float pdf(Vec3 w) const {
    float sum = 0.0f;
    for (const Lobe& lobe : lobes)
      sum += lobe.weight * von_mises_fisher::pdf_solid_angle(lobe.kappa, length_squared(w - lobe.mean));
    return sum;
  }
  std::vector<GuideSample> teach(int n, uint64_t seed) const {
    Pcg32 rng(seed);
    std::vector<GuideSample> samples;
    for (int i = 0; i < n; ++i) {
      const Vec2 u(rng.next_float(), rng.next_float());
      const Vec3 w = warp::square_to_sphere(u);
      // The density of the BSDF is uniform.
      samples.push_back({Vec3(rng.next_float(), rng.next_float(), 0.0f), Vec3(0, 0, 1), w, 0.0f,
                         pdf(w) / warp::sphere_pdf_solid_angle(), warp::sphere_pdf_solid_angle(), GuideKind::Diffuse});
    }
    return samples;
  }
};
std::vector<const GuideSample*> pointers(const std::vector<GuideSample>& samples) {
  std::vector<const GuideSample*> all;
  for (const GuideSample& s : samples) all.push_back(&s);
  return all;
}
GuideDistribution taught(const std::vector<GuideSample>& samples, int iterations = 20) {
  GuideDistribution d;
  const auto all = pointers(samples);
  d.start(Vec3(0.5f, 0.5f, 0.0f), all);
  d.fit(all, {0.0f, GuideTree::kWidthPriorOfGatherRays, iterations});
  return d;
}

TEST(VonMisesFisher, exponential_is_exact_to_two_ten_millionths) {
  for (float x = 0.0f; x > -80.0f; x -= 0.00937f)
    EXPECT_NEAR(double(exp_of_negative(x)) / std::exp(double(x)), 1.0, 2e-7 + 1.2e-7 * double(-x))
        << x;  // the second term is the rounding error of x
  EXPECT_LT(exp_of_negative(-1e30f), 1e-37f);
  EXPECT_GE(exp_of_negative(-1e30f), 0.0f);
}

TEST(VonMisesFisher, samples_follow_their_density) {
  for (const float kappa : {1e-2f, 1.0f, 20.0f, 2000.0f, 1e5f}) {
    const auto map = [=](Vec2 u) { return std::optional(von_mises_fisher::square_to_lobe(u, kappa)); };
    const auto pdf = [=](Vec3 w) {
      return von_mises_fisher::pdf_solid_angle(kappa, length_squared(w - Vec3(0, 0, 1)));
    };
    EXPECT_TRUE(chi_square_agrees(from_square(map), pdf,
                                  {.domain = statistical::SampleDomain::Sphere, .level = {.test_count = 5}}))
        << kappa;
  }
}

TEST(VonMisesFisher, corners_of_the_square_stay_on_the_sphere) {
  for (const float kappa : {kMinKappa, 1.0f, 100.0f, kMaxKappa})
    for (const float x : {0.0f, 0x1p-24f, 0.5f, kOneMinusEpsilon})
      for (const float y : {0.0f, 0.5f, kOneMinusEpsilon})
        EXPECT_NEAR(glm::length(von_mises_fisher::square_to_lobe({x, y}, kappa)), 1.0f, 1e-6f) << kappa;
}

TEST(GuideLobes, samples_follow_the_learned_density_at_all_points) {
  std::vector<GuideSample> samples = Teacher{
      {{glm::normalize(Vec3(1, 0, 1)), 300.0f, 0.5f},
       {glm::normalize(Vec3(-1, 1, 0.2f)), 12.0f,
        0.5f}}}.teach(4000, 1);
  // The light comes from a distance of two metres, so that the lobes at a corner of the cell have other directions.
  for (GuideSample& s : samples) s.inverse_distance = 0.5f;
  const GuideDistribution learned = taught(samples);
  for (const Vec3 from : {Vec3(0.5f, 0.5f, 0.0f), Vec3(1.4f, -0.3f, 0.5f)}) {
    GuideLobes lobes;
    learned.aim(from, lobes);
    const auto sample = [&](Pcg32& rng) {
      const float u_lobe = rng.next_float(), x = rng.next_float();
      return std::optional(learned.sample(lobes, u_lobe, {x, rng.next_float()}));
    };
    EXPECT_TRUE(chi_square_agrees(sample, [&](Vec3 w) { return pdf_solid_angle(lobes, w); },
                                  {.domain = statistical::SampleDomain::Sphere, .level = {.test_count = 2}}));
  }
}

TEST(GuideLobes, known_mixture_is_recovered_from_importance_weights) {
  const Teacher teacher{
      {{glm::normalize(Vec3(1, 0, 1)), 80.0f, 0.7f}, {glm::normalize(Vec3(-1, 1, 0.2f)), 25.0f, 0.3f}}};
  const GuideDistribution learned = taught(teacher.teach(20000, 2));
  GuideLobes lobes;
  learned.aim(learned.center(), lobes);
  // The Kullback-Leibler divergence, by quadrature over the sphere. The share is the maximum, since the uniform BSDF is
  // a bad density.
  Pcg32 rng(3);
  double divergence = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const Vec3 w = warp::square_to_sphere({(float(i) + 0.5f) / n, rng.next_float()});
    const double p = double(teacher.pdf(w));
    divergence += p * std::log(std::max(p, 1e-30) / double(pdf_solid_angle(lobes, w))) * 4.0 * double(kPi) / n;
  }
  EXPECT_LT(divergence, 0.05);
  EXPECT_GT(divergence, -0.02);
  EXPECT_NEAR(learned.share(GuideKind::Diffuse), 0.5f, 0.001f);  // the maximum share
}

/// In each training step, the sums of the past are multiplied by one half.
TEST(GuideLobes, a_thousand_training_steps_do_not_drift) {
  const Teacher teacher{
      {{glm::normalize(Vec3(1, 0, 1)), 80.0f, 0.7f}, {glm::normalize(Vec3(-1, 1, 0.2f)), 25.0f, 0.3f}}};
  GuideDistribution learned = taught(teacher.teach(2000, 1));
  Pcg32 rng(3);
  for (int round = 0; round < 1000; ++round) {
    learned.move_to(Vec3(0.5f + 0.01f * (rng.next_float() - 0.5f), 0.5f, 0.0f));
    const auto samples = teacher.teach(500, 10 + uint64_t(round));
    learned.fit(pointers(samples), {0.5f, GuideTree::kWidthPriorOfGatherRays, 1});
  }
  GuideLobes lobes;
  learned.aim(learned.center(), lobes);
  double integral = 0.0, divergence = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const Vec3 w = warp::square_to_sphere({(float(i) + 0.5f) / n, rng.next_float()});
    const double p = double(teacher.pdf(w)), q = double(pdf_solid_angle(lobes, w));
    integral += q * 4.0 * double(kPi) / n;
    divergence += p * std::log(std::max(p, 1e-30) / q) * 4.0 * double(kPi) / n;
  }
  EXPECT_NEAR(integral, 1.0, 0.02);
  EXPECT_LT(divergence, 0.1);  // for training steps of 500 samples each
}

TEST(GuideLobes, the_share_of_the_guide_falls_where_the_bsdf_is_the_better_density) {
  // The incident light is proportional to the density of the BSDF.
  Pcg32 rng(4);
  std::vector<GuideSample> samples;
  for (int i = 0; i < 4000; ++i) {
    const float u = rng.next_float();
    const Vec3 w = warp::square_to_cosine_hemisphere({u, rng.next_float()});
    samples.push_back(
        {Vec3(0.0f), Vec3(0, 0, 1), w, 0.0f, 1.0f, warp::cosine_hemisphere_pdf_solid_angle(w.z), GuideKind::Diffuse});
  }
  EXPECT_LT(taught(samples, 200).share(GuideKind::Diffuse), 0.35f);
  EXPECT_GT(taught(samples, 3).share(GuideKind::Diffuse), taught(samples, 200).share(GuideKind::Diffuse));
}

TEST(GuideLobes, extreme_samples_give_a_valid_density) {
  const auto check = [](std::vector<GuideSample> samples) {
    const GuideDistribution d = taught(samples, 5);
    GuideLobes lobes;
    d.aim(Vec3(1e4f, 0, 0), lobes);
    double integral = 0.0;
    Pcg32 rng(5);
    const int n = 400;
    for (int i = 0; i < n; ++i) {
      const Vec3 w = d.sample(lobes, rng.next_float(), {rng.next_float(), rng.next_float()});
      EXPECT_NEAR(glm::length(w), 1.0f, 1e-5f);
      EXPECT_GT(pdf_solid_angle(lobes, w), 0.0f);
      EXPECT_TRUE(std::isfinite(pdf_solid_angle(lobes, w)));
    }
    for (const float weight : d.weights()) integral += double(weight);
    EXPECT_NEAR(integral, 1.0, 1e-5);
  };
  const GuideSample one{Vec3(0.0f), Vec3(0, 0, 1), Vec3(0, 0, 1), 1e6f, 1.0f, 0.3f, GuideKind::Diffuse};
  check({one});
  check(std::vector<GuideSample>(1000, one));
  GuideSample black = one, glaring = one;
  black.weight = 0.0f;
  glaring.weight = 1e30f;
  check({black, black});
  check({black, one, glaring});
  GuideTree tree;
  tree.learn({});
  EXPECT_EQ(tree.find(Vec3(0.0f), Vec3(0, 0, 1)), nullptr);
  tree.learn(std::vector<GuideSample>(5000, black));
  tree.learn(std::vector<GuideSample>(5000, one));  // all at one point, so that the cell is not divided
  EXPECT_LE(tree.cell_count(), 1u);
}

TEST(GuideTree, walls_that_meet_in_a_corner_have_separate_cells) {
  Pcg32 rng(6);
  std::vector<GuideSample> samples;
  for (int i = 0; i < 3000; ++i) {
    const bool floor = i & 1;
    const Vec3 n = floor ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
    samples.push_back({Vec3(0.01f * rng.next_float()), n, n, 0.0f, 1.0f, 0.1f, GuideKind::Diffuse});
  }
  GuideTree tree;
  tree.learn(samples);
  const GuideDistribution* const floor = tree.find(Vec3(0.005f), Vec3(0, 0, 1));
  const GuideDistribution* const wall = tree.find(Vec3(0.005f), Vec3(1, 0, 0));
  ASSERT_TRUE(floor && wall);
  GuideLobes lobes;
  floor->aim(Vec3(0.005f), lobes);
  EXPECT_GT(pdf_solid_angle(lobes, Vec3(0, 0, 1)), 100.0f * pdf_solid_angle(lobes, Vec3(1, 0, 0)));
}

TEST(GuidedBsdf, the_mixture_with_the_bsdf_is_a_density) {
  GuideTree tree;
  std::vector<GuideSample> samples = Teacher{{{glm::normalize(Vec3(1, 0, 1)), 100.0f, 1.0f}}}.teach(300, 7);
  tree.learn(samples);
  Bsdf bsdf;
  bsdf.start(Vec3(0, 0, 1), Vec3(0, 0, 1));
  Lobe lobe;
  lobe.weight = Color(0.5f);
  bsdf.add(lobe);
  Lobe clear;
  clear.kind = LobeKind::Transparent;
  clear.weight = Color(0.5f);
  bsdf.add(clear);
  const Vec3 wo = glm::normalize(Vec3(0.3f, 0.1f, 1));
  bsdf.prepare(wo);
  GuidedBsdf guided;
  guided.start(&tree, bsdf, Vec3(0.5f, 0.5f, 0.0f), 0.75f);
  ASSERT_TRUE(guided.guided());
  EXPECT_NEAR(guided.delta_probability(), 0.5f, 1e-5f);
  // Refused samples: those of the transparent half, and those of the guide below the surface.
  const auto sample = [&](Pcg32& rng) -> std::optional<Vec3> {
    const float u_guide = rng.next_float(), u_lobe = rng.next_float(), x = rng.next_float();
    float pdf_bsdf;
    const auto s = guided.sample(wo, u_guide, u_lobe, {x, rng.next_float()}, pdf_bsdf);
    if (!s || s->specular) return std::nullopt;
    EXPECT_FLOAT_EQ(s->pdf_solid_angle, guided.pdf_solid_angle(bsdf.pdf_solid_angle(wo, s->wi), s->wi));
    return s->wi;
  };
  const auto pdf = [&](Vec3 w) {
    const float p = bsdf.pdf_solid_angle(wo, w);
    return p > 0.0f ? guided.pdf_solid_angle(p, w) : 0.0f;
  };
  EXPECT_TRUE(chi_square_agrees(sample, pdf, {.domain = statistical::SampleDomain::Sphere}));
}

TEST(GuidedPhase, the_mixture_with_the_phase_function_is_a_density) {
  std::vector<GuideSample> samples = Teacher{{{glm::normalize(Vec3(1, 0, 1)), 100.0f, 1.0f}}}.teach(300, 11);
  for (GuideSample& sample : samples) sample.kind = GuideKind::Volume;
  GuideTree tree;
  tree.learn(samples);
  EXPECT_EQ(tree.find(Vec3(0.5f, 0.5f, 0.0f), Vec3(0, 0, 1)),
            nullptr);  // what volumes teach says nothing about surfaces
  MediumPoint medium;
  medium.add_scattering(Color(0.3f), PhaseShape::henyey_greenstein(0.5f));
  medium.add_scattering(Color(0.1f), PhaseShape::henyey_greenstein(-0.2f));
  const PhaseFunction phase(medium);
  const Vec3 direction = glm::normalize(Vec3(0.2f, 0.9f, -0.3f)), place(0.5f, 0.5f, 0.0f);
  const auto sample = [&](Pcg32& rng) -> std::optional<Vec3> {
    const float u_guide = rng.next_float(), u_lobe = rng.next_float(), x = rng.next_float();
    const PhaseSample s = sample_phase_guided(phase, direction, &tree, place, 0.75f,
                                              {u_guide, u_lobe, {x, rng.next_float()}});
    EXPECT_FLOAT_EQ(s.pdf_phase, phase.pdf_solid_angle(glm::dot(direction, s.wi)));
    return s.wi;
  };
  const GuideDistribution* const found = tree.find_in_volume(place);
  ASSERT_TRUE(found && found->share(GuideKind::Volume) > 0.0f);
  GuideLobes lobes;
  found->aim(place, lobes);
  const float share = 0.75f * found->share(GuideKind::Volume);
  const auto pdf = [&](Vec3 w) {
    return (1.0f - share) * phase.pdf_solid_angle(glm::dot(direction, w)) + share * pdf_solid_angle(lobes, w);
  };
  EXPECT_TRUE(chi_square_agrees(sample, pdf, {.domain = statistical::SampleDomain::Sphere}));
}

/// A wrong guide: at eight vertices it points away from the direction of the path.
TEST(GuidedBsdf, the_density_of_a_path_is_at_least_a_fixed_share_of_the_unguided_one) {
  GuideTree tree;
  tree.learn(Teacher{{{glm::normalize(Vec3(1, 0, 1)), 500.0f, 1.0f}}}.teach(300, 8));
  Bsdf bsdf;
  bsdf.start(Vec3(0, 0, 1), Vec3(0, 0, 1));
  const Vec3 wo(0, 0, 1);
  bsdf.set_lambert(Color(0.5f), wo);
  const Vec3 wi = glm::normalize(Vec3(-1, 0, 1));
  const float pdf_bsdf = bsdf.pdf_solid_angle(wo, wi);
  float plain = kPlainShareOfPaths;
  double product = 1.0, by_shares_alone = 1.0;
  for (int vertex = 0; vertex < 8; ++vertex) {
    GuidedBsdf guided, distrustless;
    guided.start(&tree, bsdf, Vec3(0.5f, 0.5f, 0.0f), 1.0f - plain);
    distrustless.start(&tree, bsdf, Vec3(0.5f, 0.5f, 0.0f), 1.0f);
    const float pdf = guided.pdf_solid_angle(pdf_bsdf, wi);
    product *= double(pdf) / double(pdf_bsdf);
    by_shares_alone *= double(distrustless.pdf_solid_angle(pdf_bsdf, wi)) / double(pdf_bsdf);
    plain *= pdf_bsdf / pdf;
  }
  EXPECT_GT(product, double(kPlainShareOfPaths));
  EXPECT_LT(by_shares_alone, 0.02);
  EXPECT_LE(plain, 1.0f);
}

/// A walk of three vertices in a field of light. At each vertex it finds light, and the light in its direction. A part
/// of the directions of the guide is below the surface.
struct ToyWalk {
  GuideTree tree;
  Bsdf bsdf;
  ToyWalk() {
    tree.learn(Teacher{{{glm::normalize(Vec3(1, 0, 0.1f)), 8.0f, 1.0f}}}.teach(300, 9));
    bsdf.start(Vec3(0, 0, 1), Vec3(0, 0, 1));
    bsdf.set_lambert(Color(0.7f), Vec3(0, 0, 1));
  }
  static float light(Vec3 wi) { return wi.x > 0.8f ? 8.0f : 0.1f; }
  /// Returns the light of the walk.
  float sample(const GuideTree* guide, Pcg32& rng, GuidedPath& path) const {
    float sum = 0.0f, beta = 1.0f;
    const auto add = [&](float y) {
      sum += y;
      path.note_light(y);
    };
    for (int vertex = 0; vertex < 3; ++vertex) {
      path.bsdf.start(guide, bsdf, Vec3(0.5f, 0.5f, 0.0f), 1.0f - path.plain);
      add(beta * 0.1f);
      const float u_guide = rng.next_float(), u_lobe = rng.next_float(), x = rng.next_float();
      float pdf_bsdf;
      const auto s = path.bsdf.sample(Vec3(0, 0, 1), u_guide, u_lobe, {x, rng.next_float()}, pdf_bsdf);
      if (!s || !(s->pdf_solid_angle > 0.0f)) {
        path.note_failure(u_guide, u_lobe);
        break;
      }
      path.note_direction(pdf_bsdf, s->pdf_solid_angle);
      beta *= s->f_cos.x / s->pdf_solid_angle;
      path.hit_weight = 1.0f;
      add(beta * light(s->wi));
    }
    return sum;
  }
};

TEST(GuidedPaths, tell_the_second_moment_of_unguided_paths) {
  const ToyWalk walk;
  Pcg32 rng(10);
  RunningMoments told, actual, guided, share;
  for (int i = 0; i < 1100000; ++i) {
    GuidedPath with, without;
    const double y = double(walk.sample(&walk.tree, rng, with)), unguided = double(walk.sample(nullptr, rng, without));
    const Guided::Outcome outcome = with.outcome();
    told.add(double(outcome.share) * double(outcome.unguided) * double(outcome.unguided));
    share.add(double(outcome.share));
    guided.add(y * y);
    actual.add(unguided * unguided);
  }
  EXPECT_TRUE(means_agree(told, actual, {0.01, 2})) << told.mean() << " " << actual.mean();
  EXPECT_TRUE(mean_agrees(share, 1.0, {0.01, 2}));
  EXPECT_LT(std::sqrt(told.variance_of_mean() + actual.variance_of_mean()), 0.005 * actual.mean());  // sees 2 %
  EXPECT_GT(std::abs(guided.mean() - actual.mean()), 0.1 * actual.mean());
}

/// With few samples, the test would detect the bias of a sample that influences its own density.
TEST(GuidedPaths, agree_with_unguided_ones_while_they_learn) {
  std::vector<TransportScene> scenes;
  for (TransportScene& scene : transport_scenes()) {
    const auto is = [&](const char* name) { return scene.name == name; };
    // With few bounces of each type, the type of a guided direction must be sampled as the BSDF does.
    if (is("glossy") || is("rough_glass_and_mirror")) {
      scenes.push_back({scene.name + "_limited", scene.description});
      scenes.back().description.settings.bounces = {4, 1, 1, 2, 2, 0};
    }
    if (is("area_lamp") || is("glossy") || is("rough_glass_and_mirror") || is("sphere_and_spot"))
      scenes.push_back(std::move(scene));
  }
  for (TransportScene& scene : feature_scenes())
    if (scene.name == "fog_around_the_camera" || scene.name == "forward_scattering_fog" ||
        scene.name == "uneven_smoke" || scene.name == "glowing_volume")
      scenes.push_back(std::move(scene));
  ASSERT_EQ(scenes.size(), 10u);
  const int tests = int(scenes.size());
  for (const TransportScene& scene : scenes) {
    SceneDescription guided = scene.description;
    guided.settings.guiding = Guiding::On;
    const bool in_media = build(scene.description)->has_media();
    const auto expected = blocks(scene.description, "path", 32, 16, 100),
               actual = blocks(guided, "path", 16, 24, in_media ? 400 : 200);
    for (int i = 0; i < kValues; ++i) {
      if (i % 4 == 3 && std::abs(expected[size_t(i)].mean() - actual[size_t(i)].mean()) < 1e-5)
        continue;  // alpha differs by rounding
      EXPECT_TRUE(means_agree(expected[size_t(i)], actual[size_t(i)], {0.01, kValues * tests}))
          << scene.name << ", block " << i / 4 << ", channel " << i % 4;
    }
    if (!in_media) continue;
    double sum = 0.0, variance = 0.0;
    for (size_t i = 1; i < size_t(kValues); i += 4) {
      sum += expected[i].mean();
      variance += expected[i].variance_of_mean() + actual[i].variance_of_mean();
    }
    EXPECT_LT(3.0 * std::sqrt(variance), 0.02 * sum) << scene.name << ": a bias of 2 % would not be seen";
  }
}

/// A lamp that points at the wall, so that all light comes from the lit part of the wall.
SceneDescription screened_room(int size) {
  SceneDescription d = grey_room(size);
  d.lights.push_back(area_lamp(Vec3(0.9f, 0.0f, 0.5f), Vec3(1, 0, 0), 0.2f, 20.0f));
  return d;
}

TEST(GuidedPaths, the_image_does_not_depend_on_the_number_of_threads) {
  for (Guiding mode : {Guiding::On, Guiding::Auto}) {
    SceneDescription d = screened_room(40);
    d.settings.guiding = mode;
    EXPECT_EQ(render(d, "path", 24, 3, 1), render(d, "path", 24, 3, 2)) << name_of(mode);
  }
}

/// Sum of the variances of the pixels of a path traced image.
double path_variance(SceneDescription d, Guiding mode) {
  d.settings.guiding = mode;
  d.settings.passes = {"Combined"};
  std::vector<RunningMoments> pixels;
  for (uint32_t seed = 0; seed < 8; ++seed) {
    const auto image = render(d, "path", 64, 40 + seed);
    pixels.resize(image.size() / 4);
    for (size_t i = 0; i < pixels.size(); ++i) pixels[i].add(double(image[4 * i + 1]));
  }
  double sum = 0.0;
  for (const RunningMoments& p : pixels) sum += p.variance_of_mean();
  return sum;
}

TEST(GuidedPaths, lower_the_variance_of_light_from_a_small_lit_part_of_a_wall) {
  const SceneDescription d = screened_room(24);
  EXPECT_LT(path_variance(d, Guiding::On), 0.6 * path_variance(d, Guiding::Off));
}

/// The boundary of the volume is between the wall and what it lights.
TEST(GuidedPaths, lower_the_variance_of_that_light_in_fog) {
  SceneDescription d = screened_room(24);
  add_object(d, textured_cube(), add_medium(d, "ShaderNodeVolumeScatter", Color(0.9f), Vec2(0.1f)),
             moved(Vec3(0.0f), 0.98f));
  d.settings.bounces.volume = 8;
  EXPECT_LT(path_variance(d, Guiding::On), 0.5 * path_variance(d, Guiding::Off));
}

/// The guide learns the distance to the wall, not that to the clear surface before it.
TEST(GuidedPaths, lower_the_variance_of_that_light_behind_a_clear_surface) {
  SceneDescription d = screened_room(24);
  add_object(d, cube(), add_closure(d, "ShaderNodeBsdfTransparent", {value_input("Color", Vec4(1.0f))}),
             moved(Vec3(0.0f), 0.98f));
  EXPECT_LT(path_variance(d, Guiding::On), 0.5 * path_variance(d, Guiding::Off));
}

TEST(GuidedPaths, auto_does_not_follow_the_guide_where_it_gains_nothing) {
  // A convex object in a constant world, for which the BSDF is the best density.
  SceneDescription d;
  add_object(d, sphere(), add_diffuse(d, Color(0.5f)));
  set_camera(d, Vec3(0, -4, 0), Vec3(0), 32);
  set_world(d, Color(1.0f));
  d.settings.integrator = "path";
  d.settings.guiding = Guiding::Auto;
  d.settings.samples = 32;
  Session session;
  session.start(d);
  ASSERT_TRUE(session.wait(kHang));
  EXPECT_EQ(session.take_error(), "");
  EXPECT_NE(session.statistics_json().find("\"guide_followed\": 0.0"), std::string::npos);
}

TEST(GuidedPaths, the_measured_gain_does_not_depend_on_light_power_times_exposure) {
  const auto gain = [](float times) {
    SceneDescription d = screened_room(24);
    d.lights[0].energy *= times;
    d.settings.exposure = 1.0f / times;
    d.settings.integrator = "path";
    d.settings.guiding = Guiding::Auto;
    d.settings.samples = 32;
    Session session;
    session.start(d);
    EXPECT_TRUE(session.wait(kHang));
    EXPECT_EQ(session.take_error(), "");
    const std::string statistics = session.statistics_json(), key = "\"guide_measured_gain\": ";
    const size_t at = statistics.find(key);
    EXPECT_NE(at, std::string::npos);
    return at == std::string::npos ? 0.0 : std::stod(statistics.substr(at + key.size()));
  };
  const double plain = gain(1.0f);
  EXPECT_GT(plain, 0.0);
  EXPECT_NEAR(gain(4096.0f), plain, 0.01 * plain);
  EXPECT_NEAR(gain(1.0f / 4096.0f), plain, 0.01 * plain);
}

}  // namespace

}  // namespace ajar::test_guide
