#include <gtest/gtest.h>

#include "bsdf_fixtures.h"
#include "render/session.h"
#include "scene_fixtures.h"
#include "statistical.h"
#include "transport/direct/estimators/make_estimator.h"

namespace ajar::test_lobe_components {

using namespace fixtures;
using statistical::DensityTest;

namespace {

const Color kWhite(1.0f);
const Vec3 kTangent(1, 0, 0);

Material coated_diffuse(float roughness, float share) {
  return {"coated diffuse", [=](Bsdf& b, const closures::Surface& s) {
            closures::add_diffuse(b, s, (1.0f - share) * kWhite, s.ng, 0.0f);
            closures::add_glossy(b, s, share * kWhite, s.ng, {closures::Distribution::Ggx, roughness},
                                 {kTangent, 0.0f, 0.0f});
          }};
}

/// Surfaces with two or three components.
std::vector<Material> several_lobes() {
  using namespace closures;
  std::vector<Material> list{coated_diffuse(0.2f, 0.05f)};
  for (int version : {1, 2}) {
    list.push_back({"principled, version " + std::to_string(version), [=](Bsdf& b, const Surface& s) {
                      PrincipledInputs in;
                      in.version = version;
                      in.roughness = 0.35f;
                      in.clearcoat = in.sheen = 1.0f;
                      in.clearcoat_roughness = 0.1f;
                      add_principled(b, s, kWhite, in);
                    }});
  }
  list.push_back({"diffuse and glass", [](Bsdf& b, const Surface& s) {
                    add_diffuse(b, s, 0.5f * kWhite, s.ng, 0.0f);
                    add_glass(b, s, 0.5f * kWhite, s.ng, {Distribution::Ggx, 0.3f, 1.5f});
                  }});
  // More lobes than components, one with a rotated normal.
  list.push_back({"five lobes", [](Bsdf& b, const Surface& s) {
                    add_diffuse(b, s, 0.2f * kWhite, s.ng, 0.0f);
                    add_translucent(b, s, 0.2f * kWhite, s.ng);
                    for (float roughness : {0.1f, 0.4f})
                      add_glossy(b, s, 0.2f * kWhite, s.ng, {Distribution::Ggx, roughness}, {kTangent, 0.0f, 0.0f});
                    const Vec3 turned = glm::normalize(s.ng + 0.3f * kTangent);
                    add_glossy(b, s, 0.2f * kWhite, turned, {Distribution::Ggx, 0.3f}, {Frame(turned).s, 0.0f, 0.0f});
                  }});
  return list;
}

}  // namespace

TEST(LobeComponents, each_is_sampled_with_the_density_it_states) {
  const int count = LobeComponents::kMax * (int(several_lobes().size()) + 1);
  for (const Material& material : several_lobes()) {
    for (float cosine : {0.9f, 0.35f}) {
      if (cosine > 0.5f && material.name != "five lobes") continue;
      const Vec3 wo = direction(cosine);
      const Bsdf bsdf = make_bsdf(material, wo);
      const LobeComponents lobes(bsdf, wo, true);
      ASSERT_GE(lobes.count(), 2) << material;
      for (int i = 0; i < lobes.count(); ++i) {
        DensityTest test;
        test.sample_count = 20000;
        test.bin_count = 64;
        test.integral_tolerance = 0.01;
        test.level = {0.01, count};
        const auto sample = [&](Pcg32& rng) -> std::optional<Vec3> {
          const float u_lobe = rng.next_float(), ux = rng.next_float();
          const auto drawn = lobes.sample(i, wo, u_lobe, {ux, rng.next_float()});
          return drawn ? std::optional(drawn->wi) : std::nullopt;
        };
        EXPECT_TRUE(statistical::chi_square_agrees(
            sample, [&](Vec3 wi) { return lobes.evaluate(wo, wi).pdf[size_t(i)]; }, test))
            << material << ", component " << i << ", cosine " << cosine;
      }
    }
  }
}

TEST(LobeComponents, their_sum_is_the_bsdf) {
  Pcg32 rng(5);
  for (const Material& material : several_lobes()) {
    const Vec3 wo = direction(0.7f);
    const Bsdf bsdf = make_bsdf(material, wo);
    const LobeComponents lobes(bsdf, wo, true);
    for (int n = 0; n < 300; ++n) {
      const int i = n % lobes.count();
      const float u_lobe = rng.next_float(), ux = rng.next_float();
      const auto drawn = lobes.sample(i, wo, u_lobe, {ux, rng.next_float()});
      if (!drawn) continue;
      const Bsdf::Evaluation whole = bsdf.evaluate(wo, drawn->wi);
      const LobeComponents::Evaluation parts = lobes.evaluate(wo, drawn->wi);
      float pdf = 0.0f;
      // The prior is the mean of equal shares and of the probabilities in sampling of the whole BSDF.
      for (int k = 0; k < lobes.count(); ++k) {
        pdf += (2.0f * lobes.prior(k) - 1.0f / float(lobes.count())) * parts.pdf[size_t(k)];
        EXPECT_NEAR(drawn->value.pdf[size_t(k)], parts.pdf[size_t(k)], 1e-4f * parts.pdf[size_t(k)]) << material;
      }
      EXPECT_NEAR(pdf, whole.pdf_solid_angle, 1e-4f * whole.pdf_solid_angle) << material;
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(parts.f_cos[c], whole.f_cos[c], 1e-4f * whole.f_cos[c]) << material;
        EXPECT_NEAR(drawn->value.f_cos[c], whole.f_cos[c], 1e-4f * whole.f_cos[c]) << material;
      }
    }
  }
}

