#include "transport/media/subsurface_walk.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "math/frame.h"
#include "math/warps.h"
#include "shading/bsdf/closure_parts.h"
#include "shading/models/fresnel.h"
#include "shading/models/microfacet.h"
#include "transport/media/phase_function.h"
#include "transport/media/subsurface_profile.h"

namespace ajar {

namespace {

constexpr int kMaxSteps = 256, kAnisotropicSteps = 9;
constexpr float kMinAlbedo = 0.2f, kNothingLeft = 1e-6f;
/// For light inside an object, the object's visibility by type of ray does not matter.
constexpr uint32_t kEveryKind = kRayCamera | kRayDiffuse | kRayGlossy | kRayTransmission | kRayShadow |
                                kRayVolumeScatter;

/// Coefficients of a polynomial in the anisotropy, constant term first.
using Polynomial = std::array<float, 8>;

float evaluate(const Polynomial& coefficients, float g) {
  float value = 0.0f;
  for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) value = value * g + *c;
  return value;
}

/// scale * atan(steepness * albedo)^exponent. The steepness is base + factor * exp(growth).
struct ArcTangentTerm {
  Polynomial scale;
  float base, factor;
  Polynomial growth;
  Polynomial exponent;

  float at(float albedo, float g) const {
    const float steepness = base + factor * std::exp(evaluate(growth, g));
    return evaluate(scale, g) * std::pow(std::atan(steepness * albedo), evaluate(exponent, g));
  }
};

// The coefficients of the fit that Blender uses.
constexpr ArcTangentTerm kDark = {{1.8260523782f, -1.28451056436f, -1.79904629312f, 9.19393289202f, -22.8215585862f,
                                   32.0234874259f, -23.6264803333f, 7.21067002658f},
                                  4.98511194385f,
                                  0.127355959438f,
                                  {0.0f, 31.1491581433f, -201.847017512f, 841.576016723f, -2018.09288505f,
                                   2731.71560286f, -1935.41424244f, 559.009054474f},
                                  {1.09686102424f, -0.394704063468f, 1.05258115941f, -8.83963712726f, 28.8643230661f,
                                   -46.8802913581f, 38.5402837518f, -12.7181042538f}};
constexpr ArcTangentTerm kBright = {{0.496310210422f, 0.360146581622f, -2.15139309747f, 17.8896899217f, -55.2984010333f,
                                     82.065982243f, -58.5106008578f, 15.8478295021f},
                                    4.23190299701f,
                                    0.00310603949088f,
                                    {0.0f, 76.7316253952f, -594.356773233f, 2448.8834203f, -5576.68528998f,
                                     7116.60171912f, -4763.54467887f, 1303.5318055f},
                                    {2.40602999408f, -2.51814844609f, 9.18494908356f, -79.2191708682f, 259.082868209f,
                                     -403.613804597f, 302.85712436f, -87.4370473567f}};

/// The single scattering albedo that gives a half-space this albedo. The method is that of Chiang, Kutz and Burley 2016
/// ("Practical and Controllable Subsurface Scattering for Production Path Tracing"): half-spaces are simulated, and a
/// curve is fitted to the inverse. This curve, by Kulla and Chiang, has one term for dark and one for bright albedos,
/// which are mixed by the fourth root of the albedo.
float single_scattering_albedo(float albedo, float g) {
  return std::clamp(glm::mix(kDark.at(albedo, g), kBright.at(albedo, g), std::pow(albedo, 0.25f)), 0.0f, 0.999999f);
}

/// The same by the van de Hulst relation between both albedos [d'Eon, A Hitchhiker's Guide to Multiple Scattering,
/// v0.3.2, eq. 53.7].
float van_de_hulst_albedo(float albedo, float g) {
  const float s = 4.20863f * albedo - std::sqrt(9.59217f + albedo * (41.6808f + albedo * 17.7126f)) + 4.09712f;
  const float s2 = s * s, denominator = 1.0f - g * s2;
  return denominator > 0.0f ? std::clamp((1.0f - s2) / denominator, 0.0f, 0.999999f) : 0.0f;
}

/// Samples the direction in which light that arrives along -wo enters the medium. False if there is none.
bool sample_entry(const SubsurfaceMedium& medium, Vec3 normal, Vec3 wo, Pcg32& rng, Vec3& direction) {
  const Vec2 u{rng.next_float(), rng.next_float()};
  const Frame frame(normal);
  bool diffuse = medium.entry == SubsurfaceEntry::Diffuse;
  if (medium.entry == SubsurfaceEntry::Mixed) diffuse = rng.next_float() < 0.5f;
  if (diffuse) {
    direction = -frame.to_world(warp::square_to_cosine_hemisphere(u));
    return true;
  }
  const Vec3 local = frame.to_local(wo);
  Vec3 refracted;
  if (!(local.z > 0.0f)) return false;
  // The weight of the sample is that of a boundary without masking: all light enters.
  const Vec3 facet = microfacet::ggx_sample_visible(local, medium.alpha, medium.alpha, u);
  if (!fresnel::refract(local, facet, medium.eta, refracted)) return false;
  direction = frame.to_world(refracted);
  return true;
}

/// Steps that lead back to the surface, by the solution of diffusion in a half-space [Krivanek and d'Eon 2014, "A
/// zero-variance-based sampling scheme for Monte Carlo subsurface scattering"]. Light that leaves has a density that
/// falls with the depth in units of the diffusion length. Directions towards the surface are therefore more probable, and
/// steps in these directions are longer.
class GuideToSurface {
 public:
  explicit GuideToSurface(const WalkMedium& medium) {
    // The diffusion length of an isotropic medium, in mean free paths; the fit of the same paper (eq. 30).
    for (int i = 0; i < 3; ++i) {
      const float a = std::clamp(medium.albedo[i], 0.01f, 0.999999f);
      length_[i] = 1.0f / std::sqrt(1.0f - std::pow(a, 2.44294f - 0.0215813f * a + 0.578637f / a));
      scale_[i] = 0.5f * kInvPi / std::log((length_[i] + 1.0f) / (length_[i] - 1.0f));
    }
  }
  /// The depth in which light that leaves falls to 1/e, in the channel with the largest one.
  float depth(const WalkMedium& medium) const { return max_component(length_ / medium.extinction); }
  /// The cosine to the normal outwards.
  float sample(int channel, float u) const {
    const float v = length_[channel];
    return std::clamp(v - (v + 1.0f) * std::pow((v - 1.0f) / (v + 1.0f), u), -1.0f, 1.0f);
  }
  /// Density per solid angle, if the direction was chosen for this channel.
  Color pdf(float cosine) const { return scale_ / (length_ - cosine); }
  /// The factor on the extinction by which distances are sampled.
  Color stretch(float cosine) const { return Color(1.0f) - cosine / length_; }

