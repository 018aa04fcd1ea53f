// Denoising of images, with Open Image Denoise from a file.
#include "arrays.h"
#include "bind.h"
#include "denoise/denoise.h"
#include "denoise/open_image_denoise.h"
#include "denoise/quality.h"

namespace ajar::python {

namespace {

/// The first three channels of an array [height, width, channels]; empty for None.
std::vector<float> rgb_of(const std::optional<Floats>& array, size_t height, size_t width, const char* what) {
  if (!array) return {};
  const bool fits = array->ndim() == 3 && size_t(array->shape(0)) == height && size_t(array->shape(1)) == width &&
                    array->shape(2) >= 3;
  if (!fits)
    throw py::value_error(std::string(what) + " must be an array [" + std::to_string(height) + ", " +
                          std::to_string(width) + ", 3 or more], not " + shape_text(*array));
  const size_t channels = size_t(array->shape(2));
  std::vector<float> result(3 * height * width);
  for (size_t i = 0; i < height * width; ++i)
    for (size_t c = 0; c < 3; ++c) result[3 * i + c] = array->data()[channels * i + c];
  return result;
}

/// A flag that another thread sets.
struct Cancellation {
  std::atomic<bool> is_set = false;
};

/// An array of the pass "Halves" or "Direct Halves", of one or more techniques; empty for None.
std::vector<float> halves_of(const std::optional<Floats>& array, size_t height, size_t width, const char* what) {
  if (!array) return {};
  const size_t pixels = height * width, size = size_t(array->size());
  if (array->ndim() != 3 || size == 0 || size % (6 * pixels) != 0)
    throw py::value_error(std::string(what) + " must be an array [" + std::to_string(height) + ", " +
                          std::to_string(width) + ", 6 for each technique], not " + shape_text(*array));
  return copy_numbers(*array);
}

/// Arrays of the passes that a denoiser uses besides the image, or None.
struct Passes {
  const std::optional<Floats>&halves, &direct_halves, &albedo, &normal;
  const std::vector<bool>& biased;
  float exposure;
};

py::object denoised(const Floats& image, const Passes& passes, DenoiseQuality quality, int threads,
                    const Cancellation* cancellation, bool needs_error) {
  if (image.ndim() != 3 || image.shape(2) < 3)
    throw py::value_error("image must be an array [height, width, 3 or more], not " + shape_text(image));
  const size_t height = size_t(image.shape(0)), width = size_t(image.shape(1)), channels = size_t(image.shape(2));
  std::vector<float> color = rgb_of(image, height, width, "image"),
                     both = halves_of(passes.halves, height, width, "halves"),
                     direct = halves_of(passes.direct_halves, height, width, "direct_halves"),
                     guides[] = {rgb_of(passes.albedo, height, width, "albedo"),
                                 rgb_of(passes.normal, height, width, "normal")};
  if (!direct.empty() && direct.size() != both.size())
    throw py::value_error("direct_halves must have the shape of halves, not " + shape_text(*passes.direct_halves));
  std::vector<float> result = copy_numbers(image);
  std::vector<float> error;
  const Cancellation never;
  const std::atomic<bool>& stop = (cancellation ? *cancellation : never).is_set;
  const DenoisePlan plan = plan_of(quality);
  if (!plan.separates) direct.clear();
  try {
    py::gil_scoped_release release;
    std::optional<OpenImageDenoise> small;
    DenoiseFunction estimator;
    if (plan.runs == DenoiseRuns::Whole && !both.empty() && (needs_error || plan.estimates_errors)) {
      small.emplace(int(width), int(height), guides[0], guides[1], DenoiseNetwork::Small, threads, stop);
      estimator = std::cref(*small);
    }
    const OpenImageDenoise library(int(width), int(height), std::move(guides[0]), std::move(guides[1]), plan.network,
                                   threads, stop);
    Denoised image = denoise({color, both, std::move(direct), int(width), int(height), passes.biased, passes.exposure},
                             std::cref(library), plan.runs, estimator);
    for (size_t i = 0; i < height * width; ++i)
      for (size_t c = 0; c < 3; ++c) result[channels * i + c] = image.image[3 * i + c];
    error = std::move(image.error);
  } catch (const DenoisingCancelled&) {
    return py::none();
  }
  const bool has_error = !error.empty();
  return py::make_tuple(take_array(std::move(result), {height, width, channels}),
                        has_error ? py::object(take_array(std::move(error), {height, width})) : py::none());
}

}  // namespace

void bind_denoise(py::module_& module) {
  py::enum_<DenoiseQuality>(module, "DenoiseQuality", "How much time a denoiser takes for a smaller error.")
      .value("High", DenoiseQuality::High,
             "A large network, for each half of the samples; direct light and the rest are denoised apart.")
      .value("Balanced", DenoiseQuality::Balanced, "As High, but once for both halves. Half of the time.")
      .value("Fast", DenoiseQuality::Fast, "A large network, once for the whole image.")
      .value("Fastest", DenoiseQuality::Fastest, "A smaller network, once for the whole image.");
  module.def(
      "denoise_seconds_per_ray", [] { return kDenoiseSecondsPerRay; },
      "Return the time of a ray that denoise_quality_for assumes, in seconds of a core.");
  module.def(
      "denoise_quality_for", &denoise_quality_for, py::arg("rays"), py::arg("pixels"), py::arg("free_seconds"),
      py::arg("separates"),
      "Return the best DenoiseQuality that takes at most a tenth of a render with this number of rays, or, except "
      "High, free_seconds (float, seconds of a core). It follows from fixed costs, not from the clock: frames of "
      "different machines agree. separates: direct light is denoised apart.");
  py::class_<Cancellation>(module, "Cancellation", "A request to stop, which another thread makes.")
      .def(py::init<>(), "A request that is not made yet.")
      .def(
          "set", [](Cancellation& c) { c.is_set = true; }, "Make the request.");
  module.def(
      "load_denoiser", [](const std::string& file) { OpenImageDenoise::load(file); }, py::arg("file"),
      py::call_guard<py::gil_scoped_release>(),
      "Load Open Image Denoise 2 from a file, for the whole process. A second call has no effect. Raises RuntimeError, "
      "with the reason, when the file is not that library.");
  module.def("denoiser_version", &OpenImageDenoise::version,
             "The version of Open Image Denoise, such as \"2.5.1\"; \"\" before `load_denoiser`.");
  module.def(
      "denoise",
      [](const Floats& image, const std::optional<Floats>& halves, const std::optional<Floats>& albedo,
         const std::optional<Floats>& normal, DenoiseQuality quality, int threads, const Cancellation* cancellation,
         const std::optional<Floats>& direct_halves, const std::vector<bool>& biased, float exposure, bool error) {
        return denoised(image, {halves, direct_halves, albedo, normal, biased, exposure}, quality, threads,
                        cancellation, error);
      },
      py::arg("image"), py::arg("halves") = py::none(), py::arg("albedo") = py::none(), py::arg("normal") = py::none(),
      py::arg("quality") = DenoiseQuality::High, py::arg("threads") = 0, py::arg("cancellation") = py::none(),
      py::arg("direct_halves") = py::none(), py::arg("biased") = std::vector<bool>{}, py::arg("exposure") = 1.0f,
      py::arg("error") = false,
      "Return (image, error). The image has no noise, float32[height, width, channels]; its error is None or "
      "float32[height, width], an estimate of the relMSE of each pixel, which needs `halves`, and with the qualities "
      "Fast and Fastest also `error`. image: "
      "float32[height, width, 3 or more], linear; only the first three channels change. halves: the pass "
      "\"Halves\", float32[height, width, 6], or 6 channels for each technique that has rendered the image. With it, "
      "the result is consistent: it becomes the correct image as the number of samples grows. direct_halves: the pass "
      "\"Direct Halves\" of the same shape. With the qualities High and Balanced, this part of the light and the "
      "rest are denoised apart, which has a smaller error. It is not used if a number is NaN. "
      "biased: list[bool], whether each technique is biased; none is if it is empty. exposure: float, a factor on the "
      "light by which the image is displayed; errors are judged in the displayed image. error: bool, whether Fast and "
      "Fastest estimate the error, which takes two more runs of a small network. "
      "albedo and normal: float32[height, width, 3 or more], the guides. quality: time against error. threads: 0 uses "
      "all. cancellation: Cancellation or None; the result is "
      "None if it is set during the call. Raises RuntimeError when no denoiser is loaded or when it fails, and "
      "ValueError for a wrong shape.");
}

}  // namespace ajar::python
