#include "film/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "film/tvi.h"
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
constexpr uint32_t kSettledSamples = 16;  // for the average pixel; by then, an adaptive render has found its shares
constexpr int kErrorBlock = 8;            // pixels, along each side
// minimum ratio of the present sample count to that of the image with which the present image is compared
constexpr double kFirstStep = 4.0 / 3.0;
// number of standard deviations by which errors must fall faster than those of independent samples
constexpr double kErrorConfidence = 2.0;

/// Passes that are made from SampleAux.
bool is_aux_pass(const std::string& pass) {
  return pass == "Mist" || pass == "IndexOB" || pass == "IndexMA" || pass == "Depth" || pass == "Normal" ||
         pass == "Position" || pass == "UV" || pass == "Albedo" || pass.starts_with("Share ");
}

/// An image whose samples extend those of an earlier image differs from it by the variance that it has lost. With a
/// variance of c n^-p after n samples, the differences from n2 to n1 and from n1 to n determine p and c. p is 1 for
/// independent samples and more for stratified ones.
double error_from_steps(double before, double recent, double n2, double n1, double n) {
  double low = 1.0, high = 2.5;
  for (int i = 0; i < 40; ++i) {
    const double p = 0.5 * (low + high),
                 ratio = (std::pow(n2, -p) - std::pow(n1, -p)) / (std::pow(n1, -p) - std::pow(n, -p));
    (ratio * recent < before ? low : high) = p;
  }
  return recent * std::pow(n, -low) / (std::pow(n1, -low) - std::pow(n, -low));
}

double luminance_of(const double rgb[3]) { return 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2]; }

}  // namespace

