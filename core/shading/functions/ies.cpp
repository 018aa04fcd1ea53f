#include "shading/functions/ies.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "shading/functions/math_functions.h"

namespace ajar::nodes {
namespace {

constexpr double kWattsPerCandela = 4.0 * M_PI / 177.83;
constexpr double kSameAngle = 1e-4;   ///< degrees

bool is_same(double a, double b) { return std::abs(a - b) < kSameAngle; }

/// The planes of a file while they are turned and mirrored: degrees, and what each plane holds.
struct Planes {
  std::vector<double> horizontal, vertical;
  std::vector<std::vector<double>> values;   // one row of vertical angles for each horizontal one

  void add(double angle, std::vector<double> plane) {
    horizontal.push_back(angle);
    values.push_back(std::move(plane));
  }
  /// Beyond the last plane the ones before it again, at `sum` minus their angles.
  void mirror(double sum) {
    for (size_t i = horizontal.size() - 1; i-- > 0;) add(sum - horizontal[i], values[i]);
  }
  void turn_around() {
    std::reverse(horizontal.begin(), horizontal.end());
    std::reverse(values.begin(), values.end());
  }
};

/// Numbers separated by white space or commas.
class Numbers {
 public:
  explicit Numbers(std::string_view text) : rest_(text) {}