 private:
  Color length_{2.0f}, scale_{0.0f};
};

/// A walk, and the densities with which each way of sampling would have made it.
///
/// In the guided way, the guide chooses most steps, and the phase function the others. In the plain way, the phase
/// function chooses all of them: the guide leads away from the other side of a thin object, which may be lit. The way is
/// chosen once for a walk, and so is the channel whose distances are sampled. The weight is that of the balance heuristic
/// over the six combinations [Veach 1997, section 9.2.4]. The guide is made for isotropic scattering, and begins when
/// the medium is isotropic.
class Walk {
 public:
  /// `importance` of the channels.
  Walk(const WalkMedium& medium, Vec3 normal, Color importance, Pcg32& rng)
      : medium_(medium), guide_(medium), frame_(normal), channels_(importance), truth_(medium.factor) {
    const float sum = channels_.x + channels_.y + channels_.z;
    is_possible_ = sum > 0.0f;
    channels_ /= sum;
    const float u = rng.next_float();
    channel_ = u < channels_.x ? 0 : (u < channels_.x + channels_.y ? 1 : 2);
  }
  bool is_possible() const { return is_possible_; }

  /// The distance within which the other side of an object matters.
  float reach() const { return kReach * guide_.depth(medium_); }
  /// Before the first scattering, if the other side is within reach. `u` chooses the way.
  void choose_way(float thickness, float u) {
    plain_share_ = kPlainShare * std::exp(-thickness / (kThin * guide_.depth(medium_)));
    plain_ = u < plain_share_;
  }