TEST(LobeComponents, similar_lobes_are_one_component_and_mirrors_none) {
  using namespace closures;
  const Vec3 wo = direction(0.7f);
  const auto components = [&](std::function<void(Bsdf&, const Surface&)> add) {
    const Bsdf bsdf = make_bsdf({"", std::move(add)}, wo);
    const LobeComponents lobes(bsdf, wo, true);
    EXPECT_EQ(lobes.signature() == 0, lobes.count() == 1);
    return lobes.count();
  };
  const auto glossy = [](Bsdf& b, const Surface& s, float roughness) {
    add_glossy(b, s, kWhite, s.ng, {Distribution::Ggx, roughness}, {kTangent, 0.0f, 0.0f});
  };
  EXPECT_EQ(components([](Bsdf& b, const Surface& s) {
              add_diffuse(b, s, kWhite, s.ng, 0.0f), add_velvet(b, s, kWhite, s.ng, 0.5f);
            }),
            1);
  EXPECT_EQ(components([&](Bsdf& b, const Surface& s) { add_diffuse(b, s, kWhite, s.ng, 0.0f), glossy(b, s, 0.5f); }),
            1);
  EXPECT_EQ(components([&](Bsdf& b, const Surface& s) { add_diffuse(b, s, kWhite, s.ng, 0.0f), glossy(b, s, 0.3f); }),
            2);
  EXPECT_EQ(components([&](Bsdf& b, const Surface& s) { glossy(b, s, 0.6f), glossy(b, s, 0.3f), glossy(b, s, 0.1f); }),
            2);

  // Sampling a BSDF of a diffuse lobe and a mirror chooses the mirror with probability one half. Sampling the diffuse
  // component never does.
  const Bsdf bsdf = make_bsdf(
      {"", [&](Bsdf& b, const Surface& s) { add_diffuse(b, s, kWhite, s.ng, 0.0f), glossy(b, s, 0.0f); }}, wo);
  const LobeComponents lobes(bsdf, wo, true);
  ASSERT_EQ(lobes.count(), 1);
  Pcg32 rng(2);
  for (int i = 0; i < 100; ++i) {
    const float u_lobe = rng.next_float(), ux = rng.next_float();
    const auto drawn = lobes.sample(0, wo, u_lobe, {ux, rng.next_float()});
    ASSERT_TRUE(drawn);
    EXPECT_NEAR(drawn->value.pdf[0], drawn->wi.z * kInvPi, 1e-5f);
  }
}

// ---- Direct light ------------------------------------------------------------------------------