  double next() {
    const size_t start = std::min(rest_.find_first_not_of(" \t\r\n\f\v,"), rest_.size());
    rest_.remove_prefix(start);
    if (!rest_.empty() && rest_[0] == '+') rest_.remove_prefix(1);
    double value = 0.0;
    const auto [end, problem] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
    if (problem != std::errc() || !std::isfinite(value)) {
      if (ok_) ended_ = rest_.empty(), ok_ = false;
      return 0.0;
    }
    rest_.remove_prefix(size_t(end - rest_.data()));
    return value;
  }
  /// A count or a code; -1 for what is no whole number.
  int next_whole() {
    const double value = next();
    return ok_ && value == std::floor(value) && std::abs(value) < 1e9 ? int(value) : -1;
  }
  bool ok() const { return ok_; }
  std::string problem() const {
    return ended_ ? "the file ends early" : "'" + std::string(rest_.substr(0, rest_.find_first_of(" \t\r\n,"))).substr(0, 20) + "' is not a number";
  }
  size_t length_left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  bool ok_ = true, ended_ = false;
};

/// What follows the line that begins with TILT=, and that line's value.
bool find_tilt(std::string_view text, std::string_view& tilt, std::string_view& rest) {
  for (size_t line = 0; line < text.size();) {
    const size_t end = std::min(text.find_first_of("\r\n", line), text.size());
    if (text.substr(line, 5) == "TILT=") {
      tilt = text.substr(line + 5, end - line - 5);
      rest = text.substr(end);
      return true;
    }
    line = end + 1;
  }
  return false;
}

/// Type A counts from the horizon, and turns the other way.
void from_type_a(Planes& p) {
  for (double& v : p.vertical) v += 90.0;
  const bool half = is_same(p.horizontal[0], 0.0);
  p.turn_around();
  for (double& h : p.horizontal) h = 180.0 - h;
  if (half) p.mirror(360.0);
}

/// Type B has its pole on the horizon: the angles change places.
void from_type_b(Planes& p) {
  std::vector<std::vector<double>> turned(p.vertical.size());
  for (size_t v = 0; v < p.vertical.size(); ++v)
    for (const auto& plane : p.values) turned[v].push_back(plane[v]);
  p.values = std::move(turned);
  std::swap(p.horizontal, p.vertical);
  if (is_same(p.horizontal[0], 0.0)) {
    p.turn_around();
    for (double& h : p.horizontal) h = -h;
    p.mirror(0.0);
  }
  for (double& h : p.horizontal) h += 90.0;
  if (is_same(p.vertical[0], 0.0)) {
    std::vector<double> whole(p.vertical.rbegin(), p.vertical.rend());
    for (double& v : whole) v = -v;
    whole.insert(whole.end(), p.vertical.begin() + 1, p.vertical.end());
    p.vertical = whole;
    for (auto& plane : p.values) {
      std::vector<double> both(plane.rbegin(), plane.rend());
      both.insert(both.end(), plane.begin() + 1, plane.end());
      plane = both;
    }
  }
  for (double& v : p.vertical) v += 90.0;
}

void from_type_c(Planes& p) {
  if (is_same(p.horizontal[0], 90.0))
    for (double& h : p.horizontal) h -= 90.0;
  if (p.horizontal.size() == 1) {
    p.horizontal[0] = 0.0;
    p.add(360.0, p.values[0]);
  }
  if (is_same(p.horizontal.back(), 90.0)) p.mirror(180.0);
  if (is_same(p.horizontal.back(), 180.0)) p.mirror(360.0);
  // Some files leave out the last plane, which is the first one.
  const size_t n = p.horizontal.size();
  if (is_same(p.horizontal[0], 0.0) && !is_same(p.horizontal[n - 1], 360.0)) {
    const double gap = 360.0 - p.horizontal[n - 1];
    if (is_same(p.horizontal[n - 1] - p.horizontal[n - 2], gap) || is_same(p.horizontal[1] - p.horizontal[0], gap)) p.add(360.0, p.values[0]);
  }
}

std::string read_planes(std::string_view text, Planes& p, int& type) {
  std::string_view tilt, rest;
  if (!find_tilt(text, tilt, rest)) return "it has no line TILT=";
  Numbers numbers(rest);
  if (tilt.substr(0, 7) == "INCLUDE") {
    numbers.next();   // how the lamp sits in the luminaire
    const int count = numbers.next_whole();
    if (!numbers.ok() || count < 0 || size_t(count) > rest.size()) return "its table of tilt factors is broken";
    for (int i = 0; i < 2 * count; ++i) numbers.next();
  }
  numbers.next();     // lamps
  numbers.next();     // lumens of each
  double factor = numbers.next();
  const int rows = numbers.next_whole(), planes = numbers.next_whole();
  type = numbers.next_whole();
  for (int i = 0; i < 4; ++i) numbers.next();   // unit of length, width, length, height
  factor *= numbers.next();   // ballast
  factor *= numbers.next();   // ballast and lamp
  numbers.next();     // watts
  if (!numbers.ok()) return numbers.problem();
  if (type < 1 || type > 3) return "its photometric type is none of 1 (C), 2 (B) and 3 (A)";
  if (rows < 2 || planes < 1) return "it needs two vertical angles and a horizontal one at least";
  // Every number takes a character at least.
  if ( size_t(rows) > text.size() || size_t(planes) > text.size() || size_t(rows) * size_t(planes) > numbers.length_left())
    return "it names " + std::to_string(rows) + " vertical and " + std::to_string(planes) + " horizontal angles, for which it does not hold the values";
  for (int i = 0; i < rows; ++i) p.vertical.push_back(numbers.next());
  for (int i = 0; i < planes; ++i) p.horizontal.push_back(numbers.next());
  for (int h = 0; h < planes; ++h) {
    p.values.emplace_back();
    for (int v = 0; v < rows; ++v) p.values.back().push_back(numbers.next() * factor * kWattsPerCandela);
  }
  if (!numbers.ok()) return numbers.problem();
  return "";
}

float spline(float a, float b, float c, float d, float x) {
  return b + 0.5f * x * (c - a + x * (2.0f * a - 5.0f * b + 4.0f * c - d + x * (3.0f * (b - c) + d - a)));
}

/// The interval of `angles` in which x lies.
size_t interval(const std::vector<float>& angles, float x) {
  return size_t(std::lower_bound(angles.begin() + 1, angles.end() - 1, x) - angles.begin()) - 1;
}

}  // namespace

IesProfile IesProfile::read(std::string_view text, std::string& error) {
  Planes planes;
  int type = 0;
  error = read_planes(text, planes, type);
  IesProfile profile;
  if (!error.empty()) return profile;
  if (type == 1) from_type_c(planes);
  if (type == 2) from_type_b(planes);
  if (type == 3) from_type_a(planes);
  if (planes.horizontal.size() < 2) error = "it holds a single plane, which only type C may";
  const auto radians = [](double degrees) { return float(degrees * (M_PI / 180.0)); };
  for (double h : planes.horizontal) profile.horizontal_.push_back(radians(h));
  for (double v : planes.vertical) profile.vertical_.push_back(radians(v));
  for (const auto* angles : {&profile.vertical_, &profile.horizontal_})
    if (std::adjacent_find(angles->begin(), angles->end(), std::greater_equal<>()) != angles->end())
      error = std::string("its ") + (angles == &profile.vertical_ ? "vertical" : "horizontal") + " angles do not ascend";
  for (const auto& plane : planes.values)
    for (double value : plane) {
      profile.values_.push_back(float(value));
      if (!std::isfinite(profile.values_.back())) error = "its values are too large";
    }
  if (!error.empty()) return IesProfile();
  profile.closed_ = is_same(planes.horizontal.front(), 0.0) && is_same(planes.horizontal.back(), 360.0);
  return profile;
}

/// Below the first row the second again, where the first is the nadir; beyond the last the last.
float IesProfile::along_plane(size_t plane, size_t row, float fraction) const {
  const size_t rows = vertical_.size();
  const float* values = values_.data() + plane * rows;
  const size_t before = row > 0 ? row - 1 : vertical_[0] < 1e-6f ? 1 : 0;
  return spline(values[before], values[row], values[row + 1], values[std::min(row + 2, rows - 1)], fraction);
}

float IesProfile::towards(Vec3 direction) const {
  const Vec3 d = normalize_or_zero(direction);
  const float v = std::acos(glm::clamp(-d.z, -1.0f, 1.0f)), h = std::atan2(d.x, d.y) + kPi;
  if (empty() || !(v >= vertical_.front() && v < vertical_.back())) return 0.0f;
  if (!closed_ && !(h >= horizontal_.front() && h < horizontal_.back())) return 0.0f;
  const size_t planes = horizontal_.size(), row = interval(vertical_, v), plane = interval(horizontal_, h);
  const float at_row = (v - vertical_[row]) / (vertical_[row + 1] - vertical_[row]);
  const float at_plane = (h - horizontal_[plane]) / (horizontal_[plane + 1] - horizontal_[plane]);
  const size_t before = plane > 0 ? plane - 1 : closed_ ? planes - 2 : 0;
  const size_t after = plane + 2 < planes ? plane + 2 : closed_ ? 1 : plane;
  // The spline may dip below the values it joins.
  return std::max(0.0f, spline(along_plane(before, row, at_row), along_plane(plane, row, at_row), along_plane(plane + 1, row, at_row),
                               along_plane(after, row, at_row), at_plane));
}

}  // namespace ajar::nodes
