#include "shading/functions/ies.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "shading/functions/math_functions.h"

namespace ajar::nodes {
namespace {

constexpr double kWattsPerCandela = 4.0 * M_PI / 177.83;
constexpr double kSameAngle = 1e-4;  ///< degrees

bool is_same(double a, double b) { return std::abs(a - b) < kSameAngle; }

// ---- The file (ANSI/IES LM-63-02) ---------------------------------------------------------------------------

/// The thirteen numbers between the tilt and the angles, in the order of the file.
enum Field : size_t {
  Lamps,
  LumensPerLamp,
  Multiplier,
  VerticalAngles,
  HorizontalAngles,
  PhotometricType,
  Units,
  Width,
  Length,
  Height,
  BallastFactor,
  FutureUse,
  InputWatts,
  kFields
};

enum class PhotometricSystem { C = 1, B = 2, A = 3 };

/// The content of a file, unchanged. Angles are in degrees.
struct Measurement {
  PhotometricSystem system = PhotometricSystem::C;
  std::vector<double> vertical, horizontal;
  std::vector<double> watts;  ///< all values of the first horizontal angle, then those of the next
};

/// Reads numbers that are separated by white space or commas. After the first error, all numbers are 0.
class NumberReader {
 public:
  explicit NumberReader(std::string_view text) : rest_(text) {}

  double next() {
    if (!problem_.empty()) return 0.0;
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSeparators), rest_.size()));
    if (rest_.empty()) {
      problem_ = "the file ends early";
      return 0.0;
    }
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kSeparators));
    const char* digits = word.data() + (word[0] == '+' ? 1 : 0);  // from_chars does not accept the sign
    double value = 0.0;
    const auto [end, status] = std::from_chars(digits, word.data() + word.size(), value);
    if (status != std::errc() || !std::isfinite(value)) {
      problem_ = "'" + std::string(word.substr(0, 20)) + "' is not a number";
      return 0.0;
    }
    rest_.remove_prefix(size_t(end - rest_.data()));
    return value;
  }
  std::vector<double> next(size_t count) {
    std::vector<double> numbers(count);
    for (double& number : numbers) number = next();
    return numbers;
  }
  /// Empty if all numbers could be read.
  const std::string& problem() const { return problem_; }
  size_t characters_left() const { return rest_.size(); }

 private:
  static constexpr std::string_view kSeparators = " \t\r\n\f\v,";
  std::string_view rest_;
  std::string problem_;
};

/// Converts a number to a count from 0 to 10^9. Returns -1 if it is not one.
int whole(double number) { return number >= 0.0 && number < 1e9 && number == std::floor(number) ? int(number) : -1; }

/// Finds the line TILT=, which ends the keywords. Returns its position, or npos.
size_t find_tilt_line(std::string_view text) {
  constexpr std::string_view kKeyword = "TILT=";
  size_t at = text.find(kKeyword);
  while (at != std::string_view::npos && at > 0 && text[at - 1] != '\n' && text[at - 1] != '\r')
    at = text.find(kKeyword, at + 1);
  return at;
}

/// Parses the file. Returns a description of the first error, or an empty string.
std::string parse(std::string_view text, Measurement& m) {
  const size_t tilt = find_tilt_line(text);
  if (tilt == std::string_view::npos) return "it has no line TILT=";
  const size_t line_end = std::min(text.find_first_of("\r\n", tilt), text.size());
  const std::string_view tilt_line = text.substr(tilt, line_end - tilt);
  NumberReader numbers(text.substr(line_end));

  // TILT=INCLUDE is followed by the orientation of the lamp, a count, and this number of angles and of factors.
  if (tilt_line.starts_with("TILT=INCLUDE")) {
    numbers.next();
    const int count = whole(numbers.next());
    if (!numbers.problem().empty() || count < 0 || size_t(count) > numbers.characters_left())
      return "its table of tilt factors is broken";
    numbers.next(2 * size_t(count));
  }

  std::array<double, kFields> header;
  for (double& field : header) field = numbers.next();
  if (!numbers.problem().empty()) return numbers.problem();
  const int type = whole(header[PhotometricType]), rows = whole(header[VerticalAngles]),
            planes = whole(header[HorizontalAngles]);
  if (type < 1 || type > 3) return "its photometric type is not 1 (C), 2 (B) or 3 (A)";
  if (rows < 2 || planes < 1) return "it has fewer than two vertical angles or no horizontal angle";
  // A number takes at least one character. This check avoids allocating memory for values that the file cannot contain.
  if (size_t(rows) * size_t(planes) > numbers.characters_left())
    return "it announces " + std::to_string(rows) + " vertical and " + std::to_string(planes) +
           " horizontal angles but does not hold the values for them";

  m.system = PhotometricSystem(type);
  m.vertical = numbers.next(size_t(rows));
  m.horizontal = numbers.next(size_t(planes));
  m.watts = numbers.next(size_t(rows) * size_t(planes));
  if (!numbers.problem().empty()) return numbers.problem();
  for (double& value : m.watts)
    value *= header[Multiplier] * header[BallastFactor] * header[FutureUse] * kWattsPerCandela;
  for (const auto* angles : {&m.vertical, &m.horizontal})
    for (size_t i = 1; i < angles->size(); ++i)
      if (!((*angles)[i] - (*angles)[i - 1] >= kSameAngle))
        return std::string("its ") + (angles == &m.vertical ? "vertical" : "horizontal") + " angles do not ascend";
  return "";
}

