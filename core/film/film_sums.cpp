#include "film/film_sums.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>

#include "film/film.h"

namespace ajar {

bool FilmSums::has_same_form(const FilmSums& other) const {
  bool same = pixels == other.pixels && firsts.size() == other.firsts.size();
  for (size_t k = 0; k < tables.size(); ++k) same = same && tables[k].high.size() == other.tables[k].high.size();
  return same;
}

void FilmSums::add(const FilmSums& other) {
  for (size_t i = 0; i < counts.size(); ++i) counts[i] += other.counts[i];
  for (size_t i = 0; i + kFirsts <= firsts.size(); i += kFirsts)
    if (firsts[i + kFirsts - 1] == 0.0f)
      std::copy_n(other.firsts.begin() + ptrdiff_t(i), kFirsts, firsts.begin() + ptrdiff_t(i));
  for (size_t k = 0; k < tables.size(); ++k) {
    Table& to = tables[k];
    const Table& from = other.tables[k];
    for (size_t i = 0; i < to.high.size(); ++i) {
      add_exactly(to.high[i], to.low[i], from.high[i]);
      add_exactly(to.high[i], to.low[i], from.low[i]);
    }
  }
}

/// What the sums of a film lose by rounding, in the same structures.
struct Film::Lost {
  std::vector<Pixel> pixels;
  std::vector<AuxPixel> aux;
  std::vector<GuidePixel> guides;
  std::vector<PartsPixel> parts;
  std::vector<SplatPixel> splats;
  std::vector<DirectPixel> direct;
};

void Film::LostDeleter::operator()(Lost* lost) const { delete lost; }

/// The structures begin with their sums.
template <class Entry>
double* Film::numbers_of(Entry& entry) {
  return reinterpret_cast<double*>(&entry);
}

template <class Entry>
void Film::add_numbers(Entry& sums, Entry& lost, Entry& more, size_t count) {
  double *high = numbers_of(sums), *low = numbers_of(lost), *value = numbers_of(more);
  for (size_t k = 0; k < count; ++k) add_exactly(high[k], low[k], value[k]);
}

bool Film::keep_exact_sums() {
  static_assert(offsetof(Pixel, count) == FilmSums::kWidths[0] * sizeof(double));
  static_assert(offsetof(AuxPixel, object_index) == FilmSums::kWidths[1] * sizeof(double));
  static_assert(sizeof(GuidePixel) == FilmSums::kWidths[2] * sizeof(double));
  static_assert(sizeof(PartsPixel) == FilmSums::kWidths[3] * sizeof(double));
  static_assert(sizeof(SplatPixel) == FilmSums::kWidths[4] * sizeof(double));
  static_assert(sizeof(DirectPixel) == FilmSums::kWidths[5] * sizeof(double));
  if (extra_.wanted() || !extra_.groups().empty() || caught_.enabled()) return false;
  lost_.reset(new Lost);
  lost_->pixels.resize(pixels_.size());
  lost_->aux.resize(aux_.size());
  lost_->guides.resize(guides_.size());
  lost_->parts.resize(parts_.size());
  lost_->direct.resize(direct_.size());
  return true;
}

uint64_t Film::lost_bytes() const {
  if (!lost_) return 0;
  return lost_->pixels.size() * sizeof(Pixel) + lost_->aux.size() * sizeof(AuxPixel) +
         lost_->guides.size() * sizeof(GuidePixel) + lost_->parts.size() * sizeof(PartsPixel) +
         lost_->splats.size() * sizeof(SplatPixel) + lost_->direct.size() * sizeof(DirectPixel);
}

void Film::add_sample_exactly(size_t index, bool odd, Color radiance, float alpha, const SampleAux* aux) {
  Pixel more;
  for (int c = 0; c < 3; ++c) {
    more.sum[c] = double(radiance[c]);
    if (odd) more.half[c] = double(radiance[c]);
  }
  more.sum_alpha = double(alpha);
  const float y = std::clamp(luminance(radiance), -1e15f, 1e15f);
  more.sum_luminance_squared = double(y * y);
  add_numbers(pixels_[index], lost_->pixels[index], more, FilmSums::kWidths[0]);
  if (!aux || aux_.empty()) return;
  add_first(aux_[index], *aux);
  AuxPixel surface;
  for (int c = 0; c < 3; ++c) {
    surface.normal[c] = double(aux->normal[c]);
    surface.uv[c] = double(aux->uv[c]);
    surface.albedo[c] = double(aux->albedo[c]);
  }
  for (size_t k = 0; k < aux->shares.size(); ++k) surface.shares[k] = double(aux->shares[k]);
  surface.mist = double(aux->mist);
  add_numbers(aux_[index], lost_->aux[index], surface, FilmSums::kWidths[1]);
  if (guides_.empty()) return;
  GuidePixel guide;
  for (int c = 0; c < 3; ++c) {
    guide.albedo[c] = double(aux->guide_albedo[c]);
    guide.normal[c] = double(aux->guide_normal[c]);
  }
  add_numbers(guides_[index], lost_->guides[index], guide, FilmSums::kWidths[2]);
}

void Film::add_parts_exactly(size_t index, const SampleParts& parts) {
  PartsPixel more;
  for (int c = 0; c < 3; ++c) {
    more.emission[c] = double(parts.emission[c]);
    more.environment[c] = double(parts.environment[c]);
    for (size_t k = 0; k < 2; ++k) more.volume[k][c] = double(parts.volume[k][c]);
    for (size_t k = 0; k < 3; ++k) {
      more.direct[k][c] = double(parts.direct[k][c]);
      more.indirect[k][c] = double(parts.indirect[k][c]);
      more.color[k][c] = double(parts.color[k][c]);
    }
  }
  add_numbers(parts_[index], lost_->parts[index], more, FilmSums::kWidths[3]);
}

void Film::add_direct_exactly(size_t index, bool odd, Color light) {
  DirectPixel more;
  for (int c = 0; c < 3; ++c) {
    more.sum[c] = double(light[c]);
    if (odd) more.half[c] = double(light[c]);
  }
  add_numbers(direct_[index], lost_->direct[index], more, FilmSums::kWidths[5]);
}

void Film::add_splats_exactly(size_t index, int half, int channel, __int128 sum, double units) {
  if (lost_->splats.empty()) lost_->splats.resize(splat_count());
  double &high = splats_[index].sum[half][channel], &low = lost_->splats[index].sum[half][channel];
  const double rounded = double(sum);  // units are powers of two: divisions by them are exact
  add_exactly(high, low, rounded / units);
  add_exactly(high, low, double(sum - __int128(rounded)) / units);
}

template <class Entry, class Entries>
void Film::read_table(FilmSums::Table& table, const Entries& entries, const std::vector<Entry>& lost, size_t count,
                      size_t width) {
  table.width = width;
  table.high.resize(count * width);
  table.low.resize(count * width);
  for (size_t i = 0; i < count; ++i) {
    std::copy_n(reinterpret_cast<const double*>(&entries[i]), width, table.high.data() + i * width);
    if (!lost.empty()) std::copy_n(reinterpret_cast<const double*>(&lost[i]), width, table.low.data() + i * width);
  }
}

template <class Entry, class Entries>
void Film::write_table(const FilmSums::Table& table, Entries& entries, std::vector<Entry>& lost, size_t count,
                       size_t width) {
  for (size_t i = 0; i < count; ++i) {
    std::copy_n(table.high.data() + i * width, width, numbers_of(entries[i]));
    std::copy_n(table.low.data() + i * width, width, numbers_of(lost[i]));
  }
}

FilmSums Film::sums() const {
  FilmSums s;
  if (!lost_) return s;
  s.pixels = pixels_.size();
  s.counts.resize(2 * s.pixels);
  for (size_t i = 0; i < s.pixels; ++i) s.counts[2 * i] = pixels_[i].count, s.counts[2 * i + 1] = pixels_[i].half_count;
  s.firsts.resize(FilmSums::kFirsts * aux_.size());
  for (size_t i = 0; i < aux_.size(); ++i) {
    const AuxPixel& a = aux_[i];
    const float values[FilmSums::kFirsts] = {float(a.depth),           float(a.position[0]), float(a.position[1]),
                                             float(a.position[2]),     a.object_index,       a.material_index,
                                             a.has_first ? 1.0f : 0.0f};
    std::copy_n(values, FilmSums::kFirsts, s.firsts.data() + FilmSums::kFirsts * i);
  }
  const auto& widths = FilmSums::kWidths;
  read_table(s.tables[0], pixels_, lost_->pixels, s.pixels, widths[0]);
  read_table(s.tables[1], aux_, lost_->aux, aux_.size(), widths[1]);
  read_table(s.tables[2], guides_, lost_->guides, guides_.size(), widths[2]);
  read_table(s.tables[3], parts_, lost_->parts, parts_.size(), widths[3]);
  read_table(s.tables[4], splats_, lost_->splats, splats_ ? splat_count() : 0, widths[4]);
  read_table(s.tables[5], direct_, lost_->direct, direct_.size(), widths[5]);
  // These are values and not sums.
  for (size_t i = 0; i < aux_.size(); ++i)
    for (const size_t k : {size_t(0), size_t(4), size_t(5), size_t(6)}) s.tables[1].high[i * widths[1] + k] = 0.0;
  return s;
}

void Film::set_sums(const FilmSums& s) {
  if (!lost_ && !keep_exact_sums()) throw std::invalid_argument("this film has passes without exact sums");
  const auto& widths = FilmSums::kWidths;
  if (!s.tables[4].high.empty()) {
    enable_splats();
    lost_->splats.resize(splat_count());
  }
  const size_t entries[] = {pixels_.size(), aux_.size(), guides_.size(), parts_.size(), splats_ ? splat_count() : 0,
                            direct_.size()};
  bool fits = s.pixels == pixels_.size() && s.counts.size() == 2 * s.pixels &&
              s.firsts.size() == FilmSums::kFirsts * aux_.size();
  for (size_t k = 0; k < widths.size(); ++k)
    fits = fits && s.tables[k].high.size() == entries[k] * widths[k] &&
           s.tables[k].low.size() == s.tables[k].high.size();
  if (!fits) throw std::invalid_argument("the passes differ");
  write_table(s.tables[0], pixels_, lost_->pixels, entries[0], widths[0]);
  write_table(s.tables[1], aux_, lost_->aux, entries[1], widths[1]);
  write_table(s.tables[2], guides_, lost_->guides, entries[2], widths[2]);
  write_table(s.tables[3], parts_, lost_->parts, entries[3], widths[3]);
  write_table(s.tables[4], splats_, lost_->splats, entries[4], widths[4]);
  direct_known_ = true;
  write_table(s.tables[5], direct_, lost_->direct, entries[5], widths[5]);
  for (size_t i = 0; i < s.pixels; ++i) pixels_[i].count = s.counts[2 * i], pixels_[i].half_count = s.counts[2 * i + 1];
  for (size_t i = 0; i < aux_.size(); ++i) {
    AuxPixel& a = aux_[i];
    const float* first = s.firsts.data() + FilmSums::kFirsts * i;
    a.depth = double(first[0]);
    for (int c = 0; c < 3; ++c) a.position[c] = double(first[1 + c]);
    a.object_index = first[4];
    a.material_index = first[5];
    a.has_first = first[6] != 0.0f;
  }
  if (splats_) splat_scale_ = sample_counts().mean > 0.0 ? 1.0 / sample_counts().mean : 0.0;
}

}  // namespace ajar