  /// Samples the direction after scattering.
  Vec3 scatter(Vec3 direction, Pcg32& rng) {
    guided_share_ = medium_.anisotropy == 0.0f ? kGuidedSteps : 0.0f;
    by_guide_ = !plain_ && rng.next_float() < guided_share_;
    const Vec2 u{rng.next_float(), rng.next_float()};
    const PhaseShape phase = PhaseShape::henyey_greenstein(medium_.anisotropy);
    const float cosine = by_guide_ ? guide_.sample(channel_, u.x) : phase.sample(u.x),
                sine = safe_sqrt(1.0f - cosine * cosine), phi = 2.0f * kPi * u.y;
    const Frame frame = by_guide_ ? frame_ : Frame(direction);
    const Vec3 next = frame.to_world(Vec3(sine * std::cos(phi), sine * std::sin(phi), cosine));
    phase_ = phase.evaluate(glm::dot(direction, next));
    const float outwards = glm::dot(next, frame_.n);
    guide_pdf_ = guide_.pdf(outwards);
    stretch_ = guide_.stretch(outwards);
    return next;
  }
  float sample_distance(Pcg32& rng) const {
    const float extinction = medium_.extinction[channel_] * (by_guide_ ? stretch_[channel_] : 1.0f);
    return -std::log(1.0f - rng.next_float()) / extinction;
  }
  /// A step of this length; `ends`: it reached a surface.
  void add_step(float length, bool ends) {
    const auto reached = [&](Color extinction) {
      const Color transmittance = glm::exp(-extinction * length);
      return ends ? transmittance : extinction * transmittance;
    };
    const Color plain = phase_ * reached(medium_.extinction);
    truth_ *= ends ? plain : medium_.albedo * plain;
    plain_density_ *= plain;
    guided_density_ *= guided_share_ > 0.0f ? (1.0f - guided_share_) * plain +
                                                  guided_share_ * guide_pdf_ * reached(medium_.extinction * stretch_)
                                            : plain;
    const float largest = std::max(max_component(plain_density_), max_component(guided_density_));
    if (!(largest > 0.0f)) return;
    truth_ /= largest;  // products of many steps
    plain_density_ /= largest;
    guided_density_ /= largest;
  }
  /// The throughput.
  Color weight() const {
    const float density = glm::dot(channels_, glm::mix(guided_density_, plain_density_, plain_share_));
    return density > 0.0f ? truth_ / density : Color(0.0f);
  }
  void become_isotropic() {
    medium_ = similar_isotropic(medium_);
    guide_ = GuideToSurface(medium_);
  }

 private:
  static constexpr float kGuidedSteps = 0.9f;
  /// Share of the plain walks in an object without thickness. It falls to 1/e with this many depths of thickness, and
  /// is 0 beyond the reach. Measured: docs/research/speed.md.
  static constexpr float kPlainShare = 0.8f, kThin = 4.0f, kReach = 8.0f;

  WalkMedium medium_;
  GuideToSurface guide_;
  Frame frame_;
  Color channels_, truth_, plain_density_{1.0f}, guided_density_{1.0f};
  float plain_share_ = 0.0f;
  int channel_ = 0;
  bool is_possible_ = false, plain_ = false;
  // Of the present step:
  Color guide_pdf_{0.0f}, stretch_{1.0f};
  float phase_ = 1.0f, guided_share_ = 0.0f;
  bool by_guide_ = false;
};

}  // namespace

void leave_surface(const ShaderProgram& program, const ShadingPoint& point, Vec3 seen_from, SurfaceShading& shading) {
  Vec3 normal = point.ns;
  if (program.subsurface_has_normal()) {
    ShadingPoint exit = point;
    exit.after_diffuse = false;
    exit.wo = seen_from;
    SurfaceShading at_exit;
    program.evaluate_surface(exit, at_exit);
    const Bsdf::SubsurfacePart part = at_exit.bsdf.subsurface_part();
    if (part.selection > 0.0f) normal = part.normal;
  }
  shading.bsdf.start(point.ng, point.ns);
  // For roughness 0 and a view along the normal, this lobe has only the Fresnel factor of the exit direction.
  const LobeKind kind = shading.medium.fresnel ? LobeKind::PrincipledDiffuse : LobeKind::Diffuse;
  shading.bsdf.add(closures::make_lobe(kind, Color(1.0f), normal));
  shading.bsdf.prepare(point.wo);
}

namespace {

/// find_own_surface, but a surface of another instance beyond `needed` ends the search.
Hit find_own_surface_within(const Scene& scene, uint32_t instance, Ray ray, float needed, uint64_t& rays) {
  float travelled = 0.0f;
  ShadingPoint other;
  for (;;) {
    Hit hit = scene.intersect(ray, kEveryKind);
    ++rays;
    if (!hit.found() || hit.instance == instance) {
      hit.t += travelled;
      return hit;
    }
    if (travelled + hit.t > needed) return {};
    scene.shading_point(ray, hit, other);
    travelled += hit.t;
    ray = scene.straight_on(other, ray, hit.t);
    if (!(ray.t_max > 0.0f)) return {};
  }
}

}  // namespace