namespace {

/// A floor with a weak, sharp coat that reflects a large dim lamp, and a small bright lamp. With `coat` 0 it is
/// diffuse.
SceneDescription coated_floor(float coat) {
  SceneDescription d;
  MaterialDescription material;
  material.name = "Coated";
  Node mix;
  mix.type = mix.name = "ShaderNodeMixShader";
  mix.inputs = {{"Fac", {}, Vec4(coat)}, {"Shader", {0, "BSDF"}, Vec4(0.0f)}, {"Shader_001", {1, "BSDF"}, Vec4(0.0f)}};
  material.graph.nodes = {closure_node("ShaderNodeBsdfDiffuse", Color(0.8f)),
                          closure_node("ShaderNodeBsdfGlossy", kWhite), mix};
  material.graph.nodes[1].inputs.push_back({"Roughness", {}, Vec4(0.2f)});
  material.graph.surface = {2, "Shader"};
  d.materials.push_back(material);
  add_object(d, plane(4.0f), 0);
  for (const auto& [position, watts, size] :
       {std::tuple(Vec3(0, 3, 2), 40.0f, 2.0f), {Vec3(-1, 0.5f, 1), 20.0f, 0.05f}}) {
    LightDescription light = point_light(position, watts);
    light.kind = LightKind::Area;
    light.area_size = Vec2(size);
    d.lights.push_back(light);
  }
  set_camera(d, Vec3(0, -1.5f, 1), Vec3(0), 8, 0.1f);
  d.settings.bounces.total = 0;
  return d;
}

/// The lobes of a surface are separate components of the mixture, or one component.
enum class Lobes : uint8_t { Apart, Together };

/// Estimates of the direct light at one point of the floor.
class PointOfFloor {
 public:
  explicit PointOfFloor(float coat) : scene_(build(coated_floor(coat))) {
    const Ray ray = scene_->camera().generate_ray(Vec2(4.0f), Vec2(0.5f), 0.0f);
    const Hit hit = scene_->intersect(ray, kRayCamera);
    scene_->shading_point(ray, hit, point_);
    scene_->material(hit).evaluate_surface(point_, shading_);
  }
  const Bsdf& bsdf() const { return shading_.bsdf; }

  /// The correct value, by the midpoint rule over each lamp. No lamp is occluded.
  double truth() const {
    constexpr int kGrid = 500;
    double sum = 0.0;
    for (uint32_t light = 0; light < scene_->lights().size(); ++light) {
      for (int i = 0; i < kGrid * kGrid; ++i) {
        const Vec2 u((float(i % kGrid) + 0.5f) / kGrid, (float(i / kGrid) + 0.5f) / kGrid);
        if (const auto sample = scene_->lights().sample_li(light, point_.position, u, 0.0f))
          sum += double(luminance(bsdf().evaluate(point_.wo, sample->wi).f_cos * sample->radiance) /
                        sample->pdf_solid_angle);
      }
    }
    return sum / (kGrid * kGrid);
  }

  /// Luminance of independent estimates of `samples` samples each, after training samples.
  RunningMoments estimates(DirectMethod method, int samples, Lobes lobes, int replicates) const {
    const auto estimator = make_direct_estimator(*scene_, method,
                                                 {.samples = samples, .lobes_apart = lobes == Lobes::Apart});
    const DirectLightContext context{*scene_, point_, bsdf(), 0, 4, 4};
    uint64_t rays = 0;
    // Each replicate has its own seed, since pixels of one seed are not exactly independent: the variance of means over
    // 20,000 of them was twice that of independent numbers.
    const auto estimate = [&](uint32_t seed, uint32_t index) {
      Sampler sampler(Sampler::Kind::Sobol, hash32(seed));
      sampler.start(0, index);
      DirectVertex vertex;
      return double(luminance(estimator->estimate(context, sampler, 6, vertex, nullptr, rays)));
    };
    for (uint32_t i = 0; i < 192; ++i) {
      estimate(~0u, i);
      if (i % 64 == 63) estimator->learn();
    }
    RunningMoments moments;
    for (int i = 0; i < replicates; ++i) moments.add(estimate(uint32_t(i), 0));
    return moments;
  }

 private:
  std::shared_ptr<const Scene> scene_;
  ShadingPoint point_;
  SurfaceShading shading_;
};

}  // namespace