// ---- Conversion of the three coordinate systems of the standard to one --------------------------------------------

/// An angle in degrees, and the index of the angle in the file whose values are valid there.
struct Knot {
  double angle;
  size_t source;
};

/// An axis of the table under construction, ascending. Symmetry adds knots but no values.
class Axis {
 public:
  explicit Axis(const std::vector<double>& angles) {
    for (size_t i = 0; i < angles.size(); ++i) knots_.push_back({angles[i], i});
  }

  double first() const { return knots_.front().angle; }
  double last() const { return knots_.back().angle; }
  size_t size() const { return knots_.size(); }
  const Knot& operator[](size_t i) const { return knots_[i]; }

  void shift(double degrees) {
    for (Knot& knot : knots_) knot.angle += degrees;
  }
  /// Reverses the direction: an angle a becomes `sum` - a.
  void reverse(double sum) {
    for (Knot& knot : knots_) knot.angle = sum - knot.angle;
    std::reverse(knots_.begin(), knots_.end());
  }
  /// Adds the mirror image `sum` - a of each knot a. If two knots have equal angles, the original one is kept.
  void mirror(double sum) {
    Axis image = *this;
    image.reverse(sum);
    knots_.insert(knots_.end(), image.knots_.begin(), image.knots_.end());
    std::stable_sort(knots_.begin(), knots_.end(), [](const Knot& a, const Knot& b) { return a.angle < b.angle; });
    knots_.erase(std::unique(knots_.begin(), knots_.end(),
                             [](const Knot& a, const Knot& b) { return is_same(a.angle, b.angle); }),
                 knots_.end());
  }
  void add(double angle, size_t source) { knots_.push_back({angle, source}); }

 private:
  std::vector<Knot> knots_;
};

/// Type C: vertical angles start at the nadir, horizontal angles turn around the vertical axis. The last horizontal
/// angle determines the symmetry: 0 is rotation, 90 is four equal quadrants, 180 is two equal halves.
void complete_type_c(Axis& turn) {
  if (is_same(turn.first(), 90.0)) turn.shift(-90.0);  // 90 to 270: symmetric about the other plane
  if (turn.size() == 1) {
    const size_t only = turn[0].source;
    turn.shift(-turn.first());
    turn.add(360.0, only);
    return;
  }
  if (is_same(turn.last(), 90.0)) turn.mirror(180.0);
  if (is_same(turn.last(), 180.0)) turn.mirror(360.0);
  // Some files leave out 360, which is equal to 0. This is assumed if the gap is as wide as the first or the last
  // interval.
  const size_t n = turn.size();
  const double gap = 360.0 - turn.last();
  const bool continues = is_same(gap, turn[1].angle - turn[0].angle) ||
                         is_same(gap, turn[n - 1].angle - turn[n - 2].angle);
  if (is_same(turn.first(), 0.0) && continues) turn.add(360.0, turn[0].source);
}

/// Type B: the poles of the system are on the horizon, so vertical angles turn and horizontal angles go up and down. An
/// axis that starts at 0 is valid for both sides.
void complete_type_b(Axis& turn, Axis& from_nadir) {
  for (Axis* axis : {&turn, &from_nadir})
    if (is_same(axis->first(), 0.0)) axis->mirror(0.0);
  turn.shift(90.0);
  from_nadir.shift(90.0);
}

/// Type A: vertical angles start at the horizon. Horizontal angles start at the front and turn in the opposite
/// direction to type C. A file that starts at 0 is valid for both sides.
void complete_type_a(Axis& turn, Axis& from_nadir) {
  const bool one_side = is_same(turn.first(), 0.0);
  from_nadir.shift(90.0);
  turn.reverse(180.0);
  if (one_side) turn.mirror(360.0);
}

// ---- Interpolation ------------------------------------------------------------------------------------------------

/// Four neighbouring entries of an axis, with their weights.
struct Support {
  std::array<size_t, 4> entries;
  std::array<float, 4> weights;
};