bool is_part_pass(const std::string& pass) {
  if (pass == "Emit" || pass == "Env" || pass == "VolumeDir" || pass == "VolumeInd") return true;
  const bool kind = pass.starts_with("Diff") || pass.starts_with("Gloss") || pass.starts_with("Trans");
  return kind && (pass.ends_with("Dir") || pass.ends_with("Ind") || pass.ends_with("Col"));
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
                                            {"Sample Count", 1},
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
    : x0_(x0), y0_(y0), x1_(x1), y1_(y1) {
  bool wants_parts = false;
  for (const std::string& pass : passes) {
    const auto& known = known_passes();
    if (std::none_of(known.begin(), known.end(), [&](const PassInfo& info) { return info.name == pass; })) {
      std::string names;
      for (const PassInfo& info : known) names += (names.empty() ? "" : ", ") + info.name;
      throw std::invalid_argument("Unknown pass '" + pass + "'. Known passes: " + names + ".");
    }
    wants_aux_ |= is_aux_pass(pass);
    wants_parts |= is_part_pass(pass);
  }
  pixels_.resize(size_t(width()) * size_t(height()));
  if (wants_aux_) aux_.resize(pixels_.size());
  if (wants_parts) parts_.resize(pixels_.size());
}

uint64_t Film::bytes_per_pixel(const std::vector<std::string>& passes, bool splats) {
  const bool aux = std::any_of(passes.begin(), passes.end(), is_aux_pass),
             parts = std::any_of(passes.begin(), passes.end(), is_part_pass);
  return sizeof(Pixel) + (aux ? sizeof(AuxPixel) : 0) + (parts ? sizeof(PartsPixel) : 0) +
         kMaxRemembered * 3 * sizeof(float) +
         (splats ? sizeof(SplatPixel) + std::tuple_size_v<decltype(pending_)> * sizeof(PendingPixel) : 0);
}

uint64_t Film::memory_bytes() const {
  uint64_t bytes = pixels_.size() * sizeof(Pixel) + aux_.size() * sizeof(AuxPixel) +
                   parts_.size() * sizeof(PartsPixel) + goals_.size() * sizeof(uint32_t);
  if (splats_) bytes += pixels_.size() * sizeof(SplatPixel);
  for (const PendingSplats& pending : pending_) bytes += pending.pixels ? pixels_.size() * sizeof(PendingPixel) : 0;
  for (const Remembered& one : remembered_)
    for (const std::vector<float>& channel : one.image) bytes += channel.size() * sizeof(float);
  return bytes;
}

bool Film::add_sample(int x, int y, Color radiance, float alpha, const SampleAux* aux) {
  const size_t index = index_of(x, y);
  Pixel& pixel = pixels_[index];
  const uint32_t number = pixel.count;
  const bool odd = number & 1;
  ++pixel.count;  // a refused sample counts as a black one; leaving it out would bias the mean
  if (odd) ++pixel.half_count;
  if (!is_finite(radiance)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  for (int c = 0; c < 3; ++c) {
    pixel.sum[c] += double(radiance[c]);
    if (odd) pixel.half[c] += double(radiance[c]);
  }
  pixel.sum_alpha += double(alpha);
  const double y_luminance = double(luminance(radiance));
  pixel.sum_luminance_squared += y_luminance * y_luminance;
  if (early_.enabled()) early_.add(index, number, float(y_luminance));
  if (aux && wants_aux_) {
    AuxPixel& a = aux_[index];
    // Depth and position cannot be averaged across an edge. The first sample is used for the pixel, as in Cycles.
    if (!a.has_first) {
      a.depth = double(aux->depth);
      for (int c = 0; c < 3; ++c) a.position[c] = double(aux->position[c]);
      a.object_index = aux->object_index;
      a.material_index = aux->material_index;
      a.has_first = true;
    }
    for (int c = 0; c < 3; ++c) {
      a.normal[c] += double(aux->normal[c]);
      a.uv[c] += double(aux->uv[c]);
      a.albedo[c] += double(aux->albedo[c]);
    }
    for (size_t k = 0; k < aux->shares.size(); ++k) a.shares[k] += double(aux->shares[k]);
    a.mist += double(aux->mist);
  }
  return true;
}

void Film::add_parts(int x, int y, const SampleParts& parts) {
  PartsPixel& p = parts_[index_of(x, y)];
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

void Film::set_goals(std::vector<uint32_t> goals) {
  goals_ = std::move(goals);
  if (!goals_.empty()) early_.reserve(pixels_.size(), *std::max_element(goals_.begin(), goals_.end()));
}

void Film::enable_splats() {
  static_assert(std::size(kSplatRanges) == std::tuple_size_v<decltype(pending_)>);
  if (!splats_) splats_ = std::make_unique<SplatPixel[]>(pixels_.size());
}

Film::PendingSplats& Film::pending_of(float largest, double& units) {
  const size_t range = largest < kSplatRanges[1].below ? (largest < kSplatRanges[0].below ? 0 : 1) : 2;
  units = kSplatRanges[range].units;
  PendingSplats& splats = pending_[range];
  std::call_once(splats.made, [&] { splats.pixels = std::make_unique<PendingPixel[]>(pixels_.size()); });
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

void Film::add_splat(int x, int y, Color value, bool odd) {
  if (x < x0_ || x >= x1_ || y < y0_ || y >= y1_) return;
  const float largest = max_component(glm::abs(value));
  if (!(largest < std::end(kSplatRanges)[-1].below)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  if (largest == 0.0f) return;
  double units;
  PendingSplats& splats = pending_of(largest, units);
  const size_t index = index_of(x, y);
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
    for (size_t i = 0; i < pixels_.size(); ++i)
      for (int half = 0; half < 2; ++half)
        for (int c = 0; c < 3; ++c) {
          // Round only the total: how much of it was carried depends on the threads.
          __int128 sum = pending.pixels[i].sum[half][c].exchange(0, std::memory_order_relaxed);
          if (!pending.carried.empty())
            if (const auto carried = pending.carried.find((2 * i + size_t(half)) * 3 + size_t(c));
                carried != pending.carried.end())
              sum += __int128(carried->second) * kCarried;
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

std::vector<float> Film::resolve(const std::string& pass, float exposure) const {
  const auto& known = known_passes();
  const auto info = std::find_if(known.begin(), known.end(), [&](const PassInfo& p) { return p.name == pass; });
  if (info == known.end()) throw std::invalid_argument("Unknown pass '" + pass + "'.");
  const size_t channels = size_t(info->channels);
  std::vector<float> out(pixels_.size() * channels, 0.0f);
  if ((is_aux_pass(pass) && aux_.empty()) || (is_part_pass(pass) && parts_.empty())) return out;
  const size_t kind = pass.starts_with("Diff") ? 0 : pass.starts_with("Gloss") ? 1 : 2;
  std::vector<float> variance;
  if (pass == "Variance" || pass == "Error" || pass == "Perceptual Error") variance = variance_of_mean();
  constexpr std::array kShares{"Share BSDF",   "Share Light 1", "Share Light 2", "Share Cone",
                               "Share Lobe 1", "Share Lobe 2",  "Share Lobe 3"};
  const auto share_of_pass = std::find(kShares.begin(), kShares.end(), pass);
  const int share = share_of_pass == kShares.end() ? -1 : int(share_of_pass - kShares.begin());
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& p = pixels_[i];
    if (p.count == 0 && !splats_) continue;
    const double scale = p.count > 0 ? 1.0 / double(p.count) : 0.0;
    float* o = out.data() + i * channels;
    if (pass == "Combined") {
      for (int c = 0; c < 3; ++c) o[c] = float((p.sum[c] * scale + splatted(i, c)) * double(exposure));
      o[3] = float(p.sum_alpha * scale);
    } else if (pass == "Sample Count") {
      o[0] = float(p.count);
    } else if (pass == "Variance") {
      o[0] = variance[i];
    } else if (pass == "Error" || pass == "Perceptual Error") {
      // Standard deviation of the luminance of the mean: relative, or in units of the visibility threshold.
      double mean[3];
      for (int c = 0; c < 3; ++c) mean[c] = p.sum[c] * scale + splatted(i, c);
      const double y = luminance_of(mean);
      const double unit = pass == "Error" ? std::sqrt(y * y + 0.01)
                                          : tvi(std::max(0.0, y) * kCandelasPerUnit) / kCandelasPerUnit;
      o[0] = float(std::sqrt(double(variance[i])) / unit);
    } else if (share >= 0) {
      o[0] = float(aux_[i].shares[share] * scale);
    } else if (pass == "Depth") {
      o[0] = float(aux_[i].depth);
    } else if (pass == "Mist") {
      o[0] = float(aux_[i].mist * scale);
    } else if (pass == "IndexOB" || pass == "IndexMA") {
      o[0] = pass == "IndexOB" ? aux_[i].object_index : aux_[i].material_index;
    } else if (is_part_pass(pass)) {
      const PartsPixel& parts = parts_[i];
      for (int c = 0; c < 3; ++c) {
        const double color = parts.color[kind][c];
        if (pass == "Emit" || pass == "Env")
          o[c] = float((pass == "Emit" ? parts.emission : parts.environment)[c] * scale * double(exposure));
        else if (pass.starts_with("Volume"))
          o[c] = float(parts.volume[pass == "VolumeInd"][c] * scale * double(exposure));
        else if (pass.ends_with("Col"))
          o[c] = float(color * scale);
        else
          o[c] = color > 0.0 ? float((pass.ends_with("Dir") ? parts.direct : parts.indirect)[kind][c] / color *
                                     double(exposure))
                             : 0.0f;
      }
    } else {
      const AuxPixel& a = aux_[i];
      const double* source = pass == "Normal"     ? a.normal
                             : pass == "Position" ? a.position
                             : pass == "UV"       ? a.uv
                                                  : a.albedo;
      const double s = pass == "Position" ? 1.0 : scale;
      for (int c = 0; c < 3; ++c) o[c] = float(source[c] * s);
    }
  }
  return out;
}

/// Variance of the mean luminance of a pixel for independent samples. Stratified samples have slightly less.
double Film::scatter_variance(const Pixel& p) {
  if (p.count < 2) return 0.0;
  const double mean = luminance_of(p.sum) / double(p.count);
  return std::max(0.0, p.sum_luminance_squared / double(p.count) - mean * mean) / double(p.count - 1);
}

/// Variance of the mean luminance of each pixel. For samples it follows from their scatter. For splats it follows from
/// the difference of their halves, averaged over a neighbourhood, because a single difference is too noisy.
std::vector<float> Film::variance_of_mean() const {
  constexpr int kReach = 2;
  std::vector<float> variance(pixels_.size(), 0.0f), splat_variance(splats_ ? pixels_.size() : 0);
  for (size_t i = 0; i < splat_variance.size(); ++i) {
    double difference[3];
    for (int c = 0; c < 3; ++c) difference[c] = splat_scale_ * (splats_[i].sum[1][c] - splats_[i].sum[0][c]);
    splat_variance[i] = float(luminance_of(difference) * luminance_of(difference));
  }
  for (int y = 0; y < height(); ++y) {
    for (int x = 0; x < width(); ++x) {
      const size_t i = size_t(y) * size_t(width()) + size_t(x);
      const Pixel& p = pixels_[i];
      variance[i] = float(scatter_variance(p));
      if (!splats_) continue;
      double sum = 0.0;
      int terms = 0;
      for (int v = std::max(0, y - kReach); v <= std::min(height() - 1, y + kReach); ++v)
        for (int u = std::max(0, x - kReach); u <= std::min(width() - 1, x + kReach); ++u, ++terms)
          sum += double(splat_variance[size_t(v) * size_t(width()) + size_t(u)]);
      variance[i] += float(sum / terms);
    }
  }
  return variance;
}

bool Film::has_halves(const Pixel& p) const {
  return (p.half_count > 0 && p.half_count < p.count) || (splats_ && p.count == 0);
}

/// Mean of a pixel and the difference between the means of its two halves. Returns false if there are too few samples.
bool Film::halves_of(size_t index, double mean[3], double difference[3]) const {
  const Pixel& p = pixels_[index];
  const uint32_t even = p.count - p.half_count;
  if (!has_halves(p)) return false;
  for (int c = 0; c < 3; ++c) {
    mean[c] = splatted(index, c);
    difference[c] = 0.0;
    if (p.count > 0) {
      difference[c] = p.half[c] / double(p.half_count) - (p.sum[c] - p.half[c]) / double(even);
      mean[c] += p.sum[c] / double(p.count);
    }
    if (splats_) difference[c] += 2.0 * splat_scale_ * (splats_[index].sum[1][c] - splats_[index].sum[0][c]);
  }
  return true;
}

/// An estimate of the true value of a pixel, for the denominator of a relative error. `value` holds the mean of the
/// pixel and `around` the mean of its neighbours. If a channel of the pixel is above its neighbours by no more than the
/// scatter of its samples explains, the cause is probably a firefly. Its value is then moved towards the neighbours
/// [after James and Stein 1961].
void Film::make_likely(size_t index, const double around[3], double value[3]) const {
  double above[3];
  bool any_above = false;
  for (int c = 0; c < 3; ++c) {
    above[c] = value[c] - around[c];
    any_above |= above[c] > 0.0;
  }
  double mean[3], difference[3];
  if (!any_above || !halves_of(index, mean, difference)) return;
  const double y_own = luminance_of(mean), y_half = 0.5 * luminance_of(difference);
  const double variance = scatter_variance(pixels_[index]) + (splats_ ? y_half * y_half : 0.0);
  for (int c = 0; c < 3; ++c) {
    if (!(above[c] > 0.0)) continue;
    const double part = y_own > 0.0 ? value[c] / y_own : 1.0;  // ratio of the channel to the luminance
    value[c] = around[c] + above[c] * std::max(0.0, 1.0 - variance * part * part / (above[c] * above[c]));
  }
}

/// Sums over the pixels at most one away in each direction, for row y of `image`; `columns` is temporary memory.
void Film::sums_around(const std::vector<float>& image, int y, std::vector<double>& columns,
                       std::vector<double>& sums) const {
  const size_t w = size_t(width());
  const float* const row = image.data() + size_t(y) * w;
  const float* const below = y > 0 ? row - w : nullptr;
  const float* const above = y + 1 < height() ? row + w : nullptr;
  columns.assign(row, row + w);
  for (const float* const other : {below, above})
    for (size_t x = 0; other && x < w; ++x) columns[x] += double(other[x]);
  sums = columns;
  for (size_t x = 0; x + 1 < w; ++x) sums[x] += columns[x + 1];
  for (size_t x = 1; x < w; ++x) sums[x] += columns[x - 1];
}

Film::ErrorEstimate Film::estimated_error_of_few() const {
  constexpr ErrorEstimate kUnknown{-1.0, -1.0};
  CompensatedSum sum, scattered, halved, seen;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    double mean[3], difference[3];
    if (!halves_of(i, mean, difference)) return kUnknown;
    for (int c = 0; c < 3; ++c) sum.add(0.25 * difference[c] * difference[c] / (mean[c] * mean[c] + 0.01));
    const double y = luminance_of(mean), d = luminance_of(difference), weight = 1.0 / (y * y + 0.01);
    const double of_scatter = splats_ ? 0.0 : scatter_variance(pixels_[i]), of_halves = 0.25 * d * d;
    seen.add(kCandelasPerUnit * kCandelasPerUnit * (splats_ ? of_halves : of_scatter) /
             tvi(kCandelasPerUnit * std::max(0.0, y)));
    if (splats_) continue;
    halved.add(of_halves * weight);
    scattered.add(of_scatter * weight);
  }
  if (pixels_.empty()) return kUnknown;
  const double pixels = double(pixels_.size());
  return {sum.value() / (3.0 * pixels) * (halved.value() > 0.0 ? scattered.value() / halved.value() : 1.0),
          seen.value() / pixels};
}

std::array<std::vector<float>, 3> Film::means() const {
  std::array<std::vector<float>, 3> image;
  for (int c = 0; c < 3; ++c) {
    image[size_t(c)].resize(pixels_.size());
    for (size_t i = 0; i < pixels_.size(); ++i)
      image[size_t(c)][i] = float((pixels_[i].count > 0 ? pixels_[i].sum[c] / double(pixels_[i].count) : 0.0) +
                                  splatted(i, c));
  }
  return image;
}

void Film::remember(uint32_t samples) {
  if (remembered_.size() == kMaxRemembered) remembered_.erase(remembered_.begin());
  remembered_.push_back({samples, means()});
}

Film::ErrorEstimate Film::estimated_error(uint32_t samples) const {
  // The latest remembered image that has sufficiently fewer samples.
  size_t k = remembered_.size();
  while (k > 0 && kFirstStep * double(remembered_[k - 1].samples) > double(samples)) --k;
  if (k < 2 || !std::all_of(pixels_.begin(), pixels_.end(), [&](const Pixel& p) { return has_halves(p); }))
    return estimated_error_of_few();
  const ErrorEstimate latest = error_from_pictures(remembered_[k - 1], remembered_[k - 2], samples);
  // An image is used from 4/3 of its samples on, where the difference to it is small and uncertain. Until twice its
  // samples, the estimate moves from the image before it to this one, without a jump.
  const double part = std::clamp(
      (double(samples) / double(remembered_[k - 1].samples) - kFirstStep) / (2.0 - kFirstStep), 0.0, 1.0);
  if (k < 3 || part == 1.0 || !(latest.relmse > 0.0) || !(latest.perceptual > 0.0)) return latest;
  const ErrorEstimate before = error_from_pictures(remembered_[k - 2], remembered_[k - 3], samples);
  if (!(before.relmse > 0.0) || !(before.perceptual > 0.0)) return latest;
  return {std::pow(before.relmse, 1.0 - part) * std::pow(latest.relmse, part),
          std::pow(before.perceptual, 1.0 - part) * std::pow(latest.perceptual, part)};
}

/// Error of the present image from its difference to `one`, and from the difference of `one` to `two`, which has half
/// the samples of `one`.
Film::ErrorEstimate Film::error_from_pictures(const Remembered& one, const Remembered& two, uint32_t samples) const {
  const std::array<std::vector<float>, 3> now = means();
  const size_t columns = size_t((width() + kErrorBlock - 1) / kErrorBlock);
  std::vector<std::array<double, 2>> blocks(columns * size_t((height() + kErrorBlock - 1) / kErrorBlock));
  CompensatedSum recent, before, recent_seen, before_seen;
  std::array<std::vector<double>, 3> sums;
  std::vector<double> room;
  for (int y = 0; y < height(); ++y) {
    for (size_t c = 0; c < 3; ++c) sums_around(now[c], y, room, sums[c]);
    const int rows = std::min(height() - 1, y + 1) - std::max(0, y - 1) + 1;
    for (int x = 0; x < width(); ++x) {
      const int others = rows * (std::min(width() - 1, x + 1) - std::max(0, x - 1) + 1) - 1;
      const size_t i = size_t(y) * size_t(width()) + size_t(x);
      double value[3], around[3], recently[3], earlier[3];
      for (size_t c = 0; c < 3; ++c) {
        value[c] = double(now[c][i]);
        around[c] = others > 0 ? (sums[c][size_t(x)] - value[c]) / others : value[c];
        recently[c] = value[c] - double(one.image[c][i]);
        earlier[c] = double(one.image[c][i]) - double(two.image[c][i]);
      }
      make_likely(i, around, value);
      std::array<double, 2>& block = blocks[size_t(y / kErrorBlock) * columns + size_t(x / kErrorBlock)];
      for (size_t c = 0; c < 3; ++c) {
        const double unit = value[c] * value[c] + 0.01;
        block[0] += earlier[c] * earlier[c] / unit;
        block[1] += recently[c] * recently[c] / unit;
      }
      const double unit = tvi(kCandelasPerUnit * std::max(0.0, luminance_of(value))) /
                          (kCandelasPerUnit * kCandelasPerUnit);
      const double y_recently = luminance_of(recently), y_earlier = luminance_of(earlier);
      recent_seen.add(y_recently * y_recently / unit);
      before_seen.add(y_earlier * y_earlier / unit);
    }
  }
  for (const std::array<double, 2>& block : blocks) {
    before.add(block[0]);
    recent.add(block[1]);
  }
  // The blocks show how certain it is that errors fall faster than 1/n. If a few blocks have most of the error, it is
  // uncertain.
  double deviation = 0.0;
  if (recent.value() > 0.0 && before.value() > 0.0)
    for (const std::array<double, 2>& block : blocks) {
      const double d = block[0] / before.value() - block[1] / recent.value();
      deviation += d * d;
    }
  // While the counts still adapt to the noise, errors fall faster than they will later.
  const bool is_settled = goals_.empty() || two.samples >= kSettledSamples;
  const double confidence = !is_settled ? 0.0 : std::exp(-kErrorConfidence * std::sqrt(deviation));
  const double pixels = double(pixels_.size());
  return {
      error_from_steps(confidence * before.value(), recent.value(), two.samples, one.samples, samples) / (3.0 * pixels),
      error_from_steps(confidence * before_seen.value(), recent_seen.value(), two.samples, one.samples, samples) /
          pixels};
}

}  // namespace ajar
