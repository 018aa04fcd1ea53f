#include "shading/images/color_spaces.h"

#include <OpenImageIO/color.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "math/srgb.h"

namespace ajar {

namespace {

using Processor = OIIO::ColorProcessorHandle;

/// A configuration is read once. Its file can have thousands of lines.
std::shared_ptr<const OIIO::ColorConfig> read_config(const std::string& path) {
  static std::mutex mutex;
  static std::map<std::string, std::shared_ptr<const OIIO::ColorConfig>> known;
  if (path.empty()) return nullptr;
  const std::lock_guard lock(mutex);
  auto [entry, is_new] = known.try_emplace(path);
  if (is_new) {
    auto config = std::make_shared<OIIO::ColorConfig>(path);
    if (!config->has_error()) entry->second = std::move(config);
  }
  return entry->second;
}

/// Whether the configuration itself has the space. OpenImageIO also knows some names that are not in it.
bool contains(const OIIO::ColorConfig& config, const std::string& name) {
  for (int i = 0; i < config.getNumColorSpaces(); ++i) {
    const char* space = config.getColorSpaceNameByIndex(i);
    if (space && name == space) return true;
  }
  return config.getColorSpaceNameByRole(name) != nullptr;
}

Color converted(OIIO::ColorProcessor& processor, Color c) {
  float rgb[3] = {c.x, c.y, c.z};
  processor.apply(rgb);
  return {rgb[0], rgb[1], rgb[2]};
}

bool is_near(Color a, Color b, float tolerance) {
  return max_component(glm::abs(a - b)) <= tolerance * (1.0f + max_component(glm::abs(b)));
}

/// Whether the conversion applies one curve, which `curve` computes, to each channel.
template <class Curve>
bool applies(OIIO::ColorProcessor& processor, float tolerance, Curve&& curve) {
  for (int i = 0; i <= 64; ++i) {
    const float x = float(i) / 64.0f;
    for (const Color& c : {Color(x, 0, 0), Color(0, x, 0), Color(0, 0, x), Color(x)})
      if (!is_near(converted(processor, c), Color(curve(c.x), curve(c.y), curve(c.z)), tolerance)) return false;
  }
  return true;
}

Mat3 rows(Vec3 x, Vec3 y, Vec3 z) { return glm::transpose(Mat3(x, y, z)); }

/// Rec. ITU-R BT.709, relative to CIE XYZ with D65.
const Mat3 kXyzFromRec709 = glm::inverse(rows({3.2404542f, -1.5371385f, -0.4985314f},
                                              {-0.9692660f, 1.8760108f, 0.0415560f},
                                              {0.0556434f, -0.2040259f, 1.0572252f}));
/// SMPTE ST 2065-1 (ACES AP0), adapted to D65 by Bradford's method.
const Mat3 kXyzFromAces = rows({0.938280f, -0.004451f, 0.016628f}, {0.337369f, 0.729522f, -0.066890f},
                               {0.001174f, -0.003711f, 1.091595f});

}  // namespace

struct ColorSpaces::Data {
  ColorDescription description;
  bool is_rec709 = true;  ///< the working space
  std::map<std::string, Processor> processors;

  const Processor& processor(const std::string& name) {
    auto [entry, is_new] = processors.try_emplace(name);
    const auto config = is_new ? read_config(description.config) : nullptr;
    if (config && contains(*config, name))
      entry->second = config->createColorProcessor(name, description.working_space);
    return entry->second;
  }
};

ColorSpaces::ColorSpaces(const ColorDescription& description) : data_(std::make_unique<Data>()) {
  data_->description = description;
  data_->is_rec709 = working_from_rec709(description) == Mat3(1.0f);
}
ColorSpaces::ColorSpaces(ColorSpaces&&) noexcept = default;
ColorSpaces& ColorSpaces::operator=(ColorSpaces&&) noexcept = default;
ColorSpaces::~ColorSpaces() = default;

const ColorDescription& ColorSpaces::description() const { return data_->description; }

ColorEncoding ColorSpaces::encoding(const std::string& name, bool is_float, std::string& problem) {
  problem.clear();
  const auto is = [&](std::initializer_list<const char*> names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (is({"Non-Color", "Non-Colour Data", "Raw", "Generic Data"})) return ColorEncoding::Data;
  if (name == "scene_linear" || (!name.empty() && name == data_->description.working_space))
    return ColorEncoding::Working;
  if (name.empty()) return is_float ? ColorEncoding::Working : ColorEncoding::Srgb;
  if (data_->is_rec709) {
    if (is({"Linear", "Linear Rec.709", "Linear BT.709"})) return ColorEncoding::Working;
    if (name == "sRGB") return ColorEncoding::Srgb;
  }
  const Processor& processor = data_->processor(name);
  if (processor) {
    if (applies(*processor, 1e-6f, [](float x) { return x; })) return ColorEncoding::Working;
    return applies(*processor, 1e-4f, linear_from_srgb) ? ColorEncoding::Srgb : ColorEncoding::Other;
  }
  const bool linear = name.find("Linear") != std::string::npos || name == "XYZ";
  problem = "colour space '" + name + "' is not in the OpenColorIO configuration; it is approximated by " +
            (linear ? "linear Rec. 709" : "sRGB");
  return linear ? ColorEncoding::Working : ColorEncoding::Srgb;
}

void ColorSpaces::convert(const std::string& name, float* rgba, int64_t count) {
  constexpr int64_t kAtOnce = 1 << 16;
  const Processor& processor = data_->processor(name);
  for (int64_t done = 0; processor && done < count; done += kAtOnce) {
    const int n = int(std::min(kAtOnce, count - done));
    processor->apply(rgba + 4 * done, n, 1, 4, sizeof(float), 4 * sizeof(float), OIIO::stride_t(n) * 4 * sizeof(float));
  }
}

Mat3 working_from_rec709(const ColorDescription& description) {
  const std::string& space = description.working_space;
  if (space.empty() || space == "Linear" || space == "Linear Rec.709") return Mat3(1.0f);
  const auto config = read_config(description.config);
  const Processor from_aces = config ? config->createColorProcessor("aces_interchange", space) : nullptr;
  if (!from_aces) return Mat3(1.0f);
  const Mat3 working_from_aces(converted(*from_aces, {1, 0, 0}), converted(*from_aces, {0, 1, 0}),
                               converted(*from_aces, {0, 0, 1}));
  const Mat3 matrix = working_from_aces * glm::inverse(kXyzFromAces) * kXyzFromRec709;
  for (int i = 0; i < 3; ++i)
    if (!is_near(matrix[i], Mat3(1.0f)[i], 2e-4f)) return matrix;
  return Mat3(1.0f);
}

}  // namespace ajar
