#include "film/film.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "math/statistics.h"

namespace ajar {

namespace {
constexpr double kSplatUnits = 0x1p32;
constexpr float kMaxSplat = 0x1p30f;

/// Passes that come from what a sample tells besides its radiance.
bool is_aux_pass(const std::string& pass) {
  return pass == "Depth" || pass == "Normal" || pass == "Position" || pass == "UV" || pass == "Albedo" || pass.starts_with("Share ");
}

}  // namespace

const std::vector<PassInfo>& known_passes() {
  static const std::vector<PassInfo> passes{{"Combined", 4}, {"Depth", 1}, {"Normal", 3}, {"Position", 3}, {"UV", 3},
                                            {"Albedo", 3}, {"Sample Count", 1}, {"Variance", 1},
                                            {"Share BSDF", 1}, {"Share Light 1", 1}, {"Share Light 2", 1}, {"Share Cone", 1}};
  return passes;
}

Film::Film(int x0, int y0, int x1, int y1, const std::vector<std::string>& passes) : x0_(x0), y0_(y0), x1_(x1), y1_(y1) {
  for (const std::string& pass : passes) {
    const auto& known = known_passes();
    if (std::none_of(known.begin(), known.end(), [&](const PassInfo& info) { return info.name == pass; })) {
      std::string names;
      for (const PassInfo& info : known) names += (names.empty() ? "" : ", ") + info.name;
      throw std::invalid_argument("Unknown pass '" + pass + "'. Known passes: " + names + ".");
    }
    wants_aux_ |= is_aux_pass(pass);
  }
  pixels_.resize(size_t(width()) * size_t(height()));
  if (wants_aux_) aux_.resize(pixels_.size());
}

bool Film::add_sample(int x, int y, Color radiance, float alpha, const SampleAux* aux) {
  const size_t index = size_t(y - y0_) * size_t(width()) + size_t(x - x0_);
  Pixel& pixel = pixels_[index];
  const bool odd = pixel.count & 1;
  ++pixel.count;  // a refused sample still was one: leaving it out would bias the mean
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
  if (aux && wants_aux_) {
    AuxPixel& a = aux_[index];
    // Depth and position cannot be averaged across an edge: the first sample stands for the pixel, as in Cycles.
    if (!a.has_first) {
      a.depth = double(aux->depth);
      for (int c = 0; c < 3; ++c) a.position[c] = double(aux->position[c]);
      a.has_first = true;
    }
    for (int c = 0; c < 3; ++c) {
      a.normal[c] += double(aux->normal[c]);
      a.uv[c] += double(aux->uv[c]);
      a.albedo[c] += double(aux->albedo[c]);
    }
    for (size_t k = 0; k < 4; ++k) a.shares[k] += double(aux->shares[k]);
  }
  return true;
}

void Film::enable_splats() {
  if (!splats_) splats_ = std::make_unique<SplatPixel[]>(pixels_.size());
}

void Film::add_splat(int x, int y, Color value, bool odd) {
  if (x < x0_ || x >= x1_ || y < y0_ || y >= y1_) return;
  const float largest = max_component(glm::abs(value));
  if (!(largest <= kMaxSplat)) {
    refused_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  SplatPixel& pixel = splats_[size_t(y - y0_) * size_t(width()) + size_t(x - x0_)];
  for (int c = 0; c < 3; ++c)
    pixel.pending[odd][c].fetch_add(int64_t(std::llrint(double(value[c]) * kSplatUnits)), std::memory_order_relaxed);
}

void Film::end_splats(double scale) {
  splat_scale_ = scale;
  for (size_t i = 0; i < pixels_.size(); ++i)
    for (int half = 0; half < 2; ++half)
      for (int c = 0; c < 3; ++c)
        splats_[i].sum[half][c] += double(splats_[i].pending[half][c].exchange(0, std::memory_order_relaxed)) / kSplatUnits;
}

Film::SampleCounts Film::sample_counts() const {
  SampleCounts counts{0.0, pixels_.empty() ? 0u : ~0u, 0};
  CompensatedSum sum;
  for (const Pixel& pixel : pixels_) {
    sum.add(double(pixel.count));
    counts.least = std::min(counts.least, pixel.count);
    counts.most = std::max(counts.most, pixel.count);
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
  if (is_aux_pass(pass) && aux_.empty()) return out;
  const int share = pass == "Share BSDF" ? 0 : pass == "Share Light 1" ? 1 : pass == "Share Light 2" ? 2 : pass == "Share Cone" ? 3 : -1;
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
      // Of the pixel's mean luminance, from the scatter of its samples.
      const double mean = 0.2126729 * p.sum[0] * scale + 0.7151522 * p.sum[1] * scale + 0.0721750 * p.sum[2] * scale;
      if (p.count > 1) o[0] = float(std::max(0.0, p.sum_luminance_squared * scale - mean * mean) / double(p.count - 1));
    } else if (share >= 0) {
      o[0] = float(aux_[i].shares[share] * scale);
    } else if (pass == "Depth") {
      o[0] = float(aux_[i].depth);
    } else {
      const AuxPixel& a = aux_[i];
      const double* source = pass == "Normal" ? a.normal : pass == "Position" ? a.position : pass == "UV" ? a.uv : a.albedo;
      const double s = pass == "Position" ? 1.0 : scale;
      for (int c = 0; c < 3; ++c) o[c] = float(source[c] * s);
    }
  }
  return out;
}

double Film::estimated_relmse() const {
  CompensatedSum sum;
  uint64_t terms = 0;
  for (size_t i = 0; i < pixels_.size(); ++i) {
    const Pixel& p = pixels_[i];
    const uint32_t even = p.count - p.half_count;
    if ((p.half_count == 0 || even == 0) && !(splats_ && p.count == 0)) return -1.0;
    for (int c = 0; c < 3; ++c) {
      double odd_mean = 0.0, even_mean = 0.0, mean = splatted(i, c);
      if (p.count > 0) {
        odd_mean = p.half[c] / double(p.half_count);
        even_mean = (p.sum[c] - p.half[c]) / double(even);
        mean += p.sum[c] / double(p.count);
      }
      double difference = odd_mean - even_mean;
      if (splats_) difference += 2.0 * splat_scale_ * (splats_[i].sum[1][c] - splats_[i].sum[0][c]);
      sum.add(0.25 * difference * difference / (mean * mean + 0.01));
      ++terms;
    }
  }
  return terms > 0 ? sum.value() / double(terms) : -1.0;
}

}  // namespace ajar
