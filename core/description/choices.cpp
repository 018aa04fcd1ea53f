#include "description/choices.h"

namespace ajar {

namespace {

constexpr Choice<FilterKind> kFilters[] = {
    {FilterKind::Box, "box", "Box", "The square of the pixel"},
    {FilterKind::Gaussian, "gaussian", "Gaussian", "Soft"},
    {FilterKind::BlackmanHarris, "blackman_harris", "Blackman-Harris", "Soft, with more contrast at edges"}};

constexpr Choice<BumpTerminator> kBumpTerminators[] = {
    {BumpTerminator::Cubic, "cubic", "Cubic", "As in Blender until 4.4"},
    {BumpTerminator::Microfacet, "microfacet", "Microfacet", "As in Blender since 4.5"},
    {BumpTerminator::None, "none", "None", "Hard edges"}};

constexpr Choice<DirectMethod> kDirectMethods[] = {
    {DirectMethod::Mis, "mis", "Multiple Importance",
     "Samples both lights and surfaces. The right choice for nearly every scene."},
    {DirectMethod::PmcHi, "pmc_hi", "Adaptive Mixture",
     "Learns, for each region of the scene, which lights and lobes to sample."},
    {DirectMethod::OcvProgressive, "ocv_progressive", "Progressive Control Variates",
     "Corrects each estimate by what earlier ones found nearby."},
    {DirectMethod::Ocv, "ocv", "Control Variates",
     "Corrects one half of the samples by the other half. Use 16 or more direct samples."},
    {DirectMethod::PmcHiPaper, "pmc_hi_paper", "Adaptive Mixture (per estimate)",
     "Learns within each estimate. Use 16 or more direct samples. For comparison."},
    {DirectMethod::OcvPaper, "ocv_paper", "Control Variates (as published)", "Darkens the picture. For comparison.",
     true},
    {DirectMethod::Correlated, "correlated", "Single Control Variate",
     "One control variate for all lights. For comparison."},
    {DirectMethod::Ris, "ris", "Resampled Importance",
     "Sends shadow rays to the brightest of several candidates. For comparison."},
    {DirectMethod::MisBalance, "mis_balance", "Multiple Importance (balance)",
     "Multiple importance sampling with the balance heuristic."},
    {DirectMethod::Light, "light", "Lights Only", "Samples only lights. For comparison."},
    {DirectMethod::Bsdf, "bsdf", "Surfaces Only", "Samples only surfaces. For comparison."}};

constexpr Choice<Guiding> kGuiding[] = {
    {Guiding::Off, "off", "Off", "Directions come from the materials only"},
    {Guiding::On, "on", "On", "Directions come from the materials and from what earlier samples found"},
    {Guiding::Auto, "auto", "Automatic", "Measure in the first 16 samples whether guiding reduces the noise"}};

constexpr Choice<Merging> kMerging[] = {
    {Merging::Off, "off", "Off", "Path tracing finds them rarely, as very bright pixels. Unbiased"},
    {Merging::On, "on", "On", "From photons, whose blur shrinks as the render goes on. Consistent"}};

constexpr Choice<ImageSampling> kImageSampling[] = {
    {ImageSampling::Uniform, "uniform", "Uniform", "All pixels get the same number of samples"},
    {ImageSampling::PmcIp, "pmc_ip", "Adaptive (PMC-IP)", "Noisy pixels get more samples"}};

constexpr Choice<ErrorMeasure> kErrorMeasures[] = {
    {ErrorMeasure::Relative, "relative", "Relative Error", "Relative to the brightness of each pixel"},
    {ErrorMeasure::Perceptual, "perceptual", "Visible Error",
     "Relative to the smallest difference that an eye can see"}};

}  // namespace

template <>
const Choices<FilterKind>& choices() {
  static const Choices<FilterKind> table{"pixel filter", kFilters};
  return table;
}
template <>
const Choices<BumpTerminator>& choices() {
  static const Choices<BumpTerminator> table{"bump terminator", kBumpTerminators};
  return table;
}
template <>
const Choices<DirectMethod>& choices() {
  static const Choices<DirectMethod> table{"direct light method", kDirectMethods};
  return table;
}
template <>
const Choices<Guiding>& choices() {
  static const Choices<Guiding> table{"guiding", kGuiding};
  return table;
}
template <>
const Choices<Merging>& choices() {
  static const Choices<Merging> table{"vertex merging", kMerging};
  return table;
}
template <>
const Choices<ImageSampling>& choices() {
  static const Choices<ImageSampling> table{"image sampling", kImageSampling};
  return table;
}
template <>
const Choices<ErrorMeasure>& choices() {
  static const Choices<ErrorMeasure> table{"image error", kErrorMeasures};
  return table;
}

}  // namespace ajar
