// The film: sums of all samples for each pixel.
//
// Samples are drawn from the pixel filter (importance sampling). Each sample therefore belongs to one pixel with weight
// 1, and the mean of a pixel's samples is the filtered image. Paths that arrive from lights are splatted instead, from
// any thread and in any order. Sums are double. Non-finite samples are refused and counted.
//
// Splats are summed in 64-bit integers, so that their sum does not depend on the order of threads; `end_splats` then
// adds it to doubles. The unit is 2^-60 for splats below 2^-20, 2^-32 for those below 2^20, and 1 for those below 2^52.
// Larger splats are refused. Any number of splats may arrive: a sum that would overflow is moved to a carry table. The
// image is the mean of the samples plus the sum of the splats times the splat scale. Pixels are rows from the bottom up
// over the render region.
#pragma once

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "description/settings.h"
#include "film/caught_light.h"
#include "film/early_samples.h"
#include "film/extra_passes.h"
#include "film/film_sums.h"
#include "film/tvi.h"
#include "math/relative_error.h"
#include "math/types.h"

namespace ajar {

/// A pass with Blender's name and the number of channels that the film keeps for it.
struct PassInfo {
  std::string name;
  int channels;
};
/// All passes of the film that have a fixed name. A request for another pass is an error whose message lists these.
const std::vector<PassInfo>& known_passes();
/// The number of channels of a pass, which may also be one of ExtraPasses; 0 if there is no such pass.
int channels_of_pass(const std::string& pass);

/// Values of one sample besides its radiance; filled at the first hit.
struct SampleAux {
  float depth = 1e10f;
  Vec3 normal{0.0f}, position{0.0f}, uv{0.0f};
  Color albedo{0.0f};
  float mist = 1.0f;  ///< 0: near, 1: far
  float object_index = 0.0f, material_index = 0.0f;
  /// Shares of a learned mixture: BSDF, first and second light or half of the light tree, cone, and the lobes of the
  /// BSDF from the widest to the sharpest.
  std::array<float, 7> shares{};
  bool has_first = false;  ///< the first hit was recorded
  bool has_guides = false;
  bool shows_first = true;  ///< false: the first hit is not recorded, as if a medium had scattered the ray before it
  SampleExtras* extras = nullptr;  ///< null: no pass needs them
  /// Guides of a denoiser: the albedo and the normal of the first surface that is not nearly a mirror, seen through
  /// mirrors and glass, whose colours the albedo contains. Media in front of it are added, with what they scatter.
  Color guide_albedo{0.0f}, guide_throughput{1.0f};
  Vec3 guide_normal{0.0f};
  float guide_share = 1.0f;  ///< of the surface in the normal
};

/// The radiance of a sample in the parts of Blender's passes: emission that is seen directly, and light that the first
/// surface scatters by each kind of lobe (diffuse, glossy, transmission) or that a volume in front of it scatters.
/// Scattered light is separated into direct and indirect light. The sum of all parts is the radiance.
struct SampleParts {
  Color emission{0.0f}, environment{0.0f};
  std::array<Color, 3> direct{Color(0.0f), Color(0.0f), Color(0.0f)}, indirect{Color(0.0f), Color(0.0f), Color(0.0f)};
  /// albedo by which Blender divides the direct and the indirect light
  std::array<Color, 3> color{Color(0.0f), Color(0.0f), Color(0.0f)};
  std::array<Color, 2> volume{Color(0.0f), Color(0.0f)};  ///< direct and indirect light that a volume scatters
  /// The light of each group whose pass is asked for; empty: none is.
  std::vector<Color> groups;
  Color direct_paths{0.0f};  ///< for Film::add_direct
};
/// Whether a pass is made from SampleAux.
bool is_surface_pass(const std::string& pass);
/// Whether a pass is made from SampleParts, which not all integrators provide.
bool is_part_pass(const std::string& pass);

/// The passes to which the light of one path belongs.
struct PathPasses {
  enum class Part : uint8_t { None, Emission, Environment, Direct, Indirect, VolumeDirect, VolumeIndirect };
  int group = -1;  ///< index in Film::light_groups(); -1: no pass shows it
  Part part = Part::None;
  bool is_direct = false;                                              ///< the path belongs to "Direct Halves"
  std::array<Color, 3> shares{Color(0.0f), Color(0.0f), Color(0.0f)};  ///< of the kinds of lobes in Direct and Indirect
};
/// Adds the light of a path.
void add_light(SampleParts& parts, const PathPasses& of, Color light);

class Film {
 public:
  Film() = default;
  /// (x0, y0) to (x1, y1) is the rendered region of the full frame.
  Film(int x0, int y0, int x1, int y1, const std::vector<std::string>& passes);