/// Catmull and Rom 1974: a cubic through the two middle entries. Its slopes are the differences between their
/// neighbours.
std::array<float, 4> catmull_rom(float t) {
  const float s = 1.0f - t;
  return {-0.5f * t * s * s, s * (1.0f + t - 1.5f * t * t), t * (1.0f + s - 1.5f * s * s), -0.5f * s * t * t};
}

/// The index of the interval of `angles` that contains x.
size_t interval(const std::vector<float>& angles, float x) {
  return size_t(std::lower_bound(angles.begin() + 1, angles.end() - 1, x) - angles.begin()) - 1;
}

std::array<float, 4> weights_at(const std::vector<float>& angles, size_t i, float x) {
  return catmull_rom((x - angles[i]) / (angles[i + 1] - angles[i]));
}

/// Rows, from the nadir. If the first row is the nadir itself, its neighbour on the other side is the second row. The
/// last row is repeated.
Support support_of_rows(const std::vector<float>& angles, float x) {
  const size_t i = interval(angles, x), last = angles.size() - 1;
  const size_t beyond_first = angles[0] < 1e-6f ? 1 : 0;
  return {{i > 0 ? i - 1 : beyond_first, i, i + 1, std::min(i + 2, last)}, weights_at(angles, i, x)};
}

/// Planes, around the axis. If the planes are closed, the last is the first. If they are open, Blender repeats the
/// first plane before the first interval; after the last interval it uses the plane at the start of this interval
/// again.
Support support_of_planes(const std::vector<float>& angles, float x, bool closed) {
  const size_t i = interval(angles, x), last = angles.size() - 1;
  const size_t before = i > 0 ? i - 1 : closed ? last - 1 : 0;
  const size_t after = i + 2 <= last ? i + 2 : closed ? 1 : i;
  return {{before, i, i + 1, after}, weights_at(angles, i, x)};
}

}  // namespace

IesProfile IesProfile::read(std::string_view text, std::string& error) {
  Measurement m;
  error = parse(text, m);
  if (!error.empty()) return {};

  const bool sideways = m.system == PhotometricSystem::B;
  Axis turn(sideways ? m.vertical : m.horizontal), from_nadir(sideways ? m.horizontal : m.vertical);
  switch (m.system) {
    case PhotometricSystem::C: complete_type_c(turn); break;
    case PhotometricSystem::B: complete_type_b(turn, from_nadir); break;
    case PhotometricSystem::A: complete_type_a(turn, from_nadir); break;
  }
  if (turn.size() < 2 || from_nadir.size() < 2) {
    error = "it holds a single plane, which only type C allows";
    return {};
  }

  IesProfile profile;
  const auto radians = [](const Knot& knot) { return float(knot.angle * (M_PI / 180.0)); };
  for (size_t v = 0; v < from_nadir.size(); ++v) profile.vertical_.push_back(radians(from_nadir[v]));
  for (size_t h = 0; h < turn.size(); ++h) {
    profile.horizontal_.push_back(radians(turn[h]));
    for (size_t v = 0; v < from_nadir.size(); ++v) {
      const size_t plane = sideways ? from_nadir[v].source : turn[h].source,
                   row = sideways ? turn[h].source : from_nadir[v].source;
      profile.values_.push_back(float(m.watts[plane * m.vertical.size() + row]));
      if (!std::isfinite(profile.values_.back())) error = "its values are too large";
    }
  }
  if (!error.empty()) return {};
  profile.closed_ = is_same(turn.first(), 0.0) && is_same(turn.last(), 360.0);
  return profile;
}

float IesProfile::towards(Vec3 direction) const {
  const Vec3 d = normalize_or_zero(direction);
  const float from_nadir = std::acos(glm::clamp(-d.z, -1.0f, 1.0f)), turn = std::atan2(d.x, d.y) + kPi;
  if (empty() || !(from_nadir >= vertical_.front() && from_nadir < vertical_.back())) return 0.0f;
  if (!closed_ && !(turn >= horizontal_.front() && turn < horizontal_.back())) return 0.0f;
  const Support planes = support_of_planes(horizontal_, turn, closed_), rows = support_of_rows(vertical_, from_nadir);
  float sum = 0.0f;
  for (size_t h = 0; h < 4; ++h) {
    const float* plane = values_.data() + planes.entries[h] * vertical_.size();
    float along_plane = 0.0f;
    for (size_t v = 0; v < 4; ++v) along_plane += rows.weights[v] * plane[rows.entries[v]];
    sum += planes.weights[h] * along_plane;
  }
  return std::max(0.0f, sum);  // the cubic can be lower than the values that it connects
}

}  // namespace ajar::nodes
