#include "denoise/open_image_denoise.h"

#include <algorithm>
#include <cstring>
#include <mutex>
#include <stdexcept>

#include "platform/platform.h"

namespace ajar {

namespace {

// The C interface of the library [https://www.openimagedenoise.org/documentation.html], as far as it is used.
constexpr int kCpu = 1, kFloat3 = 3, kCancelled = 6, kFast = 4, kBalanced = 5, kHigh = 6;
constexpr int kFirstWithFast = 20300;  // version number
struct Interface {
  void* (*new_device)(int type);
  void (*set_device_int)(void* device, const char* name, int value);
  void (*set_device_bool)(void* device, const char* name, bool value);
  int (*get_device_int)(void* device, const char* name);
  void (*commit_device)(void* device);
  void (*release_device)(void* device);
  int (*get_device_error)(void* device, const char** message);
  void* (*new_filter)(void* device, const char* type);
  void (*set_shared_filter_image)(void* filter, const char* name, void* data, int format, size_t width, size_t height,
                                  size_t offset, size_t pixel_stride, size_t row_stride);
  void (*set_filter_bool)(void* filter, const char* name, bool value);
  void (*set_filter_int)(void* filter, const char* name, int value);
  void (*set_filter_progress)(void* filter, bool (*goes_on)(void* user, double done), void* user);
  void (*commit_filter)(void* filter);
  void (*execute_filter)(void* filter);
  void (*release_filter)(void* filter);
};

struct Loaded {
  std::mutex mutex;
  bool done = false;
  Interface functions{};
  std::string version;
  bool has_fast = false;
};
Loaded& loaded() {
  static Loaded one;
  return one;
}

template <class Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(platform::find_function(library, name));
  if (function == nullptr) throw std::runtime_error(std::string("Open Image Denoise has no function ") + name + ".");
}

int number_of(DenoiseNetwork network) {
  if (network == DenoiseNetwork::Large) return kHigh;
  return network == DenoiseNetwork::Small && loaded().has_fast ? kFast : kBalanced;
}

bool goes_on(void* cancelled, double) { return !static_cast<const std::atomic<bool>*>(cancelled)->load(); }

}  // namespace

struct OpenImageDenoise::Device {
  const Interface& use;
  void* handle;

  /// `threads`: 0 uses all.
  static std::unique_ptr<Device> make(int threads) {
    if (version().empty()) throw std::runtime_error("Open Image Denoise is not loaded.");
    auto device = std::make_unique<Device>(loaded().functions);
    const Interface& f = device->use;
    if (threads > 0) f.set_device_int(device->handle, "numThreads", threads);
    f.set_device_bool(device->handle, "setAffinity", false);
    f.commit_device(device->handle);
    device->check();
    return device;
  }
  explicit Device(const Interface& functions) : use(functions), handle(functions.new_device(kCpu)) {
    if (handle == nullptr) throw std::runtime_error("Open Image Denoise has no device for this CPU.");
  }
  ~Device() { use.release_device(handle); }
  Device(const Device&) = delete;

  /// Float RGB of one size. The image `name` is denoised in place. Guides that are not used are null.
  struct Images {
    const char* name;
    float* image;
    const float *albedo, *normal;
    size_t width, height;
    int quality;  ///< number of the library
  };
  /// A filter that is not committed. To be released.
  void* make_filter(const Images& images) const {
    void* const filter = use.new_filter(handle, "RT");
    const auto set = [&](const char* slot, const float* data) {
      use.set_shared_filter_image(filter, slot, const_cast<float*>(data), kFloat3, images.width, images.height, 0, 0,
                                  0);
    };
    set(images.name, images.image);
    set("output", images.image);
    use.set_filter_int(filter, "quality", images.quality);
    if (std::strcmp(images.name, "color") == 0) use.set_filter_bool(filter, "hdr", true);
    if (images.albedo != nullptr) set("albedo", images.albedo);
    if (images.normal != nullptr) set("normal", images.normal);
    if (images.albedo != nullptr) use.set_filter_bool(filter, "cleanAux", images.quality == kHigh);
    return filter;
  }
  void run(void* filter, const std::atomic<bool>& cancelled) const {
    use.set_filter_progress(filter, goes_on, const_cast<std::atomic<bool>*>(&cancelled));
    use.commit_filter(filter);
    use.execute_filter(filter);
  }
  void check() const {
    const char* message = nullptr;
    const int error = use.get_device_error(handle, &message);
    if (error == kCancelled) throw DenoisingCancelled();
    if (error != 0)
      throw std::runtime_error(std::string("Open Image Denoise: ") + (message ? message : "unknown error"));
  }
};