  /// Maximum memory of a film with these passes, in bytes per pixel; `splats`: including memory for splats.
  static uint64_t bytes_per_pixel(const std::vector<std::string>& passes, bool splats);
  uint64_t memory_bytes() const;
  /// Light times this is displayed. Errors are relative to displayed light (math/relative_error.h).
  void set_shown_exposure(double exposure) { shown_exposure_ = std::abs(exposure); }
  double shown_exposure() const { return shown_exposure_; }
  int width() const { return x1_ - x0_; }
  int height() const { return y1_ - y0_; }
  int x0() const { return x0_; }
  int y0() const { return y0_; }
  bool wants_aux() const { return wants_aux_; }
  bool wants_parts() const { return wants_light_parts() || !extra_.groups().empty(); }
  /// Whether a pass is asked for for which is_part_pass is true.
  bool wants_light_parts() const { return !parts_.empty(); }
  const std::vector<std::string>& light_groups() const { return extra_.groups(); }
  /// Coverage of mattes that their tables could not hold, as a fraction of all samples.
  double dropped_mattes() const;

  /// Adds one sample of pixel (x, y) of the full frame. Different pixels may be written by different threads. Returns
  /// false, and counts the sample as refused, if it is not finite.
  bool add_sample(int x, int y, Color radiance, float alpha, const SampleAux* aux);
  /// Before the first sample: the samples of a pixel have the numbers from `first` on. Other renders have those before.
  void begin_at(uint32_t first) { first_sample_ = first; }
  /// Before the first sample: keeps what sums lose by rounding (film/film_sums.h). Returns false if a pass is asked for
  /// whose sums are not kept: those of ExtraPasses, and shadow catchers.
  bool keep_exact_sums();
  /// The sums so far; without pixels if they are not kept exactly.
  FilmSums sums() const;
  /// Continues from these sums. Throws std::invalid_argument if they are those of other passes.
  void set_sums(const FilmSums& sums);
  /// Adds the number of rays of the latest sample of this pixel, for `early_samples`.
  void add_rays(int x, int y, uint64_t rays) {
    if (!early_.enabled()) return;
    const size_t index = index_of(x, y);
    early_.add_rays(index, first_sample_ + pixels_[index].count - 1, rays);
  }
  /// Adds the parts of the latest sample of this pixel.
  void add_parts(int x, int y, const SampleParts& parts);
  /// Whether "Direct Halves" is asked for.
  bool wants_direct() const { return !direct_.empty(); }
  /// Adds light of the latest sample of this pixel to "Direct Halves": that of paths LS*E and L(D)S*E, whose noise
  /// differs from that of the other light. Integrators that do not know it leave the pass empty (NaN).
  void add_direct(int x, int y, Color light);
  /// For a scene with shadow catchers: "Combined" is then the composite with them. Must be called before the first sample.
  void enable_catchers(bool transparent_film) { caught_.enable(pixels_.size(), transparent_film); }
  bool has_catchers() const { return caught_.enabled(); }
  /// Adds the latest sample of this pixel to the composite.
  void add_caught(int x, int y, const CaughtSample& sample) {
    const size_t index = index_of(x, y);
    caught_.add(index, sample, ((first_sample_ + pixels_[index].count) & 1) == 0);  // the count includes this sample
  }
  /// The index of the next sample of this pixel of the full frame: the number of its samples, if the first one is 0.
  uint32_t samples_of(int x, int y) const { return first_sample_ + pixels_[index_of(x, y)].count; }
  /// Sets the goal of each pixel, in the order of the film; empty: the same for all. The luminances and rays of samples
  /// up to the maximum goal are summed in `early_samples`.
  void set_goals(std::vector<uint32_t> goals);
  const std::vector<uint32_t>& goals() const { return goals_; }
  /// Goal of this pixel; `uniform` if no goals are set.
  uint32_t goal_of(int x, int y, uint32_t uniform) const { return goals_.empty() ? uniform : goals_[index_of(x, y)]; }
  EarlySamples& early_samples() { return early_; }
  /// Allocates memory for splats. Must be called before the first splat.
  void enable_splats();
  /// Adds a splat to pixel (x, y) of the full frame, from any thread; splats outside the region are ignored. `odd`
  /// selects one of two independent halves of all splats, for the estimate of the error. Light of the environment
  /// that is seen directly is not splatted.
  void add_splat(int x, int y, Color value, bool odd, const PathPasses& passes = {});
  /// Called between iterations: adds the splats since the last call to the image. `scale` is the factor of the sum of
  /// all splats so far, such as one over the number of light paths per pixel.
  void end_splats(double scale);
  /// Samples so far: the mean over the film, and the minimum and maximum of the pixels.
  struct SampleCounts {
    double mean;
    uint32_t min, max;
  };
  SampleCounts sample_counts() const;
  uint64_t refused() const { return refused_.load(); }