TEST(DirectLobes, estimates_of_few_samples_have_the_correct_mean) {
  const PointOfFloor floor(0.05f);
  const double truth = floor.truth();
  for (const auto& [method, samples] : {std::pair(DirectMethod::PmcHi, 2),
                                        {DirectMethod::PmcHi, 3},
                                        {DirectMethod::PmcHi, 8},
                                        {DirectMethod::PmcHiPaper, 8},
                                        {DirectMethod::Ocv, 8},
                                        {DirectMethod::Ocv, 13},
                                        {DirectMethod::OcvProgressive, 2},
                                        {DirectMethod::OcvProgressive, 7}})
    EXPECT_TRUE(statistical::mean_agrees(floor.estimates(method, samples, Lobes::Apart, 20000), truth, {0.01, 8}))
        << name_of(method) << ", " << samples;
  EXPECT_FALSE(
      statistical::mean_agrees(floor.estimates(DirectMethod::OcvPaper, 8, Lobes::Apart, 20000), truth, {0.01}));
}

TEST(DirectLobes, separate_sampling_of_a_weak_sharp_coat_reduces_the_variance) {
  const PointOfFloor floor(0.05f);
  // Measured ratios of the variance: 0.08, 0.09, 0.06 and 0.05.
  for (DirectMethod method :
       {DirectMethod::PmcHi, DirectMethod::PmcHiPaper, DirectMethod::Ocv, DirectMethod::OcvProgressive}) {
    const RunningMoments together = floor.estimates(method, 16, Lobes::Together, 4000),
                         apart = floor.estimates(method, 16, Lobes::Apart, 4000);
    EXPECT_LT(apart.variance(), 0.2 * together.variance()) << name_of(method);
  }
}

TEST(DirectLobes, sampling_of_surfaces_with_one_lobe_does_not_change) {
  const PointOfFloor floor(0.0f);
  ASSERT_EQ(floor.bsdf().lobe_count(), 1);
  for (DirectMethod method :
       {DirectMethod::PmcHi, DirectMethod::PmcHiPaper, DirectMethod::Ocv, DirectMethod::OcvProgressive}) {
    const RunningMoments together = floor.estimates(method, 9, Lobes::Together, 100),
                         apart = floor.estimates(method, 9, Lobes::Apart, 100);
    EXPECT_EQ(apart.mean(), together.mean()) << name_of(method);
    EXPECT_EQ(apart.variance(), together.variance()) << name_of(method);
  }
}

TEST(DirectLobes, passes_show_the_share_of_each_lobe) {
  SceneDescription d = coated_floor(0.05f);
  d.settings.samples = 128;
  d.settings.direct_samples = 8;
  d.settings.passes = {"Combined", "Share BSDF", "Share Lobe 1", "Share Lobe 2", "Share Lobe 3"};
  for (DirectMethod method :
       {DirectMethod::PmcHi, DirectMethod::PmcHiPaper, DirectMethod::Ocv, DirectMethod::OcvProgressive}) {
    d.settings.direct = method;
    Session session;
    session.start(d);
    ASSERT_TRUE(session.wait(kHang));
    ASSERT_EQ(session.take_error(), "");
    const auto bsdf = session.snapshot("Share BSDF"), diffuse = session.snapshot("Share Lobe 1"),
               coat = session.snapshot("Share Lobe 2"), none = session.snapshot("Share Lobe 3");
    double diffuse_sum = 0.0, coat_sum = 0.0;
    for (size_t i = 0; i < bsdf.size(); ++i) {
      EXPECT_NEAR(bsdf[i], diffuse[i] + coat[i], 1e-5f);
      EXPECT_GT(diffuse[i], 0.01f);
      EXPECT_GT(coat[i], 0.01f);
      EXPECT_EQ(none[i], 0.0f);
      diffuse_sum += double(diffuse[i]);
      coat_sum += double(coat[i]);
    }
    // Sampling of the whole BSDF would choose the coat with probability 1/16.
    if (method == DirectMethod::PmcHi) {
      EXPECT_GT(coat_sum, diffuse_sum);
    }
  }
}

}  // namespace ajar::test_lobe_components