Hit find_own_surface(const Scene& scene, uint32_t instance, Ray ray, uint64_t& rays) {
  return find_own_surface_within(scene, instance, ray, kInfinity, rays);
}

WalkMedium walk_medium(const SubsurfaceMedium& medium) {
  WalkMedium walk;
  walk.anisotropy = medium.anisotropy;
  for (int i = 0; i < 3; ++i) {
    const float albedo = std::clamp(medium.albedo[i], 0.0f, 1.0f);
    walk.extinction[i] = 1.0f / std::max(medium.radius[i], 1e-16f);
    if (medium.van_de_hulst) {
      walk.albedo[i] = van_de_hulst_albedo(albedo, medium.anisotropy);
    } else {
      walk.albedo[i] = single_scattering_albedo(albedo, medium.anisotropy);
      walk.extinction[i] /= 1.0f - medium.anisotropy;
    }
    if (walk.albedo[i] < kMinAlbedo) {
      walk.factor[i] = walk.albedo[i] / kMinAlbedo;
      walk.albedo[i] = kMinAlbedo;
    }
  }
  return walk;
}

WalkMedium similar_isotropic(const WalkMedium& medium) {
  WalkMedium similar = medium;
  similar.anisotropy = 0.0f;
  const Color scattering = medium.extinction * medium.albedo * (1.0f - medium.anisotropy);
  similar.extinction = medium.extinction * (1.0f - medium.albedo) + scattering;
  similar.albedo = scattering / similar.extinction;
  return similar;
}

bool walk_below_surface(const Scene& scene, const EntryPoint& entry, Pcg32& rng, ShadingPoint& point,
                        SurfaceShading& shading, Color& weight, uint64_t& rays) {
  const SubsurfaceMedium& medium = shading.medium;
  const WalkMedium inside = walk_medium(medium);
  Vec3 direction;
  if (!sample_entry(medium, entry.normal, point.wo, rng, direction)) return false;
  if (!(glm::dot(direction, point.ng) < 0.0f)) return false;
  Walk walk(inside, point.ng, inside.factor * inside.albedo * weight, rng);
  if (!walk.is_possible()) return false;
  Ray ray = scene.spawn_ray(point, direction);
  for (int step = 0; step < kMaxSteps; ++step) {
    if (step > 0) ray.direction = walk.scatter(ray.direction, rng);
    const float distance = walk.sample_distance(rng);
    ray.t_max = step == 0 ? std::max(distance, walk.reach()) : distance;
    // Other objects may be in between, which must not cost many rays only to know the thickness.
    Hit hit = find_own_surface_within(scene, entry.instance, ray, distance, rays);
    if (step == 0 && hit.found() && hit.t > distance) {
      walk.choose_way(hit.t, entry.choice);
      hit = Hit();
    }
    walk.add_step(hit.found() ? hit.t : distance, hit.found());
    const Color carried = walk.weight();
    if (hit.found()) {
      ray.direction = -ray.direction;  // as if the surface were seen from outside
      scene.shading_point(ray, hit, point);
      if (!(glm::dot(point.ns, point.ng) > 0.0f)) point.ns = point.ng;
      point.wo = point.ns;
      weight *= carried;
      leave_surface(scene.material(hit), point, -ray.direction, shading);
      return is_finite(weight);
    }
    if (!(max_component(carried) > kNothingLeft)) return false;
    ray.origin += distance * ray.direction;
    if (step == kAnisotropicSteps) walk.become_isotropic();
  }
  return false;
}

bool walk_below_or_stay(const Scene& scene, uint32_t instance, SubsurfaceNumbers numbers, ShadingPoint& point,
                        SurfaceShading& shading, Color& beta, uint64_t& rays) {
  const Bsdf::SubsurfacePart part = shading.bsdf.subsurface_part();
  if (numbers.u >= part.selection) {
    shading.bsdf.remove_subsurface(point.wo);
    beta /= 1.0f - part.selection;
    return !shading.bsdf.empty();
  }
  Pcg32 rng(uint64_t(numbers.u * 0x1p32f), numbers.stream);
  Color weight = beta * part.weight / (glm::max(shading.medium.albedo, Color(1e-6f)) * part.selection);
  const auto scatter = shading.medium.profile ? scatter_by_profile : walk_below_surface;
  if (!scatter(scene, {instance, part.normal, numbers.u / part.selection}, rng, point, shading, weight, rays))
    return false;
  beta = weight;
  return true;
}

}  // namespace ajar