  /// The resolved channels of a pass: width * height * channels floats. "Halves" has the means of the even and of the
  /// odd samples of a pixel, RGB each; NaN if the pixel has no sample in one of them. "Direct Halves" has the part of
  /// add_direct in both.
  std::vector<float> resolve(const std::string& pass, float exposure) const;
  /// Stores the present image of `samples` samples for the average pixel. Errors are estimated from changes of the
  /// image.
  void remember(uint32_t samples);
  /// Error of the present image of `samples` samples for the average pixel: relative mean squared error, and mean of
  /// e^2 / tvi(M) in cd/m^2 (film/tvi.h). Negative if there are too few samples. It is accurate to some 15 % once the
  /// samples have found all light; rare bright paths that no sample has found are in no estimate.
  struct ErrorEstimate {
    double relmse, perceptual;
  };
  ErrorEstimate estimated_error(uint32_t samples) const;
  /// An estimate of the relative mean squared error of the present image for few samples: the mean of variance / (M^2 +
  /// 0.01) over pixels and channels, for displayed light. The variance is that of two half buffers, (A-B)^2 / 4. Without
  /// splats, the result is scaled as a whole to the scatter of luminances, because halves of a stratified sequence differ
  /// more than independent ones. Negative if there are too few samples.
  double estimated_relmse() const { return estimated_error_of_few().relmse; }
  /// The same for the luminance, relative to the visibility threshold (film/tvi.h).
  double estimated_perceptual_error() const { return estimated_error_of_few().perceptual; }

