#include "film/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "math/statistics.h"

namespace ajar {

namespace {
/// Splats are summed as multiples of a unit that depends on their magnitude: none has more than 2^52 units.
struct SplatRange {
  float below;
  double units;
};
constexpr SplatRange kSplatRanges[] = {{0x1p-20f, 0x1p60}, {0x1p20f, 0x1p32}, {0x1p52f, 1.0}};
/// A sum beyond this is moved to the carry table. Before that, a thousand more splats fit into the integer.
constexpr int64_t kCarried = int64_t(1) << 62;

bool is_guide_pass(const std::string& pass) { return pass == "Denoising Albedo" || pass == "Denoising Normal"; }

constexpr std::array kShares{"Share BSDF",   "Share Light 1", "Share Light 2", "Share Cone",
                             "Share Lobe 1", "Share Lobe 2",  "Share Lobe 3"};

/// The passes whose light can be splatted, in the order of Film::plane_of_part.
constexpr std::array kSplattedParts{"DiffDir",  "GlossDir",  "TransDir",  "DiffInd", "GlossInd",
                                    "TransInd", "VolumeDir", "VolumeInd", "Emit"};

constexpr const char* kDirectHalves = "Direct Halves";

/// -1: it is not in the list.
template <class List>
int index_of_name(const List& names, const std::string& name) {
  const auto found = std::find(std::begin(names), std::end(names), name);
  return found == std::end(names) ? -1 : int(found - std::begin(names));
}

std::string names_of(const std::vector<PassInfo>& passes) {
  std::string names;
  for (const PassInfo& info : passes) {
    if (!names.empty()) names += ", ";
    names += info.name;
  }
  return names;
}

}  // namespace

bool is_surface_pass(const std::string& pass) {
  return pass == "Mist" || pass == "IndexOB" || pass == "IndexMA" || pass == "Depth" || pass == "Normal" ||
         pass == "Position" || pass == "UV" || pass == "Albedo" || is_guide_pass(pass) || pass.starts_with("Share ");
}

bool is_part_pass(const std::string& pass) {
  if (pass == "Emit" || pass == "Env" || pass == "VolumeDir" || pass == "VolumeInd") return true;
  const bool kind = pass.starts_with("Diff") || pass.starts_with("Gloss") || pass.starts_with("Trans");
  return kind && (pass.ends_with("Dir") || pass.ends_with("Ind") || pass.ends_with("Col"));
}

int channels_of_pass(const std::string& pass) {
  for (const PassInfo& info : known_passes())
    if (info.name == pass) return info.channels;
  if (matte_pass(pass)) return 4;
  if (const auto aov = aov_pass(pass)) return aov->is_color ? 4 : 1;
  return light_group_of(pass).empty() ? 0 : 3;
}

const std::vector<PassInfo>& known_passes() {
  static const std::vector<PassInfo> passes{{"Combined", 4},
                                            {"Depth", 1},
                                            {"Normal", 3},
                                            {"Position", 3},
                                            {"UV", 3},
                                            {"Albedo", 3},
                                            {"Mist", 1},
                                            {"IndexOB", 1},
                                            {"IndexMA", 1},
                                            {"Emit", 3},
                                            {"Env", 3},
                                            {"DiffDir", 3},
                                            {"DiffInd", 3},
                                            {"DiffCol", 3},
                                            {"GlossDir", 3},
                                            {"GlossInd", 3},
                                            {"GlossCol", 3},
                                            {"TransDir", 3},
                                            {"TransInd", 3},
                                            {"TransCol", 3},
                                            {"VolumeDir", 3},
                                            {"VolumeInd", 3},
                                            {"Vector", 4},
                                            {"AO", 3},
                                            {"Roughness", 1},
                                            {"Render Time", 1},
                                            {"Sample Count", 1},
                                            {"Halves", 6},
                                            {"Direct Halves", 6},
                                            {"Shadow Catcher", 3},
                                            {"Denoising Albedo", 3},
                                            {"Denoising Normal", 3},
                                            {"Variance", 1},
                                            {"Error", 1},
                                            {"Perceptual Error", 1},
                                            {"Share BSDF", 1},
                                            {"Share Light 1", 1},
                                            {"Share Light 2", 1},
                                            {"Share Cone", 1},
                                            {"Share Lobe 1", 1},
                                            {"Share Lobe 2", 1},
                                            {"Share Lobe 3", 1}};
  return passes;
}

Film::Film(int x0, int y0, int x1, int y1, const std::vector<std::string>& passes)
    : x0_(x0), y0_(y0), x1_(x1), y1_(y1), extra_(passes, size_t(width()) * size_t(height())) {
  bool wants_surface = false, wants_parts = false, wants_guides = false;
  for (const std::string& pass : passes) {
    if (channels_of_pass(pass) == 0)
      throw std::invalid_argument("Unknown pass '" + pass + "'. Known passes: " + names_of(known_passes()) +
                                  ", and those of Cryptomatte, AOVs and light groups.");
    wants_surface |= is_surface_pass(pass);
    wants_parts |= is_part_pass(pass);
    wants_guides |= is_guide_pass(pass);
  }
  pixels_.resize(size_t(width()) * size_t(height()));
  wants_aux_ = wants_surface || extra_.wanted();
  if (wants_surface) aux_.resize(pixels_.size());
  if (wants_guides) guides_.resize(pixels_.size());
  if (wants_parts) parts_.resize(pixels_.size());
  if (std::find(passes.begin(), passes.end(), kDirectHalves) != passes.end()) direct_.resize(pixels_.size());
  for (size_t part = 0; part < kSplattedParts.size(); ++part)
    if (std::find(passes.begin(), passes.end(), kSplattedParts[part]) != passes.end())
      part_planes_[part] = uint16_t(1 + light_groups().size() + splatted_parts_++);
}

uint64_t Film::bytes_per_pixel(const std::vector<std::string>& passes, bool splats) {
  const bool aux = std::any_of(passes.begin(), passes.end(), is_surface_pass),
             guides = std::any_of(passes.begin(), passes.end(), is_guide_pass),
             parts = std::any_of(passes.begin(), passes.end(), is_part_pass);
  const auto separate = size_t(std::count_if(passes.begin(), passes.end(), [](const std::string& pass) {
    return !light_group_of(pass).empty() ||
           std::find(kSplattedParts.begin(), kSplattedParts.end(), pass) != kSplattedParts.end() ||
           pass == kDirectHalves;
  }));
  const bool direct = std::find(passes.begin(), passes.end(), kDirectHalves) != passes.end();
  return sizeof(Pixel) + (aux ? sizeof(AuxPixel) : 0) + (guides ? sizeof(GuidePixel) : 0) +
         (parts ? sizeof(PartsPixel) : 0) + (direct ? sizeof(DirectPixel) : 0) + ExtraPasses::bytes_per_pixel(passes) +
         kMaxRemembered * 3 * sizeof(float) +
         (splats ? (1 + separate) * (sizeof(SplatPixel) + std::tuple_size_v<decltype(pending_)> * sizeof(PendingPixel))
                 : 0);
}

uint64_t Film::memory_bytes() const {
  uint64_t bytes = pixels_.size() * sizeof(Pixel) + aux_.size() * sizeof(AuxPixel) +
                   guides_.size() * sizeof(GuidePixel) + parts_.size() * sizeof(PartsPixel) +
                   direct_.size() * sizeof(DirectPixel) + goals_.size() * sizeof(uint32_t) + caught_.memory_bytes() +
                   extra_.memory_bytes() + early_.memory_bytes() + lost_bytes();
  if (splats_) bytes += splat_count() * sizeof(SplatPixel);
  for (const PendingSplats& pending : pending_) bytes += pending.pixels ? splat_count() * sizeof(PendingPixel) : 0;
  for (const Remembered& one : remembered_)
    for (const std::vector<float>& channel : one.image) bytes += channel.size() * sizeof(float);
  return bytes;
}

/// Depth and position cannot be averaged across an edge. The first sample is used for the pixel, as in Cycles.
void Film::add_first(AuxPixel& pixel, const SampleAux& aux) {
  if (pixel.has_first) return;
  pixel.depth = double(aux.depth);
  for (int c = 0; c < 3; ++c) pixel.position[c] = double(aux.position[c]);
  pixel.object_index = aux.object_index;
  pixel.material_index = aux.material_index;
  pixel.has_first = true;
}

bool Film::add_sample(int x, int y, Color radiance, float alpha, const SampleAux* aux) {
  const size_t index = index_of(x, y);
  Pixel& pixel = pixels_[index];
  const uint32_t number = first_sample_ + pixel.count;
  const bool odd = number & 1;
  ++pixel.count;  // a refused sample counts as a black one; leaving it out would bias the mean
  if (odd) ++pixel.half_count;
  if (!is_finite(radiance)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  if (lost_) [[unlikely]] {
    add_sample_exactly(index, odd, radiance, alpha, aux);
    return true;
  }
  for (int c = 0; c < 3; ++c) {
    pixel.sum[c] += double(radiance[c]);
    if (odd) pixel.half[c] += double(radiance[c]);
  }
  pixel.sum_alpha += double(alpha);
  const double y_luminance = double(luminance(radiance));
  pixel.sum_luminance_squared += y_luminance * y_luminance;
  if (early_.enabled()) early_.add(index, number, float(y_luminance));
  if (aux && aux->extras) extra_.add(index, *aux->extras);
  if (aux && !aux_.empty()) {
    AuxPixel& a = aux_[index];
    add_first(a, *aux);
    for (int c = 0; c < 3; ++c) {
      a.normal[c] += double(aux->normal[c]);
      a.uv[c] += double(aux->uv[c]);
      a.albedo[c] += double(aux->albedo[c]);
    }
    if (!guides_.empty())
      for (int c = 0; c < 3; ++c) {
        guides_[index].albedo[c] += double(aux->guide_albedo[c]);
        guides_[index].normal[c] += double(aux->guide_normal[c]);
      }
    for (size_t k = 0; k < aux->shares.size(); ++k) a.shares[k] += double(aux->shares[k]);
    a.mist += double(aux->mist);
  }
  return true;
}

double Film::dropped_mattes() const {
  if (extra_.dropped() == 0.0) return 0.0;
  const double samples = sample_counts().mean * double(pixels_.size());
  return samples > 0.0 ? extra_.dropped() / samples : 0.0;
}

void SampleRecord::begin_extras(const Film& film, int x, int y) {
  film.extra_.begin(extras_, uint32_t(film.index_of(x, y)), film.samples_of(x, y));
  aux_.extras = &extras_;
}

void Film::add_parts(int x, int y, const SampleParts& parts) {
  const size_t index = index_of(x, y);
  if (!parts.groups.empty()) extra_.add_groups(index, parts.groups);
  if (parts_.empty()) return;
  if (lost_) [[unlikely]] {
    add_parts_exactly(index, parts);
    return;
  }
  PartsPixel& p = parts_[index];
  for (int c = 0; c < 3; ++c) {
    p.emission[c] += double(parts.emission[c]);
    p.environment[c] += double(parts.environment[c]);
    for (size_t k = 0; k < 2; ++k) p.volume[k][c] += double(parts.volume[k][c]);
    for (size_t k = 0; k < 3; ++k) {
      p.direct[k][c] += double(parts.direct[k][c]);
      p.indirect[k][c] += double(parts.indirect[k][c]);
      p.color[k][c] += double(parts.color[k][c]);
    }
  }
}

void Film::add_direct(int x, int y, Color light) {
  const size_t index = index_of(x, y);
  const bool odd = (first_sample_ + pixels_[index].count - 1) & 1;  // the count includes this sample
  // All threads share this flag: written once, it stays in their caches.
  if (!direct_known_.load(std::memory_order_relaxed)) direct_known_.store(true, std::memory_order_relaxed);
  if (lost_) [[unlikely]] {
    add_direct_exactly(index, odd, light);
    return;
  }
  DirectPixel& p = direct_[index];
  for (int c = 0; c < 3; ++c) {
    p.sum[c] += double(light[c]);
    if (odd) p.half[c] += double(light[c]);
  }
}

void add_light(SampleParts& parts, const PathPasses& of, Color light) {
  if (of.is_direct) parts.direct_paths += light;
  if (of.group >= 0) parts.groups[size_t(of.group)] += light;
  using Part = PathPasses::Part;
  switch (of.part) {
    case Part::None: break;
    case Part::Emission: parts.emission += light; break;
    case Part::Environment: parts.environment += light; break;
    case Part::VolumeDirect: parts.volume[0] += light; break;
    case Part::VolumeIndirect: parts.volume[1] += light; break;
    case Part::Direct:
    case Part::Indirect:
      for (size_t k = 0; k < 3; ++k)
        (of.part == Part::Direct ? parts.direct : parts.indirect)[k] += light * of.shares[k];
  }
}

void Film::set_goals(std::vector<uint32_t> goals) {
  goals_ = std::move(goals);
  if (!goals_.empty()) early_.reserve(pixels_.size(), *std::max_element(goals_.begin(), goals_.end()));
}

void Film::enable_splats() {
  static_assert(std::size(kSplatRanges) == std::tuple_size_v<decltype(pending_)>);
  if (!splats_) splats_ = std::make_unique<SplatPixel[]>(splat_count());
}

Film::PendingSplats& Film::pending_of(float largest, double& units) {
  const size_t range = largest < kSplatRanges[1].below ? (largest < kSplatRanges[0].below ? 0 : 1) : 2;
  units = kSplatRanges[range].units;
  PendingSplats& splats = pending_[range];
  std::call_once(splats.made, [&] { splats.pixels = std::make_unique<PendingPixel[]>(splat_count()); });
  return splats;
}

/// Moves 2^62 from a sum that is about to overflow to the carry table. The total does not depend on the order of
/// threads.
void Film::carry(PendingSplats& splats, size_t index, bool odd, int channel) {
  std::lock_guard lock(splats.carrying);
  std::atomic<int64_t>& sum = splats.pixels[index].sum[odd][channel];
  const int64_t now = sum.load(std::memory_order_relaxed), part = now > kCarried    ? kCarried
                                                                  : now < -kCarried ? -kCarried
                                                                                    : 0;
  sum.fetch_sub(part, std::memory_order_relaxed);
  splats.carried[(2 * index + odd) * 3 + size_t(channel)] += part / kCarried;
}

void Film::add_splat(int x, int y, Color value, bool odd, const PathPasses& passes) {
  if (x < x0_ || x >= x1_ || y < y0_ || y >= y1_) return;
  const float largest = max_component(glm::abs(value));
  if (!(largest < std::end(kSplatRanges)[-1].below)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  if (largest == 0.0f) return;
  const size_t index = index_of(x, y);
  add_splat_at(index, value, largest, odd);
  if (passes.group >= 0) add_splat_at(index + pixels_.size() * size_t(passes.group + 1), value, largest, odd);
  if (passes.is_direct && wants_direct()) add_splat_at(index + pixels_.size() * direct_plane(), value, largest, odd);
  if (passes.part == PathPasses::Part::None || splatted_parts_ == 0) return;
  const auto add_to = [&](size_t part, Color light) {
    const float greatest = max_component(glm::abs(light));
    if (plane_of_part(part) > 0 && greatest > 0.0f)
      add_splat_at(index + pixels_.size() * plane_of_part(part), light, greatest, odd);
  };
  using Part = PathPasses::Part;
  if (passes.part == Part::Direct || passes.part == Part::Indirect)
    for (size_t k = 0; k < 3; ++k) add_to(k + (passes.part == Part::Direct ? 0 : 3), value * passes.shares[k]);
  else if (passes.part != Part::Environment)
    add_to(passes.part == Part::VolumeDirect ? 6 : passes.part == Part::VolumeIndirect ? 7 : 8, value);
}

void Film::add_splat_at(size_t index, Color value, float largest, bool odd) {
  double units;
  PendingSplats& splats = pending_of(largest, units);
  for (int c = 0; c < 3; ++c) {
    const int64_t before = splats.pixels[index].sum[odd][c].fetch_add(std::llrint(double(value[c]) * units),
                                                                      std::memory_order_relaxed);
    if (before > kCarried || before < -kCarried) carry(splats, index, odd, c);
  }
}

void Film::end_splats(double scale) {
  splat_scale_ = scale;
  for (size_t range = 0; range < pending_.size(); ++range) {
    PendingSplats& pending = pending_[range];
    if (!pending.pixels) continue;
    for (size_t i = 0; i < splat_count(); ++i)
      for (int half = 0; half < 2; ++half)
        for (int c = 0; c < 3; ++c) {
          // Round only the total: how much of it was carried depends on the threads.
          __int128 sum = pending.pixels[i].sum[half][c].exchange(0, std::memory_order_relaxed);
          if (!pending.carried.empty())
            if (const auto carried = pending.carried.find((2 * i + size_t(half)) * 3 + size_t(c));
                carried != pending.carried.end())
              sum += __int128(carried->second) * kCarried;
          if (lost_)
            add_splats_exactly(i, half, c, sum, kSplatRanges[range].units);
          else
            splats_[i].sum[half][c] += double(sum) / kSplatRanges[range].units;
        }
    pending.carried.clear();
  }
}

Film::SampleCounts Film::sample_counts() const {
  SampleCounts counts{0.0, pixels_.empty() ? 0u : ~0u, 0};
  CompensatedSum sum;
  for (const Pixel& pixel : pixels_) {
    sum.add(double(pixel.count));
    counts.min = std::min(counts.min, pixel.count);
    counts.max = std::max(counts.max, pixel.count);
  }
  counts.mean = pixels_.empty() ? 0.0 : sum.value() / double(pixels_.size());
  return counts;
}

/// The passes that contain the composite with shadow catchers.
std::vector<float> Film::resolve_caught(const std::string& pass, float exposure, size_t channels) const {
  std::vector<float> out(pixels_.size() * channels, 1.0f);
  for (size_t i = 0; i < pixels_.size() && caught_.enabled(); ++i) {
    const Pixel& p = pixels_[i];
    const uint32_t even = p.count - p.half_count;
    float* o = out.data() + i * channels;
    float half[4];
    if (pass == "Shadow Catcher") {
      caught_.shadow(i, o);
    } else if (pass == "Combined") {
      caught_.composite(i, even, p.half_count, double(exposure), o);
    } else {
      std::fill_n(o, channels, std::numeric_limits<float>::quiet_NaN());
      for (const bool odd : {false, true}) {
        if ((odd ? p.half_count : even) == 0) continue;
        caught_.composite(i, odd ? 0 : even, odd ? p.half_count : 0, double(exposure), half);
        std::copy_n(half, 3, o + (odd ? 3 : 0));
      }
    }
  }
  return out;
}

/// A pass that is_part_pass knows, of one pixel.
void Film::resolve_part(const std::string& pass, size_t index, double exposure, float out[3]) const {
  const PartsPixel& parts = parts_[index];
  const size_t indirect = pass.ends_with("Ind") ? 1 : 0;
  const size_t kind = pass.starts_with("Diff") ? 0 : pass.starts_with("Gloss") ? 1 : 2;
  const double scale = pixels_[index].count > 0 ? 1.0 / double(pixels_[index].count) : 0.0;
  for (int c = 0; c < 3; ++c) {
    const double color = parts.color[kind][c];
    if (pass == "Emit")
      out[c] = float((parts.emission[c] * scale + splatted_part(8, index, c)) * exposure);
    else if (pass == "Env")
      out[c] = float(parts.environment[c] * scale * exposure);
    else if (pass.starts_with("Volume"))
      out[c] = float((parts.volume[indirect][c] * scale + splatted_part(6 + indirect, index, c)) * exposure);
    else if (pass.ends_with("Col"))
      out[c] = float(color * scale);
    else
      out[c] = color > 0.0 ? float(((indirect ? parts.indirect : parts.direct)[kind][c] +
                                    splatted_part(kind + 3 * indirect, index, c) / scale) /
                                   color * exposure)
                           : 0.0f;
  }
}

std::vector<float> Film::resolve(const std::string& pass, float exposure) const {
  const size_t channels = size_t(channels_of_pass(pass));
  if (channels == 0) throw std::invalid_argument("Unknown pass '" + pass + "'.");
  if (pass == "Shadow Catcher" || (caught_.enabled() && (pass == "Combined" || pass == "Halves")))
    return resolve_caught(pass, exposure, channels);
  std::vector<float> out(pixels_.size() * channels, 0.0f);
  if ((is_surface_pass(pass) && aux_.empty()) || (is_guide_pass(pass) && guides_.empty()) ||
      (is_part_pass(pass) && parts_.empty()))
    return out;
  const bool is_extra = ExtraPasses::makes(pass);
  const int group = index_of_name(light_groups(), light_group_of(pass));
  std::vector<float> variance;
  if (pass == "Variance" || pass == "Error" || pass == "Perceptual Error") variance = variance_of_mean();
  const int share = index_of_name(kShares, pass);
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& p = pixels_[i];
    if (p.count == 0 && !splats_) continue;
    const double scale = p.count > 0 ? 1.0 / double(p.count) : 0.0;
    float* o = out.data() + i * channels;
    if (is_extra) {
      extra_.resolve(pass, i, double(p.count), exposure, o);
      for (int c = 0; c < 3 && group >= 0; ++c)
        o[c] += float(splatted(i + pixels_.size() * size_t(group + 1), c) * double(exposure));
    } else if (pass == "Combined") {
      for (int c = 0; c < 3; ++c) o[c] = float((p.sum[c] * scale + splatted(i, c)) * double(exposure));
      o[3] = float(p.sum_alpha * scale);
    } else if (pass == "Sample Count") {
      o[0] = float(p.count);
    } else if (pass == "Halves") {
      means_of_halves(i, exposure, o);
    } else if (pass == kDirectHalves) {
      means_of_direct_halves(i, exposure, o);
    } else if (pass == "Variance") {
      o[0] = variance[i];
    } else if (pass == "Error" || pass == "Perceptual Error") {
      // Standard deviation of the luminance of the mean: relative, or in units of the visibility threshold.
      double mean[3];
      for (int c = 0; c < 3; ++c) mean[c] = p.sum[c] * scale + splatted(i, c);
      const double y = luminance_of(mean);
      o[0] = float(std::sqrt(double(variance[i])) /
                   (pass == "Error" ? std::sqrt(relative_square(y)) : threshold_at(y)));
    } else if (share >= 0) {
      o[0] = float(aux_[i].shares[share] * scale);
    } else if (pass == "Depth") {
      o[0] = float(aux_[i].depth);
    } else if (pass == "Mist") {
      o[0] = float(aux_[i].mist * scale);
    } else if (pass == "IndexOB" || pass == "IndexMA") {
      o[0] = pass == "IndexOB" ? aux_[i].object_index : aux_[i].material_index;
    } else if (is_part_pass(pass)) {
      resolve_part(pass, i, double(exposure), o);
    } else {
      const AuxPixel& a = aux_[i];
      const double* source = pass == "Normal"             ? a.normal
                             : pass == "Position"         ? a.position
                             : pass == "UV"               ? a.uv
                             : pass == "Denoising Albedo" ? guides_[i].albedo
                             : pass == "Denoising Normal" ? guides_[i].normal
                                                          : a.albedo;
      const double s = pass == "Position" ? 1.0 : scale;
      for (int c = 0; c < 3; ++c) o[c] = float(source[c] * s);
    }
  }
  return out;
}

}  // namespace ajar
