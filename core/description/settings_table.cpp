#include "description/settings_table.h"

#include <cmath>
#include <cstdio>
#include <type_traits>

namespace ajar {

namespace {

template <auto Member>
SettingField in_settings(RenderSettings& settings) {
  return &(settings.*Member);
}
template <auto Member>
SettingField in_bounces(BounceLimits& bounces) {
  return &(bounces.*Member);
}

using S = RenderSettings;
using B = BounceLimits;

constexpr SettingRange kFrameSide{1, 65536, Outside::Refuse, Outside::Refuse};
constexpr SettingRange kFinite{-kMaxFloat, kMaxFloat, Outside::Refuse, Outside::Refuse};
constexpr SettingRange kFactor{0, kMaxFloat, Outside::Reset, Outside::Reset};
constexpr SettingRange kRays{1, 65536};
constexpr SettingRange kFilterWidth{0.01, 1000};  // the minimum is Blender's
constexpr SettingRange kNotNegative{0};
/// No path has so many bounces: more have the same meaning.
constexpr SettingRange kBounces{0, 1 << 20, Outside::Clamp, Outside::Clamp};

constexpr Setting<RenderSettings> kRenderSettings[] = {
    {.name = "width",
     .field = in_settings<&S::width>,
     .text = "The width of the full frame.",
     .unit = "pixels",
     .range = kFrameSide},
    {.name = "height",
     .field = in_settings<&S::height>,
     .text = "The height of the full frame.",
     .unit = "pixels",
     .range = kFrameSide},
    {.name = "region",
     .field = in_settings<&S::region>,
     .text = "x0, y0, x1, y1, y up. The part of the frame that is rendered. Four zeros mean the full frame.",
     .unit = "pixels"},
    {.name = "filter",
     .field = in_settings<&S::filter>,
     .text = "The pixel filter.",
     .property = {"Pixel Filter", "How samples near a pixel are weighted"}},
    {.name = "filter_width",
     .field = in_settings<&S::filter_width>,
     .text = "The width of the filter, as in Blender. A box is always 1 pixel wide. A Gaussian covers 3 times and "
             "Blackman-Harris 2 times this width, as in Cycles.",
     .unit = "pixels",
     .range = kFilterWidth,
     .property = {"Width", "Full width of the filter in pixels", 0.01, 10}},
    {.name = "exposure",
     .field = in_settings<&S::exposure>,
     .text = "A factor on the image.",
     .range = kFinite,
     .property = {"Exposure", "Brightness multiplier", 0, 10}},
    {.name = "transparent_film",
     .field = in_settings<&S::transparent_film>,
     .text = "Whether the world is hidden from the camera, so that alpha is 0 there."},
    {.name = "bounces", .field = in_settings<&S::bounces>, .text = "The limits on path length."},
    {.name = "clamp_direct",
     .field = in_settings<&S::clamp_direct>,
     .text = "The maximum of the mean of R, G and B of a contribution that was scattered at most once. 0 is no limit. "
             "Clamping is a bias. Only path tracing follows it, and `auto` never.",
     .unit = "radiance",
     .range = kNotNegative,
     .property = {"Clamp Direct",
                  "Maximum brightness of a direct light sample. A limit darkens the picture. 0 for no limit", 0, 1e8}},
    {.name = "clamp_indirect",
     .field = in_settings<&S::clamp_indirect>,
     .text = "The maximum of the mean of R, G and B of a contribution that was scattered more than once. 0 is no "
             "limit. Clamping is a bias. Only path tracing follows it, and `auto` never.",
     .unit = "radiance",
     .range = kNotNegative,
     .property = {"Clamp Indirect",
                  "Maximum brightness of an indirect light sample. A limit darkens the picture. 0 for no limit", 0,
                  1e8}},
    {.name = "reflective_caustics",
     .field = in_settings<&S::reflective_caustics>,
     .text = "Whether light reaches diffuse surfaces by glossy reflection.",
     .property = {"Reflective Caustics", "Light reflected by glossy surfaces onto diffuse surfaces"}},
    {.name = "refractive_caustics",
     .field = in_settings<&S::refractive_caustics>,
     .text = "Whether light reaches diffuse surfaces by refraction.",
     .property = {"Refractive Caustics", "Light refracted by glass onto diffuse surfaces"}},
    {.name = "integrator",
     .field = in_settings<&S::integrator>,
     .text = "A name from `integrator_list()`.",
     .property = {.label = "Integrator", .description = "Rendering technique of the final render", .initial = "auto"}},
    {.name = "direct",
     .field = in_settings<&S::direct>,
     .text = "The estimator of direct light. `direct_method_list()` describes them.",
     .property = {"Direct Light", "How direct light is sampled"}},
    {.name = "image",
     .field = in_settings<&S::image>,
     .text = "How samples are distributed over the pixels: equally, or by the noise of the pixels.",
     .property = {.label = "Image Sampling",
                  .description = "How samples are distributed over the pixels. Chains place their samples themselves",
                  .initial = "pmc_ip"}},
    {.name = "samples",
     .field = in_settings<&S::samples>,
     .text = "The render stops after this number. 0 is no limit.",
     .unit = "samples per pixel",
     .range = kNotNegative,
     .property = {"Samples", "Samples per pixel", 1, 1 << 24}},
    {.name = "seconds",
     .field = in_settings<&S::seconds>,
     .text =
         "The render stops after this time. It includes the pilot and learning, not the building of the scene. 0 is "
         "no limit.",
     .unit = "seconds",
     .range = kNotNegative,
     .property = {.label = "Time Limit",
                  .description = "Stop after this time, which includes denoising. 0 for no limit",
                  .min = 0,
                  .max = 1e7,
                  .subtype = "TIME_ABSOLUTE",
                  .name = "time_limit"}},
    {.name = "target_error",
     .field = in_settings<&S::target_error>,
     .text = "The render stops when the estimated relative mean squared error is at most this, after 16 samples per "
             "pixel at the earliest. 0 is no limit.",
     .unit = "relMSE",
     .range = kNotNegative,
     .option = "error",
     .property = {.label = "Noise Target",
                  .description = "Stop when the estimated relative mean squared error is below this. 0 for never",
                  .min = 0,
                  .max = 1,
                  .name = "noise_target"}},
    {.name = "seed",
     .field = in_settings<&S::seed>,
     .text = "The seed of all random numbers. The same seed gives the same image for any number of threads.",
     .range = {0, std::numeric_limits<uint32_t>::max()},
     .property = {"Seed", "A different seed gives a different noise pattern", 0, kMaxInt}},
    {.name = "threads",
     .field = in_settings<&S::threads>,
     .text = "The number of threads. 0 uses the environment variable AJAR_THREADS, or all hardware threads.",
     .range = kNotNegative},
    {.name = "passes",
     .field = in_settings<&S::passes>,
     .text = "The names of the passes to render, from `known_passes()`."},
    {.name = "photons",
     .field = in_settings<&S::photons>,
     .text = "The number of photon paths that are emitted for each sample per pixel. 0 chooses it by the size of the "
             "frame.",
     .range = kNotNegative,
     .property = {"Photons", "Photons emitted per sample of the picture. 0 to choose by the size of the picture", 0,
                  1e8}},
    {.name = "photon_radius",
     .field = in_settings<&S::photon_radius>,
     .text = "The radius of density estimates in the first pass. 0 chooses it by the density of the photons.",
     .unit = "metres",
     .range = kNotNegative,
     .property = {.label = "Photon Radius",
                  .description = "Radius of the first pass. 0 to choose it from the photon density",
                  .min = 0,
                  .subtype = "DISTANCE"}},
    {.name = "gather_rays",
     .field = in_settings<&S::gather_rays>,
     .text = "The number of final gather rays for each sample, at the first rough surface.",
     .range = kRays,
     .property = {"Gather Rays",
                  "Rays per sample that look up the photon map from the first rough surface. The irradiance cache uses "
                  "25 times as many per record",
                  1, 1024}},
    {.name = "direct_samples",
     .field = in_settings<&S::direct_samples>,
     .text = "The number of samples of a direct light estimate at the surfaces that the camera sees.",
     .range = kRays,
     .property = {"Direct Samples", "Direct light samples at each surface that the camera sees", 1, 256}},
    {.name = "image_error",
     .field = in_settings<&S::image_error>,
     .text = "The error that `image` \"pmc_ip\" reduces.",
     .since = '3',
     .property = {"Noise Measure", "Which error adaptive sampling reduces"}},
    {.name = "importance_region",
     .field = in_settings<&S::importance_region>,
     .text = "x0, y0, x1, y1, y up. The region to which `importance_factor` applies.",
     .unit = "fractions of the frame",
     .since = '3'},
    {.name = "importance_factor",
     .field = in_settings<&S::importance_factor>,
     .text = "A factor for the number of samples of pixels in `importance_region`. 1 is neutral. Used with `image` "
             "\"pmc_ip\". Negative and non-finite values are read as 1.",
     .range = kFactor,
     .since = '3',
     .property = {.label = "Region Importance",
                  .description = "Pixels in the region get this many times more samples. Does not change the mean of "
                                 "the picture",
                  .min = 0,
                  .soft_max = 10}},
    {.name = "guiding",
     .field = in_settings<&S::guiding>,
     .text = "Path guiding of the path tracer. \"auto\" measures first whether guiding is faster.",
     .since = '5',
     .property = {"Path Guiding", "Learn where light comes from during the render, and send more paths there"}},
    {.name = "mist",
     .field = in_settings<&S::mist>,
     .text = "Start in metres, depth in metres (> 0), exponent. The pass Mist is ((distance - start) / "
             "depth)^exponent, where the base is clamped to the range 0 to 1.",
     .since = '6'},
    {.name = "vertex_merging",
     .field = in_settings<&S::vertex_merging>,
     .text = "Whether bdpt, erpt, pmc_pt and metropolis compute caustics that are seen in mirrors from photons. The "
             "image is "
             "then consistent and no longer unbiased.",
     .since = '7',
     .property = {.label = "Vertex Merging",
                  .description = "Render caustics that are seen in mirrors and through glass with photons. No other "
                                 "light path reaches them",
                  .initial = "on"}},
    {.name = "memory_limit",
     .field = in_settings<&S::memory_limit>,
     .text = "A render that is estimated to need more memory fails before the scene is built. 0 is no limit.",
     .unit = "MiB",
     .range = kNotNegative,
     .since = '8',
     .property = {"Memory Limit (MiB)",
                  "Refuse to start a render that needs more memory, and report what needs most. 0 for no limit", 0,
                  kMaxInt}},
    {.name = "bump_terminator",
     .field = in_settings<&S::bump_terminator>,
     .text = "How light fades at grazing angles on bumped surfaces.",
     .since = 'C'},
    {.name = "denoised",
     .field = in_settings<&S::denoised>,
     .text = "Whether the image will be denoised. Then `auto` chooses the technique by the noise that a denoiser "
             "leaves. The render itself does not denoise.",
     .since = 'D'},
    {.name = "pass_alpha_threshold",
     .field = in_settings<&S::pass_alpha_threshold>,
     .text = "Passes such as Depth show the first surface whose alpha is at least this.",
     .range = {0, 1, Outside::Clamp, Outside::Clamp},
     .since = 'K'},
    {.name = "ao_distance",
     .field = in_settings<&S::ao_distance>,
     .text = "Surfaces that are farther away than this do not occlude a point in the pass AO.",
     .unit = "metres",
     .range = kNotNegative,
     .since = 'K'},
    {.name = "transparent_glass",
     .field = in_settings<&S::transparent_glass>,
     .text = "Whether a transparent film shows the world through glass as transparent. Only path tracing follows it.",
     .since = 'L',
     .property = {"Transparent Glass", "Make the film transparent behind glass"}},
    {.name = "transparent_glass_roughness",
     .field = in_settings<&S::transparent_glass_roughness>,
     .text = "Glass that is rougher than this stays opaque before a transparent film.",
     .range = {0, 1, Outside::Clamp, Outside::Clamp},
     .since = 'L',
     .property = {"Roughness Threshold", "Glass that is rougher than this stays opaque", 0, 1}},
    {.name = "texture_cache",
     .field = in_settings<&S::texture_cache>,
     .text =
         "Whether images are read in tiles, at the resolution that the picture needs, from files in the folder of the "
         "texture cache. Images without such a file are loaded whole.",
     .since = 'N',
     .property = {.label = "Texture Cache",
                  .description = "Read images in tiles, at the resolution that the picture needs, so that scenes with "
                                 "many large images need less memory. Images without a file in the texture cache are "
                                 "loaded whole",
                  .name = "use_texture_cache"}},
    {.name = "texture_cache_generate",
     .field = in_settings<&S::texture_cache_generate>,
     .text = "Whether missing files of the texture cache are made when a scene is built.",
     .since = 'N',
     .property = {.label = "Auto Generate",
                  .description = "Make the files of the texture cache when rendering, if they do not exist or the "
                                 "image has changed",
                  .name = "use_auto_generate_texture_cache"}},
    {.name = "texture_cache_folder",
     .field = in_settings<&S::texture_cache_folder>,
     .text =
         "The folder of the texture cache. A relative folder is relative to the file of each image, and an empty one "
         "is the folder of that file.",
     .since = 'N'},
    {.name = "texture_cache_size",
     .field = in_settings<&S::texture_cache_size>,
     .text = "The most memory for tiles of images. Tiles that were not read for long make place for new ones.",
     .unit = "MiB",
     .range = {16, 1 << 20, Outside::Clamp, Outside::Clamp},
     .since = 'N',
     .property = {"Cache Size (MiB)",
                  "Most memory for tiles of images. With less memory, tiles are read from the files more often", 16,
                  1 << 20}},
    {.name = "compact_bvh",
     .field = in_settings<&S::compact_bvh>,
     .text = "Whether the ray tracing structure of triangles takes about half of the memory. Rays then need more time.",
     .since = 'O',
     .property = {.label = "Compact BVH",
                  .description = "Build a ray tracing structure that needs about half of the memory. Rendering takes "
                                 "longer"}},
    {.name = "view_exposure",
     .field = in_settings<&S::view_exposure>,
     .text = "A factor on the light by which the image is displayed. The image does not change. Errors are judged in "
             "the displayed image, by adaptive sampling, the noise target, `auto` and the denoiser.",
     .range = kNotNegative,
     .since = 'Q'}};

constexpr Setting<BounceLimits> kBounceLimits[] = {
    {.name = "total",
     .field = in_bounces<&B::total>,
     .text = "The maximum number of bounces of a path of any kind.",
     .range = kBounces,
     .property = {"Total", "Maximum number of bounces of all kinds together", 0, 1024}},
    {.name = "diffuse",
     .field = in_bounces<&B::diffuse>,
     .text = "The maximum number of diffuse reflections.",
     .range = kBounces,
     .property = {"Diffuse", "Maximum number of diffuse bounces", 0, 1024}},
    {.name = "glossy",
     .field = in_bounces<&B::glossy>,
     .text = "The maximum number of glossy reflections.",
     .range = kBounces,
     .property = {"Glossy", "Maximum number of glossy bounces", 0, 1024}},
    {.name = "transmission",
     .field = in_bounces<&B::transmission>,
     .text = "The maximum number of transmissions.",
     .range = kBounces,
     .property = {"Transmission", "Maximum number of bounces through glass", 0, 1024}},
    {.name = "transparent",
     .field = in_bounces<&B::transparent>,
     .text = "The maximum number of surfaces that a ray passes straight through.",
     .range = kBounces,
     .property = {"Transparent", "Transparent surfaces that a path may cross", 0, 1024}},
    {.name = "volume",
     .field = in_bounces<&B::volume>,
     .text = "The maximum number of scattering events in volumes.",
     .range = kBounces,
     .property = {"Volume", "Maximum number of bounces in volumes. 0 scatters light once", 0, 1024}}};

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}

[[noreturn]] void refuse(const std::string& name, double value, const SettingRange& range) {
  if (std::isnan(value)) throw SceneError("The setting '" + name + "' is not a number.");
  const bool low = value < range.min;
  throw SceneError("The setting '" + name + "' is " + text_of(value) + ". The " + (low ? "minimum" : "maximum") +
                   " is " + text_of(low ? range.min : range.max) + ".");
}

template <class Struct>
void apply_ranges_of(Struct& values, const std::string& prefix) {
  Struct defaults;
  for (const Setting<Struct>& row : setting_table<Struct>()) {
    const auto apply = [&]<class T>(T* field) {
      if constexpr (std::is_same_v<T, BounceLimits>) {
        apply_ranges_of(*field, prefix + row.name + ".");
      } else if constexpr (std::is_arithmetic_v<T> && !std::is_same_v<T, bool>) {
        const bool below = !(double(*field) >= row.range.min), above = double(*field) > row.range.max;
        if (!below && !above) return;
        switch (below ? row.range.below : row.range.above) {
          case Outside::Refuse: refuse(prefix + row.name, double(*field), row.range);
          case Outside::Clamp: *field = T(below ? row.range.min : row.range.max); break;
          case Outside::Reset: *field = *std::get<T*>(row.field(defaults)); break;
        }
      }
    };
    std::visit(apply, row.field(values));
  }
}

/// The type in Python.
template <class T>
std::string type_text() {
  if constexpr (std::is_same_v<T, bool>) return "bool";
  if constexpr (std::is_same_v<T, int> || std::is_same_v<T, uint32_t>) return "int";
  if constexpr (std::is_same_v<T, float> || std::is_same_v<T, double>) return "float";
  if constexpr (std::is_same_v<T, std::string>) return "str";
  if constexpr (std::is_same_v<T, std::array<int, 4>>) return "list of 4 ints";
  if constexpr (std::is_same_v<T, std::array<float, 4>>) return "list of 4 floats";
  if constexpr (std::is_same_v<T, std::vector<std::string>>) return "list of str";
  if constexpr (std::is_same_v<T, FilterKind>) return "FilterKind";
  if constexpr (std::is_same_v<T, BumpTerminator>) return "BumpTerminator";
  if constexpr (std::is_same_v<T, BounceLimits>) return "BounceLimits";
  if constexpr (std::is_same_v<T, MistDescription>) return "tuple of 3 floats";
  if constexpr (std::is_enum_v<T>) {
    std::string names;
    const auto& all = choices<T>().all;
    for (const Choice<T>& choice : all)
      names += (names.empty() ? "" : &choice == &all.back() ? " or " : ", ") + ('"' + std::string(choice.name) + '"');
    return "str: " + names;
  }
}

}  // namespace

template <>
std::span<const Setting<RenderSettings>> setting_table() {
  return kRenderSettings;
}
template <>
std::span<const Setting<BounceLimits>> setting_table() {
  return kBounceLimits;
}

void apply_ranges(RenderSettings& settings) { apply_ranges_of(settings, ""); }

template <class Struct>
std::string facts_of(const Setting<Struct>& setting) {
  Struct any;
  std::string text = std::visit([]<class T>(T*) { return type_text<T>(); }, setting.field(any));
  if (*setting.unit) text += std::string(", ") + setting.unit;
  const bool has_min = setting.range.min > -kMaxFloat, has_max = setting.range.max < kMaxFloat;
  if (has_min && has_max)
    text += ", " + text_of(setting.range.min) + " to " + text_of(setting.range.max);
  else if (has_min)
    text += ", >= " + text_of(setting.range.min);
  return text;
}
template std::string facts_of(const Setting<RenderSettings>&);
template std::string facts_of(const Setting<BounceLimits>&);

}  // namespace ajar