 private:
  struct Pixel {
    double sum[3] = {0, 0, 0};
    double half[3] = {0, 0, 0};  ///< of the odd samples
    double sum_alpha = 0.0;
    double sum_luminance_squared = 0.0;
    uint32_t count = 0, half_count = 0;
  };
  struct AuxPixel {
    double depth = 0.0, normal[3] = {0, 0, 0}, position[3] = {0, 0, 0}, uv[3] = {0, 0, 0}, albedo[3] = {0, 0, 0},
           shares[7] = {}, mist = 0.0;
    float object_index = 0.0f, material_index = 0.0f;
    bool has_first = false;
  };
  struct GuidePixel {
    double albedo[3] = {0, 0, 0}, normal[3] = {0, 0, 0};
  };
  struct PartsPixel {
    double emission[3] = {0, 0, 0}, environment[3] = {0, 0, 0}, direct[3][3] = {}, indirect[3][3] = {},
           color[3][3] = {}, volume[2][3] = {};
  };
  struct DirectPixel {
    double sum[3] = {0, 0, 0}, half[3] = {0, 0, 0};  ///< half: of the odd samples
  };
  struct SplatPixel {
    double sum[2][3] = {};  ///< even, odd
  };
  struct PendingPixel {
    std::atomic<int64_t> sum[2][3]{};  ///< even, odd; in units of their range
  };
  /// Splats of one range of magnitudes; allocated at the first of them.
  struct PendingSplats {
    std::once_flag made;
    std::unique_ptr<PendingPixel[]> pixels;
    std::mutex carrying;
    std::map<size_t, int64_t> carried;  ///< carry table: the index of a sum, and how often 2^62 was moved out of it
  };
  struct Lost;
  struct LostDeleter {
    void operator()(Lost* lost) const;
  };
  template <class Entry>
  static double* numbers_of(Entry& entry);
  template <class Entry>
  static void add_numbers(Entry& sums, Entry& lost, Entry& more, size_t count);
  template <class Entry, class Entries>
  static void read_table(FilmSums::Table& table, const Entries& entries, const std::vector<Entry>& lost, size_t count,
                         size_t width);
  template <class Entry, class Entries>
  static void write_table(const FilmSums::Table& table, Entries& entries, std::vector<Entry>& lost, size_t count,
                          size_t width);
  static void add_first(AuxPixel& pixel, const SampleAux& aux);
  void add_sample_exactly(size_t index, bool odd, Color radiance, float alpha, const SampleAux* aux);
  void add_parts_exactly(size_t index, const SampleParts& parts);
  void add_direct_exactly(size_t index, bool odd, Color light);
  void add_splats_exactly(size_t index, int half, int channel, __int128 sum, double units);
  void add_splat_at(size_t index, Color value, float largest, bool odd);
  /// Entries of the splats: those of the image, after them those of each light group, then those of the part passes, then
  /// those of direct paths.
  size_t splat_count() const { return pixels_.size() * (direct_plane() + (wants_direct() ? 1 : 0)); }
  size_t direct_plane() const { return 1 + light_groups().size() + splatted_parts_; }
  /// Index of the entries of a part pass; 0 if it is not asked for. `part`: 0 to 2 direct light by kind, 3 to 5 indirect
  /// light, 6 and 7 direct and indirect light of volumes.
  size_t plane_of_part(size_t part) const { return part_planes_[part]; }
  double splatted_part(size_t part, size_t pixel, int channel) const {
    return plane_of_part(part) > 0 ? splatted(pixel + pixels_.size() * plane_of_part(part), channel) : 0.0;
  }
  uint64_t lost_bytes() const;
  PendingSplats& pending_of(float largest, double& units);
  static void carry(PendingSplats& splats, size_t index, bool odd, int channel);
  size_t index_of(int x, int y) const { return size_t(y - y0_) * size_t(width()) + size_t(x - x0_); }
  struct Remembered {
    uint32_t samples;
    std::array<std::vector<float>, 3> image;
  };
  std::array<std::vector<float>, 3> means() const;
  void make_likely(size_t index, const double around[3], double value[3]) const;
  void sums_around(const std::vector<float>& image, int y, std::vector<double>& columns,
                   std::vector<double>& sums) const;
  ErrorEstimate estimated_error_of_few() const;
  void resolve_part(const std::string& pass, size_t index, double exposure, float out[3]) const;
  std::vector<float> resolve_caught(const std::string& pass, float exposure, size_t channels) const;
  ErrorEstimate error_from_pictures(const Remembered& one, const Remembered& two, uint32_t samples) const;
  double relative_square(double light) const { return light * light + dark_squared(shown_exposure_); }
  /// The smallest difference from a luminance that is visible.
  double threshold_at(double luminance) const;
  double candelas_per_unit() const { return kCandelasPerUnit * shown_exposure_; }
  static double scatter_variance(const Pixel& pixel);
  bool has_halves(const Pixel& pixel) const;
  bool halves_of(size_t index, double mean[3], double difference[3]) const;
  void means_of_halves(size_t index, double exposure, float out[6]) const;
  void means_of_direct_halves(size_t index, double exposure, float out[6]) const;
  void means_of_halves(size_t index, const double sum[3], const double half[3], size_t splats, double exposure,
                       float out[6]) const;
  std::vector<float> variance_of_mean() const;
  static double luminance_of(const double rgb[3]) {
    return 0.2126729 * rgb[0] + 0.7151522 * rgb[1] + 0.0721750 * rgb[2];
  }
  double splatted(size_t index, int channel) const {
    return splats_ ? (splats_[index].sum[0][channel] + splats_[index].sum[1][channel]) * splat_scale_ : 0.0;
  }
  std::unique_ptr<SplatPixel[]> splats_;
  std::array<PendingSplats, 3> pending_;
  double splat_scale_ = 0.0, shown_exposure_ = 1.0;
  std::array<uint16_t, 9> part_planes_{};
  size_t splatted_parts_ = 0;
  int x0_ = 0, y0_ = 0, x1_ = 0, y1_ = 0;
  bool wants_aux_ = false;
  std::vector<Pixel> pixels_;
  std::vector<AuxPixel> aux_;
  std::vector<GuidePixel> guides_;
  std::vector<PartsPixel> parts_;
  std::vector<DirectPixel> direct_;
  std::atomic<bool> direct_known_{false};
  std::unique_ptr<Lost, LostDeleter> lost_;  ///< null: sums are not kept exactly
  uint32_t first_sample_ = 0;
  static constexpr size_t kMaxRemembered = 3;
  std::vector<Remembered> remembered_;  // in the order of time
  std::vector<uint32_t> goals_;
  EarlySamples early_;
  CaughtLight caught_;
  ExtraPasses extra_;
  friend class SampleRecord;
  std::atomic<uint64_t> refused_{0};
};

/// The film of a render with these passes.
std::unique_ptr<Film> make_film(const RenderSettings& settings, const std::vector<std::string>& passes);

/// Storage of a thread for the values of a sample that passes need.
class SampleRecord {
 public:
  /// Starts the next sample of pixel (x, y) of the full frame. Returns null if no pass needs its values.
  SampleAux* begin(const Film& film, int x, int y) {
    if (!film.wants_aux_) return nullptr;
    aux_ = SampleAux();
    if (film.extra_.wanted()) begin_extras(film, x, y);
    return &aux_;
  }

 private:
  void begin_extras(const Film& film, int x, int y);
  SampleAux aux_;
  SampleExtras extras_;
};

}  // namespace ajar
