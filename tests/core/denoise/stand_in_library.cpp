// A library with the interface of Open Image Denoise, as far as Ajar uses it. Its images are blue, and as bright as the
// mean of what they are made of. AJAR_STAND_IN_FAILS lets images fail, AJAR_STAND_IN_SECONDS lets them take this time.
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

namespace {

constexpr int kUnknownError = 1, kCancelled = 6;
struct Device {
  int error = 0;
};
struct Filter {
  Device* device = nullptr;
  const float* color = nullptr;
  float* output = nullptr;
  size_t width = 0, height = 0;
  bool (*goes_on)(void*, double) = nullptr;
  void* user = nullptr;
};

bool waits(Filter& f) {
  const char* seconds = std::getenv("AJAR_STAND_IN_SECONDS");
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds ? std::atof(seconds) : 0.0);
  while (std::chrono::steady_clock::now() < end) {
    if (f.goes_on && !f.goes_on(f.user, 0.5)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace

extern "C" {

void* oidnNewDevice(int) { return new Device; }
void oidnSetDeviceInt(void*, const char*, int) {}
void oidnSetDeviceBool(void*, const char*, bool) {}
int oidnGetDeviceInt(void*, const char* name) { return std::string(name) == "version" ? 20400 : 2; }
void oidnCommitDevice(void*) {}
void oidnReleaseDevice(void* device) { delete static_cast<Device*>(device); }
int oidnGetDeviceError(void* device, const char** message) {
  int& error = static_cast<Device*>(device)->error;
  const int found = error;
  error = 0;
  *message = found ? "the stand-in fails" : nullptr;
  return found;
}
void* oidnNewFilter(void* device, const char*) {
  auto* filter = new Filter;
  filter->device = static_cast<Device*>(device);
  return filter;
}
void oidnSetSharedFilterImage(void* filter, const char* name, void* data, int, size_t width, size_t height, size_t,
                              size_t, size_t) {
  auto* f = static_cast<Filter*>(filter);
  f->width = width;
  f->height = height;
  if (std::strcmp(name, "output") == 0) f->output = static_cast<float*>(data);
  if (std::strcmp(name, "color") == 0) f->color = static_cast<float*>(data);
}
void oidnSetFilterBool(void*, const char*, bool) {}
void oidnSetFilterInt(void*, const char*, int) {}
void oidnSetFilterProgressMonitorFunction(void* filter, bool (*goes_on)(void*, double), void* user) {
  static_cast<Filter*>(filter)->goes_on = goes_on;
  static_cast<Filter*>(filter)->user = user;
}
void oidnCommitFilter(void*) {}
void oidnExecuteFilter(void* filter) {
  auto& f = *static_cast<Filter*>(filter);
  if (!waits(f)) f.device->error = kCancelled;
  if (std::getenv("AJAR_STAND_IN_FAILS")) f.device->error = kUnknownError;
  if (f.device->error || !f.color) return;
  const size_t pixels = f.width * f.height;
  double sum = 0.0;
  for (size_t i = 0; i < 3 * pixels; ++i) sum += f.color[i];
  for (size_t i = 0; i < pixels; ++i) {
    f.output[3 * i] = f.output[3 * i + 1] = 0.0f;
    f.output[3 * i + 2] = float(sum / double(pixels));
  }
}
void oidnReleaseFilter(void* filter) { delete static_cast<Filter*>(filter); }
}