void OpenImageDenoise::load(const std::string& file) {
  Loaded& l = loaded();
  const std::lock_guard lock(l.mutex);
  if (l.done) return;
  void* library = platform::load_library(file);
  Interface& f = l.functions;
  find(library, "oidnNewDevice", f.new_device);
  find(library, "oidnSetDeviceInt", f.set_device_int);
  find(library, "oidnSetDeviceBool", f.set_device_bool);
  find(library, "oidnGetDeviceInt", f.get_device_int);
  find(library, "oidnCommitDevice", f.commit_device);
  find(library, "oidnReleaseDevice", f.release_device);
  find(library, "oidnGetDeviceError", f.get_device_error);
  find(library, "oidnNewFilter", f.new_filter);
  find(library, "oidnSetSharedFilterImage", f.set_shared_filter_image);
  find(library, "oidnSetFilterBool", f.set_filter_bool);
  find(library, "oidnSetFilterInt", f.set_filter_int);
  find(library, "oidnSetFilterProgressMonitorFunction", f.set_filter_progress);
  find(library, "oidnCommitFilter", f.commit_filter);
  find(library, "oidnExecuteFilter", f.execute_filter);
  find(library, "oidnReleaseFilter", f.release_filter);
  const Device device(f);
  f.commit_device(device.handle);
  device.check();
  for (const char* part : {"versionMajor", "versionMinor", "versionPatch"})
    l.version += (l.version.empty() ? "" : ".") + std::to_string(f.get_device_int(device.handle, part));
  l.has_fast = f.get_device_int(device.handle, "version") >= kFirstWithFast;
  l.done = true;
}

std::string OpenImageDenoise::version() {
  Loaded& l = loaded();
  const std::lock_guard lock(l.mutex);
  return l.done ? l.version : "";
}

OpenImageDenoise::OpenImageDenoise(int width, int height, std::vector<float> albedo, std::vector<float> normal,
                                   DenoiseNetwork network, int threads, const std::atomic<bool>& cancelled)
    : width_(width),
      height_(height),
      network_(network),
      cancelled_(cancelled),
      albedo_(std::move(albedo)),
      normal_(std::move(normal)) {
  device_ = Device::make(threads);
  if (network_ != DenoiseNetwork::Large) return;
  if (!albedo_.empty()) run("albedo", albedo_, kBalanced);
  if (!normal_.empty()) run("normal", normal_, kBalanced);
}

OpenImageDenoise::~OpenImageDenoise() = default;

std::vector<float> OpenImageDenoise::operator()(std::vector<float> image) const {
  run("color", image, number_of(network_));
  return image;
}

/// Denoises the image `name` in place. `quality`: number of the library.
void OpenImageDenoise::run(const char* name, std::vector<float>& image, int quality) const {
  const bool is_guide = &image == &albedo_ || &image == &normal_, guided = !is_guide && !albedo_.empty();
  void* const filter = device_->make_filter({name, image.data(), guided ? albedo_.data() : nullptr,
                                             guided && !normal_.empty() ? normal_.data() : nullptr, size_t(width_),
                                             size_t(height_), quality});
  device_->run(filter, cancelled_);
  device_->use.release_filter(filter);
  device_->check();
}

PreparedDenoiser::PreparedDenoiser(int width, int height, bool guided, DenoiseNetwork network, int threads)
    : device_(OpenImageDenoise::Device::make(threads)),
      image_(size_t(width) * size_t(height) * 3),
      albedo_(guided ? image_.size() : 0),
      normal_(albedo_.size()),
      filter_(device_->make_filter({"color", image_.data(), guided ? albedo_.data() : nullptr,
                                    guided ? normal_.data() : nullptr, size_t(width), size_t(height),
                                    number_of(network)})) {
  device_->use.commit_filter(filter_);
  device_->check();
}

PreparedDenoiser::~PreparedDenoiser() { device_->use.release_filter(filter_); }

void PreparedDenoiser::set_guides(const std::vector<float>& albedo, const std::vector<float>& normal) {
  std::copy_n(albedo.begin(), std::min(albedo.size(), albedo_.size()), albedo_.begin());
  std::copy_n(normal.begin(), std::min(normal.size(), normal_.size()), normal_.begin());
}

std::vector<float> PreparedDenoiser::operator()(std::vector<float> image, const std::atomic<bool>& cancelled) {
  std::copy(image.begin(), image.end(), image_.begin());
  device_->run(filter_, cancelled);
  device_->check();
  std::copy(image_.begin(), image_.end(), image.begin());
  return image;
}

}  // namespace ajar
